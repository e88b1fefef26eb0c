"""Surface interactions of CalculiX."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact._answers.laws.abaqus import write_closure
from roughcontact._answers.laws.tables import (
    THERMAL,
    conductance_rows,
    describe,
    find_conductance,
    keyword_name,
    list_uncertainties,
    unit_system,
)
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._answers.laws.law import InterfaceLaw

_MARK = "**"
# Difference of overclosures, in units of the model, up to which CalculiX changes the second one.
_SMALLEST = 1e-10
# Temperature of all rows, K: the table of one temperature holds at all.
_TEMPERATURE = "293."


def write_interaction(law: InterfaceLaw, name: str, conductance: str | None, units: str) -> list[str]:
    """Return the lines of a surface interaction.

    The conductance is over the pressure without a parameter that says so, follows the surface behavior, and stands
    before the first step.

    References
    ----------
    Dhondt, CalculiX CrunchiX User's Manual 2.17, *GAP CONDUCTANCE and *SURFACE BEHAVIOR,
    https://ccx.openaircraft.com/ccx-doc/ccx_2.17/doc/ccx/node315.html
    """
    lines = [
        *describe(law, _MARK),
        f"{_MARK} Include this file before the first step.",
        f"*SURFACE INTERACTION,NAME={keyword_name(name)}",
        *write_closure(law, units, separator=",", smallest=_SMALLEST),
    ]
    conductance = find_conductance(law, conductance)
    if conductance is None:
        return lines
    if law[conductance].unit != THERMAL:
        raise InputError(f"CalculiX takes thermal conductances, in {THERMAL}, but {conductance!r} is another column.")
    system = unit_system(units)
    unit, factor = system.conductance
    pressures, values, spread = conductance_rows(law, conductance)
    pressures = pressures * system.pressure[1]
    heading = f"pressure in {system.pressure[0]}, conductance in {unit}, one standard deviation"
    return [
        *lines,
        *list_uncertainties(law, _MARK, heading, (pressures, values * factor, spread * factor)),
        "*GAP CONDUCTANCE",
        *(f"{v * factor:.9e},{p:.9e},{_TEMPERATURE}" for v, p in zip(values, pressures, strict=True)),
    ]
