"""Corrections of the approach: the highest summit between the cells, and uniform pressure on each cell."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.calibration import TIP_RISE_DEFICIT, TIP_RISE_ERROR
from roughcontact._answers.areas.cells import NEIGHBOUR_STEPS, find_cut_cells, find_straight_rows
from roughcontact._answers.areas.creases import CREASE_REACH, find_creased_tops
from roughcontact._answers.areas.edges import MAX_RIDGE_LAY, is_diagonal
from roughcontact._answers.areas.initial_gap import (
    CONTINUED_CELLS,
    ROUNDING,
    average_curvature,
    bend_at_border,
    continue_beyond,
    curvature_resolution,
    find_filled,
    is_linear,
    lay_ratio,
    rim_ratio,
)
from roughcontact._base.arrays import Array, Mask
from roughcontact._parts.grid import Boundary, pad_axes
from roughcontact._solve.solution import ContactSolution, heal

# Number of the highest cells of a map that are tried: often the highest summit is not beside the highest cell.
_SEARCHED_CELLS = 64
# Cells on each side of a summit through which polynomials are fitted.
_POLYNOMIAL_REACH = 4
# Largest distance of a summit from its highest cell along an axis, and the distances that are tried, cells.
_MAX_SUMMIT_OFFSET = 0.75
_TRIED_OFFSETS = np.linspace(-_MAX_SUMMIT_OFFSET, _MAX_SUMMIT_OFFSET, 13)
# Cells on each side of a tip through which a hyperboloid is fitted.
TIP_REACH = 2
# Quadratic forms at these cells, shape (cells, 6).
_TIP_FORMS = np.stack(
    [
        (x**a * y**b).ravel()
        for x, y in [np.mgrid[-TIP_REACH : TIP_REACH + 1, -TIP_REACH : TIP_REACH + 1].astype(np.float64)]
        for a, b in ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    ],
    axis=1,
)
# Smallest ratio of the principal curvatures of a hyperboloid: any ridge has one through five cells across it.
_MIN_CURVATURE_RATIO = 0.1
# Misfit of a hyperboloid over the misfit of a paraboloid below which the summit is a hyperboloid, and below which it is
# one if its radius at the tip, over the range of the gap, is below the third number.
_EXACT_TIP_MISFIT = 0.02
_TIP_MISFIT = 0.2
_MAX_TIP_RADIUS = 0.3
# The same misfit from which the summit is not pointed.
_ROUND_MISFIT = 0.3
# Steps along both axes, along both diagonals, and to the two cells on each side.
_LINES = np.split(NEIGHBOUR_STEPS[::2], 2)
_BESIDE = np.arange(-2, 3)
# Places without a kink on both lines through a summit, from which the map is linear between points there.
_MIN_KINKLESS = 3


def _weigh(reach: int) -> Array:
    """Return the weights of cells in value, slope and bend of the polynomial through them, shape (3, places, cells)."""
    cells = np.arange(-reach, reach + 1.0)
    power = np.arange(cells.size)
    at = _TRIED_OFFSETS[:, np.newaxis]
    value = at**power
    slope = power * at ** np.maximum(power - 1, 0)
    bend = power * (power - 1) * at ** np.maximum(power - 2, 0)
    return np.asarray(np.stack((value, slope, bend)) @ np.linalg.inv(np.vander(cells, increasing=True)))


# The order of products that is best for the polynomials: finding it takes longer than the products.
_EINSUM_PATH = ["einsum_path", (0, 1), (0, 1)]
_POLYNOMIAL_WEIGHTS = {reach: _weigh(reach) for reach in (_POLYNOMIAL_REACH - 1, _POLYNOMIAL_REACH)}


def find_rise(
    gap: Array, boundary: Boundary, non_measured: Mask | None = None, *, linear: bool = False
) -> tuple[float, float]:
    """Return the height of the highest summit above the highest measured cell, and its standard deviation, m.

    Parameters
    ----------
    gap
        Initial gap, m, shape (nx, ny).
    boundary
        Whether the gap repeats beyond the border.
    non_measured
        Cells that were not measured.
    linear
        Whether the gap is linear between points, with its summits at points.
    """
    if any(n < 2 * TIP_REACH + 1 for n, free in zip(gap.shape, boundary.free_axes, strict=True) if free):
        return 0.0, float(np.ptp(gap))
    measured = gap if non_measured is None else np.where(non_measured, np.inf, gap)
    wide, summits = _gather_highest(gap, measured, boundary)
    beside = slice(CREASE_REACH - _POLYNOMIAL_REACH, CREASE_REACH + _POLYNOMIAL_REACH + 1)
    near = wide[:, beside, beside]
    highest = float(measured.min())
    # Beside a smooth summit there may be lands, whose heights are linear as well.
    if linear and _is_linear(near[int(np.argmin(near[:, _POLYNOMIAL_REACH, _POLYNOMIAL_REACH]))]):
        # Beside a step the lines of both sides meet anywhere.
        rises = np.array(
            [float(window[_POLYNOMIAL_REACH, _POLYNOMIAL_REACH]) - _extend_lines(window) for window in near]
        )
        tops = near[:, _POLYNOMIAL_REACH, _POLYNOMIAL_REACH] - np.minimum(rises, _bound_rise(near))
        rise = max(highest - float(tops.min()), 0.0)
        return rise, TIP_RISE_ERROR * rise
    near = near[summits]
    rough, fine = (_interpolate(near, reach) for reach in (_POLYNOMIAL_REACH - 1, _POLYNOMIAL_REACH))
    here = near[:, _POLYNOMIAL_REACH, _POLYNOMIAL_REACH]
    bounds = _bound_rise(near)
    tops, creased = find_creased_tops(wide[summits])
    beyond = ~creased & (here - fine > bounds)
    fine = np.where(beyond, here - 0.5 * bounds, np.where(creased, np.minimum(tops, here), fine))
    best = int(np.argmin(fine))
    beside = slice(_POLYNOMIAL_REACH - TIP_REACH, _POLYNOMIAL_REACH + TIP_REACH + 1)
    tip, pointed = fit_hyperboloid(near[best][beside, beside])
    if creased[best] and tip is None:
        rise = max(highest - float(fine[best]), 0.0)
        return rise, calibration.CREASED_RISE_STD * rise
    if beyond.any():
        # Polynomials swing beside creases and the edges of lands: possibly nothing rises at all.
        rise = max(highest - float(fine[best]), 0.0)
        std = 0.5 * float(bounds[best]) if beyond[best] else abs(float(fine[best] - rough[best]))
        return rise, max(std, 0.5 * rise)
    if tip is not None:
        rise = max(highest - tip, 0.0)
        return rise, TIP_RISE_ERROR * rise
    rise = max(highest - float(fine[best]), 0.0)
    # Polynomials lack part of the height of tips between a cone and a paraboloid.
    lacking = pointed * (rise + TIP_RISE_DEFICIT[0] * _find_bend(near[best]))
    return rise + lacking, math.hypot(float(fine[best] - rough.min()), TIP_RISE_DEFICIT[1] * lacking)


def _gather_highest(gap: Array, measured: Array, boundary: Boundary) -> tuple[Array, Mask]:
    """Return the gap around the highest cells, shape (count, cells, cells), and which are summits."""
    wide = gap
    more_rows = ((CREASE_REACH, CREASE_REACH), (0, 0))
    for free in boundary.free_axes:
        # Each axis in turn is the first one.
        wide = (_continue(wide) if free else pad_axes(wide, more_rows, (False, False))).T
    count = min(_SEARCHED_CELLS, gap.size)
    highest = np.argpartition(measured, count - 1, axis=None)[:count]
    highest = highest[np.isfinite(measured.ravel()[highest])]
    i, j = np.divmod(highest, gap.shape[1])
    step = np.arange(2 * CREASE_REACH + 1)
    near = wide[(i[:, np.newaxis] + step)[:, :, np.newaxis], (j[:, np.newaxis] + step)[:, np.newaxis]]
    beside = slice(CREASE_REACH - 1, CREASE_REACH + 2)
    here = near[:, CREASE_REACH, CREASE_REACH]
    summits = near[:, beside, beside].min(axis=(1, 2)) >= here
    # Beside non-measured points possibly no cell is higher than its neighbours.
    summits[np.argmin(here)] = True
    return near, np.asarray(summits)


def _continue(gap: Array) -> Array:
    further = CONTINUED_CELLS - CREASE_REACH
    return continue_beyond(gap)[further:-further]


def _interpolate(near: Array, reach: int) -> Array:
    """Return the smallest gap of the polynomial through the cells around each summit, m, shape (count,)."""
    beside = slice(_POLYNOMIAL_REACH - reach, _POLYNOMIAL_REACH + reach + 1)
    near = near[:, beside, beside]
    weights = _POLYNOMIAL_WEIGHTS[reach]
    values = np.einsum("ai,nij,bj->nab", weights[0], near, weights[0], optimize=_EINSUM_PATH)
    i, j = np.divmod(values.reshape(len(near), -1).argmin(axis=1), _TRIED_OFFSETS.size)

    def derive(first: int, second: int) -> Array:
        return np.asarray(np.einsum("ni,nij,nj->n", weights[first][i], near, weights[second][j]))

    x = derive(1, 0)
    y = derive(0, 1)
    xx = derive(2, 0)
    yy = derive(0, 2)
    xy = derive(1, 1)
    determinant = xx * yy - xy**2
    convex = (determinant > 0.0) & (xx > 0.0)
    determinant = np.where(convex, determinant, 1.0)
    along_x = (xy * y - yy * x) / determinant
    along_y = (xy * x - xx * y) / determinant
    inside = convex & (np.maximum(np.abs(along_x), np.abs(along_y)) <= _TRIED_OFFSETS[1] - _TRIED_OFFSETS[0])
    return derive(0, 0) + np.where(inside, 0.5 * (x * along_x + y * along_y), 0.0)


def _bound_rise(near: Array) -> Array:
    """Return how high heights that are concave along lines rise at most above the cells in the middle, m."""
    sums = []
    for pair in _LINES:
        lines = (near[:, _POLYNOMIAL_REACH + di * _BESIDE, _POLYNOMIAL_REACH + dj * _BESIDE] for di, dj in pair)
        first, second = (np.maximum(_meet(line), _meet(line[:, ::-1])) for line in lines)
        sums.append(first + second)
    return np.asarray(np.max(sums, axis=0))


def _meet(line: Array) -> Array:
    """Return how far below the middle cell, m, the line from the cell before it meets the one from the two beyond."""
    before, here, after, beyond = line[:, 1:].T
    down = before - here
    up = beyond - after
    crossing = (up - (after - here)) / np.where(down + up > 0.0, down + up, 1.0)
    return np.where(down > 0.0, down * np.clip(crossing, 0.0, 1.0), 0.0)


def _find_bend(near: Array) -> float:
    """Return the sum of the second differences of the gap along x and y at a summit, m."""
    here = near[_POLYNOMIAL_REACH, _POLYNOMIAL_REACH]
    beside = (
        near[_POLYNOMIAL_REACH - 1, _POLYNOMIAL_REACH]
        + near[_POLYNOMIAL_REACH + 1, _POLYNOMIAL_REACH]
        + near[_POLYNOMIAL_REACH, _POLYNOMIAL_REACH - 1]
        + near[_POLYNOMIAL_REACH, _POLYNOMIAL_REACH + 1]
    )
    return float(beside - 4.0 * here)


def fit_hyperboloid(near: Array) -> tuple[float | None, float]:
    """Return the gap at the tip of a hyperboloid, m, or None, and how pointed the summit is, from 0 to 1.

    Paraboloids and cones are hyperboloids, (g + t)^2 a quadratic, which is linear in its seven numbers. The second is
    zero on paraboloids, waves, rough surfaces and round tips, about 0.3 to 0.5 on tips r^1.5 and one on cones.

    Parameters
    ----------
    near
        Gap around a summit, m, shape (5, 5).
    """
    lowest = near[TIP_REACH, TIP_REACH]
    wide = float(np.ptp(near))
    if wide == 0.0:
        return None, 0.0
    gap = ((near - lowest) / wide).ravel()
    forms = _TIP_FORMS
    round_off = float(np.linalg.norm(gap - forms @ np.linalg.lstsq(forms, gap, rcond=None)[0]))
    *form, shift = np.linalg.lstsq(np.column_stack((forms, -2.0 * gap)), gap**2, rcond=None)[0]
    hessian = np.array(((2.0 * form[3], form[4]), (form[4], 2.0 * form[5])))
    smaller, larger = np.linalg.eigvalsh(hessian)
    if round_off < ROUNDING or smaller <= _MIN_CURVATURE_RATIO * larger or larger <= 0.0:
        return None, 0.0
    place = -np.linalg.solve(hessian, form[1:3])
    if np.max(np.abs(place)) > _MAX_SUMMIT_OFFSET:
        return None, 0.0
    radius = max(shift**2 + form[0] + 0.5 * float(np.dot(form[1:3], place)), 0.0)
    found = np.sqrt(np.maximum(forms @ form + shift**2, 0.0)) - shift
    misfit = float(np.linalg.norm(found - gap)) / round_off
    if misfit < _EXACT_TIP_MISFIT or (misfit < _TIP_MISFIT and radius < _MAX_TIP_RADIUS**2):
        return float(lowest + wide * (math.sqrt(radius) - shift)), 1.0 if radius < _MAX_TIP_RADIUS**2 else 0.0
    return None, max(1.0 - misfit / _ROUND_MISFIT, 0.0)


def _is_linear(near: Array) -> bool:
    """Return whether around a summit there are no kinks at, or between, several cells along x and y.

    A smooth summit in the middle between two cells bends alike at both, along each axis once.
    """
    kinkless = 0
    for line in (near[:, _POLYNOMIAL_REACH], near[_POLYNOMIAL_REACH]):
        bends = np.diff(line, 2)
        smallest = ROUNDING * float(np.abs(bends).max())
        kinkless += int(
            np.count_nonzero(np.abs(bends) <= smallest) + np.count_nonzero(np.abs(np.diff(bends)) <= smallest)
        )
    return kinkless >= _MIN_KINKLESS


def _extend_lines(near: Array) -> float:
    """Return the gap at the summit of a map that is linear between points, m: where the lines of both sides meet."""
    here = near[_POLYNOMIAL_REACH, _POLYNOMIAL_REACH]
    (x, along_x, i), (y, along_y, j) = (
        _find_kink(line) for line in (near[:, _POLYNOMIAL_REACH], near[_POLYNOMIAL_REACH])
    )
    twist = here - near[i, _POLYNOMIAL_REACH] - near[_POLYNOMIAL_REACH, j] + near[i, j]
    return float(here + x * along_x + y * along_y + x * y * twist)


def _find_kink(line: Array) -> tuple[float, float, int]:
    """Return the distance in cells to where the lines of both sides meet, the slope there and the cell behind."""
    bends = np.diff(line[_POLYNOMIAL_REACH - 2 : _POLYNOMIAL_REACH + 3], 2)
    if abs(bends[1]) <= ROUNDING * np.max(np.abs(bends)):
        return 0.0, 0.0, _POLYNOMIAL_REACH
    # A kink between two cells bends the line at both.
    side = 1 if abs(bends[2] - bends[1]) < abs(bends[0] - bends[1]) else -1
    before, here, after, beyond = (float(line[_POLYNOMIAL_REACH + side * k]) for k in (-1, 0, 1, 2))
    slope = here - before
    change = beyond - after - slope
    distance = (beyond - 2.0 * after + here) / change if change != 0.0 else 0.0
    return (distance if 0.0 <= distance <= 1.0 else 0.0), slope, _POLYNOMIAL_REACH - side


@attrs.frozen(eq=False)
class Bend:
    """The curvature of the heights under a contact, and how far the cells show the heights.

    Attributes
    ----------
    load
        Fraction of the load on each patch, shape (count,).
    spread
        Standard deviation of the curvature of each over its mean, shape (count,).
    mean
        Half the second differences under the contact along x and y together, weighted by the pressure, m.
    highest
        The same, or that of the cells beside free borders alone where it is larger, m.
    width
        Fourth root of the cells of a patch, weighted by the load.
    saturated, filled
        Fractions of the load on saturated cells and on cells that were filled from their neighbours.
    resolution
        Resolution ratio of `curvature_resolution`.
    rim
        Sharpness of the rims of flats that were run in, times the width; zero without such rims.
    linear
        Whether the heights are linear between points further apart than the cells.
    """

    load: Array
    spread: Array
    mean: float
    highest: float
    width: float
    saturated: float
    filled: float
    resolution: float
    rim: float
    linear: bool


def measure_bend(solution: ContactSolution) -> Bend:
    """Return the curvature of the heights under the contact of a solution that has one."""
    healed = heal(solution)
    return healed._keep("bend", lambda: _measure_bend(healed))


def _measure_bend(solution: ContactSolution) -> Bend:
    patches = solution.patches
    touching = np.flatnonzero(solution.contact)
    _, _, spread, bends = (part[1:] for part in average_curvature(solution))
    load = patches.forces / patches.forces.sum()
    pressure = solution.pressure.ravel()[touching] / np.sum(solution.pressure)
    resolution = curvature_resolution(solution)
    width = float(np.sum(load * np.sqrt(np.sqrt(patches.cells))))
    mean = float(np.sum(load * np.maximum(bends, 0.0)))
    at_border = float(np.sum(pressure * np.maximum(bend_at_border(solution, touching), 0.0)))
    return Bend(
        load=load,
        spread=spread,
        mean=mean,
        highest=max(mean, at_border),
        width=width,
        saturated=float(np.sum(pressure, where=solution.saturated.ravel()[touching])),
        filled=float(np.sum(pressure, where=find_filled(solution, touching))),
        resolution=resolution,
        rim=min(resolution, 1.0) * width * _ramp(rim_ratio(solution), calibration.RIM_RATIOS),
        linear=is_linear(solution, touching),
    )


def find_shift(solution: ContactSolution) -> tuple[float, float]:
    """Return the deficit of the approach and its standard deviation, m."""
    solution = heal(solution)
    if solution.patches.count == 0:
        return 0.0, 0.0
    bend = measure_bend(solution)
    cells = np.maximum(solution.patches.cells, 1)
    held = cells / (cells + calibration.HALF_EXCESS_CELLS)
    shift = calibration.GAP_EXCESS * solution.edge_shift * float(np.sum(bend.load * held))
    kinked = 0.0
    kinked_std = 0.0
    if bend.linear:
        kinked, kinked_std = calibration.LINEAR_GAP_EXCESS
    filled, filled_std = calibration.FILLED_GAP_EXCESS
    rim, rim_std = calibration.RIM_GAP_EXCESS
    # Uniform pressure is exact where cells are saturated.
    elastic = 1.0 - bend.saturated
    shift = (shift + kinked + filled * bend.filled + rim * bend.rim) * elastic
    unsure: tuple[float, ...] = (
        _find_spread(bend, cells),
        _find_aligned(solution),
        kinked_std,
        filled_std * math.sqrt(bend.filled),
        rim_std * bend.rim * elastic,
    )
    # The shift fades with the open part of a periodic domain.
    open_part = 1.0 if solution.boundary.has_free_axis else 1.0 - float(np.mean(solution.contact))
    fading = min(1.0, calibration.FADING_FACTOR * open_part)
    if solution._is_changed:
        # What loads before have left bends elsewhere, too: on draw 1 of benchmarks/memory_classes.py by as much.
        unsure = (*unsure, shift)
    std = max(fading, calibration.MIN_FADING) * math.hypot(*unsure)
    highest = bend.highest
    if solution._is_changed and solution.capped:
        # The height that was flattened has the error of the contact on the fresh surface.
        fresh = attrs.evolve(solution, initial_gap=solution._fresh_gap)
        highest = max(highest, measure_bend(fresh).highest)
    return fading * shift * bend.mean, std * highest


def _find_aligned(solution: ContactSolution) -> float:
    """Return the error of the shift over the bend where the edge is straight and its cells have the same error."""
    rows = find_straight_rows(solution)
    # The mean counts, because a slender ellipse has some long rows too.
    long = rows.size > 0 and float(np.mean(rows)) > 0.5 * min(solution.grid.shape)
    if long:
        return calibration.ALIGNED_GAP_STD
    lay = lay_ratio(solution)
    return calibration.OBLIQUE_GAP_STD if lay < MAX_RIDGE_LAY and is_diagonal(solution, lay) else 0.0


def _find_spread(bend: Bend, cells: Array) -> float:
    """Return the standard deviation of the shift of smooth heights over their second difference, no unit."""
    # Equal patches have the same error; errors of different ones average out.
    squares = float(np.sum(bend.load**2))
    unlike = min(1.0, float(np.sum(bend.load * bend.spread)) ** 2 + bend.load.size * squares - 1.0)
    number = 1.0 + (1.0 / squares - 1.0) * unlike
    few = calibration.SMALL_PATCH_GAP_STD * float(np.sum(bend.load / np.sqrt(cells)))
    ratio = min(bend.resolution, 1.0)
    own = (calibration.PATCH_GAP_STD + few * (1.0 + ratio)) / math.sqrt(number)
    edge = calibration.SATURATED_GAP_STD * bend.saturated**2 * bend.width / number
    return math.hypot(own, edge)


def find_hidden_rise(solution: ContactSolution) -> float:
    """Return the standard deviation of the height of the highest summit where the cells do not resolve it, m."""
    solution = heal(solution)
    if solution.patches.count == 0:
        return 0.0
    bend = measure_bend(solution)
    lost, filled = calibration.HIDDEN_RISE_STD
    _, rims = calibration.RIM_GAP_EXCESS
    unresolved = lost * _ramp(bend.resolution, calibration.UNRESOLVED_RATIOS)
    return math.hypot(unresolved, rims * bend.rim, filled * math.sqrt(bend.filled)) * bend.mean


def _ramp(value: float, ends: tuple[float, float]) -> float:
    """Return how far a value lies from the first end to the second, from 0 to 1."""
    return min(max((value - ends[0]) / (ends[1] - ends[0]), 0.0), 1.0)


def find_cut_shift(solution: ContactSolution) -> tuple[float, float]:
    """Return the excess of the approach where the contact is cut, and its standard deviation, m.

    There the pressure rises as the inverse root of the distance, which uniform pressure on each cell does not follow:
    the deficit of energy is a fraction of p^2 / E* over the cells at the cut.
    """
    non_measured = solution.non_measured
    if solution.force == 0.0 or (non_measured is None and not solution.boundary.has_free_axis):
        return 0.0, 0.0
    cut = find_cut_cells(solution)
    if solution.capped and solution._offset is not None:
        # Where the border was flattened at the limit, the pressure stays finite when the load falls.
        cut &= solution._offset <= 0.0
    beside = None if non_measured is None else np.nonzero(non_measured)
    border = 0.0
    unknown = 0.0
    for axis, step in enumerate(solution.grid.spacing):
        weight = step * solution.grid.cell_area
        pressure = np.moveaxis(solution.pressure, axis, 0)
        elastic = np.moveaxis(~solution.saturated, axis, 0)
        free = solution.boundary.free_axes[axis]
        if free:
            ends = np.moveaxis(cut, axis, 0)[[0, -1]] & elastic[[0, -1]]
            border += weight * float(np.sum(pressure[[0, -1]] ** 2, where=ends))
        if beside is not None:
            for neighbour in (beside[axis] - 1, beside[axis] + 1):
                row = np.clip(neighbour, 0, len(pressure) - 1) if free else neighbour % len(pressure)
                at = row, beside[1 - axis]
                unknown += weight * float(np.sum(pressure[at] ** 2, where=elastic[at]))
    energies = np.array((border, unknown))
    modulus = float(solution.effective_modulus(1.0 / math.sqrt(solution.grid.resolved.cell_area)))
    shift, std = (
        np.transpose((calibration.CUT_BORDER_EXCESS, calibration.CUT_NON_MEASURED_EXCESS))
        @ energies
        / (modulus * solution.force)
    )
    return float(shift), float(std)
