"""Columns of numbers with their uncertainties, in one unit."""

from __future__ import annotations

import math
from collections.abc import Sequence

from roughcontact._base.units import Estimate, prefixed, with_spread


def write_column(column: Sequence[Estimate]) -> list[str]:
    """Return values of one quantity as people write them, all in the unit that suits the middle of their range."""
    base, power = ("m", 2) if column[0].unit == "m2" else (column[0].unit, 1)
    sizes = [size for one in column if 0.0 < (size := max(abs(one.value), one.uncertainty)) < math.inf]
    middle = math.sqrt(min(sizes)) * math.sqrt(max(sizes)) if sizes else 0.0
    factor, unit = prefixed(middle, base, power) if base else (1.0, "")
    return [_write(one, factor, unit) for one in column]


def _write(one: Estimate, factor: float, unit: str) -> str:
    if not one.uncertainty:
        return f"{one.value * factor:.6g} {unit}".strip()
    number = with_spread(one.value * factor, one.uncertainty * factor).strip("()").replace("+-", "±")
    return f"{number} {unit}".strip()
