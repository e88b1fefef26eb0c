"""Lists of points x y z in text files: on a regular grid, in any order."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.files.base import RawMap
from roughcontact.errors import InputError

# Rounding of printed positions in a list of points, over the step.
_GRID_TOLERANCE = 0.05
# Gaps between sorted positions below this fraction of the largest are rounding.
_MIN_GAP_FRACTION = 0.3
# A map with both sides below this in its own unit is assumed to be in metres.
_MAX_METRIC_SIDE = 0.1
# Maximum position that has differences in float64.
_MAX_PLACE = 1e300
# Minimum fraction of the points of a grid that are listed; the others were not measured.
_MIN_LISTED_FRACTION = 0.5
# Further columns of a list of points that are looked for, and the minimum points of such a list: 3 x 3.
_MAX_COLUMNS = 8
_MIN_POINTS = 9
# The name of a column with its unit in brackets or behind it: "X [um]", "z_nm", "height (nm)".
_NAME = re.compile(
    r"([^\W\d_]+)(?:_([A-Za-zµμ]{1,5}))?\s*(?:[\[(]\s*([^\])]*?)\s*[\])]|(?:/|\bin\b)\s*([^\W\d]{1,11}))?"
)
_COLUMNS = {"x": ("x",), "y": ("y",), "z": ("z", "height", "heights", "höhe", "hauteur", "elevation", "topography")}


def read_columns(points: Array, header: Sequence[str]) -> tuple[Array, dict[str, str]] | None:
    """Return the columns x, y and z of a list of points and their units by axis; None without names above them."""
    for line in reversed(header):
        names = [(found[1].lower(), found[2] or found[3] or found[4] or "") for found in _NAME.finditer(line)]
        places = {
            axis: [place for place, (name, _) in enumerate(names) if name in words] for axis, words in _COLUMNS.items()
        }
        # A column of numbers of the lines has no name.
        before = points.shape[1] - len(names)
        if all(len(found) == 1 for found in places.values()) and before in (0, 1):
            chosen = [places[axis][0] for axis in "xyz"]
            units = {axis: names[place][1] for axis, place in zip("xyz", chosen, strict=True) if names[place][1]}
            return points[:, [place + before for place in chosen]], units
    return None


def refuse_further_columns(table: Array) -> None:
    """Refuse a list of points x y z with further columns, such as an intensity: any of them may hold the heights."""
    rows, columns = table.shape
    if not 3 < columns <= _MAX_COLUMNS or rows < _MIN_POINTS or rows < columns:
        return
    try:
        put_on_grid(table[:, :3])
    except InputError:
        return
    raise InputError(
        f"each of its {rows} rows holds {columns} numbers, of which the first two are places on a regular grid, as in "
        "a list of points x y z with further columns: keep the three columns x y z, or name them above the numbers"
    )


def put_on_grid(points: Array) -> RawMap:
    """Return the map of points x y z, shape (n, 3), in any order, on a regular grid along x and y; NaN elsewhere.

    Its size is not known, because x and y have an unknown unit. `InputError` if the points do not lie on a regular
    grid, on most of its points and once on each.
    """
    i, nx, dx = _indices(points[:, 0])
    j, ny, dy = _indices(points[:, 1])
    if not _MIN_LISTED_FRACTION * nx * ny <= len(points) <= nx * ny:
        raise _irregular(len(points))
    heights = np.full((nx, ny), np.nan)
    heights[i, j] = points[:, 2]
    if np.bincount(i * ny + j, minlength=nx * ny).max() > 1:
        raise _irregular(len(points))
    unit, length = (1.0, "metre") if max(nx * dx, ny * dy) < _MAX_METRIC_SIDE else (1e-6, "micrometre")
    sides = ", ".join(f"{unit * side:.6g}" for side in (nx * dx, ny * dy))
    return RawMap(
        heights,
        steps=(dx, dy),
        hint=f"its {nx} x {ny} points are {dx:.6g} x {dy:.6g} apart in a unit that it does not state; if that is the "
        f"{length}, size=({sides})",
    )


def _indices(places: Array) -> tuple[np.ndarray, int, float]:
    """Return index of each position on the regular axis through all of them, number of points, and step."""
    if not np.abs(places).max() < _MAX_PLACE:
        raise _irregular(len(places))
    gaps = np.diff(np.sort(places))
    true = gaps[gaps > _MIN_GAP_FRACTION * gaps.max(initial=0.0)]
    span = float(np.ptp(places))
    count = round(span / float(np.median(true))) + 1 if true.size else 0
    if not 2 <= count <= len(places):
        raise _irregular(len(places))
    step = span / (count - 1)
    exact = (places - places.min()) / step
    index = np.rint(exact).astype(np.intp)
    if np.abs(exact - index).max() > _GRID_TOLERANCE:
        raise _irregular(len(places))
    return index, count, step


def _irregular(count: int) -> InputError:
    return InputError(
        f"each of its {count} rows holds 3 numbers, as in a list of points x y z, but they do not lie on a regular "
        "grid: interpolate them on one, as by scipy.interpolate.griddata, and write the heights with "
        "numpy.savez(path, heights=heights, size=(lx, ly))"
    )
