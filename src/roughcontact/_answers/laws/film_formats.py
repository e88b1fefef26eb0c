"""Files of film laws that other programs read: two columns, JSON, and COMSOL's spreadsheet of several functions."""

from __future__ import annotations

from collections.abc import Sequence

from roughcontact._answers.laws.columns import ColumnTable
from roughcontact._answers.laws.formats import UnitSystem, describe, unit_system
from roughcontact._base.arrays import Array
from roughcontact._base.checks import list_of
from roughcontact._solve.problem import format_json
from roughcontact._solve.solution import versions
from roughcontact.errors import InputError

_TEXT_COMMENT = "#"
_COMSOL_COMMENT = "%"
# The version of the JSON files.
_VERSION = 1
_CLAMP = "Keep the last values beyond both ends; below the first separation the asperity pressure must not be kept."


def _convert(unit: str, system: UnitSystem) -> tuple[str, float]:
    """Return the unit of a column in a system of units, and the factor from SI."""
    known = {"m": system.length, "Pa": system.pressure}
    return known.get(unit, (unit, 1.0))


def _list_chosen(law: ColumnTable, columns: object) -> list[str]:
    """Return the columns that a file has: those that are chosen, or all."""
    if columns is None:
        return list(law.columns)
    return [law[name].name for name in list_of(columns, "The columns", "a list of names of columns")]


def _write_rows(heading: Sequence[str], columns: Sequence[Array]) -> list[str]:
    rows = (" ".join(f"{value:.9e}" for value in row) for row in zip(*columns, strict=True))
    return [" ".join(heading), *rows]


def tabulate_column(law: ColumnTable, separations: Array, name: str, units: str) -> list[str]:
    """Return a heading and two columns: the separation and one function."""
    system = unit_system(units)
    column = law[name]
    unit, factor = _convert(column.unit, system)
    length, scale = system.length
    heading = [f"{_TEXT_COMMENT} separation_{length}", f"{name}_{unit}" if unit else name]
    return _write_rows(heading, [separations * scale, column.values * factor])


def write_comsol(law: ColumnTable, separations: Array, columns: object, units: str) -> list[str]:
    """Return the lines of an interpolation function of several values: the separation, and a column for each.

    References
    ----------
    COMSOL Multiphysics Reference Manual, Spreadsheet Data Format,
    https://doc.comsol.com/6.1/doc/com.comsol.help.comsol/comsol_api_fileformats.53.04.html
    """
    system = unit_system(units)
    chosen = _list_chosen(law, columns)
    if not chosen:
        raise InputError("COMSOL's table needs a column: give columns=None for all.")
    length, scale = system.length
    converted = [(name, law[name].values, *_convert(law[name].unit, system)) for name in chosen]
    named = ", ".join(f"{name} in {unit}" if unit else name for name, _, unit, _ in converted)
    lines = [
        *describe(law, _COMSOL_COMMENT),
        f"{_COMSOL_COMMENT} {_CLAMP}",
        f"{_COMSOL_COMMENT} Argument: separation in {length}; functions: {named}",
    ]
    heading = [f"{_COMSOL_COMMENT} separation", *chosen]
    functions = (values * factor for _, values, _, factor in converted)
    return [*lines, *_write_rows(heading, [separations * scale, *functions])]


def write_json(law: ColumnTable, separations: Array, rms_heights: Sequence[float]) -> list[str]:
    """Return one JSON object, in SI units."""
    columns = [
        {
            "name": one.name,
            "unit": one.unit,
            "values": one.values.tolist(),
            "uncertainty_grid": one.uncertainties.tolist(),
            "uncertainty_sample": None if one.sampling is None else one.sampling.tolist(),
        }
        for one in law.columns.values()
    ]
    content = {
        "kind": "film law",
        "version": _VERSION,
        "description": list(law.description),
        "warnings": list(law.warnings),
        "rms_heights": {"unit": "m", "values": list(rms_heights)},
        "separation": {"unit": "m", "values": separations.tolist()},
        "columns": columns,
        "versions": versions(),
    }
    return [format_json(content)]
