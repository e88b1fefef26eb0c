"""Problems in tables of names, numbers and texts: the form that study files, command line and page have in common."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin

import attrs

from roughcontact._base.archive.plain import parts
from roughcontact._base.arrays import Pair
from roughcontact._base.checks import INFINITE, Part
from roughcontact._base.registry import Registry, list_fields, registries
from roughcontact._base.units import parse_quantity
from roughcontact._parts.files import list_reader_options, read_surface
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.materials import materials, resolve_material
from roughcontact._parts.surfaces import HeightMap, Surface, SurfaceSum, match, surfaces
from roughcontact._solve.problem import Body, ContactProblem, require_memory_of_solve
from roughcontact._work.studies.coatings import complete_kernel, read_layers
from roughcontact.errors import InputError, MissingPackage
from roughcontact.errors.door import guarded

T = TypeVar("T")

# Arguments of `read_surface` beside the path and the options of readers, of `match` beside both maps, and of a filter.
_OF_READING = tuple(inspect.signature(read_surface).parameters)[1:-1]
_OF_MATCH = tuple(inspect.signature(match).parameters)[2:]
_OF_FILTER = ("shortest", "longest", "robust")
_LENGTHS_OF_MAPS = ("size", "cell", "unit", "offset", "tip_radius", "shortest", "longest")
_UNITS_OF_MAPS = {**dict.fromkeys(_LENGTHS_OF_MAPS, "m"), "rotation": "rad"}


class Form:
    """Reads tables, and notes what is wrong in them.

    Parameters
    ----------
    folder
        The folder in which, or below which, the height maps lie; None if tables may not name files.

    Attributes
    ----------
    faults
        The place of each wrong entry, such as ``"body.material.young"``, and what is wrong with it.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder
        self.faults: list[tuple[str, InputError]] = []

    def read(self, kind: Any, value: Any, place: str, unit: str | None = None) -> Any:
        """Return what an entry describes; None if it is wrong.

        Parameters
        ----------
        kind
            The class, or the annotation of a field.
        value
            An instance; the registered name of a part, or a table with the name as ``type`` and its fields; a table of
            the fields of another class; a number or a text.
        place
            The place of the entry.
        unit
            SI unit of the texts that stand for numbers; None if texts do not.
        """
        try:
            return self._read(kind, value, place) if unit is None else self._convert(unit, value)
        except InputError as error:
            self.faults.append((place, error))
        except MissingPackage:
            raise
        # A part of a plug-in may raise anything.
        except Exception as error:
            self.faults.append((place, InputError(f"not accepted ({error})")))
        return None

    def _read(self, kind: Any, value: Any, place: str) -> Any:
        if _is_union(kind):
            members = [one for one in get_args(kind) if one is not NoneType]
            if value is None or (value == "auto" and str in members):
                return value
            if isinstance(value, (int, float)) and float in members:
                return value
            if isinstance(value, tuple(one for one in members if isinstance(one, type) and _has_form(one))):
                return value
            kind = next(filter(_has_form, members), members[0])
        kind = _without_arguments(kind)
        if not _has_form(kind):
            return self._read_plain(kind, value)
        if not isinstance(kind, type):
            return self._read_several(kind, value, place)
        if isinstance(value, kind):
            return value
        registry = _registry_of(kind)
        if registry is not None:
            return self._read_part(registry, value, place)
        if _is_inner_part(kind) and isinstance(value, Mapping) and "type" in value:
            return self._read_inner_part(kind, value, place)
        if not attrs.has(kind):
            return value
        if not isinstance(value, Mapping):
            raise InputError.about(f"A {kind.__name__}", value, "a table of its fields")
        if kind is ContactProblem:
            return self._read_problem(value, place)
        return self._read_fields(kind, value, place)

    def _read_problem(self, table: Mapping[str, Any], place: str) -> ContactProblem | None:
        """Return a problem, of which layers on the bodies are the kernel."""
        before = len(self.faults)

        def read(kind: Any, value: Any, inner: str) -> Any:
            return self.read(kind, value, join(place, inner))

        table = read_layers(table, read)
        if "kernel" in table:
            table = {**table, "kernel": complete_kernel(table["kernel"], read, table)}
        if len(self.faults) > before:
            return None
        return self._read_matched(table, place) if "match" in table else self._read_fields(ContactProblem, table, place)

    def _read_plain(self, kind: Any, value: Any) -> Any:
        """Return a value as its class takes it; on the command line numbers are texts."""
        if kind is int and isinstance(value, str) and value.isdecimal():
            return int(value)
        return self._convert("", value) if kind in (float, Pair) else value

    def _convert(self, unit: str, value: Any) -> Any:
        """Return a text with a unit, or a list of them, in SI units; numbers are."""
        if isinstance(value, list):
            return [self._convert(unit, item) for item in value]
        # The class knows whether it may be infinite.
        if not isinstance(value, str) or value == INFINITE:
            return value
        try:
            return parse_quantity(value, unit)
        except ValueError as error:
            numbers = f", or as a number in {unit}" if unit and self.folder is not None else ""
            raise InputError(f"{error}{numbers}") from error

    def _in_si_of_maps(self, name: str, value: Any) -> Any:
        if name not in _UNITS_OF_MAPS:
            return value
        try:
            return self._convert(_UNITS_OF_MAPS[name], value)
        except InputError as error:
            raise InputError(f"The {name} of a map: {error}.") from error

    def _read_several(self, kind: Any, value: Any, place: str) -> Any:
        """Return the items of a mapping or a sequence of parts."""
        item = _item_of(kind)
        if issubclass(get_origin(kind), Mapping):
            if not isinstance(value, Mapping):
                raise InputError.about(f"The entry {place}", value, "a table")
            return {name: self.read(item, one, join(place, name)) for name, one in value.items()}
        if not isinstance(value, (list, tuple)):
            raise InputError.about(f"The entry {place}", value, "a list")
        return tuple(self.read(item, one, f"{place}[{index}]") for index, one in enumerate(value))

    def _read_part(self, registry: Registry[Any], value: Any, place: str) -> Any:
        if registry is materials and isinstance(value, str):
            return resolve_material(value)
        name, fields = _name_and_fields(value, registry)
        if name == "file" and registry is surfaces:
            return self._read_map(fields)
        return self._read_fields(registry[name], fields, place)

    def _read_inner_part(self, base: type, value: Mapping[str, Any], place: str) -> Any:
        """Return a part of a base that has no registry of its own, such as the hardening of a material."""
        name, fields = _name_and_fields(value, parts)
        cls = parts[name]
        # Whoever asks for a protocol checks it itself.
        if issubclass(base, Part) and not issubclass(cls, base):
            raise InputError.about(f"A {base.__name__}", name, "the registered name of one")
        return self._read_fields(cls, fields, place)

    def _read_fields(self, cls: type[T], table: Mapping[str, Any], place: str) -> T | None:
        """Return an instance of a class from its fields; None, with the faults noted, if one is wrong."""
        known = list_fields(cls)
        before = len(self.faults)
        unknown = [name for name in table if name not in known]
        if unknown:
            self.faults.append((place, InputError(_name_unknown(unknown, known))))
        for name, field in known.items():
            if field.is_needed and name not in table:
                self.faults.append((place, InputError(f"required field {name!r} is missing")))
        values = {
            name: self.read(field.kind, table[name], join(place, name), field.text_unit)
            for name, field in known.items()
            if name in table
        }
        return cls(**values) if len(self.faults) == before else None

    def _read_matched(self, table: Mapping[str, Any], place: str) -> ContactProblem | None:
        """Return a problem whose two height maps are interpolated on a common grid."""
        settings = table["match"]
        if not isinstance(settings, Mapping):
            raise InputError.about("The entry 'match'", settings, f"a table with some of {', '.join(_OF_MATCH)}")
        _refuse_unknown(settings, _OF_MATCH)
        before = len(self.faults)
        bodies = {}
        for name in ("body", "counterbody"):
            if name not in table:
                raise InputError(f"Maps are matched in pairs: the {name} is missing.")
            bodies[name] = self.read(Body, table[name], join(place, name))
        if len(self.faults) > before:
            return None
        maps = {name: _only_map(body.surface, name) for name, body in bodies.items()}
        pair = match(*maps.values(), **{name: self._in_si_of_maps(name, value) for name, value in settings.items()})
        placed = {"body": pair.body, "counterbody": pair.counterbody}
        changed = {
            name: attrs.evolve(body, surface=_replace(body.surface, maps[name], placed[name]))
            for name, body in bodies.items()
        }
        others = {name: value for name, value in table.items() if name != "match"}
        return self._read_fields(ContactProblem, {**others, **changed, "grid": table.get("grid", pair.grid)}, place)

    def _read_map(self, fields: Mapping[str, Any]) -> HeightMap:
        reading = (*_OF_READING, *list_reader_options())
        _refuse_unknown(fields, ("path", *reading, "tip_radius", "detrend", *_OF_FILTER, "resample"))
        path = fields.get("path")
        if self.folder is None:
            raise InputError("Only a study file names files of height maps.")
        file = (self.folder / str(path)).resolve()
        if not isinstance(path, str) or not file.is_relative_to(self.folder.resolve()):
            raise InputError.about("The path of a map", path, "that of a file in the folder of the study file")
        given = {name: self._in_si_of_maps(name, fields[name]) for name in reading if name in fields}
        surface = read_surface(file, **given)
        if "tip_radius" in fields:
            surface = surface.restored(self._in_si_of_maps("tip_radius", fields["tip_radius"]))
        if "detrend" in fields:
            surface = surface.detrend(fields["detrend"])
        if chosen := {name: self._in_si_of_maps(name, fields[name]) for name in _OF_FILTER if name in fields}:
            surface = surface.filtered(**chosen)
        if "resample" not in fields:
            return surface
        # A map that is too large to be solved on is not made; this boundary needs less than the others.
        require_memory_of_solve(Grid(fields["resample"], surface.size), Boundary.PERIODIC)
        return surface.resample(fields["resample"])


@guarded
def build_problem(table: Mapping[str, Any]) -> ContactProblem:
    """Return the problem that a table of the arguments of `ContactProblem` describes.

    Parameters
    ----------
    table
        The arguments by name: objects, or names, numbers and texts as in a study file. ``match``, the arguments of
        `roughcontact.match`, interpolates the height maps of both bodies on a common grid.

    Raises
    ------
    InputError
        If an entry is wrong; the first one that is.

    Examples
    --------
    >>> from roughcontact.faces import build_problem
    >>> ball = {"surface": {"type": "sphere", "radius": "1 mm"}, "material": "bearing steel"}
    >>> build_problem({"body": ball, "grid": {"shape": [32, 32], "size": "100 um"}})
    <ContactProblem 32 x 32 cells on 100 µm x 100 µm, free: SphereSurface on FlatSurface>
    """
    form = Form()
    problem: ContactProblem = form.read(ContactProblem, table, "")
    if form.faults:
        error = form.faults[0][1]
        is_sentence = str(error).endswith((".", "..."))
        raise error if is_sentence else InputError(f"The table of the problem cannot be used: {error.marked}.")
    return problem


@guarded
def find_parts(kind: Any) -> dict[str, type]:
    """Return the classes that a field of a part may hold, by registered name; empty where it holds no part.

    A class that is of no registered kind, such as the hardening of a material, may be listed under the entry points
    ``roughcontact.parts``. Plug-ins that cannot be loaded are omitted.

    Parameters
    ----------
    kind
        The type by which the field is annotated: `PartField.kind`.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rc.faces.find_parts(rc.Surface)["sphere"].__name__
    'SphereSurface'
    """
    members = [one for one in get_args(kind) if one is not NoneType] if _is_union(kind) else [kind]
    found = {}
    for base in (one for one in members if isinstance(one, type) and get_origin(one) is None):
        registry = _registry_of(base)
        if registry is None and not _is_inner_part(base):
            continue
        for name in parts if registry is None else registry:
            with suppress(InputError):
                cls = parts[name] if registry is None else registry[name]
                if issubclass(cls, base):
                    found[name] = cls
    return found


def _is_union(kind: Any) -> bool:
    return get_origin(kind) in (Union, UnionType)


def join(place: str, name: str) -> str:
    """Return the place of an entry of a table."""
    return f"{place}.{name}" if place else name


def guess(name: str, known: Iterable[str]) -> str:
    """Return in brackets the known name that is meant, or all of them."""
    names = list(known)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    return f" (did you mean {close[0]!r}?)" if close else f" (known: {', '.join(names)})"


def _name_unknown(unknown: Iterable[str], known: Iterable[str]) -> str:
    names = list(known)
    return ", ".join(f"unknown field {name!r}{guess(str(name), names)}" for name in sorted(map(str, unknown)))


def _refuse_unknown(table: Mapping[str, Any], known: Iterable[str]) -> None:
    if unknown := [name for name in table if name not in known]:
        raise InputError(_name_unknown(unknown, known))


def _has_form(kind: Any) -> bool:
    """Return whether an annotation asks for a part, a class with fields, or several of them."""
    kind = _without_arguments(kind)
    if isinstance(kind, type) and get_origin(kind) is None:
        return _registry_of(kind) is not None or attrs.has(kind) or _is_inner_part(kind)
    return _item_of(kind) is not None and _has_form(_item_of(kind))


def _is_inner_part(kind: type) -> bool:
    """Return whether parts that are fields of others, and have no registry of their own, are of a class."""
    return issubclass(kind, Part) or getattr(kind, "_is_protocol", False)


def _without_arguments(kind: Any) -> Any:
    """Return the class of parts without what it is parametrized by, such as `Response` for ``Response[Any]``."""
    origin = get_origin(kind)
    return origin if isinstance(origin, type) and _registry_of(origin) is not None else kind


def _item_of(kind: Any) -> Any:
    """Return the annotation of the items of a mapping or a sequence, None of something else."""
    origin = get_origin(kind)
    arguments = [one for one in get_args(kind) if one is not Ellipsis]
    return arguments[-1] if isinstance(origin, type) and issubclass(origin, Iterable) and arguments else None


def _registry_of(kind: type) -> Registry[Any] | None:
    """Return the registry of a class: that of the nearest base, since an area estimator is a response too."""
    fitting = [one for one in registries().values() if one.base is not object and issubclass(kind, one.base)]
    return max(fitting, key=lambda one: len(one.base.__mro__), default=None)


def _name_and_fields(value: Any, registry: Registry[Any]) -> tuple[str, Mapping[str, Any]]:
    """Return the registered name and the fields of an entry."""
    if isinstance(value, str):
        return value, {}
    if registry is materials and isinstance(value, Mapping) and "type" not in value:
        return ("elastic-perfectly-plastic" if "hardness" in value else "elastic"), value
    if not isinstance(value, Mapping) or not isinstance(value.get("type"), str):
        raise InputError.about(f"A {registry.kind}", value, "a registered name, or a table with the name as type")
    return value["type"], {name: item for name, item in value.items() if name != "type"}


def _only_map(surface: Surface, name: str) -> HeightMap:
    maps = [part for part in (surface, *surface.parts) if isinstance(part, HeightMap)]
    if len(maps) != 1:
        raise InputError(f"Maps are matched in pairs: the {name} has {len(maps)} height maps.")
    return maps[0]


def _replace(surface: Surface, part: Surface, other: Surface) -> Surface:
    """Return a surface, or a sum of surfaces, with another part."""
    if surface is part:
        return other
    return SurfaceSum(tuple(other if one is part else one for one in surface.parts))
