"""Perimeter, number of patches, approach and mean gap, each with its uncertainty."""

from __future__ import annotations

import abc
import math

import attrs
import numpy as np

from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.approach import find_cut_shift, find_hidden_rise, find_rise, find_shift, measure_bend
from roughcontact._answers.areas.cells import (
    count_crossings,
    find_cut_patches,
    find_lost_std,
    find_spanning_patches,
    measure_obliqueness,
    measure_sides,
)
from roughcontact._answers.areas.edges import (
    CUT_OFF_CELLS,
    ends_as_root,
    is_diagonal,
    pass_on_warnings,
    trace_edges,
    warn_if_uncertain,
)
from roughcontact._answers.areas.hertz import hertz_areas
from roughcontact._answers.areas.initial_gap import average_curvature, curvature_resolution, lay_ratio
from roughcontact._answers.areas.summits import find_axes_ratio, find_beside_non_measured, is_elliptic
from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Boundary
from roughcontact._solve.solution import (
    DEFAULT_AREA,
    Area,
    AreaEstimator,
    ContactSolution,
    Estimate,
    Response,
    fill_gap,
    heal,
    responses,
)

# Relative error of lengths of edges that are straight up to the tolerance of the solution.
_STRAIGHT_LENGTH_ERROR = 1e-9
# Cells of a patch from which its traced length is not corrected.
_LARGE_PATCH_CELLS = 100
# Traced length over that of the sides of the cells, below which sharp edges of narrow patches are not traced.
_MIN_TRACED_LENGTH = 0.65
# Numbers of cells below which a patch may be a part of another one, or other patches may be missing beside it.
_SMALL_PATCH_CELLS = (4, 9)
# Relative standard deviation of the length by the sides of the cells around worn spots. Set on draw 1 of
# benchmarks/memory_classes.py: median error 0.013, at most 0.08.
_WORN_LENGTH_ERROR = 0.04
# Weights of the three outermost centres in the outward slope at the border, to second order.
_BORDER_SLOPE_WEIGHTS = np.array((2.0, -3.0, 1.0))


@attrs.frozen
class Quantity(Response[Estimate]):
    """A number of the contact that depends on its real area.

    Attributes
    ----------
    estimator
        Registered name or instance of the area estimator.
    """

    estimator: str | AreaEstimator = DEFAULT_AREA

    holds_with = frozenset({"shear", "relaxation"})

    def respond(self, solution: ContactSolution) -> Estimate:
        """Return the number and its uncertainty."""
        return self.find(heal(solution), solution.area(self.estimator, uncertainty="model"))

    @abc.abstractmethod
    def find(self, solution: ContactSolution, area: Area) -> Estimate:
        """Return the number of a healed solution, given its real contact area."""


@responses.register("perimeter")
@attrs.frozen
class EdgeLength(Quantity):
    r"""Length of the edge of the contact, m.

    Each patch has the length :math:`2\sqrt{\pi A q}` with its area A and the isoperimetric quotient q of
    Hertz's ellipse if it is a single summit, else of its traced edge.
    """

    def find(self, solution: ContactSolution, area: Area) -> Estimate:
        """Return the length; see `Quantity.find`."""
        count = solution.patches.count
        if count == 0 or solution.contact.all():
            return Estimate(0.0, 0.0, "m", pass_on_warnings(area))
        # Nothing of an edge is traced around cells that touch at their corners alone.
        if area.patches is None or area.value == 0.0:
            length = measure_sides(solution) * math.pi / 4.0
            relative = calibration.COUNTED_LENGTH_ERROR if ends_as_root(solution) else _WORN_LENGTH_ERROR
            return Estimate(length, relative * length, "m", pass_on_warnings(area))
        if _is_line(solution):
            length = measure_sides(solution)
            return Estimate(length, _STRAIGHT_LENGTH_ERROR * length, "m", pass_on_warnings(area))
        edges = trace_edges(solution)
        cell = solution.grid.cell_area
        step = math.sqrt(solution.grid.resolved.cell_area)
        mean, difference, spread, _ = (part[1:] for part in average_curvature(solution))
        # Single summits have the ellipse of their curvature, others the shape of their traced edge.
        even = is_elliptic(mean, difference, spread)
        # For edges at a border and beside non-measured points the area does not give the length.
        cut_off = find_beside_non_measured(solution) | find_cut_patches(solution)
        spanning = find_spanning_patches(solution)
        straight = edges.straight[1:]
        single = np.where(
            even & ~(cut_off | spanning | straight), 1.0 / (1.0 + (spread / calibration.UNEVEN_SPREAD) ** 4), 0.0
        )
        # Large patches may have holes or span the domain, so that no smooth convex edge bounds their quotient.
        large = solution.patches.cells >= _LARGE_PATCH_CELLS
        inside = np.maximum(edges.area[1:] - np.where(large | spanning, 0.0, CUT_OFF_CELLS) * cell, 0.3 * cell)
        traced = np.maximum(
            edges.length[1:] ** 2 / (4.0 * np.pi * inside), np.where(large | cut_off | spanning, 0.0, 1.0)
        )
        # The circle of a small patch has the sharp part of its edge too.
        around = 2.0 * np.sqrt(np.pi * area.patches) * np.where(large, 1.0, 1.0 - edges.sharp[1:])
        lobed = np.where(straight, 0.0, (1.0 - single) * np.sqrt(traced) * around)
        # Contacts at summits between the cells have the rest of the area.
        hidden = 2.0 * np.sqrt(np.pi * hertz_areas(solution).correction.hidden)
        lost = calibration.LOST_LENGTH * edges.curvature_resolution**1.5 * float(np.sum(lobed))
        length = float(np.sum(single * np.sqrt(_elliptic_quotient(mean, difference)) * around + lobed)) + lost
        length += float(np.sum(hidden))
        exact = float(np.sum(edges.length[1:], where=straight))
        # Nothing of a sharp edge is traced.
        slender = math.log(max(solution.grid.resolved.spacing) / min(solution.grid.resolved.spacing))
        excess = calibration.SHARP_LENGTH_EXCESS * (1.0 + slender)
        sharp = float(np.sum(edges.sharp_length[1:], where=~straight)) * (1.0 - excess)
        corners = math.pi * step * math.sqrt(np.count_nonzero(edges.sharp_length[1:] > 0.0))
        along_cells = calibration.SHARP_LENGTH_ERROR * (1.0 + slender)
        sharp_std = math.hypot(along_cells * sharp, corners if sharp > 0.0 else 0.0)
        lay = lay_ratio(solution)
        # Of ridges that run one way more is lost than of other edges.
        one_way = (1.0 - lay) ** 3
        uneven = calibration.UNEVEN_LENGTH_ERROR * edges.curvature_resolution * float(np.sum(lobed)) + 0.5 * lost
        # The ends of their patches are narrower than a cell, and are lost where they run across the grid.
        ended = one_way * np.where(spanning, 0.0, lobed)
        narrow = float(np.sum(ended / (1.0 + (edges.width[1:] / calibration.NARROW_PATCH_WIDTH) ** 2)))
        ends = calibration.LOST_END_LENGTH * measure_obliqueness(solution) ** 2 * narrow
        length += ends
        relative = math.hypot(calibration.LENGTH_ERROR, 0.5 * area.uncertainty / area.value)
        diagonal = 0.0
        if length > 0.0 and is_diagonal(solution, lay):
            diagonal = calibration.DIAGONAL_LENGTH_ERROR * length
        untraced = float(edges.untraced_std.sum())
        crossings = count_crossings(solution) * step
        length += calibration.UNTRACED_CUT_LENGTH[0] * crossings + exact + sharp
        # Sides of the cells count networks of ridges well, whose traced edges are short.
        counted = math.pi / 4.0 * measure_sides(solution)
        if length < _MIN_TRACED_LENGTH * counted and np.mean(solution.patches.cells) >= _SMALL_PATCH_CELLS[1]:
            return warn_if_uncertain(counted, calibration.COUNTED_LENGTH_ERROR * counted, "m", pass_on_warnings(area))
        of_networks = float(np.sum(lobed, where=large)) / length if length > 0.0 and not straight.any() else 0.0
        # In a lay the sides of the cells are not 4/pi times as long as the edge.
        networks = calibration.COUNTED_DIFFERENCE * abs(counted - length) * of_networks * lay
        untraced += calibration.UNTRACED_CUT_LENGTH[1] * crossings
        std = math.hypot(
            relative * (length - exact - sharp),
            _STRAIGHT_LENGTH_ERROR * exact,
            uneven,
            0.5 * ends,
            diagonal,
            untraced,
            sharp_std,
            networks,
        )
        return warn_if_uncertain(length, std, "m", pass_on_warnings(area))


def _is_line(solution: ContactSolution) -> bool:
    """Return whether nothing varies along a periodic axis, for it has a single cell."""
    axes = zip(solution.grid.shape, solution.boundary.free_axes, strict=True)
    return any(side == 1 and not free for side, free in axes)


@responses.register("patches")
@attrs.frozen
class PatchCount(Quantity):
    """Number of contact patches: cells that share a side or a corner are one, and so is a summit between the cells.

    The common approach tells which summits without a cell in contact touch.
    """

    def find(self, solution: ContactSolution, area: Area) -> Estimate:
        """Return the number; see `Quantity.find`."""
        patches = solution.patches
        if patches.count == 0:
            return Estimate(0.0, 0.0, "")
        cells = patches.cells
        bend = measure_bend(solution)
        uneven = bend.spread > calibration.UNEVEN_SPREAD
        small, few = (int(np.count_nonzero(uneven & (cells < limit))) for limit in _SMALL_PATCH_CELLS)
        many = int(np.count_nonzero(uneven))
        ratio = min(curvature_resolution(solution), 2.0)
        hidden = hertz_areas(solution).correction.hidden.size
        each, unresolved, of_all = calibration.MISSING_PATCH_TERMS
        variance = each * (few + ratio * many) + 0.5 * trace_edges(solution).topology / solution.grid.cell_area
        linear = calibration.LINEAR_PATCH_STD * patches.count * bend.linear
        std = math.hypot(math.sqrt(variance), unresolved * ratio * small, of_all * ratio * many, linear)
        return Estimate(float(patches.count + hidden), std, "", pass_on_warnings(area))


@responses.register("approach")
@attrs.frozen
class SummitApproach(Quantity):
    """Approach of the bodies since the first touch of the summits between the cells, m.

    The attribute `approach` of a solution counts from the highest cell. Added are the height of the summit above that
    cell and the deficit by uniform pressure on each cell: see `MeanGap`.
    """

    # The gap of bodies that relax bends where their contact once ended.
    holds_with = frozenset({"shear"})

    # That part of the change holds 98 % of machined contacts.
    flagged_factors = 0.375, 1.0

    def find(self, solution: ContactSolution, area: Area) -> Estimate:
        """Return the approach; see `Quantity.find`."""
        linear = solution.patches.count > 0 and measure_bend(solution).linear
        # The approach counts from where the bodies touched first, which may have been at another place.
        fresh = solution._fresh_gap
        if solution._shift != (0, 0) and solution.origin is not None and solution.parts.is_whole:
            fresh = solution.origin.scene.initial_gap
        rise, rise_std = find_rise(fresh, solution.boundary, solution.non_measured, linear=linear)
        shift, shift_std = find_shift(solution)
        hidden = find_hidden_rise(solution)
        warnings = pass_on_warnings(area) if solution.status.success else (str(solution.status),)
        cut, cut_std = find_cut_shift(solution)
        approach = solution.approach + rise + shift - cut
        std = math.hypot(rise_std, hidden, shift_std, cut_std, find_lost_std(solution))
        return warn_if_uncertain(approach, std, "m", warnings)


@responses.register("mean-gap")
@attrs.frozen
class MeanGap(Quantity):
    r"""Mean gap over the domain, m.

    With uniform pressure on each cell the approach is too small by :math:`h^2 \kappa / 36`, with the mean curvature
    :math:`\kappa` under the contact, and the mean gap too large (measured; zero for `fourier`).
    """

    flagged_factors = 0.5, 1.0

    def find(self, solution: ContactSolution, area: Area) -> Estimate:
        """Return the mean gap; see `Quantity.find`."""
        shift, std = find_shift(solution)
        filled = fill_gap(solution)
        # Where cells are saturated the bodies flow instead of overlapping.
        gap = np.where(solution.saturated, 0.0, filled.values)
        beyond = _correct_mean(gap, solution.boundary)
        outside = 1.0 if not solution.boundary.has_free_axis else 1.0 - area.fraction
        cut, cut_std = find_cut_shift(solution)
        part = 1.0 - area.fraction
        value = float(np.mean(gap)) + beyond - shift * outside + cut * part
        uncertainty = math.hypot(std * outside, filled.mean_std, cut_std * part, find_lost_std(solution))
        if solution.contact.all():
            # The rest of the gap is the error of the solve.
            return Estimate(max(value, 0.0), math.hypot(uncertainty, float(np.ptp(gap))), "m", pass_on_warnings(area))
        return warn_if_uncertain(max(value, 0.0), uncertainty, "m", pass_on_warnings(area))


def _correct_mean(gap: Array, boundary: Boundary) -> float:
    """Return the deficit of the mean over cell centres along free axes, m: after Euler and Maclaurin."""
    lacking = 0.0
    for axis, cells in enumerate(gap.shape):
        if not boundary.free_axes[axis] or cells < len(_BORDER_SLOPE_WEIGHTS):
            continue
        along = np.moveaxis(gap, axis, 0)
        slopes = _BORDER_SLOPE_WEIGHTS @ (
            along[: -len(_BORDER_SLOPE_WEIGHTS) - 1 : -1] + along[: len(_BORDER_SLOPE_WEIGHTS)]
        )
        lacking += float(np.mean(slopes)) / (24.0 * cells)
    return lacking


def _elliptic_quotient(mean: Array, difference: Array) -> Array:
    """Return L^2 / (4 pi A) of Hertz's ellipse of these curvatures; the length of an ellipse is Ramanujan's."""
    known = mean > difference
    ratio = np.where(known, (mean - difference) / np.where(known, mean + difference, 1.0), 1.0)
    axes = 1.0 / find_axes_ratio(ratio)
    half = 3.0 * (1.0 + axes) - np.sqrt((3.0 + axes) * (1.0 + 3.0 * axes))
    return np.asarray(half**2 / (4.0 * axes))
