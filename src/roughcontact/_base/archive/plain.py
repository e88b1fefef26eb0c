"""Parts as plain data for files and keys, and parts from plain data."""

from __future__ import annotations

import ast
import contextlib
import functools
import importlib.metadata
import inspect
import json
import linecache
import math
import sys
import textwrap
import uuid
import weakref
from collections.abc import Iterable, Iterator, Mapping
from enum import Enum
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, TypeAlias, get_args, get_origin

import attrs
import numpy as np

from roughcontact._base.archive import digest_of, short_digest
from roughcontact._base.arrays import RealArray
from roughcontact._base.registry import Registry, arguments_of, field_types, path_of, registries
from roughcontact.errors import InputError, shorten

_texts: weakref.WeakKeyDictionary[Any, tuple[str, frozenset[str]]] = weakref.WeakKeyDictionary()
Described: TypeAlias = Any
_PACKAGE = __name__.partition(".")[0]
# Characters of the text by which a field that is not plain data is described.
_MAX_TEXT_CHARACTERS = 200
# Missing classes that a message lists.
_MAX_LISTED_CLASSES = 5


def programs(classes: Iterable[type]) -> list[str]:
    """Return name and version of each distribution that defines one of the classes or their bases, but for this one.

    A class of a script or a notebook gives a digest of its source and of the functions, classes and plain values of its
    module that it names.
    """
    bases = {base for cls in classes for base in cls.__mro__ if not _is_known(base)}
    return sorted({_distribution(base) or f"{path_of(base)} {_digest(base)}" for base in bases})


def _is_known(definition: Any) -> bool:
    """Return whether a definition belongs to this package or to Python, whose versions are recorded apart."""
    top = _top(definition)
    return top == _PACKAGE or top in sys.stdlib_module_names


def _top(definition: Any) -> str:
    return str(definition.__module__).partition(".")[0]


@functools.cache
def _packages() -> Mapping[str, list[str]]:
    return importlib.metadata.packages_distributions()


def _distribution(definition: Any) -> str:
    """Return the distribution of a class or function with its version; empty without one."""
    file = getattr(sys.modules.get(definition.__module__), "__file__", None)
    found = [importlib.metadata.distribution(name) for name in dict.fromkeys(_packages().get(_top(definition), []))]
    # A folder of the user may have the name of an installed package.
    return ", ".join(
        f"{dist.name} {dist.version}"
        for dist in found
        if file is None or Path(file).is_relative_to(Path(str(dist.locate_file(""))))
    )


def _digest(definition: Any) -> str:
    """Return a digest of a class or function and of the definitions in its module that it names."""
    texts: dict[str, str] = {}
    waiting = [("", definition)]
    while waiting:
        place, value = waiting.pop()
        if place in texts:
            continue
        if not isinstance(value, (type, FunctionType)):
            texts[place] = repr(value)
        elif not _is_known(value) and not _distribution(value):
            texts[place], names = _text_of(value)
            module = vars(sys.modules.get(value.__module__, object))
            used = {name: module[name] for name in names if name in module}
            waiting += [(f"{value.__module__}.{name}", used[name]) for name in used if _is_plain(used[name])]
    content = "\0".join(f"{place}\0{texts[place]}" for place in sorted(texts))
    return short_digest(content.replace("__mp_main__", "__main__"))


def _is_plain(value: object) -> bool:
    if isinstance(value, tuple):
        return all(map(_is_plain, value))
    return isinstance(value, (type, FunctionType, bool, int, float, complex, str, bytes, type(None)))


def _text_of(definition: Any) -> tuple[str, frozenset[str]]:
    """Return the source of a class or function, as first seen, and the names in it.

    What has no source, such as a class made by exec(), is another one in each process, since it may have changed.
    """
    if definition not in _texts:
        source = _source_in_file(definition) or _source_in_cell(definition)
        names = frozenset(node.id for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Name))
        _texts[definition] = source or f"without source, {uuid.uuid4().hex}", names
    return _texts[definition]


def _source_in_file(definition: Any) -> str:
    """Return the source of a class or function of a file; empty if it is of no file."""
    with contextlib.suppress(OSError, TypeError, SyntaxError):
        # From CPython 3.13 on, inspect finds other lines for definitions by exec() in `python -c`.
        if Path(inspect.getsourcefile(definition) or "").is_file():
            source = textwrap.dedent(inspect.getsource(definition))
            ast.parse(source)
            return source
    return ""


def _source_in_cell(definition: Any) -> str:
    """Return the source of a class or function of a notebook, from the cell of a method; empty without one."""
    members = vars(definition).values() if isinstance(definition, type) else [definition]
    for cell in {code.co_filename: None for code in filter(None, map(_code_of, members))}:
        # The lines of `python -c` are not those of an exec() in it, of the same name.
        lines = [] if cell == "<string>" else linecache.getlines(cell)
        with contextlib.suppress(SyntaxError):
            for node in reversed(ast.parse("".join(lines)).body):
                if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and node.name == definition.__name__:
                    first = min(one.lineno for one in (node, *node.decorator_list))
                    return "".join(lines[first - 1 : node.end_lineno])
    return ""


def _code_of(member: Any) -> CodeType | None:
    """Return the code of a function, a property or a method that may be behind the door; None of anything else."""
    for name in ("__func__", "fget", "func"):
        member = getattr(member, name, member)
    return getattr(inspect.unwrap(member), "__code__", None) if callable(member) else None


# Classes that plug-ins use in the fields of their parts, such as a layer of a coating.
parts = Registry(object, "part", "roughcontact.parts")


def describe(value: object, arrays: dict[str, RealArray]) -> Described:
    """Return a value as data for JSON, and put its arrays into `arrays` under the digest of their content.

    Values are numbers, texts, enumerations, arrays, lists, mappings, and parts made of them. The fields of a part that
    is not an attrs class, or has a field of another type, are kept as texts.
    """
    if isinstance(value, (Enum, np.generic)):
        return describe(value.value if isinstance(value, Enum) else value.item(), arrays)
    if isinstance(value, float) and not math.isfinite(value):
        return {"number": str(value)}
    if isinstance(value, (bool, int, float, str, type(None))):
        return value
    if isinstance(value, np.ndarray):
        name = digest_of(value)
        arrays[name] = value
        return {"array": name}
    if isinstance(value, (list, tuple)):
        return [describe(item, arrays) for item in value]
    if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
        return {"mapping": {key: describe(item, arrays) for key, item in value.items()}}
    cls = type(value)
    if not attrs.has(cls) and not isinstance(value, _plug_in_bases()):
        raise InputError.about("A value kept in a file", value, "numbers, texts, arrays or attrs classes made of them")
    part = _kind_and_name(cls)
    fields = _fields_of(value)
    with contextlib.suppress(InputError):
        if attrs.has(cls) or not fields:
            return {**part, "fields": {key: describe(item, arrays) for key, item in fields.items()}}
    return {**part, "texts": {key: repr(item)[:_MAX_TEXT_CHARACTERS] for key, item in fields.items()}}


def rebuild(described: Described, arrays: Mapping[str, RealArray], bases: tuple[type, ...] | None = None) -> Any:
    """Return the value of a description and its arrays by `describe`.

    A part must derive from one of the bases, by default those of all registries. `InputError` if a class is not
    registered, does not derive from the base that its field expects, or does not accept its fields.
    """
    match described:
        case None | bool() | int() | float() | str():
            return described
        case list():
            return tuple(rebuild(item, arrays, bases) for item in described)
        case {"array": str(name)} if len(described) == 1 and name in arrays:
            return arrays[name]
        case {"number": "nan" | "inf" | "-inf" as text} if len(described) == 1:
            return float(text)
        case {"mapping": dict(items)} if len(described) == 1:
            return {key: rebuild(item, arrays, bases) for key, item in items.items()}
    cls, fields = rebuild_fields(described, arrays, bases)
    try:
        return cls(**fields)
    # A registered class may refuse its fields with an error of any type.
    except Exception as error:
        reason = shorten(" ".join(str(error).split()), _MAX_TEXT_CHARACTERS).rstrip(".")
        raise InputError(
            f"The {described['kind']} {described['name']!r} does not take its fields: {reason}."
        ) from error


def rebuild_fields(
    described: Described, arrays: Mapping[str, RealArray], bases: tuple[type, ...] | None = None
) -> tuple[type, dict[str, Any]]:
    """Return the class of a part and the arguments for its constructor; see `rebuild`."""
    match described:
        case {"kind": str(kind), "name": str(name), "fields": dict(given)} if len(described) == 3:
            cls = _class_of(kind, name)
        case _:
            raise InputError(f"{str(described)[:80]} does not describe a part.")
    if cls is None:
        raise InputError(f"The {kind} {name} must be registered.")
    bases = _plug_in_bases() if bases is None else bases
    if not issubclass(cls, bases):
        expected = " or ".join(base.__name__ for base in bases) or "plain data"
        raise InputError(f"The {kind} {name!r} stands where {expected} must stand.")
    fields = arguments_of(cls)
    # Older files have former names of some fields.
    renamed = {field.metadata["formerly"]: key for key, field in fields.items() if "formerly" in field.metadata}
    given = {renamed.get(key, key): item for key, item in given.items()}
    needed = {key for key, field in fields.items() if field.default is attrs.NOTHING}
    if not needed <= set(given) <= set(fields):
        known = ", ".join(fields) or "nothing"
        got = f"{', '.join(given)!r:.{_MAX_TEXT_CHARACTERS}}" if given else "nothing"
        raise InputError(f"The fields of the {kind} {name!r} are {known}, but the file gives {got}.")
    hints = _hints(cls)
    bases_of = {key: tuple(_bases_in(hints.get(field.name, Any))) for key, field in fields.items()}
    return cls, {key: rebuild(item, arrays, bases_of[key]) for key, item in given.items()}


def missing_classes(described: Described) -> str:
    """Return a sentence that lists the classes to register before a part can be rebuilt; empty if there are none."""
    missing: dict[str, None] = {}
    for part in _parts_in(described):
        cls = _class_of(part["kind"], part["name"])
        if "texts" in part or cls is None:
            needed = "an attrs class whose fields are plain data" if "texts" in part else "registered"
            missing[f"the {part['kind']} {part['name']} must be {needed}"] = None
    found = list(missing)
    shown = (
        [*found[:_MAX_LISTED_CLASSES], f"{len(found) - _MAX_LISTED_CLASSES} others as well"]
        if len(found) > _MAX_LISTED_CLASSES
        else found
    )
    return f"To solve it again, {', and '.join(shown)}." if missing else ""


def arrays_in(described: Described) -> Iterator[str]:
    """Yield the names of the arrays in a description, each as often as it occurs."""
    if isinstance(described, dict):
        if isinstance(described.get("array"), str):
            yield described["array"]
        described = list(described.values())
    if isinstance(described, list):
        for item in described:
            yield from arrays_in(item)


def programs_of(value: object) -> list[str]:
    """Return the `programs` of the parts of a value, also of parts given by a registered name."""
    return programs(_classes_in(value))


def key_of(value: object, *more: str) -> str:
    """Return a key that is the same for equal content and programs in any process; `InputError` without one."""
    return key_of_description(describe(value, {}), *programs_of(value), *more)


def key_of_description(described: Described, *more: str) -> str:
    """Return the key of a description by `describe`; see `key_of`."""
    for part in _parts_in(described):
        if "texts" in part or "<locals>" in part["name"]:
            advice = "make it an attrs class at the top level of a module, whose fields are plain data"
            raise InputError(f"The content of the {part['kind']} {part['name']} is not known: {advice}.")
    return short_digest(json.dumps([described, *more], sort_keys=True))


def _classes_in(value: object, place: str = "") -> Iterator[type]:
    """Yield the class of every part of a value; a text in a field named after a kind is a registered name."""
    inner: Mapping[str, object] = {}
    if isinstance(value, str) and place in registries() and value in registries()[place]:
        yield registries()[place][value]
    elif isinstance(value, Mapping):
        inner = value
    elif isinstance(value, (list, tuple)):
        inner = {str(number): item for number, item in enumerate(value)}
    elif isinstance(value, (bool, int, float, type(None))):
        return
    elif attrs.has(type(value)) or isinstance(value, _plug_in_bases()):
        yield type(value)
        inner = _fields_of(value)
    for name, item in inner.items():
        yield from _classes_in(item, name)


def _fields_of(value: object) -> dict[str, object]:
    if attrs.has(type(value)):
        return {name: getattr(value, field.name) for name, field in arguments_of(type(value)).items()}
    state = object.__getstate__(value)
    return {} if state is None else {"state": state}


def _kind_and_name(cls: type) -> dict[str, str]:
    """Return the kind of a class, and its name in a description."""
    found = [registry for registry in registries().values() if issubclass(cls, registry.base)]
    # An area estimator is a response too: of several bases the one derived from the others counts.
    registry = max(found, key=lambda one: len(one.base.__mro__))
    path = f"{_PACKAGE}:{cls.__name__}" if public_class(cls.__name__) is cls else path_of(cls)
    name = registry.name_of(cls) or path
    return {"kind": registry.kind, "name": name}


def _class_of(kind: str, name: str) -> type | None:
    """Return the class of a part; None if it belongs to a plug-in that is not registered or cannot be loaded."""
    if len(kind + name) > 2 * _MAX_TEXT_CHARACTERS or not (kind + name).isprintable():
        raise InputError(f"The name of a part must be at most {2 * _MAX_TEXT_CHARACTERS} printable characters.")
    registry = registries().get(kind)
    package, _, own = name.partition(":")
    if registry is None or (package == _PACKAGE and own):
        found = None if registry is None else public_class(own)
        if found is None:
            raise InputError(f"There is no {kind} named {name!r}.")
        return found
    with contextlib.suppress(InputError):
        return registry[name] if name in registry else registry.defined_as(name)
    return None


def public_class(name: str) -> type | None:
    """Return the attrs class that the package exports under a name."""
    package: Any = sys.modules[_PACKAGE]
    found = getattr(package, name, None) if name in package.__all__ else None
    return found if isinstance(found, type) and attrs.has(found) else None


def _plug_in_bases() -> tuple[type, ...]:
    return tuple(registry.base for registry in registries().values() if registry.base is not object)


def _hints(cls: type) -> dict[str, Any]:
    try:
        return field_types(cls)
    # Some names are imported for type checkers only: then a field may hold any plug-in.
    except Exception:
        return {}


def _bases_in(hint: Any) -> Iterator[type]:
    """Yield the classes in an annotation; the bases of all plug-ins if it names none."""
    if hint is Any or hint is object or getattr(hint, "_is_protocol", False):
        yield from _plug_in_bases()
    elif get_origin(hint) is None:
        yield from (hint,) if isinstance(hint, type) else ()
    elif get_origin(hint) is not np.ndarray:
        for inner in get_args(hint):
            yield from _bases_in(inner)


def _parts_in(described: Described) -> Iterator[dict[str, Any]]:
    """Yield every part, outer ones first."""
    inner: Any = described if isinstance(described, list) else ()
    match described:
        case {"mapping": dict(items)}:
            inner = items.values()
        case {"kind": str(), "name": str()}:
            yield described
            fields = described.get("fields")
            inner = fields.values() if isinstance(fields, dict) else ()
    for item in inner:
        yield from _parts_in(item)
