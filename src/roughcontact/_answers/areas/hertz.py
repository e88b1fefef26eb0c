"""Hertz's area of each patch, from its curvature and its load or the common approach."""

from __future__ import annotations

from functools import lru_cache

import attrs
import numpy as np
import scipy

from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.cells import NEIGHBOUR_STEPS, Neighbourhood, count_saturated, gather_around, split
from roughcontact._answers.areas.initial_gap import Spline, combine_principal, curvature_resolution
from roughcontact._answers.areas.summits import (
    MIN_CURVATURE_RATIO,
    Summits,
    find_axes_ratio,
    find_depth,
    find_lowest,
    find_summits,
    points_of_punch,
    solve_for_area,
    unwrap,
)
from roughcontact._base.arrays import Array, IntArray, Mask, Pair, read_only
from roughcontact._parts.grid import grow
from roughcontact._parts.kernels import Love
from roughcontact._solve.solution import ContactSolution

# Cells of the largest patch whose load is corrected: the load of larger ones is right.
_MAX_CORRECTED_CELLS = 36
# Spread of the curvature up to which a contact is taken for one summit.
_MAX_EVEN_SPREAD = 0.25
# Accuracy of the common approach, over the largest approach that is tried.
_APPROACH_TOLERANCE = 1e-14
# Newton steps to a summit between the cell centres.
_NEWTON_STEPS = 3
# Largest gap at the nearest cell of a summit that touches, over curvature times the square of a cell's diagonal:
# 1/8 for a summit in the corner of a cell; the sharpest summit may be sharper than those in contact.
_HIDDEN_GAP_FACTOR = 0.25
# Pressure limit, Pa, that stands for none in a mean over cells: finite, and above any material's.
_NO_PRESSURE_LIMIT = 1e150


@attrs.frozen(eq=False)
class LoadCorrection:
    """The correction of the loads on the patches by their common approach.

    Attributes
    ----------
    factor, error
        Factors of the forces on the patches, and the relative standard deviations of the areas by them, shape (count,).
    hidden
        Areas of contacts that have no cell, m2.
    """

    factor: Array
    error: Array
    hidden: Array


def correct_loads(solution: ContactSolution, summits: Summits, spline: Spline) -> LoadCorrection:
    """Return the correction of the load of each patch by the common approach; the sum remains the solution's load."""
    patches = solution.patches
    even = (
        summits.known
        & (summits.spread < _MAX_EVEN_SPREAD)
        & (patches.cells <= _MAX_CORRECTED_CELLS)
        & (count_saturated(solution)[1:] == 0)
    )
    # The load of a single patch is known.
    unknown = np.asarray(calibration.LOAD_ERROR / patches.cells**1.5 * (patches.count > 1), dtype=np.float64)
    none = LoadCorrection(np.ones(patches.count), unknown, np.zeros(0))
    # The displacement of a patch by its own pressure is known for uniform pressure on the cells of a half-space (Love).
    if solution.moduli is not None or solution.edge_shift == 0.0 or not even.any():
        return none
    flat = find_depth(patches.forces, summits.semi_axis, summits.axes_ratio, solution.modulus)
    excess = np.where(even, _find_excess(solution, summits, spline, even) - flat, 0.0)
    stiffness = 2.0 * solution.modulus * np.sqrt(np.where(summits.known, summits.area, patches.areas) / np.pi)
    depth, unit_depth, unit_area = _find_hidden(solution, spline, float(summits.curvature[even].max()))

    forces = patches.forces
    total = forces.sum()
    paraboloid = 1.5 * flat

    def loads(shift: float) -> tuple[Array, Array]:
        # A paraboloid's load grows as depth^(3/2); a large patch is stiff as a flat punch of its area.
        lowered = excess + shift
        small = forces * _raise_to_three_halves(1.0 + lowered / paraboloid)
        large = np.maximum(forces + stiffness * lowered, 0.0)
        return np.where(even, small, large), _raise_to_three_halves((depth + shift) / unit_depth)

    def surplus(shift: float) -> float:
        carried, hidden = loads(shift)
        return float(np.add.reduce(carried) + np.add.reduce(hidden) - total)

    far = 3.0 * float(flat[even].max()) + float(np.abs(excess).max())
    if surplus(-far) * surplus(far) > 0.0:
        return none
    carried, hidden = loads(
        far * float(scipy.optimize.brentq(lambda part: surplus(part * far), -1.0, 1.0, xtol=_APPROACH_TOLERANCE))
    )
    factor = np.where(even, carried / forces, 1.0)
    error = np.where(even, 0.0, unknown)
    return LoadCorrection(factor, error, unit_area[hidden > 0.0] * hidden[hidden > 0.0] ** (2.0 / 3.0))


def _raise_to_three_halves(depth: Array) -> Array:
    """Return depth^(3/2), zero for negative depths; faster than a power."""
    positive = np.maximum(depth, 0.0)
    return np.asarray(positive * np.sqrt(positive))


def _find_excess(solution: ContactSolution, summits: Summits, spline: Spline, chosen: Mask) -> Array:
    """Return approach less initial gap and displacement by other patches, averaged over flat punches, (count,), m."""
    dx, dy = solution.grid.spacing
    far = summits.far
    u, v, flat = points_of_punch()
    x, y = summits.place(u, v)
    gap = spline.derivatives(summits.row[:, np.newaxis] + x / dx, summits.column[:, np.newaxis] + y / dy, 0)[0] @ flat
    moments, displaced = _average_cells(solution, summits, chosen)
    squares = np.stack([(part * flat).sum(axis=1) for part in (x * x, x * y, y * y)])
    # From the mean over the cells, weighted by their pressure, to the mean over the flat punch around the centre.
    step = np.sum(far.slope * -moments[:2], axis=0)
    bend = far.curvature * (squares - moments[2:])
    return np.asarray(solution.approach - gap - displaced - step - 0.5 * (bend[0] + bend[2]) - bend[1])


def _average_cells(solution: ContactSolution, summits: Summits, chosen: Mask) -> tuple[Array, Array]:
    """Return means over the cells of chosen patches, weighted by their pressure, shapes (5, count) and (count,).

    They are x, y, x^2, x y and y^2 from the centre of the patch, m and m2, and the displacement by other patches, m.
    """
    patches = solution.patches
    nx, ny = solution.grid.shape
    label = patches.member_labels - 1
    which = np.flatnonzero(chosen[label])
    which = which[np.argsort(label[which], kind="stable")]
    members = patches.members[which]
    label = label[which]
    i, j = np.divmod(members, ny)
    i = solution.parts.rows(i)
    free_x, free_y = solution.boundary.free_axes
    x = unwrap(i - summits.row[label], nx, free=free_x) * solution.grid.spacing[0]
    y = unwrap(j - summits.column[label], ny, free=free_y) * solution.grid.spacing[1]
    pressure = solution.pressure.ravel()[members]

    one, other = _pair_cells(label)
    # A patch across the border is one piece.
    di = np.abs(unwrap(i[one] - i[other], nx, free=free_x)).astype(np.intp)
    dj = np.abs(unwrap(j[one] - j[other], ny, free=free_y)).astype(np.intp)
    # The reach is rounded up, so that many contacts on equal grids have the same coefficients.
    reach_x, reach_y = (1 << int(steps.max(initial=1)).bit_length() for steps in (di, dj))
    love = _find_coefficients((reach_x, reach_y), solution.grid.spacing, 1.0 / solution.modulus)
    terms = [(pressure * part, label) for part in (x, y, x * x, x * y, y * y, solution.displacement.ravel()[members])]
    terms += [(love[di, dj] * pressure[one] * pressure[other], label[one]), (pressure, label)]
    # Sums over no cells are whole numbers.
    sums = np.array([np.bincount(of, weights=part, minlength=patches.count) for part, of in terms], dtype=np.float64)
    *moments, displaced, own, total = solution.parts.total(sums)
    total[~chosen] = 1.0
    return np.stack(moments) / total, displaced / total - own / total


@lru_cache(maxsize=8)
def _find_coefficients(reach: tuple[int, int], spacing: Pair, compliance: float) -> Array:
    return read_only(Love().coefficients(reach, spacing, compliance))


def _pair_cells(label: IntArray) -> tuple[IntArray, IntArray]:
    """Return all ordered pairs of cells with the same label; labels ascend."""
    counts = np.bincount(label)[label]
    first = np.searchsorted(label, label)
    one = np.repeat(np.arange(label.size), counts)
    return one, np.repeat(first, counts) + np.arange(one.size) - np.repeat(np.cumsum(counts) - counts, counts)


def _find_hidden(solution: ContactSolution, spline: Spline, sharpest: float) -> tuple[Array, Array, Array]:
    """Return the overlap of summits between open cells, m, and their approach, m, and area, m2, under 1 N."""
    i, j, here, along_x, along_y = _gather_low_cells(solution, sharpest)
    if i.size == 0:
        return np.zeros(0), np.ones(0), np.zeros(0)
    dx, dy = solution.grid.spacing
    x = np.zeros(i.size)
    y = np.zeros(i.size)
    for _ in range(_NEWTON_STEPS):
        gx, gy, xx, xy, yy = spline.derivatives(i + x / dx, j + y / dy, 1, 2)
        determinant = xx * yy - xy**2
        summit = (determinant > 0.0) & (xx + yy > 0.0)
        determinant = np.where(summit, determinant, 1.0)
        gx = gx + along_x
        gy = gy + along_y
        x = np.where(summit, np.clip(x - (yy * gx - xy * gy) / determinant, -dx, dx), x)
        y = np.where(summit, np.clip(y - (xx * gy - xy * gx) / determinant, -dy, dy), y)
    value, xx, xy, yy = spline.derivatives(i + x / dx, j + y / dy, 0, 2)
    middle, difference = combine_principal(xx, xy, yy)
    summit = middle - difference > MIN_CURVATURE_RATIO * (middle + difference)
    overlap = solution.approach - value - here - along_x * x - along_y * y
    overlap = overlap[summit]
    middle = middle[summit]
    difference = difference[summit]
    ratio = (middle - difference) / (middle + difference)
    area, _ = solve_for_area(solution, np.ones(ratio.size), middle, ratio)
    axes_ratio = find_axes_ratio(ratio)
    depth = 1.5 * find_depth(np.ones(ratio.size), np.sqrt(area * axes_ratio / np.pi), axes_ratio, solution.modulus)
    return overlap, depth, area


def _gather_low_cells(solution: ContactSolution, sharpest: float) -> Array:
    """Return row and column of the cells of `_find_low_cells`, their displacement, m, and its slopes, shape (5, n)."""
    chosen = _find_low_cells(solution, sharpest)
    nx, ny = solution.contact.shape
    dx, dy = solution.grid.spacing
    i, j = np.divmod(chosen, ny)
    u = solution.displacement
    along_x = (u[(i + 1) % nx, j] - u[i - 1, j]) / (2.0 * dx)
    along_y = (u[i, (j + 1) % ny] - u[i, j - 1]) / (2.0 * dy)
    return solution.parts.join(np.stack((solution.parts.rows(i), j, u[i, j], along_x, along_y)))


def _find_low_cells(solution: ContactSolution, sharpest: float) -> IntArray:
    """Return open cells without lower neighbours or neighbours in contact, beside which a summit may touch."""
    nx, ny = solution.contact.shape
    dx, dy = solution.grid.spacing
    low = (solution.gap < sharpest * (dx * dx + dy * dy) * _HIDDEN_GAP_FACTOR) & ~solution.contact
    if solution.non_measured is not None:
        low &= ~grow(solution.non_measured, 2, solution.boundary)
    for axis, free in enumerate(solution.boundary.free_axes):
        if free:
            np.moveaxis(low, axis, 0)[[0, 1, -2, -1]] = False
    chosen = np.flatnonzero(solution.parts.own(low))
    near = Neighbourhood.of(*split(chosen, ny), (nx, ny), solution.boundary, 1)
    gap = solution.gap.ravel()
    contact = solution.contact.ravel()
    here = gap[chosen]
    after = NEIGHBOUR_STEPS[::2]
    before, after = (near.at(steps) for steps in (-after, after))
    # Equal neighbours have one summit between them: only the first counts.
    lowest = (gap[before] > here).all(axis=0) & (gap[after] >= here).all(axis=0)
    lowest &= ~(contact[before] | contact[after]).any(axis=0)
    return chosen[lowest]


@attrs.frozen(eq=False)
class HertzAreas:
    """Hertz's areas of the patches, shape (count + 1,), m2, their relative standard deviations, and their origin.

    The first entry is the sum of the contacts at summits without a cell. Where a patch has no summit the area is zero
    and the error infinite. `tip` is a further relative standard deviation, for summits sharper than the cells show.
    """

    area: Array
    error: Array
    tip: Array
    summits: Summits
    correction: LoadCorrection

    def common_std(self, areas: Array) -> float:
        """Return the common standard deviation of these areas, m2: similar summits have the same error."""
        known = np.isfinite(self.error)
        return calibration.HERTZ_COMMON_FRACTION * float(np.sum(np.minimum(self.error[known], 1.0) * areas[known]))


def hertz_areas(solution: ContactSolution) -> HertzAreas:
    """Return Hertz's areas of the patches, from their summits between the cell centres and the common approach."""

    def find() -> HertzAreas:
        # Very large or small lengths and loads leave the range of float64; such areas are not known.
        with np.errstate(all="ignore"):
            return _find_areas(solution)

    # Area and maximum pressure ask for the same.
    return solution._keep("Hertz's areas", find)


def _find_areas(solution: ContactSolution) -> HertzAreas:
    patches = solution.patches
    spline = solution.parts.evaluating(Spline.through_gap(solution))
    summits = find_summits(solution, spline)
    correction = correct_loads(solution, summits, spline)
    shared = correction.factor ** (2.0 / 3.0)
    area = summits.area * shared
    growth = _plastic_growth(solution, patches.forces * correction.factor, area)
    area = area * growth
    constant, square, fourth = calibration.HERTZ_ERROR
    # The error of positions grows with the longer side of a cell.
    oblong = (max(solution.grid.resolved.spacing) / min(solution.grid.resolved.spacing)) ** 0.25
    slight = constant * oblong * summits.spread / (summits.spread + calibration.EVEN_SPREAD)
    error = calibration.MIN_HERTZ_ERROR + slight + square * summits.spread**2 + fourth * summits.spread**4
    error = (
        error + calibration.HERTZ_LAYERED_ERROR * summits.change + calibration.SHARED_LOAD_ERROR * np.abs(1.0 - shared)
    )
    # On rough surfaces the spread of the curvature has grown with the other patches when its error was set.
    error = np.maximum(error, summits.crowding)
    unresolved, large = calibration.HERTZ_RESOLUTION_ERROR
    error = error + correction.error + unresolved * curvature_resolution(solution) ** 4 / (1.0 + patches.cells / large)
    error = error + np.where(growth > 1.0, calibration.PLASTIC_ERROR, 0.0)
    known = summits.known & np.isfinite(area) & (area > 0.0) & np.isfinite(error)
    hidden = float(correction.hidden.sum())
    return HertzAreas(
        np.concatenate(([hidden if np.isfinite(hidden) else 0.0], np.where(known, area, 0.0))),
        np.concatenate(([0.0], np.where(known, error, np.inf))),
        np.concatenate(([0.0], _find_tip_error(solution))),
        summits,
        correction,
    )


def _find_tip_error(solution: ContactSolution) -> Array:
    """Return the relative standard deviation for tips between the cell centres, shape (count,)."""
    mine, places = solution.parts.find(find_lowest(solution, solution.initial_gap))
    sharpness = find_sharpness(solution, places)
    first, most = calibration.TIP_ERROR
    error = np.zeros(solution.patches.count)
    error[mine] = np.where(np.isfinite(sharpness), np.minimum(first * sharpness**4, most), most)
    return solution.parts.total(error)


def find_sharpness(solution: ContactSolution, cells: IntArray) -> Array:
    """Return the logarithm of the curvature over one cell over that over two; nan where one is not positive."""
    around = gather_around(solution.initial_gap, cells, 2, solution.boundary)

    def curvature(step: int) -> Array:
        dx, dy = (step * length for length in solution.grid.spacing)
        along_x = around[2 + step, 2] + around[2 - step, 2] - 2.0 * around[2, 2]
        along_y = around[2, 2 + step] + around[2, 2 - step] - 2.0 * around[2, 2]
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
        finite = np.where(np.isfinite(limit), limit, _NO_PRESSURE_LIMIT)
        limit = patches.sum(finite) / patches.cells
    with np.errstate(divide="ignore", invalid="ignore"):
        overload = np.where(area > 0.0, 1.5 * force / (area * limit), 0.0)
    overloads, growths = calibration.PLASTIC_GROWTH
    growth = np.interp(overload, overloads, growths)
    return np.where(overload > overloads[-1], 2.0 * overload / 3.0, growth)
