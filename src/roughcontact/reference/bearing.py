"""The bearing area of heights: the fraction of them above a level."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.checks import Array, heights_array, numbers, read_only
from roughcontact._base.units import outlined
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Parts of a map along each side, whose differences give the sampling error.
_PARTS = 4


def _column(values: object) -> Array:
    return read_only(numbers(values, "A column of the bearing curve", "numbers"))


@guarded
@attrs.frozen(eq=False)
class BearingCurve:
    """The Abbott-Firestone curve.

    Attributes
    ----------
    levels
        Levels above the mean height, shape (n,), m.
    fractions
        Fraction of the heights above each level, shape (n,).
    uncertainties
        Their sampling error, one standard deviation, shape (n,): from the differences of the 16 parts of the map,
        which must be larger than its longest waves.
    """

    levels: Array = attrs.field(converter=_column, repr=outlined)
    fractions: Array = attrs.field(converter=_column, repr=outlined)
    uncertainties: Array = attrs.field(converter=_column, repr=outlined)


@guarded
def bearing_area(heights: Array, levels: Array | None = None) -> BearingCurve:
    """Return the bearing area of heights: what a flat at a level would touch if it simply cut off all above it.

    This overlap takes no account of elasticity: at the same mean gap the elastic contact is several times smaller.

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), m.
    levels
        Levels above the mean height, m; None for 101 ones from the lowest height to the highest.

    Raises
    ------
    InputError
        If the heights or the levels are not finite numbers of the right shape.

    References
    ----------
    Abbott, Firestone, Mech. Eng. 55 (1933) 569-572
    """
    rough = heights_array(heights)
    rough = rough - rough.mean()
    what = "The levels"
    allowed = "a list of finite numbers (m)"
    at = np.linspace(rough.min(), rough.max(), 101) if levels is None else numbers(levels, what, allowed)
    if at.ndim != 1 or not np.isfinite(at).all():
        raise InputError.about(what, levels, allowed)
    blocks = [part for row in np.array_split(rough, _PARTS, axis=0) for part in np.array_split(row, _PARTS, axis=1)]
    parts = np.array([_find_fractions(part, at) for part in blocks if part.size])
    spread = np.std(parts, axis=0, ddof=1) / np.sqrt(len(parts)) if len(parts) > 1 else np.zeros(at.size)
    return BearingCurve(at, _find_fractions(rough, at), spread)


def _find_fractions(heights: Array, levels: Array) -> Array:
    """Return the fraction of the heights above each level."""
    ordered = np.sort(heights, axis=None)
    return np.asarray(1.0 - np.searchsorted(ordered, levels, side="right") / ordered.size)
