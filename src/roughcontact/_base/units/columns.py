"""Columns of numbers with their uncertainties, in one unit."""

from __future__ import annotations

import math
from collections.abc import Sequence

from roughcontact._base.units import Estimate, has_power, prefixed, with_spread
from roughcontact.errors.door import guarded


@guarded
def write_column(column: Sequence[Estimate]) -> list[str]:
    """Return values of one quantity as people write them, all in the unit that suits the middle of their range."""
    numbers, unit = scale_column(column)
    return [f"{number} {unit}".strip() for number in numbers]


def scale_column(column: Sequence[Estimate]) -> tuple[list[str], str]:
    """Return the numbers of `write_column` without their unit, and the unit."""
    base, power = ("m", 2) if column[0].unit == "m2" else (column[0].unit, 1)
    sizes = [size for one in column if 0.0 < (size := max(abs(one.value), one.uncertainty)) < math.inf]
    middle = math.sqrt(min(sizes)) * math.sqrt(max(sizes)) if sizes else 0.0
    # A prefix before m3/s or 1/m would be read as one inside the power.
    factor, unit = (1.0, base) if not base or has_power(base) else prefixed(middle, base, power)
    return [_write(one, factor) for one in column], unit


def _write(one: Estimate, factor: float) -> str:
    if math.isnan(one.value):
        return "-"
    if not one.uncertainty:
        return f"{one.value * factor:.6g}"
    return with_spread(one.value * factor, one.uncertainty * factor).strip("()").replace("+-", "±")
