"""The maximum pressure between the cells."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._answers.areas import quantity_calibration as calibration
from roughcontact._answers.areas.cells import extend, find_cut_patches, grow
from roughcontact._answers.areas.curvature import curvature_resolution, lay_ratio
from roughcontact._answers.areas.edges import STRAIGHT
from roughcontact._answers.areas.hertz import find_sharpness, hertz_areas
from roughcontact._answers.areas.total import warn_if_uncertain
from roughcontact._base.checks import Array, IntArray, Mask
from roughcontact._parts.grid import Boundary
from roughcontact._solve.solution import Area, ContactSolution, Estimate, QuantityEstimator, quantities

# Change of the maximum pressure over 3 F / 2A of a summit c2 r^2 + c4 r^4, times c4 a^2 / c2: (32/9 - 32/5) / 4.
_QUARTIC = -32.0 / 45.0
# Smallest ratio of the curvatures of a summit: longer contacts are strips.
_SLENDEREST = 0.05
# Largest change by that term for which it is a small one.
_LARGEST_CHANGE = 0.2
# Distance of the maximum from the centre of the highest cell, in cells along an axis: half the diagonal.
_FURTHEST = 0.71
# Cells of a patch from which a maximum at its edge is that of a sharp edge.
_SHARP_PATCH = 9
_SHARP = (
    "the maximum lies at a sharp edge or at the border, where the pressure is unbounded: its value depends on the grid"
)
_HOLES = "points inside the contact were not measured: beside them the pressure is unbounded, and depends on the grid"


@quantities.register("peak-pressure")
@attrs.frozen
class PeakPressure(QuantityEstimator):
    r"""Maximum of the contact pressure, Pa.

    Each patch has the maximum :math:`\tfrac{3F}{2A}(1 - \tfrac{32}{45} c_4 a^2 / c_2)` of a summit
    :math:`c_2 r^2 + c_4 r^4`, A its area, and that of a quadratic through p^2 around its highest cell, weighted by the
    inverse of their variances. Where the pressure is limited the maximum is at most the limit.

    References
    ----------
    Popov, Hess, Willert, Handbook of Contact Mechanics (2019), sec. 2.3.8, https://doi.org/10.1007/978-3-662-58709-6
    """

    def estimate(self, solution: ContactSolution, area: Area) -> Estimate:
        """Return the maximum pressure; see `QuantityEstimator.estimate`."""
        patches = solution.patches
        if patches.count == 0:
            return Estimate(0.0, 0.0, "Pa")
        highest = _find_highest(solution)
        limit = np.broadcast_to(solution.pressure_limit, solution.grid.shape)
        if solution.saturated.any():
            return Estimate(float(limit[solution.saturated].max()), 0.0, "Pa", _list_warnings(solution, area, None))
        quadratic, quadratic_std, inner = _fit_quadratics(solution, highest)
        lay = lay_ratio(solution)
        if lay > STRAIGHT:
            # Ridges are narrow, and the cells show little across them.
            quadratic_std = quadratic_std * (1.0 + calibration.PEAK_LAY * (1.0 - lay))
        with np.errstate(all="ignore"):
            summit, summit_std = _find_summits(solution, area, highest)
        weight = np.where(np.isfinite(summit_std), quadratic_std**2 / (quadratic_std**2 + summit_std**2), 0.0)
        value = weight * np.where(np.isfinite(summit_std), summit, 0.0) + (1.0 - weight) * quadratic
        std = value * np.sqrt(weight) * np.where(np.isfinite(summit_std), summit_std, 0.0)
        std = np.where(weight > 0.0, std, value * quadratic_std)
        std = np.hypot(std, value * _find_pointed_error(solution, highest))
        top = int(np.argmax(value))
        peak = float(value[top])
        sharp = patches.cells[top] >= _SHARP_PATCH and not inner[top]
        sharp = sharp or bool(_find_cut(solution, highest[top])) or bool(find_cut_patches(solution).any())
        more = _HOLES if _meets_holes(solution) else _SHARP if sharp else None
        uncertainty = float(std[top]) if more is None else peak
        peak = min(peak, float(limit.max()))
        return warn_if_uncertain(peak, uncertainty, "Pa", _list_warnings(solution, area, more))


def _list_warnings(solution: ContactSolution, area: Area, more: str | None) -> tuple[str, ...]:
    return area.warnings if more is None else (*area.warnings, more)


def _find_highest(solution: ContactSolution) -> IntArray:
    """Return the flat index of the cell of highest pressure in each patch, shape (count,)."""
    labels, pressure = solution.patches.labels.ravel(), solution.pressure.ravel()
    members = np.flatnonzero(labels)
    members = members[np.lexsort((-pressure[members], labels[members]))]
    return members[np.unique(labels[members], return_index=True)[1]]


def _find_pointed_error(solution: ContactSolution, highest: IntArray) -> Array:
    """Return the relative error for the pressure at a tip, which rises between the cells, shape (count,)."""
    first, certain, most = calibration.PEAK_TIP
    # Over the resolution ratio it is a quarter on waves, zero on paraboloids, more on tips, less on blunt summits.
    ratio = curvature_resolution(solution) + calibration.SMALLEST_RATIO
    sharpness = np.nan_to_num(find_sharpness(solution, highest)) / ratio
    part = np.clip((sharpness - first) / (certain - first), 0.0, 1.0)
    return np.asarray(most * part * solution.patches.cells**-0.25)


def _fit_quadratics(solution: ContactSolution, highest: IntArray) -> tuple[Array, Array, Mask]:
    """Return the maximum of a quadratic through p^2, its relative error, and whether it has contact on all sides."""
    near = _gather(solution.pressure**2, solution.boundary, highest, 1)
    here = near[1, 1]
    fx, fy = 0.5 * (near[2, 1] - near[0, 1]), 0.5 * (near[1, 2] - near[1, 0])
    fxx, fyy = near[2, 1] - 2 * here + near[0, 1], near[1, 2] - 2 * here + near[1, 0]
    fxy = 0.25 * (near[2, 2] + near[0, 0] - near[2, 0] - near[0, 2])
    determinant = fxx * fyy - fxy**2
    peaked = (fxx < 0.0) & (fyy < 0.0) & (determinant > 0.0)
    safe = np.where(peaked, determinant, 1.0)
    x = np.clip(np.where(peaked, (fxy * fy - fyy * fx) / safe, 0.0), -_FURTHEST, _FURTHEST)
    y = np.clip(np.where(peaked, (fxy * fx - fxx * fy) / safe, 0.0), -_FURTHEST, _FURTHEST)
    top = here + np.where(peaked, 0.5 * (fx * x + fy * y), 0.0)
    bend = -(fxx + fyy) / here
    # Uniform pressure on each cell makes the discrete pressure too peaked, as it moves the edge.
    excess = calibration.PEAK_EXCESS * solution.edge_shift * np.minimum(bend, calibration.LARGEST_BEND) * here
    first, second, third = calibration.PEAK_ERROR
    error = np.abs(bend) * first + bend**2 * second + bend**4 * third
    # Along a strip all cells err alike.
    error = np.where(determinant < _SLENDEREST**2 * (fxx + fyy) ** 2, calibration.PEAK_ALIKE * error, error)
    inner = np.minimum.reduce([near[0, 1], near[2, 1], near[1, 0], near[1, 2]]) > 0.0
    inner &= ~_find_cut(solution, highest)
    # A parabola through an open cell is too low, but not across a strip, along which the pressure is even.
    edge = calibration.PEAK_EDGE * np.sqrt(np.abs(fxx * fyy)) / here
    edge += calibration.PEAK_STRIP * np.maximum(-fxx, -fyy) / here
    error = np.where(inner, error, np.maximum(error, edge))
    return np.sqrt(np.maximum(top - excess, 0.0)), error, inner


def _find_cut(solution: ContactSolution, cells: IntArray) -> Mask:
    """Return which cells lie at a free border, which cuts the contact there."""
    (nx, ny), (i, j) = solution.grid.shape, np.divmod(cells, solution.grid.shape[1])
    outermost = (i == 0) | (i == nx - 1) | (j == 0) | (j == ny - 1)
    return np.asarray(outermost & (solution.boundary is Boundary.FREE))


def _meets_holes(solution: ContactSolution) -> bool:
    """Return whether non-measured points that would touch lie beside the contact."""
    return solution.non_measured is not None and bool(
        (grow(solution.non_measured, 1, solution.boundary) & solution.contact).any()
    )


def _find_summits(solution: ContactSolution, area: Area, highest: IntArray) -> tuple[Array, Array]:
    """Return the maximum pressure of each patch as one summit, and its relative error; infinite where it is none."""
    patches = solution.patches
    if area.patches is None or solution.capped:
        return np.zeros(patches.count), np.full(patches.count, np.inf)
    found = hertz_areas(solution)
    mean, spread, factor = found.summits.curvature, found.summits.spread, found.sharing.factor
    single = np.isfinite(found.error[1:])
    areas = np.where(single, found.area[1:], solution.grid.area)
    near = _gather(solution.initial_gap, solution.boundary, highest, 2)
    dx, dy = solution.grid.spacing
    second = np.array((1.0, -2.0, 1.0))
    fourth = np.array((1.0, -4.0, 6.0, -4.0, 1.0))
    bilaplacian = np.tensordot(fourth, near[:, 2], 1) / dx**4 + np.tensordot(fourth, near[2], 1) / dy**4
    bilaplacian += 2.0 * np.einsum("i,j,ijk", second, second, near[1:4, 1:4]) / (dx * dy) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        change = _QUARTIC * bilaplacian * areas / np.pi / (32.0 * mean)
        rest, square, quartic = calibration.SUMMIT_ERROR
        error = rest + square * spread**2 + quartic * np.abs(change) + 0.5 * found.error[1:]
    known = single & (np.abs(change) < _LARGEST_CHANGE)
    pressure = 1.5 * patches.forces * factor / areas * (1.0 + np.where(known, change, 0.0))
    return pressure, np.where(known & np.isfinite(pressure), error, np.inf)


def _gather(field: Array, boundary: Boundary, at: IntArray, reach: int) -> Array:
    """Return the field around cells, shape (2 reach + 1, 2 reach + 1, n)."""
    extended = extend(field, reach, boundary)
    i, j = np.divmod(at, field.shape[1])
    steps = np.arange(2 * reach + 1)
    return extended[i + steps[:, np.newaxis, np.newaxis], j + steps[:, np.newaxis]]
