"""Hertz's area of each patch, from its load and its curvature."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import attrs
import numpy as np

from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.cells import split
from roughcontact._answers.areas.curvature import curvature_resolution
from roughcontact._answers.areas.sharing import Sharing, share_load
from roughcontact._answers.areas.spline import Spline
from roughcontact._answers.areas.summits import Summits, find_summits
from roughcontact._base.checks import Array, IntArray
from roughcontact._parts.grid import extend
from roughcontact._solve.solution import ContactSolution

# Pressure limit, Pa, that stands for none in a mean over cells: finite, and above any material's.
_UNLIMITED = 1e150
_FOUND: WeakKeyDictionary[ContactSolution, HertzAreas] = WeakKeyDictionary()


@attrs.frozen(eq=False)
class HertzAreas:
    """Areas of the patches after Hertz, shape (count + 1,), m2, their relative standard deviations, and their origin.

    The first entry stands for the contacts at summits that have no cell. Where a patch has no summit the area is
    zero and the error infinite. `tip` is a further standard deviation, for summits sharper than the cells show: no
    estimate tells more of them.
    """

    area: Array
    error: Array
    tip: Array
    summits: Summits
    sharing: Sharing

    def common_std(self, areas: Array) -> float:
        """Return the standard deviation that these areas share, m2: similar summits err alike."""
        known = np.isfinite(self.error)
        return calibration.HERTZ_COMMON * float(np.sum(np.minimum(self.error[known], 1.0) * areas[known]))


def hertz_areas(solution: ContactSolution) -> HertzAreas:
    """Return Hertz's areas of the patches, from their summits between the cell centres and the common approach."""
    # Area and maximum pressure ask for the same.
    if solution not in _FOUND:
        # Lengths and loads near the ends of float64 leave it; such areas are not known.
        with np.errstate(all="ignore"):
            _FOUND[solution] = _find_areas(solution)
    return _FOUND[solution]


def _find_areas(solution: ContactSolution) -> HertzAreas:
    patches = solution.patches
    spline = Spline.through_gap(solution)
    summits = find_summits(solution, spline)
    sharing = share_load(solution, summits, spline)
    shared = sharing.factor ** (2.0 / 3.0)
    area = summits.area * shared * (1.0 + _find_uneven_deficit(summits.spread))
    growth = _plastic_growth(solution, patches.forces * sharing.factor, area)
    area = area * growth
    constant, square, fourth = calibration.HERTZ_ERROR
    # Positions err with the longer side of a cell.
    oblong = (max(solution.grid.spacing) / min(solution.grid.spacing)) ** 0.25
    slight = constant * oblong * summits.spread / (summits.spread + calibration.EVEN)
    error = calibration.EXACT + slight + square * summits.spread**2 + fourth * summits.spread**4
    error = error + calibration.HERTZ_LAYERED * summits.change + calibration.SHARED * np.abs(1.0 - shared)
    unresolved, large = calibration.HERTZ_RESOLUTION
    error = error + sharing.error + unresolved * curvature_resolution(solution) ** 4 / (1.0 + patches.cells / large)
    common, single = calibration.PLASTIC
    error = error + np.where(growth > 1.0, common + single / patches.cells, 0.0)
    known = summits.known & np.isfinite(area) & (area > 0.0) & np.isfinite(error)
    hidden = float(sharing.hidden.sum())
    return HertzAreas(
        np.concatenate(([hidden if np.isfinite(hidden) else 0.0], np.where(known, area, 0.0))),
        np.concatenate(([calibration.HIDDEN], np.where(known, error, np.inf))),
        np.concatenate(([0.0], _find_tip_error(solution))),
        summits,
        sharing,
    )


def _find_uneven_deficit(spread: Array) -> Array:
    """Return by how much Hertz's area is too small where the curvature spreads, relative to it."""
    first, even, large = calibration.HERTZ_DEFICIT
    square = spread**2
    return np.asarray(first * square**2 / ((even + square) * (1.0 + large * square)))


def _find_tip_error(solution: ContactSolution) -> Array:
    """Return the relative standard deviation for tips between the cell centres, shape (count,)."""
    patches = solution.patches
    members = np.flatnonzero(np.concatenate(([False], patches.cells <= calibration.TIP_CELLS))[patches.labels])
    label = patches.labels.ravel()[members] - 1
    order = np.lexsort((solution.initial_gap.ravel()[members], label))
    lowest = order[np.flatnonzero(np.diff(label[order], prepend=-1))]
    sharpness = find_sharpness(solution, members[lowest])
    first, most = calibration.TIP
    error = np.zeros(patches.count)
    error[label[lowest]] = np.where(np.isfinite(sharpness), np.minimum(first * sharpness**4, most), most)
    return error


def find_sharpness(solution: ContactSolution, cells: IntArray) -> Array:
    """Return the logarithm of the curvature over one cell over that over two; nan where one is not positive."""
    gap = extend(solution.initial_gap, 2, solution.boundary)
    row, column = split(cells, solution.grid.shape[1])
    i = row + 2
    j = column + 2

    def curvature(step: int) -> Array:
        dx, dy = (step * length for length in solution.grid.spacing)
        along_x = gap[i + step, j] + gap[i - step, j] - 2.0 * gap[i, j]
        along_y = gap[i, j + step] + gap[i, j - step] - 2.0 * gap[i, j]
        return np.asarray(along_x / dx**2 + along_y / dy**2)

    near = curvature(1)
    far = curvature(2)
    rounded = (near > 0.0) & (far > 0.0)
    return np.where(rounded, np.log(np.where(rounded, near, 1.0) / np.where(rounded, far, 1.0)), np.nan)


def _plastic_growth(solution: ContactSolution, force: Array, area: Array) -> Array:
    """Return the factor by which a pressure limit widens each contact, shape (count,)."""
    limit = solution.pressure_limit
    if np.isinf(limit).all():
        return np.ones_like(area)
    if limit.ndim:
        patches = solution.patches
        finite = np.where(np.isfinite(limit), limit, _UNLIMITED)
        limit = patches.sum(finite) / patches.cells
    with np.errstate(divide="ignore", invalid="ignore"):
        overload = np.where(area > 0.0, 1.5 * force / (area * limit), 0.0)
    overloads = calibration.OVERLOADS
    growth = np.interp(overload, overloads, calibration.PLASTIC_GROWTH)
    return np.where(overload > overloads[-1], 2.0 * overload / 3.0, growth)
