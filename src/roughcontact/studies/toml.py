"""Study files: TOML made into frozen objects by cattrs and the registries."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin

import attrs
from cattrs import ClassValidationError, Converter, ForbiddenExtraKeysError, IterableValidationError, transform_error
from cattrs.gen import make_dict_structure_fn

from roughcontact.convolvers import Convolver
from roughcontact.errors import InputError
from roughcontact.files import read_surface
from roughcontact.kernels import InfluenceKernel
from roughcontact.materials import Material
from roughcontact.problem import ContactProblem
from roughcontact.registry import Registry, convolvers, kernels, materials, solvers, surfaces
from roughcontact.solvers import Solver
from roughcontact.studies.study import Study
from roughcontact.surfaces import HeightMap, Surface
from roughcontact.surfaces.sum import SurfaceSum

_REGISTRIES: dict[type, Registry] = {
    Surface: surfaces,
    Material: materials,
    InfluenceKernel: kernels,
    Convolver: convolvers,
    Solver: solvers,
}
_TABLES = ("problems", "study")
_SHAPED = ("detrend", "resample")


def read_study(path: str | Path) -> Study:
    """Read a study from a TOML file.

    The tables ``[problems.NAME]`` hold the arguments of a `ContactProblem`, the table ``[study]`` those of
    a `Study`. Surfaces, materials, kernels, convolvers and solvers are registered names, or tables with
    the name as ``type`` and the fields of the class. Beyond the registered ones a surface may be a
    ``file`` (the arguments of `read_surface`, with ``detrend`` and ``resample``; its path is relative to
    the study file) or a ``sum`` of ``parts``.

    Raises
    ------
    InputError
        If there is no such file, it is no TOML, or an entry is wrong; the sentence names its path in the
        file.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}.")
    try:
        raw = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"The file {file.name} is no TOML: {error}.") from error
    _require_tables(raw, file)
    converter = _converter(file.parent)
    problems = _structured(converter, raw["problems"], dict[str, ContactProblem], "problems", file)
    study: Study = _structured(converter, {**raw["study"], "problems": problems}, Study, "study", file)
    return study


def _require_tables(raw: Mapping[str, Any], file: Path) -> None:
    for name in raw:
        if name not in _TABLES:
            raise InputError(f"In {file.name}: unknown table{_guess(name, _TABLES)} @ {name}")
    for name in _TABLES:
        if not isinstance(raw.get(name), dict):
            raise InputError(f"In {file.name}: required table missing @ {name}")


def _structured(converter: Converter, raw: Any, kind: Any, where: str, file: Path) -> Any:
    try:
        return converter.structure(raw, kind)
    except (ClassValidationError, IterableValidationError) as error:
        lines = [re.sub(r"\['([^']*)'\]", r".\1", line) for line in transform_error(error, where, _said)]
        raise InputError(f"In {file.name}: " + "; ".join(dict.fromkeys(lines))) from error
    except InputError as error:
        raise InputError(f"In {file.name}: {error} @ {where}") from error


def _said(error: BaseException, _: type | None) -> str:
    if isinstance(error, KeyError):
        return "required field missing"
    if isinstance(error, ForbiddenExtraKeysError):
        known = [str(field.alias) for field in attrs.fields(error.cl)]
        return ", ".join(f"unknown field {name!r}{_guess(name, known)}" for name in sorted(error.extra_fields))
    if isinstance(error, InputError):
        return str(error)
    return f"not what it should be ({error})"


def _guess(name: str, known: Any) -> str:
    close = difflib.get_close_matches(name, list(known), n=1, cutoff=0.5)
    return f" (did you mean {close[0]!r}?)" if close else f" (known: {', '.join(known)})"


def _converter(folder: Path) -> Converter:
    converter = Converter(prefer_attrib_converters=True, forbid_extra_keys=True)
    converter.register_structure_hook_factory(
        attrs.has,
        lambda cls: make_dict_structure_fn(cls, converter, _cattrs_forbid_extra_keys=True, _cattrs_use_alias=True),
    )
    for base, registry in _REGISTRIES.items():
        special = {"file": _from_file, "sum": _sum} if base is Surface else {}

        def hook(value: Any, _: Any, base: type = base, registry: Registry = registry, special: Any = special) -> Any:
            name, fields = _named(value, registry)
            if name in special:
                return special[name](fields, converter, folder)
            if name == "auto" and not fields:
                return name
            cls = registry.get(name)
            return converter.structure(fields, cls) if attrs.has(cls) else _made(cls, fields)

        converter.register_structure_hook_func(partial(_asks_for, base), hook)
    return converter


def _asks_for(base: type, kind: Any) -> bool:
    """Tell whether a field is annotated with a base class, or with it or something else."""
    return kind is base or (get_origin(kind) in (Union, UnionType) and base in get_args(kind))


def _named(value: Any, registry: Registry) -> tuple[str, dict[str, Any]]:
    """Return the registered name and the fields of an entry."""
    if isinstance(value, str):
        return value, {}
    if not isinstance(value, dict) or not isinstance(value.get("type"), str):
        raise InputError.about(f"A {registry.kind}", value, "a registered name, or a table with the name as type")
    return value["type"], {name: item for name, item in value.items() if name != "type"}


def _made(cls: type, fields: dict[str, Any]) -> Any:
    try:
        return cls(**fields)
    except TypeError as error:
        raise InputError(f"{cls.__name__} does not take these fields: {error}") from error


def _from_file(fields: dict[str, Any], _: Converter, folder: Path) -> HeightMap:
    if not isinstance(fields.get("path"), str):
        raise InputError("A surface from a file needs its path")
    reading = {name: value for name, value in fields.items() if name not in ("path", *_SHAPED)}
    unknown = set(reading) - {"size", "missing", "unit", "reader"}
    if unknown:
        known = ("path", "size", "missing", "unit", "reader", *_SHAPED)
        raise InputError(", ".join(f"unknown field {name!r}{_guess(name, known)}" for name in sorted(unknown)))
    surface = read_surface(folder / fields["path"], **reading)
    if "detrend" in fields:
        surface = surface.detrend(fields["detrend"])
    return surface.resample(fields["resample"]) if "resample" in fields else surface


def _sum(fields: dict[str, Any], converter: Converter, _: Path) -> SurfaceSum:
    if set(fields) != {"parts"}:
        raise InputError(f"A sum of surfaces has one field, parts, but got {', '.join(sorted(fields)) or 'none'}")
    return SurfaceSum(tuple(converter.structure(fields["parts"], list[Surface])))
