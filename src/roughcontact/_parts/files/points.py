"""Lists of points x y z in text files: on a regular grid, in any order."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence

import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.files.base import GRIDDATA_ADVICE, SAVE_ADVICE, RawMap
from roughcontact._parts.files.stated import metres
from roughcontact._parts.files.text import decode_latin
from roughcontact.errors import InputError, Sentence, argument

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
MIN_POINTS = 9
# The name of a column with its unit in brackets or behind it: "X [um]", "z_nm", "height (nm)".
_NAME = re.compile(
    r"([^\W\d_]+)(?:_([A-Za-zµμ]{1,12}))?\s*(?:[\[(]\s*([^\])]*?)\s*[\])]|(?:/|\bin\b)\s*([^\W\d]{1,11}))?"
)
# A field with a name of several words: "X position (mm)"; what separates fields; and a word of Tecplot before them.
_FIELD = re.compile(
    r"[\s\"'#%]*([^\W\d][^\[(/]*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])]|(?:/|\bin\b)\s*([^\W\d]{1,11}))?[\s\"']*"
)
_WORDS = re.compile(r"[^\W\d]+")
_SEPARATOR = re.compile(r"[,;\t]")
_VARIABLES = re.compile(r"(?i)^\s*variables\s*=")
# Names of places that are not x and y, of which the direction, or the axis, is not stated.
_OTHER_PLACES = (
    frozenset({"row", "col"}),
    frozenset({"row", "column"}),
    frozenset({"r", "theta"}),
    frozenset({"r", "phi"}),
)
_DEPTHS = frozenset({"depth", "depths", "tiefe", "profondeur"})
_COLUMNS = {
    "x": ("x",),
    "y": ("y",),
    "z": ("z", "h", "height", "heights", "höhe", "hauteur", "elevation", "topography"),
}


def read_columns(points: Array, header: Sequence[str]) -> tuple[Array, dict[str, str]] | None:
    """Return the columns x, y and z of a list of points and their units by axis; None without names above them."""
    count = points.shape[1]
    header = [decode_latin(line) for line in header]
    for place in reversed(range(len(header))):
        for names in list_names(header[place]):
            # A column of numbers of the lines has no name.
            before = count - len(names)
            places = {
                axis: [place for place, (name, _) in enumerate(names) if name in words]
                for axis, words in _COLUMNS.items()
            }
            if before not in (0, 1) or any(len(places[axis]) != 1 for axis in "xy"):
                continue
            if _DEPTHS.intersection(name for name, _ in names):
                raise InputError("its third column is a depth, positive downwards: write heights, positive outwards")
            if len(places["z"]) != 1:
                continue
            chosen = [places[axis][0] for axis in "xyz"]
            below = _list_units(header[place + 1], len(names)) if place + 1 < len(header) else []
            found = below or [unit for _, unit in names]
            units = {axis: found[place] for axis, place in zip("xyz", chosen, strict=True) if found[place]}
            return points[:, [place + before for place in chosen]], units
    return None


def list_names(line: str) -> Iterator[list[tuple[str, str]]]:
    """Yield the names in a line with their units, as words, and as fields of several words."""
    line = _VARIABLES.sub("", line)
    yield [(found[1].lower(), _known(found[2]) or found[3] or found[4] or "") for found in _NAME.finditer(line)]
    fields = [found for field in _SEPARATOR.split(line) if (found := _FIELD.fullmatch(field))]
    yield [(_find_name(found[1]), found[2] or found[3] or "") for found in fields]


def _known(unit: str | None) -> str:
    """Return what stands behind a name if it is a unit of length."""
    return unit if unit and metres(unit) is not None else ""


def _find_name(words: str) -> str:
    """Return the word of a field that names a column of points, or its first one."""
    # "PosX", "X-Koordinate".
    found = re.split(r"[\s\-_]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", words).lower())
    known = {*itertools.chain.from_iterable(_COLUMNS.values()), *_DEPTHS}
    return next((word for word in found if word in known), next(iter(found), ""))


def _list_units(line: str, count: int) -> list[str]:
    """Return the units in a line of so many units alone; empty if it is another line."""
    words = [word.strip(" []()\"'#%") for word in (_SEPARATOR.split(line) if _SEPARATOR.search(line) else line.split())]
    return words if len(words) == count and all(not word or metres(word) for word in words) and any(words) else []


def require_named_columns(header: Sequence[str], columns: int) -> None:
    """Refuse numbers of other columns than the line above them names, where it names x, y and z."""
    for line in map(decode_latin, header):
        names, fields = ([name for name, _ in one if metres(name) is None] for one in list_names(line))
        words = _WORDS.findall(_VARIABLES.sub("", line).lower())
        if re.search("[=:{]", _VARIABLES.sub("", line)):
            continue
        are_columns = (
            len(names) == len([word for word in words if metres(word) is None])
            and {"x", "y"} <= {*names}
            and {*names} & {*_COLUMNS["z"]}
        )
        if len(names) == columns and any(places <= {*names} for places in _OTHER_PLACES):
            raise InputError(
                f"the line {line.strip()[:40]!a} names places that are not x and y: write a row x y z for each point, "
                "with these names above them"
            )
        if are_columns and columns not in (len(names), len(names) + 1, len(fields), len(fields) + 1):
            raise InputError(
                f"the line {line.strip()[:40]!a} names {len(names)} columns, but its rows hold {columns} numbers: "
                "write a row x y z for each point"
            )


def refuse_further_columns(table: Array) -> None:
    """Refuse a list of points x y z with further columns, such as an intensity: any of them may hold the heights."""
    rows, columns = table.shape
    if 3 < columns <= _MAX_COLUMNS and rows >= max(MIN_POINTS, columns) and are_on_grid(table[:, :3]):
        raise InputError(
            f"each of its {rows} rows holds {columns} numbers, of which the first two are places on a regular grid, as "
            "in a list of points x y z with further columns: keep the three columns x y z, or name them above the "
            "numbers"
        )


def are_on_grid(points: Array) -> bool:
    """Return whether points x y z, shape (n, 3), lie on a regular grid; see `put_on_grid`."""
    try:
        put_on_grid(points)
    except InputError:
        return False
    return True


def put_on_grid(points: Array) -> RawMap:
    """Return the map of points x y z, shape (n, 3), in any order, on a regular grid along x and y; NaN elsewhere.

    Its size is not known, because x and y have an unknown unit. `InputError` if the points do not lie on a regular
    grid, on most of its points and once on each.
    """
    i, nx, dx = _indices(points[:, 0])
    j, ny, dy = _indices(points[:, 1])
    if len(points) > nx * ny:
        raise _at_one_place(points, i * ny + j)
    if len(points) < _MIN_LISTED_FRACTION * nx * ny:
        raise _irregular(len(points))
    heights = np.full((nx, ny), np.nan)
    heights[i, j] = points[:, 2]
    if np.bincount(i * ny + j, minlength=nx * ny).max() > 1:
        raise _at_one_place(points, i * ny + j)
    unit, length = (1.0, "metre") if max(nx * dx, ny * dy) < _MAX_METRIC_SIDE else (1e-6, "micrometre")
    sides = (float(f"{unit * side:.6g}") for side in (nx * dx, ny * dy))
    return RawMap(
        heights,
        steps=(dx, dy),
        hint=Sentence(
            f"its {nx} x {ny} points are {dx:.6g} x {dy:.6g} apart in a unit that it does not state; if that is the "
            f"{length}, {argument('size', *sides, unit='m')}"
        ),
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


def _at_one_place(points: Array, cells: np.ndarray) -> InputError:
    """Return the refusal of points of which several stand in one cell of a regular grid."""
    order = np.argsort(cells, kind="stable")
    twin = order[1:][np.diff(cells[order]) == 0][0]
    return InputError(
        f"each of its {len(points)} rows holds 3 numbers, as in a list of points x y z, but two of them or more stand "
        f"at one place of a regular grid, as at x = {points[twin, 0]:g}, y = {points[twin, 1]:g}: keep one point at "
        f"each place, or interpolate them{GRIDDATA_ADVICE}"
    )


def _irregular(count: int) -> InputError:
    return InputError(
        f"each of its {count} rows holds 3 numbers, as in a list of points x y z, but they do not lie on a regular "
        f"grid: interpolate them on one{GRIDDATA_ADVICE}, and {SAVE_ADVICE}"
    )
