"""Study files: TOML structured into a `Study` by cattrs and the registries."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin

import attrs
from cattrs import ClassValidationError, Converter, ForbiddenExtraKeysError, IterableValidationError, transform_error
from cattrs.gen import make_dict_structure_fn, override

from roughcontact._base import checks
from roughcontact._base.registry import Registry
from roughcontact._base.units import parse_quantity
from roughcontact._parts.files import read_surface
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.interactions import interactions
from roughcontact._parts.kernels import kernels
from roughcontact._parts.materials import TYPICAL, Material, materials, resolve_material
from roughcontact._parts.surfaces import HeightMap, Surface, surfaces
from roughcontact._solve.convolvers import convolvers
from roughcontact._solve.problem import ContactProblem, require_memory_of_solve
from roughcontact._solve.solvers import solvers
from roughcontact._work.studies.study import Study
from roughcontact.errors import InputError

_REGISTRIES: tuple[Registry[Any], ...] = (surfaces, materials, kernels, interactions, convolvers, solvers)
_TABLES = ("problems", "study")
# Errors that are listed, and characters of each.
_SHOWN = 10
_TEXT = 500
# A key of more than 64 parts, of words and of texts.
_LONG_KEY = re.compile(r"""(?<![\w-])(?:(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){64}""")
_READING = ("size", "non_measured", "unit", "reader", "separator", "decimal", "skip_rows", "rows", "variable", "page")
_OF_FILE = ("path", *_READING, "detrend", "resample")


def read_study(path: str | Path) -> Study:
    """Read a study from a TOML file.

    The tables ``[problems.NAME]`` hold the arguments of a `ContactProblem`, the table ``[study]`` those of
    a `Study`. Surfaces, materials, kernels, laws of adhesion, convolvers and solvers are registered names, or tables
    with the name as ``type`` and the fields of the class. A field whose attrs metadata name its SI ``unit`` may be a
    text with another one, such as ``"210GPa"``. A surface may also be a ``file``, with the arguments of
    `read_surface`, ``detrend`` and ``resample``; its path leads to the folder of the study file or below it.

    Raises
    ------
    InputError
        If there is no such file, it is not TOML, or an entry is wrong; the sentence gives its place.
    """
    file = checks.path(path, "The study file")
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}.")
    try:
        text = file.read_text(encoding="utf-8")
        # The parser takes the square of its length for a key of many parts.
        if _LONG_KEY.search(text):
            raise ValueError("a key has too many parts")
        raw = tomllib.loads(text)
    # Beside its own, the parser raises those of numbers with thousands of digits and of deep nesting.
    except (ValueError, RecursionError) as error:
        raise InputError(f"The file {file.name} is not TOML: {error}.") from error
    for name in raw:
        if name not in _TABLES:
            raise InputError(f"In {file.name}: unknown table{_guess(name, _TABLES)} @ {_short(name)}")
    for name in _TABLES:
        if not isinstance(raw.get(name), dict):
            raise InputError(f"In {file.name}: required table missing @ {name}")
    converter = _converter(file.parent)
    problems = _structure(converter, raw["problems"], dict[str, ContactProblem], "problems", file)
    study: Study = _structure(converter, {**raw["study"], "problems": problems}, Study, "study", file)
    return study


def _structure(converter: Converter, raw: Any, kind: Any, where: str, file: Path) -> Any:
    try:
        return converter.structure(raw, kind)
    except (ClassValidationError, IterableValidationError) as error:
        lines = [re.sub(r"\['([^']*)'\]", r".\1", line) for line in transform_error(error, where, _sentence)]
        shown = [_short(line) for line in dict.fromkeys(lines)]
        more = [f"and {len(shown) - _SHOWN} more"] if len(shown) > _SHOWN else []
        raise InputError(f"In {file.name}: " + "; ".join(shown[:_SHOWN] + more)) from error
    except InputError as error:
        raise InputError(f"In {file.name}: {error} @ {where}") from error


def _sentence(error: BaseException, _: type | None) -> str:
    if isinstance(error, KeyError):
        return "required field missing"
    if isinstance(error, ForbiddenExtraKeysError):
        known = [str(field.alias) for field in attrs.fields(error.cl)]
        return ", ".join(f"unknown field {name!r}{_guess(name, known)}" for name in sorted(error.extra_fields))
    if isinstance(error, InputError):
        return str(error)
    return f"not accepted ({error})"


def _short(text: str) -> str:
    return (text if text.isprintable() else ascii(text))[:_TEXT]


def _guess(name: str, known: Any) -> str:
    close = difflib.get_close_matches(name, list(known), n=1, cutoff=0.5)
    return f" (did you mean {close[0]!r}?)" if close else f" (known: {', '.join(known)})"


def _converter(folder: Path) -> Converter:
    converter = Converter(prefer_attrib_converters=True, forbid_extra_keys=True)
    converter.register_structure_hook_factory(attrs.has, partial(_structure_table, converter))
    for registry in _REGISTRIES:
        base = registry.base

        def hook(value: Any, _: Any, base: type = base, registry: Registry[Any] = registry) -> Any:
            name, fields = _name_and_fields(value, registry)
            if name == "file" and base is Surface:
                return _read_map(fields, folder)
            if name == "auto" and not fields:
                return name
            if name in TYPICAL and not fields and base is materials.base:
                return TYPICAL[name]
            cls = registry[name]
            if attrs.has(cls):
                return converter.structure(fields, cls)
            try:
                return cls(**fields)
            except TypeError as error:
                raise InputError(f"{cls.__name__} does not take these fields: {error}") from error

        converter.register_structure_hook_func(partial(_asks_for, base), hook)
    return converter


def _structure_table(converter: Converter, cls: Any) -> Callable[[Any, Any], Any]:
    quantities: dict[str, Any] = {
        field.name: override(struct_hook=partial(_in_si, field.metadata["unit"]))
        for field in attrs.fields(cls)
        if "unit" in field.metadata
    }
    # A converter of the field itself would be handed the table.
    materials_of = [field.name for field in attrs.fields(cls) if field.converter is resolve_material]
    quantities |= {name: override(struct_hook=partial(_structure_as, converter, Material)) for name in materials_of}
    make = make_dict_structure_fn(cls, converter, _cattrs_forbid_extra_keys=True, _cattrs_use_alias=True, **quantities)

    def structure(value: Any, kind: Any) -> Any:
        if not isinstance(value, dict):
            raise InputError.about(f"A {cls.__name__}", value, "a table of its fields")
        return make(value, kind)

    return structure


def _structure_as(converter: Converter, kind: Any, value: Any, _: Any) -> Any:
    return converter.structure(value, kind)


def _in_si(unit: str, value: Any, _: Any = None) -> Any:
    """Return a quantity with its unit, or a list of them, in SI units; plain numbers are."""
    if isinstance(value, list):
        return [_in_si(unit, item) for item in value]
    if not isinstance(value, str):
        return value
    try:
        return parse_quantity(value, unit)
    except ValueError as error:
        raise InputError(f"{error}, or as a number in {unit}" if unit else str(error)) from error


def _asks_for(base: type, kind: Any) -> bool:
    """Return whether a field is annotated with a base class, or with it or something else."""
    return kind is base or (get_origin(kind) in (Union, UnionType) and base in get_args(kind))


def _name_and_fields(value: Any, registry: Registry[Any]) -> tuple[str, dict[str, Any]]:
    """Return the registered name and the fields of an entry."""
    if isinstance(value, str):
        return value, {}
    if not isinstance(value, dict) or not isinstance(value.get("type"), str):
        raise InputError.about(f"A {registry.kind}", value, "a registered name, or a table with the name as type")
    return value["type"], {name: item for name, item in value.items() if name != "type"}


def _read_map(fields: dict[str, Any], folder: Path) -> HeightMap:
    if unknown := set(fields) - set(_OF_FILE):
        raise InputError(", ".join(f"unknown field {name!r}{_guess(name, _OF_FILE)}" for name in sorted(unknown)))
    path = fields.get("path")
    file = (folder / str(path)).resolve()
    if not isinstance(path, str) or not file.is_relative_to(folder.resolve()):
        raise InputError.about("The path of a map", path, "that of a file in the folder of the study file")
    given = {name: fields[name] for name in _READING if name in fields}
    for name in given.keys() & {"size", "unit"}:
        try:
            given[name] = _in_si("m", given[name])
        except InputError as error:
            raise InputError(f"The {name} of a map: {error}.") from error
    surface = read_surface(file, **given)
    if "detrend" in fields:
        surface = surface.detrend(fields["detrend"])
    if "resample" not in fields:
        return surface
    # A map that is too large to be solved on is not made; this boundary needs less than the others.
    require_memory_of_solve(Grid(fields["resample"], surface.size), Boundary.PERIODIC)
    return surface.resample(fields["resample"])
