"""Laws for finite-element codes: Abaqus, Ansys, CalculiX, COMSOL and MOOSE."""

from __future__ import annotations

import re
import textwrap

import attrs
import numpy as np

from roughcontact._answers.laws.columns import ColumnTable, LawTable
from roughcontact._base.arrays import Array
from roughcontact._base.checks import choice, flag, number
from roughcontact.errors import InputError

THERMAL_UNIT = "W/(m2 K)"
ELECTRICAL_UNIT = "S/m2"
# Characters of a line of a comment.
_COMMENT_WIDTH = 100
# Marks of comments in the files of Abaqus and CalculiX, of Ansys, of MOOSE, and of COMSOL.
_KEYWORD_COMMENT = "**"
_ANSYS_COMMENT = "!"
_MOOSE_COMMENT = "#"
_COMSOL_COMMENT = "%"
# Difference of overclosures, in units of the model, up to which CalculiX changes the second one.
_MIN_OVERCLOSURE_STEP = 1e-10
# Temperature of all rows, K: a table at one temperature holds at all temperatures.
_TEMPERATURE = "293."
# Place of the thermal contact conductance among the real constants of contact elements of Ansys.
_ANSYS_CONSTANT = 14


@attrs.frozen
class UnitSystem:
    """Units of a file: the name of each, and the factor by which an SI value is multiplied.

    Attributes
    ----------
    length, pressure, conductance
        Of lengths, m; pressures, Pa; thermal conductances over area, W/(m2 K).
    """

    length: tuple[str, float]
    pressure: tuple[str, float]
    conductance: tuple[str, float]

    def find_conductance(self, electrical: bool) -> tuple[str, float]:
        """Return the unit of conductances over area: electrical ones are in S over the area in units of the model."""
        return (f"S/{self.length[0]}2", self.length[1] ** -2) if electrical else self.conductance


_UNIT_SYSTEMS = {
    "SI": UnitSystem(("m", 1.0), ("Pa", 1.0), (THERMAL_UNIT, 1.0)),
    "mm": UnitSystem(("mm", 1e3), ("MPa", 1e-6), ("mW/(mm2 K)", 1e-3)),
}


def unit_system(name: str) -> UnitSystem:
    """Return a system of units by its name, ``"SI"`` or ``"mm"``."""
    return _UNIT_SYSTEMS[choice(name, "The units of the file", tuple(_UNIT_SYSTEMS))]


def keyword_name(name: object) -> str:
    """Return the name of a surface interaction, or raise `InputError` unless the programs take it as a label."""
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,79}", name):
        raise InputError.about("The name", name, "a letter, then up to 79 letters, digits, - or _")
    return name


def describe(law: ColumnTable, mark: str) -> list[str]:
    """Return what was solved and the warnings, as comments."""
    texts = [*law.description, *(f"Warning: {text}" for text in law.warnings)]
    return [f"{mark} {line}" for text in texts for line in textwrap.wrap(text, _COMMENT_WIDTH)]


def find_conductance(law: LawTable, column: str | None) -> str | None:
    """Return the column of the conductance; None if there is none to write: only the default column may be absent."""
    if column is None or (column == "conductance" and column not in law.columns):
        return None
    # `InputError` for a name that the law does not have.
    _ = law[column]
    return column


def require_thermal(law: LawTable, column: str, program: str) -> None:
    """Raise `InputError` unless a column is a thermal conductance, which alone a program takes."""
    if law[column].unit != THERMAL_UNIT:
        raise InputError(f"{program} takes a thermal conductance, in {THERMAL_UNIT}, not the column {column!r}.")


def tabulate_conductance(
    law: LawTable, column: str, mark: str, system: UnitSystem, *, electrical: bool = False
) -> tuple[Array, Array, list[str]]:
    """Return pressures, conductances over nominal area, both from zero on, and comments with their uncertainties."""
    found = law[column]
    if found.unit not in (THERMAL_UNIT, ELECTRICAL_UNIT):
        raise InputError(f"The column {column!r} is in {found.unit or 'no unit'}: a conductance is in {THERMAL_UNIT}.")
    _require_finite(law, column)
    unit, factor = system.find_conductance(electrical)
    pressures = np.append(0.0, law.pressures) * system.pressure[1]
    values, spread = (np.append(0.0, numbers) * factor for numbers in (found.values, found.uncertainties))
    heading = f"pressure in {system.pressure[0]}, conductance in {unit}, one standard deviation"
    return pressures, values, list_uncertainties(mark, heading, (pressures, values, spread))


def closure_rows(law: LawTable) -> tuple[Array, Array, Array, float]:
    r"""Return pressures, overclosures, their uncertainties and the mean gap where the overclosure is zero, SI.

    The overclosure is a constant less the mean gap. The mean gap of a rough surface grows without end as the pressure
    goes to zero: the tangent at the lowest load meets zero pressure at the gap :math:`\bar u + p / k`, from which the
    overclosure counts.
    """
    gap = law["mean_gap"].values
    if gap.size < 2:
        raise InputError("A table of pressure over closure needs at least two loads.")
    _require_finite(law, "mean_gap")
    if not (np.diff(gap) < 0.0).all():
        raise InputError(
            "The mean gap does not fall from load to load: solve with a smaller tolerance, or fewer loads."
        )
    pressures = law.pressures
    stiffness = law.columns.get("stiffness")
    slope = float((pressures[1] - pressures[0]) / (gap[0] - gap[1]))
    if stiffness is not None and stiffness.unit == "Pa/m" and 0.0 < stiffness.values[0] < np.inf:
        slope = float(stiffness.values[0])
    datum = float(gap[0] + pressures[0] / slope)
    spread = law["mean_gap"].uncertainties
    return np.append(0.0, pressures), np.append(0.0, datum - gap), np.append(0.0, spread), datum


def list_uncertainties(mark: str, heading: str, columns: tuple[Array, ...]) -> list[str]:
    """Return numbers as comments: a heading, and a line for each load."""
    rows = [", ".join(f"{value:.6e}" for value in row) for row in zip(*columns, strict=True)]
    return [f"{mark} {heading}", *(f"{mark} {row}" for row in rows)]


def _require_finite(law: LawTable, name: str) -> None:
    values = law[name].values
    if not np.isfinite(values).all():
        pressure = float(law.pressures[np.flatnonzero(~np.isfinite(values))[0]])
        raise InputError(f"The column {name!r} is not finite at {pressure:g} Pa, in full contact: omit such loads.")


def write_abaqus(law: LawTable, name: str, conductance: str | None, electrical: bool, units: str) -> list[str]:
    """Return the lines of a surface interaction.

    References
    ----------
    Abaqus Keywords Guide (2017), *SURFACE BEHAVIOR and *GAP CONDUCTANCE,
    https://abaqus-docs.mit.edu/2017/English/SIMACAEKEYRefMap/simakey-r-gapconductance.htm
    """
    lines = [
        *describe(law, _KEYWORD_COMMENT),
        f"*SURFACE INTERACTION, NAME={keyword_name(name)}",
        *write_closure(law, units),
    ]
    conductance = find_conductance(law, conductance)
    if conductance is None:
        return lines
    system = unit_system(units)
    electrical = flag(electrical, "electrical=") or law[conductance].unit == ELECTRICAL_UNIT
    pressures, values, comments = tabulate_conductance(
        law, conductance, _KEYWORD_COMMENT, system, electrical=electrical
    )
    keyword = "*GAP ELECTRICAL CONDUCTANCE" if electrical else "*GAP CONDUCTANCE"
    return [
        *lines,
        *comments,
        f"{keyword}, PRESSURE",
        *(f"{value:.9e}, {pressure:.9e}" for value, pressure in zip(values, pressures, strict=True)),
    ]


def write_closure(law: LawTable, units: str, separator: str = ", ", smallest: float = 0.0) -> list[str]:
    """Return the lines of the pressure over closure, without rows whose closure grows by less than `smallest`."""
    system = unit_system(units)
    unit, scale = system.length
    pressures, closures, spread, datum = closure_rows(law)
    rows = [(0.0, 0.0, 0.0)]
    for pressure, closure, std in zip(
        pressures[1:] * system.pressure[1], closures[1:] * scale, spread[1:], strict=True
    ):
        if closure - rows[-1][1] > smallest:
            rows.append((float(pressure), float(closure), float(std * scale)))
    columns = tuple(zip(*rows, strict=True))
    heading = f"pressure in {system.pressure[0]}, overclosure in {unit}, one standard deviation"
    return [
        f"{_KEYWORD_COMMENT} Overclosure 0 is at a mean gap of {datum * scale:.6e} {unit}, where the tangent at the",
        f"{_KEYWORD_COMMENT} lowest load meets zero pressure: below that load the gap of a rough surface widens "
        "without end.",
        *list_uncertainties(_KEYWORD_COMMENT, heading, columns),  # type: ignore[arg-type]
        f"*SURFACE BEHAVIOR,{separator[1:]}PRESSURE-OVERCLOSURE=TABULAR",
        *(f"{pressure:.9e}{separator}{closure:.9e}" for pressure, closure, _ in rows),
    ]


def write_calculix(law: LawTable, name: str, conductance: str | None, units: str) -> list[str]:
    """Return the lines of a surface interaction.

    CalculiX takes the conductance over the pressure without a keyword parameter. It follows the surface behavior, and
    stands before the first step.

    References
    ----------
    Dhondt, CalculiX CrunchiX User's Manual 2.17, *GAP CONDUCTANCE and *SURFACE BEHAVIOR,
    https://ccx.openaircraft.com/ccx-doc/ccx_2.17/doc/ccx/node315.html
    """
    lines = [
        *describe(law, _KEYWORD_COMMENT),
        f"{_KEYWORD_COMMENT} Include this file before the first step.",
        f"*SURFACE INTERACTION,NAME={keyword_name(name)}",
        *write_closure(law, units, separator=",", smallest=_MIN_OVERCLOSURE_STEP),
    ]
    conductance = find_conductance(law, conductance)
    if conductance is None:
        return lines
    require_thermal(law, conductance, "CalculiX")
    pressures, values, comments = tabulate_conductance(law, conductance, _KEYWORD_COMMENT, unit_system(units))
    return [
        *lines,
        *comments,
        "*GAP CONDUCTANCE",
        *(f"{v:.9e},{p:.9e},{_TEMPERATURE}" for v, p in zip(values, pressures, strict=True)),
    ]


def write_ansys(law: LawTable, name: str, column: str, units: str) -> list[str]:
    """Return the commands that make a table and give it to contact elements.

    References
    ----------
    Ansys Mechanical APDL 2023 R2, *DIM,
    https://ansyshelp.ansys.com/Views/Secured/corp/v232/en//ans_cmd/Hlp_C_DIM.html; release 18.2, RMODIF and R,
    https://mm.bme.hu/~gyebro/files/ans_help_v182/ans_cmd/Hlp_C_RMODIF.html
    """
    system = unit_system(units)
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,31}", name):
        raise InputError.about("The name of the table", name, "a letter, then up to 31 letters, digits or _")
    require_thermal(law, column, "The file for Ansys")
    pressures, values, comments = tabulate_conductance(law, column, _ANSYS_COMMENT, system)
    return [
        *describe(law, _ANSYS_COMMENT),
        *comments,
        f"{_ANSYS_COMMENT} cid is the number of the real constants of the contact elements (CONTA172, 174, 175). In a",
        f"{_ANSYS_COMMENT} command object of Workbench below the contact it is known; elsewhere set it first.",
        f"*DIM,{name},TABLE,{pressures.size},1,1,PRESSURE",
        *(f"{name}({row},0)={pressure:.9e}" for row, pressure in enumerate(pressures, 1)),
        *(f"{name}({row},1)={value:.9e}" for row, value in enumerate(values, 1)),
        f"RMODIF,cid,{_ANSYS_CONSTANT},%{name}%",
    ]


def write_moose(
    law: LawTable, file: str, name: str, column: str, min_gap: float, units: str
) -> tuple[list[str], list[str]]:
    """Return the lines of the table and of the blocks.

    In a closed gap MOOSE divides the conductivity by `min_gap`, so that the function times `min_gap` is the
    conductivity. It is zero at zero pressure: nothing is conducted where the bodies do not touch.

    References
    ----------
    MOOSE, PiecewiseLinear, https://mooseframework.inl.gov/source/functions/PiecewiseLinear.html;
    ThermalContact, https://mooseframework.inl.gov/modules/heat_transfer/index.html
    """
    system = unit_system(units)
    name = keyword_name(name)
    require_thermal(law, column, "The thermal contact of MOOSE")
    gap = number(min_gap, "The smallest gap", "m", above=0.0) * system.length[1]
    pressures, values, comments = tabulate_conductance(law, column, _MOOSE_COMMENT, system)
    table = [*describe(law, _MOOSE_COMMENT), *comments]
    table += [f"{pressure:.9e},{value:.9e}" for pressure, value in zip(pressures, values, strict=True)]
    blocks = [
        f"{_MOOSE_COMMENT} The conductance over the contact pressure, in {system.conductance[0]} "
        f"and {system.pressure[0]};",
        f"{_MOOSE_COMMENT} above the last pressure it is constant. Replace temp, contact_pressure",
        f"{_MOOSE_COMMENT} and the two boundaries by the names of the model.",
        "[Functions]",
        f"  [{name}]",
        "    type = PiecewiseLinear",
        f"    data_file = {file}",
        "    format = columns",
        f"    scale_factor = {gap:.9e}  {_MOOSE_COMMENT} min_gap, by which the contact divides",
        "  []",
        "[]",
        "[ThermalContact]",
        f"  [{name}]",
        "    type = GapHeatTransfer",
        "    variable = temp",
        "    primary = primary_boundary",
        "    secondary = secondary_boundary",
        "    quadrature = true",
        "    gap_conductivity = 1",
        f"    gap_conductivity_function = {name}",
        "    gap_conductivity_function_variable = contact_pressure",
        f"    min_gap = {gap:.9e}",
        "    emissivity_primary = 0",
        "    emissivity_secondary = 0",
        "  []",
        "[]",
    ]
    return table, blocks


def write_comsol(law: LawTable, table: str, conductance: str, units: str) -> list[str]:
    """Return the lines of an interpolation function: columns of its argument and its value.

    References
    ----------
    COMSOL Multiphysics Reference Manual 6.1, Spreadsheet Data Format,
    https://doc.comsol.com/6.1/doc/com.comsol.help.comsol/comsol_api_fileformats.53.04.html
    """
    system = unit_system(units)
    head = describe(law, _COMSOL_COMMENT)
    if choice(table, "The table", ("conductance", "closure")) == "conductance":
        electrical = law[conductance].unit == ELECTRICAL_UNIT
        found, values, comments = tabulate_conductance(law, conductance, _COMSOL_COMMENT, system, electrical=electrical)
        unit = system.find_conductance(electrical)[0]
        named = f"Argument: contact pressure in {system.pressure[0]}; function: conductance in {unit}"
    else:
        pressures, closures, spread, datum = closure_rows(law)
        found = closures * system.length[1]
        values = pressures * system.pressure[1]
        heading = f"overclosure in {system.length[0]}, its standard deviation"
        comments = [
            f"{_COMSOL_COMMENT} Overclosure 0 is at a mean gap of {datum * system.length[1]:.6e} {system.length[0]}.",
            *list_uncertainties(_COMSOL_COMMENT, heading, (found, spread * system.length[1])),
        ]
        named = f"Argument: overclosure in {system.length[0]}; function: pressure in {system.pressure[0]}"
    rows = (f"{one:.9e} {other:.9e}" for one, other in zip(found, values, strict=True))
    return [*head, *comments, f"{_COMSOL_COMMENT} {named}", *rows]
