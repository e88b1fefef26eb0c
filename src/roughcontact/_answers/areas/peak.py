"""The maximum pressure between the cells."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.approach import TIP_REACH, fit_hyperboloid
from roughcontact._answers.areas.cells import find_cut_cells, gather_around
from roughcontact._answers.areas.edges import ends_as_root, pass_on_warnings, warn_if_uncertain
from roughcontact._answers.areas.flags import find_unbounded
from roughcontact._answers.areas.hertz import find_sharpness, hertz_areas
from roughcontact._answers.areas.initial_gap import curvature_resolution
from roughcontact._answers.areas.quantities import Quantity
from roughcontact._answers.areas.summits import Summits, find_lowest
from roughcontact._base.arrays import Array, IntArray, Mask, RealArray
from roughcontact._base.units import WarningText
from roughcontact._parts.grid import grow
from roughcontact._solve.solution import Area, ContactSolution, Estimate, defer_peak_sampling, responses

# Change of the maximum pressure over 3 F / 2A of a summit c2 r^2 + c4 r^4, times c4 a^2 / c2: (32/9 - 32/5) / 4.
_QUARTIC_FACTOR = -32.0 / 45.0
# Largest ratio of the bends of p^2 along both axes on a straight strip.
_MAX_STRIP_BEND_RATIO = 0.002
# Distance from a free border, in cells, within which the spline through the heights is less certain.
_BORDER_CELLS = 3.0
# Square of the pressure beside the highest cell over its own, up to which that neighbour is as good as open: beside a
# ridge two cells wide it was 0.0006, and the maximum 17 % too small.
_MIN_INNER_PRESSURE = 0.02
# Cells across a narrow contact: a ridge of two that pressed alike lacked 18 % of its maximum.
_NARROW_CELLS = 2
# Largest relative change by the fourth-order term of a summit for which the term is small.
_MAX_QUARTIC_CHANGE = 0.2
# Smallest bend of the gap three cells from a tip over that beside it, and rise on one side over that on the other; and
# largest bend beside it over that at it.
_MIN_TIP_BEND = 0.08
_MAX_TIP_BEND = 0.84
# Cells on each side of the highest, within which a ridge ends, and the largest change of its load over its length to
# the next cell, and curvature along it over that across it.
_RIDGE_REACH = 3
_MAX_RIDGE_BEND = 0.1
# Coefficients of the polynomial through five cells, from the constant on.
_POLYNOMIAL = np.linalg.inv(np.vander(np.arange(-TIP_REACH, TIP_REACH + 1.0), increasing=True))
# Distance of the maximum from the centre of the highest cell, in cells along an axis: half the diagonal.
_MAX_OFFSET_CELLS = 0.71
# Standard deviation of the maximum pressure of surfaces that loads have changed, over that of the quadratic, over the
# fall to a cell beside, and where the pressure ends with a finite value relative over that of the area. Set on draw 1
# of benchmarks/memory_classes.py, the last on a ball worn flat, whose pressure errs as its area.
_CHANGED_STD = (0.5, 0.3, 0.35)
# Height lost at an edge, over what the pressure there displaces over a cell, from which wear has rounded what would be
# an unbounded pressure.
_MIN_ROUNDING = 0.1
# Factor from which the pressure at a border that cuts the contact will be the highest on cells a quarter as long: there
# it doubles, as their inverse root; of those that were at 0.42 to 0.53 of the highest, three of six did.
_BORDER_RISE = 3.0
_UNBOUNDED_WARNING = WarningText(
    "at a sharp edge or a crease of the contact the pressure is unbounded: its maximum grows with every grid",
    "sharp edge",
)
_BORDER_WARNING = WarningText(
    "the border cuts the contact, where the pressure is unbounded: its maximum grows with every grid",
    "sharp edge",
)
_NON_MEASURED_WARNING = WarningText(
    "points inside the contact were not measured: beside them the pressure is unbounded, and depends on the grid",
    "non-measured points",
)


@responses.register("peak-pressure")
@attrs.frozen
class PeakPressure(Quantity):
    r"""Maximum of the contact pressure, Pa.

    Each patch has the maximum :math:`\tfrac{3F}{2A}(1 - \tfrac{32}{45} c_4 a^2 / c_2)` of a summit
    :math:`c_2 r^2 + c_4 r^4`, A its area, that of a quadratic through p^2 around its highest cell, and on a long ridge
    :math:`\sqrt{P k E^* / \pi}` by its load P over its length and its curvature k, weighted by the inverse of their
    variances. Where the pressure is limited the maximum is at most the limit.

    References
    ----------
    Popov, Hess, Willert, Handbook of Contact Mechanics (2019), sec. 2.3.8, https://doi.org/10.1007/978-3-662-58709-6
    Johnson, Contact Mechanics (1985), eq. 4.45, https://doi.org/10.1017/CBO9781139171731
    """

    # Bounded maxima lie away from the edges and creases that both grids tell of.
    flagged_factors = 0.0, 1.0

    def respond(self, solution: ContactSolution) -> Estimate:
        """Return the maximum pressure, its uncertainty and its sampling error."""
        # A study asks for it with its responses, its figures and its warnings.
        if self == PeakPressure():
            return solution._keep("peak pressure", lambda: self._respond(solution))
        return self._respond(solution)

    def _respond(self, solution: ContactSolution) -> Estimate:
        return attrs.evolve(super().respond(solution), relative_sampling=defer_peak_sampling(solution))

    def find(self, solution: ContactSolution, area: Area) -> Estimate:
        """Return the maximum pressure; see `Quantity.find`."""
        patches = solution.patches
        if patches.count == 0:
            return Estimate(0.0, 0.0, "Pa")
        highest = find_lowest(solution, -solution.pressure)
        limit = np.broadcast_to(solution.pressure_limit, solution.contact.shape)
        own = 0.0
        if solution.capped:
            own = float(np.max(limit, where=solution.parts.own(solution.saturated), initial=0.0))
        reached = solution.parts.highest(own)
        if reached > 0.0:
            return Estimate(reached, 0.0, "Pa", pass_on_warnings(area))
        sharpness = _find_sharpness(solution, highest)
        quadratic, quadratic_std = _fit_quadratics(solution, highest, sharpness)
        with np.errstate(all="ignore"):
            ridge, ridge_std = _find_ridges(solution, highest)
            summit, summit_std = _find_summits(solution, area, highest)
            weight = np.where(np.isfinite(ridge_std), quadratic_std**2 / (quadratic_std**2 + ridge_std**2), 0.0)
            quadratic_std = np.where(weight > 0.0, np.sqrt(weight) * ridge_std, quadratic_std)
        quadratic = weight * ridge + (1.0 - weight) * quadratic
        weight = np.where(np.isfinite(summit_std), quadratic_std**2 / (quadratic_std**2 + summit_std**2), 0.0)
        value = weight * np.where(np.isfinite(summit_std), summit, 0.0) + (1.0 - weight) * quadratic
        std = value * np.sqrt(weight) * np.where(np.isfinite(summit_std), summit_std, 0.0)
        std = np.where(weight > 0.0, std, value * quadratic_std)
        top = int(np.argmax(value))
        peak = float(value[top])
        is_bounded = _is_bounded(solution, highest[top])
        if _meets_non_measured(solution):
            more: WarningText | None = _NON_MEASURED_WARNING
        elif not is_bounded and any(find_unbounded(solution)):
            more = _UNBOUNDED_WARNING
        else:
            more = _BORDER_WARNING if not is_bounded and _is_highest_at_border(solution, highest[top]) else None
        pointed = peak * _find_tip_error(solution, highest[top : top + 1], int(patches.cells[top]), sharpness[top])
        if solution._is_changed:
            pointed = 0.0
            # What loads before have left is not a summit: the pressure may bend where the contact once ended.
            top = int(np.argmax(_gather(solution, solution.pressure, highest, 0)))
            peak, fall = _find_step(solution, highest[top : top + 1])
            by_fit, by_fall, by_area = _CHANGED_STD
            worn = 0.0 if ends_as_root(solution) else by_area * area.uncertainty / area.value
            # The maximum may lie between two cells; a quadratic exceeds a top that a limit has cut off.
            between = 0.0 if solution.capped else float(quadratic[top]) - peak
            std[top] = math.hypot(peak * by_fit * float(quadratic_std[top]), between, by_fall * fall, peak * worn)
        uncertainty = math.hypot(float(std[top]), pointed, _find_residual_std(solution)) if more is None else peak
        peak = min(peak, float(solution.pressure_limit.max()))
        warnings = pass_on_warnings(area)
        return warn_if_uncertain(peak, uncertainty, "Pa", warnings if more is None else (*warnings, more))


def _find_sharpness(solution: ContactSolution, highest: IntArray) -> Array:
    """Return sharpness over resolution ratio, no unit: a quarter on waves, zero on paraboloids, more on tips."""
    mine, places = solution.parts.find(highest)
    sharpness = np.zeros(highest.size)
    sharpness[mine] = np.nan_to_num(find_sharpness(solution, places))
    return solution.parts.total(sharpness) / (curvature_resolution(solution) + calibration.MIN_RESOLUTION_RATIO)


def _find_tip_error(solution: ContactSolution, highest: IntArray, cells: int, sharpness: float) -> float:
    """Return the relative error of the pressure at a tip, which rises between the cells, also if only its gap shows."""
    near = _gather(solution, solution.initial_gap, highest, 2 * TIP_REACH)[..., 0]
    if _is_bell(near) or _is_rim(near):
        return 0.0
    first, certain, most = calibration.TIP_PEAK_ERROR
    sharp = most * min(max((sharpness - first) / (certain - first), 0.0), 1.0)
    inner = slice(TIP_REACH, 3 * TIP_REACH + 1)
    pointed = fit_hyperboloid(near[inner, inner])[1]
    most, first, steep = calibration.POINTED_PEAK_ERROR
    by_gap = most * min(pointed / first, 1.0) + steep * max(pointed - first, 0.0)
    return float(math.hypot(sharp, by_gap) * cells**-0.25)


def _is_bell(near: Array) -> bool:
    """Return whether the gap around a summit bends back beside it or bends evenly there, shape (9, 9).

    At tips it bends less and less: r^1.75 three cells away at least 0.7 times, r^1.1 0.1 times as much as beside the
    summit, a bell of a standard deviation of four cells 0.1 times, and a narrower one the other way.
    """
    bends = np.sum([np.diff(line, 2) for line in _list_lines(near)], axis=0)
    beside = bends[2] + bends[4]
    return bool(bends[0] + bends[6] < _MIN_TIP_BEND * beside or beside > 2.0 * _MAX_TIP_BEND * bends[3])


def _is_rim(near: Array) -> bool:
    """Return whether the gap around the highest pressure rises on one side alone, as at the rim of a land."""
    middle = len(near) // 2
    rises = [line[[middle - TIP_REACH, middle + TIP_REACH]] - line[middle] for line in _list_lines(near)]
    return any(float(rise.min()) < _MIN_TIP_BEND * float(rise.max()) for rise in rises)


def _list_lines(near: Array) -> tuple[Array, ...]:
    """Return the four lines through the middle of a square window: along both axes and both diagonals."""
    return near[:, len(near) // 2], near[len(near) // 2], np.diagonal(near), np.diagonal(near[::-1])


def _find_residual_std(solution: ContactSolution) -> float:
    """Return the standard deviation of the pressure because the gap in contact is not zero, Pa."""
    step = math.sqrt(solution.grid.resolved.cell_area)
    modulus = float(solution.effective_modulus(1.0 / step))
    gap = solution.residuals.error * solution.residuals.scale
    return calibration.RESIDUAL_PEAK_STD * modulus * gap / step


def _fit_quadratics(solution: ContactSolution, highest: IntArray, sharpness: Array) -> tuple[Array, Array]:
    """Return the maximum of a quadratic through p^2, and its relative error."""
    near = _gather(solution, solution.pressure, highest, 2) ** 2
    along_x = near[:, 2]
    along_y = near[2]
    here = near[2, 2]
    fx = 0.5 * (along_x[3] - along_x[1])
    fy = 0.5 * (along_y[3] - along_y[1])
    fxx = along_x[3] - 2 * here + along_x[1]
    fyy = along_y[3] - 2 * here + along_y[1]
    fxy = 0.25 * (near[3, 3] + near[1, 1] - near[1, 3] - near[3, 1])
    determinant = fxx * fyy - fxy**2
    peaked = (fxx < 0.0) & (fyy < 0.0) & (determinant > 0.0)
    safe = np.where(peaked, determinant, 1.0)
    # Along a ridge that hardly bends, or rises, take the maximum across it.
    x = -fx / np.where(fxx < np.minimum(fyy, 0.0), fxx, -np.inf)
    y = -fy / np.where(fyy < np.minimum(fxx, 0.0), fyy, -np.inf)
    x = np.clip(np.where(peaked, (fxy * fy - fyy * fx) / safe, x), -_MAX_OFFSET_CELLS, _MAX_OFFSET_CELLS)
    y = np.clip(np.where(peaked, (fxy * fx - fxx * fy) / safe, y), -_MAX_OFFSET_CELLS, _MAX_OFFSET_CELLS)
    top = here + 0.5 * (fx * x + fy * y)
    # Uniform pressure on each cell makes the discrete pressure too peaked, as it moves the edge.
    bend = np.minimum(-(fxx + fyy) / here, calibration.MAX_PEAK_BEND)
    excess = calibration.PEAK_EXCESS * solution.edge_shift * bend * here
    # The error of the fit is largest across a ridge. The third difference tells how far p^2 is from even.
    mean = -0.5 * (fxx + fyy) / here
    difference = np.hypot(0.5 * (fxx - fyy), fxy) / here
    across = np.abs(mean + difference)
    skew = 6.0 * np.hypot(_POLYNOMIAL[3] @ along_x, _POLYNOMIAL[3] @ along_y) / here
    first, skewed, cubic = calibration.PEAK_ERROR
    blunt = calibration.BLUNT_PEAK_ERROR * np.clip(-sharpness / calibration.BLUNT_SHARPNESS, 0.0, 1.0)
    # Along a straight strip all cells have the same error; on an oblique ridge the highest cell lies nearer its crest.
    alike = np.minimum(np.abs(fxx), np.abs(fyy)) < _MAX_STRIP_BEND_RATIO * np.maximum(np.abs(fxx), np.abs(fyy))
    oblique = np.where(peaked, fxy**2 / np.where(peaked, fxx * fyy, 1.0), 0.0)
    uneven = blunt * across + skewed * skew + cubic * across**3
    error = across * (np.where(alike, calibration.STRIP_PEAK_FACTOR, 1.0) * first + (1.0 - 0.5 * oblique) * uneven)
    error = np.where(alike, np.hypot(error, calibration.STRAIGHT_PEAK_STD * np.abs(across) ** 0.75), error)
    # A parabola through an open cell is too low, where heights vary from cell to cell.
    open_ = np.minimum.reduce([along_x[1], along_x[3], along_y[1], along_y[3]]) <= _MIN_INNER_PRESSURE * here
    open_ |= _find_cut(solution, highest)
    compact, ridge, single = calibration.OPEN_NEIGHBOUR_ERROR
    slender = 1.0 - np.clip((mean - difference) / np.where(across > 0.0, across, 1.0), 0.0, 1.0)
    row = (np.maximum(along_x[1], along_x[3]) == 0.0) | (np.maximum(along_y[1], along_y[3]) == 0.0)
    lacking = compact + ridge * slender * np.where(row, 2.0, 1.0) + single / solution.patches.cells
    # Where the grid resolves the heights, only of contacts one or two cells wide.
    across_cells = [np.count_nonzero(line > _MIN_INNER_PRESSURE * here, axis=0) for line in (along_x, along_y)]
    narrow = np.minimum(*across_cells) <= _NARROW_CELLS
    lacking *= np.where(narrow, 1.0, min(curvature_resolution(solution), 1.0) ** 2)
    error = np.where(open_, np.maximum(error, lacking), error)
    return np.sqrt(np.maximum(top - excess, 0.0)), error


def _find_ridges(solution: ContactSolution, highest: IntArray) -> tuple[Array, Array]:
    """Return the maximum pressure of each patch as a long ridge, and its relative error; infinite without a ridge.

    The load over the length is that of the cells, however few are in contact across it, and its crest between the cells
    that of a polynomial.
    """
    none = np.zeros(highest.size), np.full(highest.size, np.inf)
    # With layers the modulus of a ridge depends on its width; what loads before have left is not a ridge.
    if solution.moduli is not None or solution.capped or solution._is_changed:
        return none
    gap = _gather(solution, solution.initial_gap, highest, TIP_REACH)
    near = _gather(solution, solution.pressure, highest, _RIDGE_REACH)
    along, crosses, width = _find_course(gap, *solution.grid.spacing)
    loads, ends = _sum_across(np.where(crosses, near, np.swapaxes(near, 0, 1)))
    bend, bent = _bend_at_crest(np.where(crosses, gap[:, 2], gap[2]))
    modulus = float(solution.effective_modulus(1.0 / math.sqrt(solution.grid.resolved.cell_area)))
    # Of an oblique ridge the highest cell lies nearer its crest, not where its load is largest.
    most = loads.max(axis=0)
    pressure = np.sqrt(modulus * most * bend / (np.pi * width))
    smallest, unresolved = calibration.RIDGE_PEAK_ERROR
    uneven = 0.25 * np.ptp(loads, axis=0) / most
    error = np.sqrt(smallest**2 + uneven**2 + bent**2 + (unresolved * curvature_resolution(solution) ** 2) ** 2)
    here = loads[_RIDGE_REACH]
    beside = loads[_RIDGE_REACH - 1 : _RIDGE_REACH + 2]
    long = (along < _MAX_RIDGE_BEND) & (np.abs(beside - here).max(axis=0) < _MAX_RIDGE_BEND * here)
    known = long & ends & (bend > 0.0) & ~_find_cut(solution, highest, _RIDGE_REACH)
    return np.where(known, pressure, 0.0), np.where(known & np.isfinite(pressure), error, np.inf)


def _find_course(gap: Array, dx: float, dy: float) -> tuple[Array, Mask, Array]:
    """Return the course of ridges through the middle of the gap, shape (5, 5, n).

    It is the curvature along a ridge over that across it, whether lines along x cross it in fewer cells than those
    along y, and the width across it, m, of a cell of these lines.
    """
    bend_x = (gap[1, 2] - 2.0 * gap[2, 2] + gap[3, 2]) / dx**2
    bend_y = (gap[2, 1] - 2.0 * gap[2, 2] + gap[2, 3]) / dy**2
    twist = (gap[3, 3] + gap[1, 1] - gap[1, 3] - gap[3, 1]) / (4.0 * dx * dy)
    half = np.hypot(0.5 * (bend_x - bend_y), twist)
    larger = 0.5 * (bend_x + bend_y) + half
    # The square of the cosine of the angle of its normal to x.
    along_x = 0.5 + 0.25 * (bend_x - bend_y) / half
    crosses = along_x * dy**2 >= (1.0 - along_x) * dx**2
    cosine = np.sqrt(np.where(crosses, along_x, 1.0 - along_x))
    return np.abs(larger - 2.0 * half) / larger, crosses, np.where(crosses, dx, dy) * cosine


def _sum_across(lines: Array) -> tuple[Array, Mask]:
    """Return the pressure summed up to the ends of the contact on each line, and whether that in the middle ends.

    `lines` have the shape (2 _RIDGE_REACH + 1, lines, n), across ridges in the first axis.
    """
    ways = lines[_RIDGE_REACH:], lines[_RIDGE_REACH::-1]
    inside = [np.logical_and.accumulate(way > 0.0, axis=0) for way in ways]
    sums = sum(np.sum(way, where=part, axis=0) for way, part in zip(ways, inside, strict=True))
    return sums - lines[_RIDGE_REACH], ~(inside[0][-1] | inside[1][-1])[_RIDGE_REACH]


def _bend_at_crest(across: Array) -> tuple[Array, Array]:
    """Return the second difference at the crest of a polynomial through five cells, shape (5, n), zero without a crest.

    The other array is its relative error: a quarter of the change to the middle cell.
    """
    _, slope, square, cubic, quartic = _POLYNOMIAL @ across
    crest = np.clip(-0.5 * slope / square, -_MAX_OFFSET_CELLS, _MAX_OFFSET_CELLS)
    bend = 2.0 * square + crest * (6.0 * cubic + 12.0 * crest * quartic)
    error = 0.25 * (np.diff(across, 2, axis=0)[1] / bend - 1.0)
    return np.where(square > 0.0, bend, 0.0), error


def _is_bounded(solution: ContactSolution, highest: IntArray) -> bool:
    """Return whether loads before have left no place where the pressure is unbounded: by a limit of it, or by wear.

    The pressure of a worn contact ends with a finite value, as under a sharp edge.
    """
    if solution._offset is None or solution.capped:
        return solution._offset is not None
    edge = find_cut_cells(solution)
    edge.flat[highest] = True
    step = math.sqrt(solution.grid.resolved.cell_area)
    lost = float(np.mean(solution._offset, where=edge))
    displaced = step * float(np.mean(solution.pressure, where=edge)) / float(solution.effective_modulus(1.0 / step))
    return not ends_as_root(solution) and lost > _MIN_ROUNDING * displaced


def _find_step(solution: ContactSolution, highest: IntArray) -> tuple[float, float]:
    """Return the pressure of a cell, Pa, and by how much it falls to the second lowest of its four neighbours."""
    near = _gather(solution, solution.pressure, highest, 1)[..., 0]
    here = float(near[1, 1])
    beside = sorted((near[0, 1], near[2, 1], near[1, 0], near[1, 2]))
    return here, here - float(beside[1])


def _find_cut(solution: ContactSolution, cells: IntArray, reach: int = 0) -> Mask:
    """Return which cells lie at a free border, which cuts the contact there, or so many cells from it."""
    nx, ny = solution.grid.shape
    i, j = np.divmod(cells, ny)
    free_x, free_y = solution.boundary.free_axes
    return np.asarray(free_x & (np.minimum(i, nx - 1 - i) <= reach) | free_y & (np.minimum(j, ny - 1 - j) <= reach))


def _is_highest_at_border(solution: ContactSolution, highest: IntArray) -> bool:
    """Return whether a free border cuts the contact where its pressure is highest, or soon will be on finer grids."""
    cut = float(np.max(solution.pressure, where=find_cut_cells(solution), initial=0.0))
    highest_cut = _BORDER_RISE * solution.parts.highest(cut)
    return bool(_find_cut(solution, highest)) or highest_cut > solution.parts.highest(float(solution.pressure.max()))


def _meets_non_measured(solution: ContactSolution) -> bool:
    """Return whether non-measured points that would touch lie beside the contact."""
    return solution.non_measured is not None and bool(
        (grow(solution.non_measured, 1, solution.boundary) & solution.contact).any()
    )


def _find_summits(solution: ContactSolution, area: Area, highest: IntArray) -> tuple[Array, Array]:
    """Return the maximum pressure of each patch as one summit, and its relative error; infinite without a summit."""
    patches = solution.patches
    if area.patches is None or solution.capped:
        return np.zeros(patches.count), np.full(patches.count, np.inf)
    found = hertz_areas(solution)
    mean = found.summits.curvature
    factor = found.correction.factor
    single = np.isfinite(found.error[1:])
    areas = np.where(single, found.area[1:], solution.grid.area)
    near = _gather(solution, solution.initial_gap, highest, 2)
    dx, dy = solution.grid.spacing
    second = np.array((1.0, -2.0, 1.0))
    fourth = np.array((1.0, -4.0, 6.0, -4.0, 1.0))
    bilaplacian = np.tensordot(fourth, near[:, 2], 1) / dx**4 + np.tensordot(fourth, near[2], 1) / dy**4
    bilaplacian += 2.0 * np.einsum("i,j,ijk", second, second, near[1:4, 1:4]) / (dx * dy) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        change = _QUARTIC_FACTOR * bilaplacian * areas / np.pi / (32.0 * mean)
        error = calibration.MIN_SUMMIT_ERROR + found.error[1:]
        error = error + calibration.BORDER_SUMMIT_ERROR * np.clip(
            1.0 - _measure_room(solution, found.summits) / _BORDER_CELLS, 0.0, 1.0
        )
    known = single & (np.abs(change) < _MAX_QUARTIC_CHANGE)
    pressure = 1.5 * patches.forces * factor / areas * (1.0 + np.where(known, change, 0.0))
    return pressure, np.where(known & np.isfinite(pressure), error, np.inf)


def _measure_room(solution: ContactSolution, summits: Summits) -> Array:
    """Return how many cells lie between each ellipse and the next free border, shape (count,)."""
    room = np.full(summits.row.shape, np.inf)
    axes = zip((summits.row, summits.column), summits.extents, solution.grid.shape, solution.grid.spacing, strict=True)
    for free, (at, extent, n, step) in zip(solution.boundary.free_axes, axes, strict=True):
        if free:
            room = np.minimum(room, np.minimum(at, n - 1 - at) + 0.5 - extent / step)
    return room


def _gather(solution: ContactSolution, field: RealArray, at: IntArray, reach: int) -> Array:
    """Return the field around cells of the domain, shape (2 reach + 1, 2 reach + 1, n)."""
    mine, places = solution.parts.find(at)
    found = np.zeros((2 * reach + 1, 2 * reach + 1, at.size), dtype=field.dtype)
    found[..., mine] = gather_around(field, places, reach, solution.boundary)
    return solution.parts.total(found)
