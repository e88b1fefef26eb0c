"""A function and a thermal contact of MOOSE."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact._answers.laws.tables import (
    THERMAL,
    conductance_rows,
    describe,
    keyword_name,
    list_uncertainties,
    unit_system,
)
from roughcontact._base.checks import number
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._answers.laws.law import InterfaceLaw

_MARK = "#"


def write_function(
    law: InterfaceLaw, file: str, name: str, column: str, min_gap: float, units: str
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
    if law[column].unit != THERMAL:
        raise InputError(f"The thermal contact of MOOSE takes a conductance in {THERMAL}, not the column {column!r}.")
    gap = number(min_gap, "The smallest gap", "m", above=0.0) * system.length[1]
    unit, factor = system.conductance
    pressures, values, spread = conductance_rows(law, column)
    rows = pressures * system.pressure[1], values * factor, spread * factor
    heading = f"pressure in {system.pressure[0]}, conductance in {unit}, one standard deviation"
    table = [*describe(law, _MARK), *list_uncertainties(law, _MARK, heading, rows)]
    table += [f"{pressure:.9e},{value:.9e}" for pressure, value in zip(rows[0], rows[1], strict=True)]
    blocks = [
        f"{_MARK} The conductance over the contact pressure, in {unit} and {system.pressure[0]};",
        f"{_MARK} above the last pressure it is constant. Replace temp, contact_pressure",
        f"{_MARK} and the two boundaries by the names of the model.",
        "[Functions]",
        f"  [{name}]",
        "    type = PiecewiseLinear",
        f"    data_file = {file}",
        "    format = columns",
        f"    scale_factor = {gap:.9e}  {_MARK} min_gap, by which the contact divides",
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
