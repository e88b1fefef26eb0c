"""Lists of points x y z, brought to the grid that they lie on."""

from __future__ import annotations

import numpy as np

from roughcontact._base.checks import Array
from roughcontact._parts.files.base import RawMap
from roughcontact.errors import InputError

# A place may differ from its grid by this part of a step: rounding of printed places.
_OFF = 0.05
# Gaps between sorted places below this part of the largest are rounding.
_SAME = 0.3
# A map of which both sides are shorter than this in its own unit is taken for one in metres.
_METRE = 0.1
# Places beyond have no differences in float64.
_FAR = 1e300
# The part of the points of a grid that must be listed; the others were not measured.
_LISTED = 0.5


def put_on_grid(points: Array) -> RawMap:
    """Return the map of points x y z, shape (n, 3), in any order, on a regular grid along x and y; NaN where none is.

    Its size is not known, because x and y have an unknown unit.

    Raises
    ------
    InputError
        If they do not lie on a regular grid, on most of its points and once on each.
    """
    i, nx, dx = _indices(points[:, 0])
    j, ny, dy = _indices(points[:, 1])
    if not _LISTED * nx * ny <= len(points) <= nx * ny:
        raise _irregular(len(points))
    heights = np.full((nx, ny), np.nan)
    heights[i, j] = points[:, 2]
    if np.unique(i * ny + j).size < len(points):
        raise _irregular(len(points))
    unit, length = (1.0, "metre") if max(nx * dx, ny * dy) < _METRE else (1e-6, "micrometre")
    sides = ", ".join(f"{unit * side:.6g}" for side in (nx * dx, ny * dy))
    return RawMap(
        heights,
        hint=f"its {nx} x {ny} points are {dx:.6g} x {dy:.6g} apart in a unit that it does not state; if that is the "
        f"{length}, size=({sides})",
    )


def _indices(places: Array) -> tuple[np.ndarray, int, float]:
    """Return the index of each place on the regular axis through them all, their number and the step."""
    if not np.abs(places).max() < _FAR:
        raise _irregular(len(places))
    gaps = np.diff(np.unique(places))
    true = gaps[gaps > _SAME * gaps.max(initial=0.0)]
    span = float(np.ptp(places))
    count = round(span / float(np.median(true))) + 1 if true.size else 0
    if not 2 <= count <= len(places):
        raise _irregular(len(places))
    step = span / (count - 1)
    exact = (places - places.min()) / step
    index = np.rint(exact).astype(np.intp)
    if np.abs(exact - index).max() > _OFF:
        raise _irregular(len(places))
    return index, count, step


def _irregular(count: int) -> InputError:
    return InputError(
        f"each of its {count} rows holds 3 numbers, as in a list of points x y z, but they do not lie on a regular "
        "grid: interpolate them on one, as by scipy.interpolate.griddata, and write the heights with "
        "numpy.savez(path, heights=heights, size=(lx, ly))"
    )
