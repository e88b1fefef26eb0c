"""The maximum of a stress between points and depths, its place and uncertainty."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact._answers.areas.cells import find_spanning_patches
from roughcontact._answers.areas.edges import MAX_RELATIVE_STD
from roughcontact._answers.subsurface.field import (
    Measure,
    StressField,
    find_largest,
    locate,
    maximum_shear,
    shear_invariant,
    von_mises,
)
from roughcontact._base.arrays import Array, RealArray
from roughcontact._base.units import Estimate, WarningText, percent, si
from roughcontact._parts.grid import Boundary
from roughcontact._solve.solution import ContactSolution

# Factors of 1/n^2 and 1/n^4 in the relative error of the maximum at a depth of n cells: set on Hertz's balls and on
# rough surfaces, and judged on others by docs/studies/stress.py.
_GRID_ERROR_TERMS = (0.012, 0.004)
# Error by the distance of the depths, over the rise of the parabola above the largest value at a depth.
_INTERPOLATION_ERROR = 0.3
# Smallest relative error: by float32 and by the tolerance of the solver.
MIN_RELATIVE_ERROR = 2e-4
# The same under lines, whose straight edges err alike, over 1/n^1.5. Set on cylinders at random places.
_STRAIGHT_STD = 0.015
# Depth in cells below which the stress depends on the shape of the cells at the edges of the contact, and errs as the
# maximum pressure does.
MIN_DEPTH_CELLS = 2.0
# Weight of the relative uncertainty of that pressure. Set on rough surfaces of two to four cells a shortest wave.
_PEAK_WEIGHT = 0.7
# Weight of the difference of that pressure from the highest of the cells, over the latter. Set on 106 smooth contacts:
# ridges one to two cells wide lack 37 to 57 % of the pressure and 32 to 47 % of the stress.
_CELL_WEIGHT = 0.49
# Relative error of a maximum at the surface inside a contact, where cells may smooth a larger one at its edge.
_SURFACE_ERROR = 0.03
# Distance of the depths on both sides of an interface, over its depth: that of rounding.
_SIDE = 1e-9
# Warnings of cells that are too large.
_CELL_RULES = ("resolution", "depths")
# Default depths: the first, in cells; the ratio of each to the one before; the last, in radii of the largest patch, and
# its bounds, in cells and in sides of the domain.
_FIRST_DEPTH_CELLS = 0.5
_DEPTH_RATIO = 1.15
_LAST_DEPTH_RADII = 2.0
_MIN_LAST_DEPTH_CELLS = 4.0
_MAX_LAST_DEPTH_SIDES = 0.5


@attrs.frozen
class StressMaximum(Estimate):
    """The maximum of a stress below a surface, and its place.

    Attributes
    ----------
    value
        The maximum, Pa.
    uncertainty
        One standard deviation, Pa.
    unit
        ``"Pa"``.
    x, y, depth
        Its place, m; the origin is the centre of the domain at the surface.
    warnings
        Why the value must not be trusted, in sentences; empty without a reason.
    """

    value: float
    uncertainty: float
    x: float
    y: float
    depth: float
    unit: str = attrs.field(default="Pa", init=False)
    warnings: tuple[str, ...] = ()

    def __str__(self) -> str:
        relative = self.uncertainty / self.value if self.value > 0.0 else 0.0
        place = f"x = {si(self.x, 'm')}, y = {si(self.y, 'm')}, depth {si(self.depth, 'm')}"
        return f"{si(self.value, 'Pa', 5)} +- {percent(relative)} at {place}{self._reasons}"


@attrs.frozen
class PlanePeak:
    """The maximum in a plane, in its scale, and its place, m."""

    value: float
    x: float
    y: float


def find_von_mises(field: StressField, boundary: Boundary) -> PlanePeak:
    """Return the maximum of the von Mises stress in a plane, between the points by a parabola along each axis."""
    return _find_peak(field, boundary, von_mises(field.values), von_mises)


def find_shear(field: StressField, boundary: Boundary) -> PlanePeak:
    """Return the largest of the maximum shear stresses in a plane, between the points by a parabola along each axis."""
    # The shear stress lies between sqrt(3)/2 and 1 of this root, so that few points need the angle.
    root = np.sqrt(shear_invariant(field.values))
    shear = math.sqrt(0.75) * root
    near = np.nonzero(root >= float(shear.max()))
    shear[near] = maximum_shear(field.values[:, near[0], near[1]])
    return _find_peak(field, boundary, shear, maximum_shear)


def _find_peak(field: StressField, boundary: Boundary, stress: RealArray, measure: Measure) -> PlanePeak:
    i, j = find_largest(stress)
    value = float(stress[i, j])
    offsets = []
    for axis, place in enumerate((i, j)):
        count = stress.shape[axis]
        beside = np.array((place - 1, place + 1))
        if boundary.repeats[axis]:
            beside %= count
        if count < 3 or beside[0] < 0 or beside[1] >= count:
            offsets.append(0.0)
            continue
        points = (beside, j) if axis == 0 else (i, beside)
        left, right = measure(field.values[:, *points])
        shift, rise = _fit_parabola(float(left), float(stress[i, j]), float(right))
        offsets.append(shift)
        value += rise
    x, y = (
        at + part * step for at, part, step in zip(locate(field.grid, i, j), offsets, field.grid.spacing, strict=True)
    )
    return PlanePeak(value, x, y)


def _fit_parabola(left: float, middle: float, right: float) -> tuple[float, float]:
    """Return where a parabola through three points has its maximum, in steps from the middle, and its rise above it."""
    bend = left - 2.0 * middle + right
    slope = 0.5 * (right - left)
    if bend >= 0.0:
        return 0.0, 0.0
    shift = min(max(-slope / bend, -0.5), 0.5)
    return shift, shift * (slope + 0.5 * bend * shift)


def find_maximum(depths: Array, peaks: Sequence[PlanePeak], scale: float, cell: float) -> StressMaximum:
    """Return the maximum over all depths, between them by a parabola over the logarithm of the depth.

    Parameters
    ----------
    depths
        Depths, m, ascending.
    peaks
        The maximum at each of them.
    scale
        The unit of the peaks, Pa.
    cell
        The larger side of a cell, m.
    """
    values = np.array([peak.value for peak in peaks])
    top = int(np.argmax(values))
    value = float(values[top])
    depth = float(depths[top])
    rise = 0.0
    warnings = []
    at_surface = depth == 0.0 and values.size > 1
    if 0 < top < values.size - 1:
        near = depths[top - 1 : top + 2]
        logarithmic = near[0] > 0.0
        place = np.log(near / depth) if logarithmic else near / depth - 1.0
        coefficients = np.polyfit(place, values[top - 1 : top + 2], 2)
        if coefficients[0] < 0.0:
            shift = float(np.clip(-0.5 * coefficients[1] / coefficients[0], place[0], place[2]))
            rise = float(np.polyval(coefficients, shift)) - value
            value = value + rise
            depth = depth * (math.exp(shift) if logarithmic else 1.0 + shift)
    elif not at_surface:
        end = "the smallest" if top == 0 else "the largest"
        text = f"the maximum lies at {end} of the depths, {si(depth, 'm')}: beyond it there may be a larger one"
        warnings.append(WarningText(text, "depths", depth))
    cells = depth / cell
    if at_surface:
        relative = _SURFACE_ERROR
    else:
        inverse = 1.0 / max(cells, 1e-3) ** 2
        relative = math.hypot(
            MIN_RELATIVE_ERROR, min(_GRID_ERROR_TERMS[0] * inverse + _GRID_ERROR_TERMS[1] * inverse**2, 1.0)
        )
    uncertainty = math.hypot(relative * value, _INTERPOLATION_ERROR * rise)
    return StressMaximum(value * scale, uncertainty * scale, peaks[top].x, peaks[top].y, depth, tuple(warnings))


def with_interfaces(depths: Array, interfaces: Array, base: float) -> Array:
    """Return depths down to a base, itself and both sides of each interface among them, m, ascending."""
    last = min(float(depths.max()), base)
    inside = interfaces[interfaces < last]
    return np.unique(np.concatenate((depths[depths < last], (1.0 - _SIDE) * inside, (1.0 + _SIDE) * inside, [last])))


def find_maxima_of_layers(
    depths: Array, interfaces: Array, peaks: Sequence[PlanePeak], scale: float, cell: float
) -> dict[int, StressMaximum]:
    """Return the maximum in each layer by its number, across whose interfaces the stress jumps; see `find_maximum`."""
    layer = np.searchsorted(interfaces, depths)
    found = {}
    for number in np.unique(layer):
        places = np.flatnonzero(layer == number)
        one = find_maximum(depths[places], [peaks[int(place)] for place in places], scale, cell)
        # At an interface a layer ends: nothing of it lies beyond the depths.
        if np.isclose(one.depth, interfaces, rtol=1e-6, atol=0.0).any():
            kept = tuple(text for text in one.warnings if getattr(text, "rule", "") != "depths")
            one = attrs.evolve(one, warnings=kept)
        found[int(number)] = one
    return found


def judge_depth(found: StressMaximum, solution: ContactSolution) -> StressMaximum:
    """Return a maximum with the uncertainty of its depth in cells, warned of where it may err by more than 10 %."""
    cells = found.depth / max(solution.grid.resolved.spacing)
    if found.value <= 0.0:
        return found
    relative = found.uncertainty / found.value
    if find_spanning_patches(solution).any():
        relative = math.hypot(relative, _STRAIGHT_STD / max(cells, 1.0) ** 1.5)
    if cells < MIN_DEPTH_CELLS:
        peak = solution.peak_pressure(uncertainty="model")
        # The stress is that of the pressure of the cells, whose highest may be far from the maximum between them.
        highest = solution.parts.highest(float(np.max(solution.pressure)))
        lacking = _CELL_WEIGHT * (peak.value / highest - 1.0)
        relative = math.hypot(relative, _PEAK_WEIGHT * peak.uncertainty / peak.value, lacking)
    return warn_of_depth(attrs.evolve(found, uncertainty=relative * found.value), solution)


def is_near_surface(found: StressMaximum, solution: ContactSolution) -> bool:
    """Return whether a maximum depends on the shape of the cells, in a contact of heights without a history or laws."""
    near = found.depth < MIN_DEPTH_CELLS * max(solution.grid.resolved.spacing)
    fresh = not (solution._laws or solution._is_changed or solution.capped) and solution.parts.is_whole
    return near and fresh and found.uncertainty < found.value


def drop_warnings_of_cells(found: StressMaximum) -> StressMaximum:
    """Return a maximum in which the cells have no part, without their warnings."""
    kept = tuple(text for text in found.warnings if getattr(text, "rule", "") not in _CELL_RULES)
    return attrs.evolve(found, warnings=kept)


def warn_of_depth(found: StressMaximum, solution: ContactSolution) -> StressMaximum:
    """Return a maximum with a warning if it is near the surface and may err by more than 10 %."""
    cells = found.depth / max(solution.grid.resolved.spacing)
    if cells >= MIN_DEPTH_CELLS or found.uncertainty <= MAX_RELATIVE_STD * found.value:
        return found
    place = f"only {cells:.2g} cells below" if cells > 0.0 else "at"
    text = f"the maximum lies {place} the surface, where it depends on the grid"
    return attrs.evolve(found, warnings=(*found.warnings, WarningText(text, "resolution", cells)))


def default_depths(solution: ContactSolution) -> Array:
    """Return depths in which the maximum of the stress is found, m, ascending."""
    resolved = solution.grid.resolved
    cell = max(resolved.spacing)
    longest = _MAX_LAST_DEPTH_SIDES * max(resolved.size)
    last = max(_MIN_LAST_DEPTH_CELLS * cell, min(_LAST_DEPTH_RADII * _find_largest_radius(solution), longest))
    count = math.ceil(math.log(last / (_FIRST_DEPTH_CELLS * cell)) / math.log(_DEPTH_RATIO)) + 1
    return np.asarray(np.geomspace(_FIRST_DEPTH_CELLS * cell, last, count), dtype=np.float64)


def _find_largest_radius(solution: ContactSolution) -> float:
    """Return the radius of a disc as large as the largest patch, or half the width of a strip, m."""
    patches = solution.patches
    if patches.count == 0:
        return 0.0
    largest = int(patches.cells.argmax())
    radius = math.sqrt(float(patches.cells[largest]) * solution.grid.resolved.cell_area / math.pi)
    if not find_spanning_patches(solution)[largest]:
        return radius
    edge = float(patches.perimeters[largest])
    return max(radius, 2.0 * float(patches.areas[largest]) / edge) if edge > 0.0 else math.inf
