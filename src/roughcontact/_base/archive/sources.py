"""Which program a class is: its distribution and version, or its source where it has none."""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib.metadata
import inspect
import sys
import textwrap
import weakref
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import CellType, CodeType, FunctionType
from typing import Any

# Hexadecimal digits of the digest of a source.
_DIGITS = 32
# What a class has besides what it does; the hash that attrs makes is another in each process.
_BESIDE = {"__module__", "__dict__", "__hash__", "__weakref__", "__firstlineno__", "__static_attributes__"}
_texts: weakref.WeakKeyDictionary[Any, tuple[str, frozenset[str]]] = weakref.WeakKeyDictionary()


def programs(classes: Iterable[type], own: str) -> list[str]:
    """Return the name and version of each distribution that defines one of the classes or of their bases.

    Those that no installed distribution defines, as in a script or a notebook, give a digest of their source, and
    of the functions, classes and plain values of their module that it names. The package `own` gives nothing.
    """
    found = set()
    ours = {own, *sys.stdlib_module_names}
    for cls in classes:
        for base in cls.__mro__:
            if _top(base) not in ours:
                path = f"{base.__module__}:{base.__qualname__}".replace("__mp_main__:", "__main__:")
                found.add(_distribution(base) or f"{path} {_digest(base, ours)}")
    return sorted(found)


def _top(definition: Any) -> str:
    return str(definition.__module__).partition(".")[0]


@functools.cache
def _packages() -> Mapping[str, list[str]]:
    return importlib.metadata.packages_distributions()


def _distribution(definition: Any) -> str:
    """Return the distribution of a class or function with its version; empty without one."""
    file = getattr(sys.modules.get(definition.__module__), "__file__", None)
    found = [importlib.metadata.distribution(name) for name in dict.fromkeys(_packages().get(_top(definition), []))]
    # A folder of the user's may have the name of a package.
    return ", ".join(
        f"{dist.name} {dist.version}"
        for dist in found
        if file is None or Path(file).is_relative_to(Path(str(dist.locate_file(""))))
    )


def _digest(definition: Any, ours: set[str]) -> str:
    """Return a digest of a class or function and of what it names in its module."""
    texts: dict[str, str] = {}
    waiting = [("", definition)]
    while waiting:
        place, value = waiting.pop()
        if place in texts:
            continue
        if not isinstance(value, (type, FunctionType)):
            texts[place] = repr(value)
        elif _top(value) not in ours and not _distribution(value):
            texts[place], names = _text_of(value)
            module = vars(sys.modules.get(value.__module__, object))
            used = {name: module[name] for name in names if name in module}
            waiting += [(f"{value.__module__}.{name}", used[name]) for name in used if _is_plain(used[name])]
    content = "\0".join(f"{place}\0{texts[place]}" for place in sorted(texts))
    return hashlib.sha256(content.replace("__mp_main__", "__main__").encode()).hexdigest()[:_DIGITS]


def _is_plain(value: object) -> bool:
    if isinstance(value, tuple):
        return all(map(_is_plain, value))
    return isinstance(value, (type, FunctionType, bool, int, float, complex, str, bytes, type(None)))


def _text_of(definition: Any) -> tuple[str, frozenset[str]]:
    """Return the source of a class or function as it was first seen, and the names in it; code without a source."""
    if definition not in _texts:
        try:
            # From CPython 3.13 on, what exec() defines in `python -c` would get lines of another text.
            if not Path(inspect.getsourcefile(definition) or "").is_file():
                raise OSError
            text = textwrap.dedent(inspect.getsource(definition))
            names = frozenset(node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name))
        except (OSError, TypeError, SyntaxError):
            codes = list(_codes_of(definition, set()))
            text = "\0".join(text for text, _ in codes)
            names = frozenset(name for _, names in codes for name in names)
        _texts[definition] = text, names
    return _texts[definition]


def _codes_of(value: Any, seen: set[int]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield the code and the plain values that make up a class or function, each with the names that it uses."""
    if id(value) in seen:
        return
    inner: list[Any] = []
    if isinstance(value, CodeType):
        yield repr((value.co_name, value.co_code)), value.co_names
        inner = list(value.co_consts)
    elif isinstance(value, (type, FunctionType)):
        seen.add(id(value))
        members = vars(value) if isinstance(value, type) else {}
        inner = [member for name, member in sorted(members.items()) if name not in _BESIDE]
        if isinstance(value, FunctionType):
            cells = [cell.cell_contents for cell in value.__closure__ or () if cell != CellType()]
            inner = [value.__code__, value.__defaults__, value.__kwdefaults__, *cells]
    elif isinstance(value, (classmethod, staticmethod, property, functools.cached_property)):
        inner = [getattr(value, name, None) for name in ("__func__", "fget", "func")]
    elif isinstance(value, frozenset):
        # In an order that is the same in any process.
        yield repr(sorted(map(repr, value))), ()
    elif isinstance(value, (tuple, list, dict)):
        inner = list(value.values() if isinstance(value, dict) else value)
    elif _is_plain(value):
        yield repr(value), ()
    for item in inner:
        yield from _codes_of(item, seen)
