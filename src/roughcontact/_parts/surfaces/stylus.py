"""The ball at the end of a stylus: the map that it traces, the surface below that map, and where it is certain."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
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
# Standard deviations of the noise up to which a gap counts as touched.
_NOISE_STDS = 3.0
# Cells that are compared at once, which stay in the cache.
_CELLS_PER_BLOCK = 2**16
# Comparisons of two points that are refused: a quarter of an hour.
_MAX_COMPARISONS = 1e12
# Peak memory in float64 arrays of the map; measured.
_ARRAYS_IN_MEMORY = 8.0
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
    from scipy.ndimage import grey_dilation

    known = heights if non_measured is None else np.where(non_measured, -np.inf, heights)
    return _apply(grey_dilation, known, heights, tip, -np.inf, periodic=periodic)


def restore(traced: Array, tip: Tip, *, periodic: bool, non_measured: Mask | None = None) -> Array:
    r"""Return the highest surface below a tip at all places of a traced map, shape (nx, ny), m: the erosion of the map.

    .. math:: r(x) = \min_d \left( m(x + d) + t(d) \right)
    """
    from scipy.ndimage import grey_erosion

    known = traced if non_measured is None else np.where(non_measured, np.inf, traced)
    return _apply(grey_erosion, known, traced, tip, np.inf, periodic=periodic)


def _apply(
    operation: Callable[..., Array], known: Array, heights: Array, tip: Tip, beyond: float, *, periodic: bool
) -> Array:
    """Return heights after a grey operation under the tip; where nothing is known in its reach they stay."""
    require_memory(8.0 * _ARRAYS_IN_MEMORY * heights.size, "The path of a tip over the map", "choose fewer cells")
    mode = "wrap" if periodic else "constant"
    found = operation(known, footprint=tip.inside, structure=-tip.rise, mode=mode, cval=beyond)
    return np.where(np.isfinite(found), found, heights)


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
    beyond = ((mx, mx), (my, my))
    around = (
        np.pad(restored, beyond, "wrap") if periodic else np.pad(restored, beyond, "constant", constant_values=-np.inf)
    )
    tolerance = max(_TOUCH_TOLERANCE * float(np.ptp(traced)), _NOISE_STDS * noise)
    offsets = [(i, j, tip.rise[i, j] - tolerance) for i, j in zip(*np.nonzero(tip.inside), strict=True)]
    certain = np.zeros(traced.shape, dtype=bool)
    usable = _find_usable(traced.shape, tip, non_measured, periodic=periodic)
    for rows in split(nx, max(1, _CELLS_PER_BLOCK // ny)):
        part = traced[rows]
        size = part.size
        best = np.full(size, np.inf)
        place = np.zeros((2, size), dtype=np.intp)
        low = np.full((2, size), np.iinfo(np.intp).max)
        high = np.full((2, size), -1)
        gap = np.empty(part.shape)
        for i, j, rise in offsets:
            np.subtract(part, around[rows.start + i : rows.stop + i, j : j + ny], out=gap)
            k = np.flatnonzero(gap <= -rise)
            if not k.size:
                continue
            for axis, index in enumerate((i, j)):
                low[axis, k] = np.minimum(low[axis, k], index)
                high[axis, k] = np.maximum(high[axis, k], index)
            left = gap.ravel()[k] + rise
            better = k[left < best[k]]
            best[k] = np.minimum(best[k], left)
            place[0, better] = i
            place[1, better] = j
        alone = usable[rows].ravel() & (high >= 0).all(axis=0) & ((high - low) <= _CONTACT_CELLS).all(axis=0)
        k = np.flatnonzero(alone)
        certain[(rows.start + k // ny + place[0, k] - mx) % nx, (k % ny + place[1, k] - my) % ny] = True
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
