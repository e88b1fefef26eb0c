"""Surface interactions of Abaqus."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact._answers.laws.tables import (
    ELECTRICAL,
    closure_rows,
    conductance_rows,
    describe,
    find_conductance,
    keyword_name,
    list_uncertainties,
    unit_system,
)
from roughcontact._base.checks import flag

if TYPE_CHECKING:
    from roughcontact._answers.laws.law import InterfaceLaw

_MARK = "**"


def write_interaction(law: InterfaceLaw, name: str, conductance: str | None, electrical: bool, units: str) -> list[str]:
    """Return the lines of a surface interaction.

    References
    ----------
    Abaqus Keywords Guide (2017), *SURFACE BEHAVIOR and *GAP CONDUCTANCE,
    https://abaqus-docs.mit.edu/2017/English/SIMACAEKEYRefMap/simakey-r-gapconductance.htm
    """
    lines = [*describe(law, _MARK), f"*SURFACE INTERACTION, NAME={keyword_name(name)}", *write_closure(law, units)]
    conductance = find_conductance(law, conductance)
    if conductance is None:
        return lines
    system = unit_system(units)
    electrical = flag(electrical, "electrical=") or law[conductance].unit == ELECTRICAL
    # Abaqus takes no unit of current beside those of its model: electrical conductances are those of SI per area.
    unit, factor = (f"S/{system.length[0]}2", system.length[1] ** -2) if electrical else system.conductance
    pressures, values, spread = conductance_rows(law, conductance)
    pressures = pressures * system.pressure[1]
    heading = f"pressure in {system.pressure[0]}, conductance in {unit}, one standard deviation"
    keyword = "*GAP ELECTRICAL CONDUCTANCE" if electrical else "*GAP CONDUCTANCE"
    return [
        *lines,
        *list_uncertainties(law, _MARK, heading, (pressures, values * factor, spread * factor)),
        f"{keyword}, PRESSURE",
        *(f"{value * factor:.9e}, {pressure:.9e}" for value, pressure in zip(values, pressures, strict=True)),
    ]


def write_closure(law: InterfaceLaw, units: str, separator: str = ", ", smallest: float = 0.0) -> list[str]:
    """Return the lines of the pressure over closure; rows by less than `smallest` above the one before are omitted."""
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
        f"{_MARK} Overclosure 0 is at a mean gap of {datum * scale:.6e} {unit}, where the tangent at the",
        f"{_MARK} lowest load meets zero pressure: below that load the gap of a rough surface widens without end.",
        *list_uncertainties(law, _MARK, heading, columns),  # type: ignore[arg-type]
        f"*SURFACE BEHAVIOR,{separator[1:]}PRESSURE-OVERCLOSURE=TABULAR",
        *(f"{pressure:.9e}{separator}{closure:.9e}" for pressure, closure, _ in rows),
    ]
