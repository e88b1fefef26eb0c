"""Registries: the names of what can be plugged in, and the fields of parts as faces ask for them.

A class is entered by the decorator ``roughcontact.kernels.register("name")`` or by an entry point of an installed
distribution; this package enters its own classes by entry points too.
"""

from __future__ import annotations

import functools
import inspect
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import Any, Generic, TypeVar, get_args, get_type_hints

import attrs

from roughcontact._base.arrays import Array, Pair
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.errors.warning import warn

T = TypeVar("T")
C = TypeVar("C", bound=type)
_BY_KIND: dict[str, Registry[Any]] = {}
# The modules that define public classes: annotations of their fields name what is known there.
_DEFINED_IN: dict[type, str] = {}
# Where a word begins inside the name of a class.
_WORD = re.compile(r"(?<=[a-z])(?=[A-Z])")


class Registry(Generic[T]):
    """The classes of one kind by name: iterable, with ``in``, ``[]`` and ``len``; `InputError` for unknown names.

    Parameters
    ----------
    base
        The base class of all registered classes.
    kind
        The kind of its classes, singular, for sentences and files.
    group
        Entry-point group that installed distributions use.
    in_files
        Whether files may name its classes.
    translates_errors
        Whether errors of its classes are translated to `roughcontact.errors`; the command line does that itself.

    Examples
    --------
    >>> import roughcontact as rc
    >>> "blend" in rc.areas
    True
    >>> rc.areas["blend"].__name__, rc.areas.name_of(rc.Blend)
    ('Blend', 'blend')
    >>> rc.areas.create("blnd")
    Traceback (most recent call last):
        ...
    roughcontact.InputError: There is no area estimator named 'blnd'. Did you mean 'blend'? Known: ...
    """

    def __init__(
        self, base: type[T], kind: str, group: str, *, in_files: bool = True, translates_errors: bool = True
    ) -> None:
        self.base = base
        self.kind = kind
        self.group = group
        self.translates_errors = translates_errors
        self._classes: dict[str, type[T]] = {}
        self._installed: dict[str, list[EntryPoint]] | None = None
        if in_files:
            _BY_KIND[kind] = self

    def register(self, name: str) -> Callable[[C], C]:
        """Return a class decorator that registers a class derived from the base under a free name."""
        if not isinstance(name, str) or not name or ":" in name:
            raise InputError.about(f"The name of {self._a_kind}", name, "a non-empty string without a colon")

        def enter(cls: C) -> C:
            checked = self._require_class(cls, "")
            # A class defined again (a notebook cell run twice) replaces itself.
            owners = {_owner(entry.value) for entry in self._entries().get(name, [])}
            if name in self._classes:
                owners.add(_owner(path_of(self._classes[name])))
            if owners - {_owner(path_of(cls))}:
                raise InputError(
                    f"The name {name!r} of {self._a_kind} is taken already by {', '.join(sorted(owners))}."
                )
            self._classes[name] = checked
            return cls

        return enter

    @property
    def _a_kind(self) -> str:
        return f"{'an' if self.kind[0] in 'aeiou' else 'a'} {self.kind}"

    def __iter__(self) -> Iterator[str]:
        return iter(sorted({*self._classes, *self._entries()}))

    def __len__(self) -> int:
        return len({*self._classes, *self._entries()})

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and (name in self._classes or name in self._entries())

    def __getitem__(self, name: str) -> type[T]:
        if name not in self._classes:
            self._classes[name] = self._load(name)
        return self._classes[name]

    def __repr__(self) -> str:
        paths = {name: [entry.value for entry in found] for name, found in self._entries().items()}
        paths |= {name: [path_of(cls)] for name, cls in self._classes.items()}
        width = max(map(len, paths), default=0)
        rows = "".join(f"\n  {name:{width}}  {' and '.join(map(_owner, paths[name]))}" for name in self)
        return f"{self.kind}: {len(self)} subclasses of {self.base.__name__}{rows}"

    def name_of(self, cls: type) -> str | None:
        """Return the name under which exactly this class is registered, the first of several; None without one."""
        top = cls.__module__.partition(".")[0]
        for name, entries in self._entries().items():
            # Only its own distribution can have listed the class: no other is loaded.
            if name not in self._classes and any(entry.module.partition(".")[0] == top for entry in entries):
                with suppress(InputError):
                    self[name]
        return min((name for name, known in self._classes.items() if known is cls), default=None)

    def defined_as(self, path: str) -> type[T] | None:
        """Return the registered class that is defined as ``module:name``; nothing is imported."""
        if not isinstance(path, str):
            raise InputError.about("The place of a class", path, "a text module:name")
        return next((cls for cls in self._classes.values() if path_of(cls) == path), None)

    def create(self, name: str, *arguments: object, **fields: object) -> T:
        """Return an instance of the class registered under `name`, by default made without arguments."""
        cls = self[name]
        try:
            return cls(*arguments, **fields)
        except InputError:
            raise
        except Exception as error:
            given = arguments or fields
            needed = ", ".join(f"{field}=..." for field in _list_required(cls))
            how = "from these arguments" if given else "without arguments"
            reason = f" ({error})" if given or not needed else ""
            advice = f": {self.group}.create({name!r}, {needed}) makes one" if needed else ""
            raise InputError(f"The {self.kind} {name!r} cannot be made {how}{reason}{advice}.") from error

    def resolve(self, choice: object) -> T:
        """Return `choice` if it is an instance of the base, or make one from the registered name."""
        made = self.create(choice) if isinstance(choice, str) else choice
        if not isinstance(made, self.base):
            hint = "Pass an instance, not the class." if isinstance(made, type) else ""
            raise InputError.about(f"The {self.kind}", choice, f"a registered name or {self.kind} object", hint)
        return made

    def _entries(self) -> dict[str, list[EntryPoint]]:
        if self._installed is None:
            found: dict[str, list[EntryPoint]] = {}
            for entry in entry_points(group=self.group):
                same = found.setdefault(entry.name, [])
                # One distribution may be on the path twice, as source and installed.
                if entry.value not in {other.value for other in same}:
                    same.append(entry)
            self._installed = found
        return self._installed

    def _load(self, name: str) -> type[T]:
        claims = self._entries().get(name, [])
        if not claims:
            raise InputError.unknown(self.kind, name, self)
        shipped = [entry for entry in claims if entry.dist is not None and entry.dist.name == "roughcontact"]
        if shipped and len(claims) > 1:
            ignored = " and ".join(entry.value for entry in claims if entry not in shipped)
            warn(f"The {self.kind} {name!r} ships with roughcontact: {ignored} is ignored.")
            claims = shipped
        if len(claims) > 1:
            values = " and ".join(entry.value for entry in claims)
            raise InputError(f"The {self.kind} {name!r} is claimed by {values}; uninstall one of them.")
        try:
            loaded = claims[0].load()
        except Exception as error:
            raise InputError(
                f"The {self.kind} {name!r} is installed as {claims[0].value}, but cannot be loaded: "
                f"{type(error).__name__}: {error}"
            ) from error
        return self._require_class(loaded, f" under the name {name!r}")

    def _require_class(self, cls: object, where: str) -> type[T]:
        if isinstance(cls, type) and issubclass(cls, self.base):
            # `guarded` was applied to the package at its import; a class loaded later needs it here.
            return guarded(cls) if self.translates_errors else cls
        what = f"What is registered as {self._a_kind}{where}"
        allowed = f"a class derived from {self.base.__name__}"
        raise InputError.about(what, cls, allowed)


@functools.cache
def find_view(name: str) -> Callable[..., Any]:
    """Return the function that draws one kind of result, named by an entry point: no lower storey imports it."""
    found: Callable[..., Any] = next(iter(entry_points(group="roughcontact.views", name=name))).load()
    return found


def registries() -> Mapping[str, Registry[Any]]:
    """Return the registries whose classes files may name, by their kind."""
    return MappingProxyType(_BY_KIND)


def _list_required(cls: type) -> list[str]:
    """Return the names of the required parameters of a class."""
    try:
        parameters = inspect.signature(cls).parameters.items()
    except (TypeError, ValueError):
        return []
    several = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD
    return [name for name, one in parameters if one.default is one.empty and one.kind not in several]


def _owner(path: str) -> str:
    """Return a path ``module:name`` for a message: ``package:name`` if the module is private."""
    package = path.partition(".")[0]
    return f"{package}:{path.partition(':')[2]}" if path.startswith(f"{package}._") else path


def path_of(cls: type) -> str:
    """Return the path of a class, ``module:name``; the main module of a process pool counts as ``__main__``."""
    return f"{cls.__module__}:{cls.__qualname__}".replace("__mp_main__:", "__main__:")


def publish(public: Any, package: str) -> None:
    """Let a class or a function say that it belongs to a package, in tracebacks, in pickles and to `help`.

    Examples
    --------
    >>> from roughcontact._base.registry import publish
    >>> def press() -> None:
    ...     pass
    >>> publish(press, "stamps")
    >>> press.__module__
    'stamps'
    """
    if isinstance(public, type):
        _DEFINED_IN[public] = public.__module__
    public.__module__ = package


def arguments_of(cls: Any) -> dict[str, attrs.Attribute[Any]]:
    """Return the fields of an attrs class by the names of its arguments; none of another class."""
    return {str(field.alias): field for field in attrs.fields(cls) if field.init} if attrs.has(cls) else {}


def field_types(cls: type) -> dict[str, Any]:
    """Return the types by which the fields of a class are annotated; NameError if one is not known."""
    modules = [_DEFINED_IN.get(base, base.__module__) for base in reversed(cls.__mro__)]
    known = {name: value for module in modules for name, value in vars(sys.modules.get(module, object)).items()}
    return get_type_hints(cls, known, {})


def name_in_words(part: object) -> str:
    """Return a part in words: what its class is called, and its fields; its own text if it has one.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact._base.registry import name_in_words
    >>> name_in_words(rc.PolonskyKeer(tolerance=1e-8))
    'Polonsky Keer, tolerance 1e-08, max iterations 10000'
    """
    cls = type(part)
    if not attrs.has(cls) or cls.__str__ is not object.__str__:
        return str(part)
    fields = []
    for field in attrs.fields(cls):
        name, comma, others = name_in_words(getattr(part, field.name)).partition(", ")
        # The fields of a part inside a part stand in parentheses.
        fields += [f"{field.name.replace('_', ' ')} {name}{f' ({others})' if comma else ''}"] if field.repr else []
    return ", ".join([_WORD.sub(" ", cls.__name__), *fields])


@attrs.frozen
class PartField:
    """A field of a part, as a form asks for it.

    Attributes
    ----------
    name
        The name.
    kind
        The type by which it is annotated.
    unit
        SI unit of its number; empty for a number without one, None if it is not a number.
    is_needed
        Whether it has no default.
    default
        Its default, if it has one that can be stated.
    plain_unit
        Unit of a number that a text may omit, such as ``"W/(m K) or S/m"``: the ``plain_unit`` in the metadata of
        the field; empty without one.
    """

    name: str
    kind: Any
    unit: str | None
    is_needed: bool
    default: Any = None
    plain_unit: str = ""

    @property
    def is_pair(self) -> bool:
        """Whether it is one number or two."""
        return bool(self.kind == Pair)

    @property
    def is_list(self) -> bool:
        """Whether it is a list of numbers."""
        return self.unit is not None and (Ellipsis in get_args(self.kind) or bool(self.kind == Array))

    @property
    def text_unit(self) -> str | None:
        """Unit of texts that stand for numbers; None if texts do not."""
        return self.plain_unit or self.unit


@guarded
def list_fields(cls: type) -> dict[str, PartField]:
    """Return the arguments of a class by name; of one that is not of attrs their types are not known.

    Examples
    --------
    >>> import roughcontact as rc
    >>> {name: field.unit for name, field in rc.faces.list_fields(rc.WavySurface).items() if field.unit}
    {'amplitude': 'm', 'wavelength': 'm', 'phase': 'rad'}
    """
    if not attrs.has(cls):
        try:
            parameters = inspect.signature(cls).parameters
        except ValueError:
            # Some classes of Python itself state none.
            return {}
        return {name: PartField(name, Any, None, one.default is one.empty) for name, one in parameters.items()}
    try:
        hints = field_types(cls)
    # A class of a script may be annotated with what is not known in its module.
    except NameError:
        hints = {}
    return {
        str(field.alias): PartField(
            str(field.alias),
            kind := hints.get(field.name, Any),
            field.metadata.get("unit", "" if kind in (float, Pair) else None),
            field.default is attrs.NOTHING,
            field.default,
            field.metadata.get("plain_unit", ""),
        )
        for field in attrs.fields(cls)
        if field.init
    }


@guarded
def summarize(cls: type) -> str:
    """Return the first line of the docstring of a class, without marks and formulas.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rc.faces.summarize(rc.laws["archard"])
    'Wear in proportion to the pressure and the sliding distance'
    """
    return (inspect.getdoc(cls) or "").partition("\n")[0].partition(":math:")[0].replace("`", "").strip(" ,.:")


def describe_fields(cls: type) -> dict[str, str]:
    """Return what the docstring of a class says of its parameters, by name."""
    section = re.search(r"^Parameters\n-+\n(.*?)(?:\n\n\S|\Z)", inspect.getdoc(cls) or "", re.DOTALL | re.MULTILINE)
    return {
        name: " ".join(text.split()).replace("`", "")
        for names, text in re.findall(r"^(\w[\w, ]*)\n((?:[ ]+.*\n?)+)", section[1] if section else "", re.MULTILINE)
        for name in names.split(", ")
    }
