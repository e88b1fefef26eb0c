"""The traced edges of all patches: areas inside them, standard deviations, and their total."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.cells import (
    count_saturated,
    find_cut_cells,
    find_sharp_edges,
    find_straight_rows,
)
from roughcontact._answers.areas.contour import Contour, find_modulus_change, trace_both
from roughcontact._answers.areas.initial_gap import curvature_resolution, lay_ratio, rim_ratio
from roughcontact._base.arrays import Array, Mask
from roughcontact._base.units import WarningText
from roughcontact._parts.grid import extend, list_borders
from roughcontact._solve.solution import Area, ContactSolution, Estimate, areas

# Area that polygons lack inside a smooth convex edge, in cells around each piece: at corners, and beside the chords. A
# chord of length l cuts off curvature * l^3 / 12, and the mean chords of the unit square are <l> = pi / 4 and
# <l^3> = 3 / 4, which gives 1/2.
CUT_OFF_CELLS = 0.5 + calibration.PIECE_AREA_DEFICIT
# Number of cells from which a patch whose topology differs between both strides is not resolved.
_MIN_TOPOLOGY_CELLS = 12
# Standard deviation of the area of single spheres over its value on rough contacts, where Hertz's areas take part.
_SINGLE_CONTACT_FACTOR = 1.6
# Relative increase of the standard deviation where all of the edge is sharp.
_SHARP_STD_FACTOR = 2.0
# Ratio of a patch's cells to its width, in cells of a disc, up to which it is compact.
_MAX_COMPACT_RATIO = 2.0
# Width, in cells of a disc, of a slender patch whose edges have half the additional standard deviation.
_WIDE_PATCH_WIDTH = 50.0
# Standard deviation of an excess that has been subtracted, over the excess.
SUBTRACTED_EXCESS_STD = 0.3
# Maximum excess over the area, above which the linear law of the excess does not hold.
_MAX_EXCESS_FRACTION = 0.3
# Mean length of the rows of sides, weighted by their length, below which a long edge is a diagonal of the grid, sides.
_MAX_DIAGONAL_ROW = 1.9
# The same for an oblique edge where the heights are ridges of one direction.
_MAX_OBLIQUE_ROW = 8.0
# Lay ratio below which the heights are ridges of one direction.
MAX_RIDGE_LAY = 0.03
# Cell sides of each patch from which an edge is long, as of a disc of six cells radius.
_LONG_EDGE_SIDES = 48
# Fraction of the counted area in patches of fewer than four cells above which the grid does not resolve the contact ...
_MAX_SMALL_FRACTION = 0.2
# ... unless the resolution ratio is below this (six cells a shortest wave), when load and curvature determine the area.
_MAX_SMOOTH_RATIO = 0.4
# Cells of the waves that dominate the curvature below which the grid does not resolve it; self-affine surfaces come
# below with three cells a shortest wave, where areas err by up to 3 % (benchmarks/rough_constants.py).
_MIN_WAVE_CELLS = 5.5
# Logarithm of the change of E* over two octaves of wavelength above which the edge is uncertain by 0.03 cells.
_MAX_MODULUS_CHANGE = 0.3
# Relative uncertainty from which an answer may err by more than 10 %: between 5 % and this no answer of 176 smooth and
# machined contacts did without another warning.
MAX_RELATIVE_STD = 0.07
# Warnings that are said of the area alone: of how well it is determined, for of 79 smooth contacts 10 had them, and
# approaches that err by 1 %; and of waves that a map lacks, which smooth surfaces do not have.
_AREA_RULES = ("resolution", "small patches", "uncertainty", "blurred map")


@attrs.frozen(eq=False)
class TracedEdges:
    """Areas inside the traced edges and their errors; arrays of shape (count + 1,), the first entry is zero.

    Attributes
    ----------
    area, refined
        Area inside the edge between neighbouring cells, and extrapolated from that between every second cell, m2.
    length, sharp, sharp_length
        Length of the edge, m, the fraction of the edge that is sharp, and the length of that part on the cells, m.
    std
        Standard deviation of either area, m2.
    alike
        Factor of the square of `std`, for the parts of this and of other edges that have the same error.
    strip
        Area of a strip along the edge, one cell wide, m2.
    curvature_resolution
        Fourth over second differences of the heights under the contact: small if the grid resolves them.
    excess
        Excess of the area because the grid hardly resolves the heights, m2.
    saturated
        Standard deviation where the pressure reaches its limit near the edge, m2.
    width
        Cells of a disc as wide as each patch.
    roundness
        One for compact patches, less for slender ones.
    border
        Standard deviation where edges meet a free border, all patches together, m2.
    topology
        One cell for each piece or hole of the larger patches that is found at only one of both strides, m2.
    shift
        Standard deviation of the position of the edges, together, in cells.
    slender
        Standard deviation of the position of the edges of slender patches, together, in cells.
    oblong
        Longer side of the cells over their mean side: the error of an edge is a part of the former.
    pieces
        Number of pieces of all edges with independent errors where the grid hardly resolves the heights, at least one:
        each is as long as a wave, and longer in a lay.
    straight
        Which patches have straight edges along the grid alone.
    """

    area: Array
    refined: Array
    length: Array
    untraced_std: Array
    sharp: Array
    sharp_length: Array
    std: Array
    alike: Array
    strip: Array
    curvature_resolution: float
    excess: Array
    saturated: Array
    width: Array
    roundness: Array
    border: float
    topology: float
    shift: Array
    slender: Array
    oblong: float
    pieces: float
    straight: Mask

    @property
    def alone_std(self) -> Array:
        """Standard deviation of either area by itself, m2, also for single contacts and parts with the same error."""
        return np.asarray(_SINGLE_CONTACT_FACTOR * self.oblong * self.std * np.sqrt(self.alike))

    @property
    def blended_std(self) -> Array:
        """Standard deviation of either area where Hertz's areas take part, m2, also for parts with the same error."""
        return np.asarray(self.oblong * self.std * np.sqrt(calibration.BLENDED_STD_FACTOR**2 - 1.0 + self.alike))

    def average_excess(self, excess: Array) -> float:
        """Return the standard deviation of the total of the excess of all edges, m2, as it varies from wave to wave."""
        return calibration.EXCESS_STD * float(np.sum(excess)) / math.sqrt(self.pieces)

    def common_std(self, excess_std: float, fraction: float | Array = 1.0) -> float:
        """Return the standard deviation common to all edges, m2: of excess, position, saturated cells and topology."""
        alike = (self.shift * self.strip, self.slender * self.strip, self.saturated)
        positions = (float(np.sum(fraction * part)) for part in alike)
        return self.oblong * math.hypot(self.oblong * excess_std, self.topology, *positions)


def trace_edges(solution: ContactSolution) -> TracedEdges:
    """Return the traced edges of all patches."""
    # Areas, perimeter and number of patches ask for the same.
    return solution._keep("traced edges", lambda: _trace_edges(solution))


def _trace_edges(solution: ContactSolution) -> TracedEdges:
    sharp = find_sharp_edges(solution)
    one, two = trace_both(solution, sharp)
    fine = _correct(solution, one, 1)
    coarse = _correct(solution, two, 2)
    cell = solution.grid.cell_area
    cells = solution.patches.cells
    # Cells along which nothing varies err alike: their edges count as those of square ones.
    square = solution.grid.resolved.cell_area
    step = math.sqrt(square)
    oblong = math.sqrt(max(solution.grid.resolved.spacing) / min(solution.grid.resolved.spacing))
    # The edge of a patch varies at least as half the edge of a disc of as many cells.
    half_disc = np.sqrt(np.pi * square * np.concatenate(([0], cells)))
    # Of edges in all directions there are 4 / pi cell sides for each cell of their length.
    std = (
        calibration.EDGE_AREA_STD
        * np.sqrt(4.0 / np.pi * np.maximum(one.length * square / cell, half_disc) / step)
        * cell
    )
    ratio = curvature_resolution(solution)
    lay = lay_ratio(solution)
    strip = step * one.length
    waves = math.sqrt(ratio) / (2.0 * math.pi)
    counted = np.concatenate(([1.0], cells))
    width = _measure_width(fine, one.length, square, counted)
    small = 1.0 + (calibration.SMALL_PATCH_WIDTH / width) ** 2
    beside = calibration.NON_MEASURED_EXCESS * cell * one.meeting
    met = step * one.meeting
    places = calibration.NON_MEASURED_PLACE_STD * cell * np.sqrt(one.meeting)
    few = calibration.SMALL_PATCH_STD * ratio * fine / counted**1.5
    straight = one.straight > 0.0
    straight_std = _find_straight_std(solution, fine, one) / (step * oblong)
    first, second = calibration.EXCESS
    excess = (first * ratio + second * ratio**2) * strip
    return TracedEdges(
        area=np.maximum(fine - beside, 0.0),
        refined=np.where(straight, fine, (4.0 * fine - coarse) / 3.0 - beside),
        length=one.length + calibration.NON_MEASURED_LENGTH * met,
        untraced_std=calibration.NON_MEASURED_LENGTH_STD * met,
        sharp=one.sharp,
        sharp_length=one.sharp_length,
        std=np.where(straight, 0.0, np.hypot(np.hypot(std * (small + _SHARP_STD_FACTOR * one.sharp), few), places)),
        alike=_count_equal_errors(one.alike)
        * (calibration.OBLIQUE_PARTS_FACTOR if lay < MAX_RIDGE_LAY and is_diagonal(solution, lay) else 1.0),
        strip=strip,
        curvature_resolution=ratio,
        excess=np.minimum(excess, _MAX_EXCESS_FRACTION * fine),
        saturated=calibration.SATURATED_POSITION_STD * _saturated_weight(solution) * strip,
        width=width,
        roundness=_measure_roundness(width, counted),
        border=oblong * _border_std(solution) * cell,
        topology=abs(float(np.sum((one.euler - two.euler)[1:], where=cells >= _MIN_TOPOLOGY_CELLS))) * cell,
        shift=np.where(straight, straight_std, calibration.LAYERED_POSITION_STD * find_modulus_change(solution))
        + _measure_rims(solution),
        slender=np.where(
            straight, 0.0, _slender_std(lay) * (1.0 - width / counted) ** 6 / (1.0 + width / _WIDE_PATCH_WIDTH)
        ),
        oblong=oblong,
        pieces=max(1.0, lay * float(np.sum(one.length / one.alike)) * square / cell * waves / step),
        straight=straight,
    )


def _find_straight_std(solution: ContactSolution, area: Array, edge: Contour) -> Array:
    """Return the standard deviation of the position of straight edges along the grid, m, shape (count + 1,)."""
    closed, open_ = calibration.STRAIGHT_POSITION_STD
    half = 0.5 * edge.length * edge.straight
    # The mean widths of the patch and of the gaps beside it, in cells.
    width = np.maximum(np.divide(area, half, out=np.ones_like(area), where=half > 0.0), 1.0)
    beyond = 0.0
    if not solution.boundary.has_free_axis and half.any():
        beyond = open_ / max((solution.grid.area - float(np.sum(area))) / float(np.sum(half)), 1.0)
    layered = calibration.LAYERED_POSITION_STD * find_modulus_change(solution)
    return np.asarray(edge.straight * (np.hypot(closed / width, beyond) + layered))


def _slender_std(lay: float) -> float:
    """Return the standard deviation of the position of the edges of very slender patches, in cells."""
    along, merged = calibration.SLENDER_POSITION_STD
    return along * (1.0 - lay) + merged * lay


def _measure_rims(solution: ContactSolution) -> Array:
    """Return the standard deviation of edges at sharp rims, cells, shape (count + 1,)."""
    first, highest, std = calibration.RIM_POSITION_TERMS
    sharpness = min(max(rim_ratio(solution) - first, 0.0), highest)
    return np.asarray(std * sharpness * (1.0 - _saturated_weight(solution)))


def _measure_roundness(width: Array, cells: Array) -> Array:
    """Return one for compact patches, and less the more slender they are."""
    slenderness = np.maximum(cells / (_MAX_COMPACT_RATIO * width), 1.0) - 1.0
    return np.asarray(1.0 / (1.0 + slenderness / (1.0 + (width / _WIDE_PATCH_WIDTH) ** 2)))


def _count_equal_errors(alike: Array) -> Array:
    """Return the number of equal errors that add up, for the number of parts of the edge that are the same."""
    return 1.0 + calibration.ALIKE_PARTS_FACTOR * (alike - 1.0)


def _measure_width(area: Array, length: Array, cell: float, cells: Array) -> Array:
    """Return the number of cells of discs with the same ratio of area to edge, at most the cells of the patch."""
    with np.errstate(divide="ignore", invalid="ignore"):
        width = np.pi * (2.0 * area / length) ** 2 / cell
    return np.where((length > 0.0) & (area > 0.0), np.clip(width, 0.5, cells), cells)


def _correct(solution: ContactSolution, edge: Contour, stride: int) -> Array:
    """Return the areas inside the smooth edges whose chords are the sides of the polygons."""
    step = np.sqrt(solution.grid.resolved.cell_area)
    cut_off = CUT_OFF_CELLS * stride**2 * edge.euler * solution.grid.cell_area
    return np.asarray(np.maximum(edge.area + solution.edge_shift * step * edge.length + cut_off, 0.0))


def _border_std(solution: ContactSolution) -> float:
    """Return the standard deviation where a free border cuts the contact, in cells: saturated pressure is bounded."""
    contact = solution.contact
    if not solution.boundary.has_free_axis or int(solution.patches.cells.sum()) == solution.grid.cells:
        return 0.0
    contact, saturated, cut = (
        np.concatenate(list_borders(field, solution.boundary))
        for field in (solution.parts.own(contact), solution.saturated, find_cut_cells(solution))
    )
    counts = np.array([np.count_nonzero(cut), np.count_nonzero(contact & ~saturated & ~cut)])
    return float(solution.parts.total(counts) @ (calibration.CUT_BORDER_STD, calibration.UNCUT_BORDER_STD))


def _saturated_weight(solution: ContactSolution) -> Array:
    """Return the weight of the saturated error in each patch, shape (count + 1,): one from half its cells saturated."""
    return np.minimum(2.0 * count_saturated(solution) / np.concatenate(([1], solution.patches.cells)), 1.0)


def is_diagonal(solution: ContactSolution, lay: float) -> bool:
    """Return whether long edges run along a diagonal of the grid, or straight ones in any oblique direction."""
    rows = find_straight_rows(solution).astype(np.float64)
    sides, squares = solution.parts.total(np.array([rows.sum(), np.sum(rows**2)]))
    oblique = _MAX_OBLIQUE_ROW if lay < MAX_RIDGE_LAY else _MAX_DIAGONAL_ROW
    return bool(sides > _LONG_EDGE_SIDES * solution.patches.count and squares < oblique * sides)


def total_area(
    solution: ContactSolution, values: Array, stds: Array, common: float, edges: TracedEdges, name: str
) -> Area:
    """Return the area of the contact from the areas of the patches; exactly zero or nominal without or in full contact.

    `values` and `stds` are the areas and their independent standard deviations, shape (count + 1,), m2; `common` is
    their common standard deviation, m2.
    """
    grid = solution.grid
    patches = solution.patches
    cells = int(patches.cells.sum())
    if cells in (0, grid.cells):
        fraction = float(cells > 0)
        parts = np.full(int(fraction), grid.area)
        hidden = _count_hidden_gaps(solution) * grid.cell_area
        return Area(fraction * grid.area, fraction, hidden, name, perimeter=0.0, patches=parts)
    total = float(values.sum())
    value = min(total, grid.area)
    values = values * (value / total if total > 0.0 else 1.0)
    uncertainty = math.sqrt(float(np.sum(stds**2)) + common**2 + edges.border**2)
    warnings = list_warnings(solution, find_fresh_resolution(solution))
    warnings = judge_uncertainty("the area", value, uncertainty, warnings)
    return Area(
        value,
        value / grid.area,
        uncertainty,
        name,
        perimeter=float(edges.length.sum()),
        patches=values[1:],
        warnings=warnings,
    )


def _count_hidden_gaps(solution: ContactSolution) -> float:
    """Return the cells in full contact beside which the pressure, extrapolated, vanishes before the next centre."""
    pressure = solution.pressure
    extended = extend(pressure, 1, solution.boundary)
    around = (extended[:-2, 1:-1], extended[2:, 1:-1], extended[1:-1, :-2], extended[1:-1, 2:])
    steepest = np.max([np.abs(neighbour - pressure) for neighbour in around], axis=0)
    hidden = solution.parts.own((pressure > 0.0) & (2.0 * pressure < steepest))
    return float(solution.parts.total(np.count_nonzero(hidden)))


def pass_on_warnings(area: Area) -> tuple[str, ...]:
    """Return the warnings of an area that hold for other numbers too, whose own uncertainty says how sure they are."""
    return tuple(text for text in area.warnings if getattr(text, "rule", "") not in _AREA_RULES)


def warn_if_uncertain(value: float, std: float, unit: str, warnings: tuple[str, ...]) -> Estimate:
    """Return an estimate, with a warning if it has no other and its relative standard deviation is too large."""
    if value != 0.0:
        warnings = judge_uncertainty("this number", value, std, warnings)
    return Estimate(value, std, unit, warnings)


def judge_uncertainty(what: str, value: float, std: float, warnings: tuple[str, ...]) -> tuple[str, ...]:
    """Return the warnings; if there are none, one of a large relative standard deviation."""
    if warnings or std <= MAX_RELATIVE_STD * abs(value):
        return warnings
    above = 100.0 * MAX_RELATIVE_STD
    text = f"the grid hardly determines {what}, whose uncertainty is above {above:.2g} %: refine the grid"
    return (WarningText(text, "uncertainty", std / abs(value) if value else math.inf),)


def ends_as_root(solution: ContactSolution) -> bool:
    """Return whether the pressure ends as the root of the distance from the edge, which wear takes away."""
    return "roots" in areas[solution._name_default_area()].expects


def list_warnings(solution: ContactSolution, curvature_resolution: float) -> tuple[str, ...]:
    """Return why an area from this solution must not be trusted, in sentences."""
    warnings = []
    waves = 2.0 * math.pi / math.sqrt(curvature_resolution) if curvature_resolution > 0.0 else math.inf
    if waves < _MIN_WAVE_CELLS:
        text = (
            f"the shortest waves have about {waves:.2g} cells; the area needs about 8 "
            "(a finer grid of a measured map adds no heights)"
        )
        warnings.append(WarningText(text, "resolution", waves))
    small = solution.patches.small_fraction
    if small > _MAX_SMALL_FRACTION and curvature_resolution > _MAX_SMOOTH_RATIO:
        text = f"{100 * small:.3g} % of the counted area is in patches of fewer than four cells"
        warnings.append(WarningText(text, "small patches", small))
    change = find_modulus_change(solution)
    if change > _MAX_MODULUS_CHANGE:
        text = (
            f"the modulus changes by a factor of {math.exp(change):.2g} between wavelengths of about a cell, as on a "
            "thin layer: refine the grid"
        )
        warnings.append(WarningText(text, "layer", math.exp(change)))
    if not solution.status.success:
        warnings.append(WarningText("the solution is not converged", "convergence"))
    return tuple(warnings)


def find_fresh_resolution(solution: ContactSolution) -> float:
    """Return the resolution ratio of the fresh heights: what loads have changed ends at rims, which are not waves."""
    if not solution._is_changed:
        return curvature_resolution(solution)
    return solution._keep(
        "fresh resolution", lambda: curvature_resolution(attrs.evolve(solution, initial_gap=solution._fresh_gap))
    )
