"""The ball at the end of a stylus: the map that it traces, the surface below that map, and where it is certain."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, Mask, RealArray
from roughcontact._base.machine import require_memory, split
from roughcontact._base.units import WarningText, percent, si
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces.statistics import FORM_DEGREE, polynomial
from roughcontact.errors import InputError

# Distance of the outermost points that a tip touches at one place, cells along an axis, up to which they are one
# contact: the certain fraction is then the true one (docs/studies/stylus_tip.py).
_CONTACT_CELLS = 1
# Gap over the range of the heights below which a tip touches: rounding, also of files in single precision.
_TOUCH_TOLERANCE = 1e-6
# The same of two points that are touched alike but for rounding: the first counts, so that periods are judged alike.
_TIE = 1e-12
# Standard deviations of the noise up to which a gap counts as touched.
_NOISE_STDS = 3.0
# Cells along the sides of squares that are compared as a whole, and squares whose cells are compared at once.
_SQUARE = 8
_SQUARES_AT_A_TIME = 256
# Points below a tip up to which an erosion by scipy, which compares all pairs, is faster: it takes a third of the time
# for 300 points, and seven times as long for 20,000.
_FEW_OFFSETS = 2000
# Comparisons of two points that are refused: a quarter of an hour.
_MAX_COMPARISONS = 1e12
# Peak memory in float64 arrays of the map; measured.
_ARRAYS_IN_MEMORY = 12.0
# Details that no tip of the radius can have traced, rms over Sq, that are warned of: noise of that size lowers the area
# by up to 10 %; maps whose shortest waves have 8 cells have up to 0.015 by their cells alone.
_MAX_SHARP = 0.025
_SHARP = "details that are sharper than the tip"


@attrs.frozen(eq=False)
class Tip:
    """A ball on the cells of a map, as far from its lowest point as it may touch.

    Attributes
    ----------
    rise
        Height of the ball above its lowest point, shape (2 mx + 1, 2 my + 1), m.
    inside
        Cells below the ball within reach, of the same shape.
    """

    rise: Array
    inside: Mask

    @property
    def reach(self) -> tuple[int, int]:
        """Distance of the farthest points that it may touch, cells along x and y."""
        nx, ny = self.rise.shape
        return nx // 2, ny // 2


def make_tip(heights: Array, grid: Grid, radius: float, *, periodic: bool) -> Tip:
    """Return a ball of a radius, m, for heights, shape (nx, ny), m, that it traces or has traced.

    It touches no farther than where its rise exceeds the range of the heights, or the steepest line through neighbours.
    `InputError` if it reaches over so many cells that the comparison of all points takes too long.
    """
    span = float(np.ptp(heights))
    steps = [
        max(
            float(np.abs(np.diff(heights, axis=axis)).max(initial=0.0)),
            float(np.abs(heights.take(0, axis) - heights.take(-1, axis)).max()) if periodic else 0.0,
        )
        for axis in (0, 1)
    ]
    slope = math.hypot(*(step / side for step, side in zip(steps, grid.spacing, strict=True)))
    reach = radius if span >= radius else math.sqrt(span * (2.0 * radius - span))
    if slope < 1.0:
        reach = min(reach, 2.0 * radius * slope / (1.0 + slope**2))
    # Images of a periodic map beyond half of it are nearer on the other side.
    farthest = [n // 2 if periodic else n - 1 for n in grid.shape]
    mx, my = (min(int(reach / side), most) for side, most in zip(grid.spacing, farthest, strict=True))
    if (2.0 * mx + 1.0) * (2.0 * my + 1.0) * grid.cells > _MAX_COMPARISONS:
        raise InputError(
            f"The tip reaches over {2 * mx + 1} x {2 * my + 1} cells of the {grid}, which takes too long: crop the "
            "map, or resample it."
        )
    dx, dy = grid.spacing
    square = (np.arange(-mx, mx + 1) * dx)[:, np.newaxis] ** 2 + (np.arange(-my, my + 1) * dy) ** 2
    inside = square <= reach**2
    inside[mx, my] = True
    # R - sqrt(R^2 - d^2) cancels near the lowest point; this form does not.
    rise = np.where(inside, square / (radius + np.sqrt(np.maximum(radius**2 - square, 0.0))), 0.0)
    return Tip(rise, inside)


def describe_restoring(radius: float, certain: float, traced: Array, again: Array) -> str:
    """Return in words how a map was restored, and whether it differs much from what the tip traces of the result."""
    text = f"restored below a tip of radius {si(radius, 'm')}, certain at {percent(certain)} of its points"
    sharp = float(np.sqrt(np.mean((traced - again) ** 2)))
    degree = min(FORM_DEGREE, min(traced.shape) - 1)
    rms_height = float(np.std(traced - polynomial(traced, degree, None)))
    limit = max(_MAX_SHARP * rms_height, _TOUCH_TOLERANCE * float(np.ptp(traced)))
    return f"{text}; {_SHARP}, of {si(sharp, 'm', 2)} rms, lost" if sharp > limit else text


def list_tip_warnings(history: Iterable[str]) -> tuple[str, ...]:
    """Return the warning of a restored map, by its history, that the stated tip cannot have traced it."""
    if not any(_SHARP in text for text in history):
        return ()
    text = (
        f"the map has {_SHARP} that was stated, by noise or from a smaller tip: the restored surface lies below them; "
        "filter the noise first, and check the radius"
    )
    return (WarningText(text, "sharper than the tip"),)


def trace(heights: Array, tip: Tip, *, periodic: bool, non_measured: Mask | None = None) -> Array:
    r"""Return the heights of the lowest point of a tip that rests on heights, shape (nx, ny), m: their dilation.

    .. math:: m(x) = \max_d \left( z(x + d) - t(d) \right)
    """
    known = heights if non_measured is None else np.where(non_measured, -np.inf, heights)
    return -_erode(-known, -heights, tip, periodic=periodic)


def restore(traced: Array, tip: Tip, *, periodic: bool, non_measured: Mask | None = None) -> Array:
    r"""Return the highest surface below a tip at all places of a traced map, shape (nx, ny), m: the erosion of the map.

    .. math:: r(x) = \min_d \left( m(x + d) + t(d) \right)
    """
    known = traced if non_measured is None else np.where(non_measured, np.inf, traced)
    return _erode(known, traced, tip, periodic=periodic)


@attrs.frozen(eq=False)
class _Squares:
    """Cells and offsets of a tip in squares, which are compared as a whole before their members are: few are near.

    Attributes
    ----------
    shape
        Cells of the map.
    counts
        Squares of cells along x and y.
    around
        Heights at the cells and all that the tip reaches from them.
    rise
        Rise of the tip at offsets, infinite beyond it.
    """

    shape: tuple[int, int]
    counts: tuple[int, int]
    around: Array
    rise: Array

    @classmethod
    def of(cls, heights: Array, tip: Tip, *, periodic: bool) -> _Squares:
        """Return the squares of heights, which are infinite beyond a border that does not repeat."""
        nx, ny = heights.shape
        counts = -(-nx // _SQUARE), -(-ny // _SQUARE)
        offsets = [-(-n // _SQUARE) for n in tip.rise.shape]
        rise = np.full([_SQUARE * n for n in offsets], np.inf)
        rise[: tip.rise.shape[0], : tip.rise.shape[1]] = np.where(tip.inside, tip.rise, np.inf)
        sides = zip(tip.reach, counts, offsets, (nx, ny), strict=True)
        pads = [(reach, _SQUARE * (n + m) - cells - reach) for reach, n, m, cells in sides]
        around = np.pad(heights, pads, "wrap") if periodic else np.pad(heights, pads, constant_values=np.inf)
        return cls((nx, ny), counts, around, rise)

    def divide(self, values: Array, beyond: float) -> Array:
        """Return values of cells by square, shape (8, 8, squares), with a number in cells beyond the map."""
        whole = np.full([_SQUARE * n for n in self.counts], beyond)
        whole[: self.shape[0], : self.shape[1]] = values
        parts = whole.reshape(self.counts[0], _SQUARE, self.counts[1], _SQUARE)
        return parts.transpose(1, 3, 0, 2).reshape(_SQUARE, _SQUARE, -1)

    def join(self, values: RealArray) -> RealArray:
        """Return values by square as those of cells, shape (nx, ny)."""
        parts = values.reshape(_SQUARE, _SQUARE, *self.counts).transpose(2, 0, 3, 1)
        return parts.reshape(_SQUARE * self.counts[0], -1)[: self.shape[0], : self.shape[1]]

    def list_near(self, highest: Array) -> Iterator[tuple[IntArray, Array, list[tuple[int, int, float]]]]:
        """Return squares of which a cell may be above the lowest height that the tip allows, with what is around.

        Parameters
        ----------
        highest
            The highest of the cells of each square; it may fall meanwhile.

        Yields
        ------
        tuple
            Numbers of some squares, the heights from their first cell on by a square of offsets, shape (15, 15,
            squares), and these offsets by their numbers with the rises.
        """
        offsets = [n // _SQUARE for n in self.rise.shape]
        smallest = self.rise.reshape(offsets[0], _SQUARE, offsets[1], _SQUARE).min(axis=(1, 3))
        lowest = self.around.reshape(self.around.shape[0] // _SQUARE, _SQUARE, -1, _SQUARE).min(axis=(1, 3))
        # The cells of a square and the offsets of another reach over two by two squares.
        lowest = np.minimum(lowest[:-1], lowest[1:])
        lowest = np.minimum(lowest[:, :-1], lowest[:, 1:])
        width = self.around.shape[1]
        window = width * np.arange(2 * _SQUARE - 1)[:, np.newaxis] + np.arange(2 * _SQUARE - 1)
        for place in np.argsort(smallest, axis=None, kind="stable").tolist():
            i, j = divmod(place, offsets[1])
            rises = self.rise[_SQUARE * i : _SQUARE * (i + 1), _SQUARE * j : _SQUARE * (j + 1)]
            inside = [(k, m, float(rises[k, m])) for k, m in zip(*np.nonzero(np.isfinite(rises)), strict=True)]
            below = lowest[i : i + self.counts[0], j : j + self.counts[1]].ravel() + smallest[i, j]
            near = np.flatnonzero(below < highest)
            for part in split(near.size if inside else 0, _SQUARES_AT_A_TIME):
                x, y = np.divmod(near[part], self.counts[1])
                first = _SQUARE * ((x + i) * width + y + j)
                yield near[part], self.around.ravel()[window[:, :, np.newaxis] + first], _number(inside, i, j)


def _number(inside: list[tuple[int, int, float]], i: int, j: int) -> list[tuple[int, int, float]]:
    """Return offsets inside a square of offsets by their numbers among all."""
    return [(_SQUARE * i + k, _SQUARE * j + m, rise) for k, m, rise in inside]


def _erode(known: Array, heights: Array, tip: Tip, *, periodic: bool) -> Array:
    """Return the erosion of known heights by the tip; where none is known in its reach heights stay."""
    from scipy.ndimage import grey_erosion

    require_memory(8.0 * _ARRAYS_IN_MEMORY * heights.size, "The path of a tip over the map", "choose fewer cells")
    if np.count_nonzero(tip.inside) <= _FEW_OFFSETS:
        under: dict[str, Any] = {"footprint": tip.inside, "structure": -tip.rise, "cval": np.inf}
        eroded: Array = grey_erosion(known, mode="wrap" if periodic else "constant", **under)
        return np.where(np.isfinite(eroded), eroded, heights)
    squares = _Squares.of(known, tip, periodic=periodic)
    found = squares.divide(np.full(known.shape, np.inf), -np.inf)
    highest = found.max(axis=(0, 1))
    for chosen, around, offsets in squares.list_near(highest):
        own = found[:, :, chosen]
        for i, j, rise in offsets:
            np.minimum(own, _take(around, i, j) + rise, out=own)
        found[:, :, chosen] = own
        highest[chosen] = own.max(axis=(0, 1))
    whole = squares.join(found)
    return np.where(np.isfinite(whole), whole, heights)


def _take(around: Array, i: int, j: int) -> Array:
    """Return the heights at an offset from the cells of squares."""
    k = i % _SQUARE
    m = j % _SQUARE
    return around[k : k + _SQUARE, m : m + _SQUARE]


def find_certain(
    traced: Array, restored: Array, tip: Tip, noise: float, *, periodic: bool, non_measured: Mask | None = None
) -> Mask:
    """Return the points of a restored map, shape (nx, ny), that the tip has touched at some place and at no other.

    Where all points that it touches are neighbours it rested on the nearest of them, and the restored surface is the
    true one there. Where they lie apart, or may lie beyond the border or on points that were not measured, it may have
    rested on others. Gaps up to three standard deviations of the noise, m, count as touched.

    References
    ----------
    Villarrubia, J. Res. Natl. Inst. Stand. Technol. 102 (1997) 425-454, https://doi.org/10.6028/jres.102.030
    """
    mx, my = tip.reach
    nx, ny = traced.shape
    tolerance = max(_TOUCH_TOLERANCE * float(np.ptp(traced)), _NOISE_STDS * noise)
    tie = _TIE * float(np.ptp(traced))
    squares = _Squares.of(-restored, tip, periodic=periodic)
    above = squares.divide(-traced, -np.inf)
    best = np.full(above.shape, np.inf)
    low = np.full((2, *above.shape), np.iinfo(np.int32).max, dtype=np.int32)
    high = np.full((2, *above.shape), -1, dtype=np.int32)
    place = np.zeros((2, *above.shape), dtype=np.int32)
    for chosen, around, offsets in squares.list_near(above.max(axis=(0, 1)) + 2.0 * tolerance):
        own = above[:, :, chosen]
        for i, j, rise in offsets:
            left = _take(around, i, j) - own
            touching = np.flatnonzero(left <= tolerance - rise)
            if not touching.size:
                continue
            gap = left.ravel()[touching] + rise
            k, m, n = np.unravel_index(touching, left.shape)
            touched = k, m, chosen[n]
            for axis, index in enumerate((i, j)):
                low[axis][touched] = np.minimum(low[axis][touched], index)
                high[axis][touched] = np.maximum(high[axis][touched], index)
            better = gap < best[touched] - tie
            nearer = tuple(one[better] for one in touched)
            best[nearer] = gap[better]
            place[0][nearer] = i
            place[1][nearer] = j
    alone = squares.join(np.all((high >= 0) & (high - low <= _CONTACT_CELLS), axis=0))
    alone = alone & _find_usable(traced.shape, tip, non_measured, periodic=periodic)
    x, y = np.nonzero(alone)
    certain = np.zeros(traced.shape, dtype=bool)
    offset_x, offset_y = (squares.join(one)[x, y] for one in place)
    certain[(x + offset_x - mx) % nx, (y + offset_y - my) % ny] = True
    return certain


def _find_usable(shape: tuple[int, ...], tip: Tip, non_measured: Mask | None, *, periodic: bool) -> Mask:
    """Return the places from which the tip reaches measured points of the map alone."""
    usable = np.ones(shape, dtype=bool)
    if not periodic:
        for axis, cells in enumerate(tip.reach):
            if cells:
                along = np.moveaxis(usable, axis, 0)
                along[:cells] = False
                along[-cells:] = False
    if non_measured is not None:
        from scipy.ndimage import maximum_filter

        size = tuple(2 * cells + 1 for cells in tip.reach)
        usable &= ~maximum_filter(non_measured, size=size, mode="wrap" if periodic else "nearest")
    return usable
