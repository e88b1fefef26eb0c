"""The area estimators, and the edge of the contact as closed lines for figures.

In the lines both dual cells beside a side share one point on it.
"""

from __future__ import annotations

import math

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._answers.areas.cells import count_sides, find_sharp_edges, find_straight_rows, measure_sides
from roughcontact._answers.areas.contour import (
    Corners,
    find_crossings,
    find_distances,
    measure_polygons,
)
from roughcontact._answers.areas.dual_cells import DualCells, find_dual_cells, find_kinds
from roughcontact._answers.areas.edges import (
    SUBTRACTED_EXCESS_STD,
    TracedEdges,
    find_fresh_resolution,
    list_warnings,
    total_area,
    trace_edges,
)
from roughcontact._answers.areas.hertz import hertz_areas
from roughcontact._base.arrays import Array, IntArray, Mask
from roughcontact._solve.solution import Area, AreaEstimator, ContactSolution, heal

# Mean excess of the count, in cells per side, over all positions and directions of a straight edge (Yastrebov 2017).
_COUNT_EXCESS = (math.pi - 1.0 + math.log(2.0)) / 24.0
# Fraction of that correction in one standard deviation: two hold all from no correction (sharp edges) to twice it.
_CORRECTION_STD = 0.5
# Position of an edge within its cell, in cells: standard deviation of a uniform distribution.
_POSITION_STD = 1.0 / math.sqrt(12.0)
# Widths, in cells of a disc, between which the two halves of the extrapolation of the traced area set in: in narrow
# patches the area inside the edge is too small, and the extrapolated area too large.
_FIRST_HALF_WIDTHS = (1.5, 3.0)
_SECOND_HALF_WIDTHS = (6.0, 60.0)
# Standard deviation of an excess that is not subtracted, over the excess: without and with extrapolation.
_KEPT_EXCESS_STD = 2.0
_REFINED_EXCESS_STD = 0.75
# Fraction of its edge that may look sharp in a smooth patch, times the resolution ratio where that is above one.
_MAX_SHARP_FRACTION = 0.1
# Corners of a dual cell in the order around it, in cells from its lower left one.
_CORNER_OFFSETS = np.array(((0, 0), (1, 0), (1, 1), (0, 1)))


@attrs.frozen
class CellCount(AreaEstimator):
    r"""Counted area: all cells with p > 0, as most codes count them.

    .. math:: A = N\, \Delta x \Delta y

    Nearly always too large, for a cell counts as soon as the contact reaches into it. The uncertainty
    is that excess as `Perimeter` estimates it.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> print(problem.solve(force=1.0).area("cell-count"))
    (742 +- 46) µm2, (7.42 +- 0.46) % of nominal [cell-count]
    """

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the counted area; see `AreaEstimator.estimate`."""
        count = _count_cells(solution)
        cell = solution.grid.cell_area
        excess = _COUNT_EXCESS * count_sides(solution) * cell
        return _counted_area(solution, count * cell, count / solution.grid.cells, excess, "cell-count")


@attrs.frozen
class Perimeter(AreaEstimator):
    r"""Counted area less a correction by the perimeter.

    .. math:: A = N \Delta x \Delta y - \frac{\pi - 1 + \ln 2}{24}\, S\, \Delta x \Delta y

    with N cells in contact and S cell sides between contact and open cells. It is exact on average for
    straight edges of random position and direction, and corrects smooth Hertzian edges too much. Edges
    of saturated cells are sharp and are not corrected, and the area is never below the load over the
    pressure limit. The uncertainty is half of the correction and the random position of each straight
    row of sides in its cells.

    References
    ----------
    Yastrebov, Anciaux, Molinari, Tribol. Int. 114 (2017) 161-171,
    https://doi.org/10.1016/j.triboint.2017.04.023

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> print(problem.solve(force=1.0).area("perimeter"))
    (696 +- 50) µm2, (6.96 +- 0.50) % of nominal [perimeter]
    """

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the corrected area; see `AreaEstimator.estimate`."""
        whole = solution.parts
        cell = solution.grid.cell_area
        elastic = count_sides(solution) - count_sides(solution, solution.saturated)
        fractions = whole.own(solution.pressure / solution.pressure_limit)
        needed = whole.total(float(np.add.reduce(fractions, axis=None)))
        value = max(_count_cells(solution) - _COUNT_EXCESS * elastic, needed) * cell
        rows = find_straight_rows(solution).astype(np.float64)
        position = _POSITION_STD * math.sqrt(whole.total(float(np.sum(rows**2))))
        uncertainty = (_CORRECTION_STD * _COUNT_EXCESS * elastic + position) * cell
        return _counted_area(solution, value, value / solution.grid.area, uncertainty, "perimeter")


def _count_cells(solution: ContactSolution) -> int:
    return solution.parts.total(int(np.count_nonzero(solution.parts.own(solution.contact))))


def _counted_area(solution: ContactSolution, value: float, fraction: float, uncertainty: float, name: str) -> Area:
    perimeter = measure_sides(solution)
    warnings = list_warnings(solution, find_fresh_resolution(solution))
    return Area(value, fraction, uncertainty, name, perimeter=perimeter, warnings=warnings)


@attrs.frozen
class LevelSet(AreaEstimator):
    r"""Area inside the edge that pressure and gap define between the cell centres.

    .. math:: A = A_\mathrm{polygon} + s\,h\,L + (\tfrac12 + 0.16)\,h^2\,\chi

    with the length L and the Euler number :math:`\chi` of the edge (`roughcontact._answers.areas.contour`) and
    the kernel's shift s of the edge, in cells. For patches of more than a few cells; see `Blend` for
    smaller ones.

    References
    ----------
    Johnson, Contact Mechanics (1985), section 5.1, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> print(problem.solve(force=1.0).area("level-set"))
    (688 +- 19) µm2, (6.88 +- 0.19) % of nominal [level-set]
    """

    expects = frozenset({"roots"})

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the area inside the traced edge; see `AreaEstimator.estimate`."""
        edges = trace_edges(solution)
        common = edges.common_std(_KEPT_EXCESS_STD * float(np.sum(edges.excess)))
        return total_area(solution, edges.area, edges.alone_std, common, edges, "level-set")

    def outline(self, solution: ContactSolution) -> Array:
        """Return the edge as line segments for a figure: both ends (x, y) of each, shape (n, 2, 2), m."""
        return trace_pieces(solution)[0]

    def contours(self, solution: ContactSolution) -> list[Array]:
        """Return the edge as lines for a figure, (x, y) of shape (n, 2), m, the contact on their left.

        The last point of a closed line is its first. Lines that cross a periodic border continue beyond it, and a line
        around the domain ends at the image of its first point; lines that reach a free border end there.
        """
        return contours(solution)


@attrs.frozen
class LevelSetRichardson(AreaEstimator):
    r"""Level-set area, extrapolated from edges between all cells, A1, and between every second cell, A2.

    .. math:: A = (4 A_1 - A_2) / 3

    Both come from one solution, so that the error of the interpolation of order h^2 cancels.

    References
    ----------
    Richardson, Phil. Trans. R. Soc. A 210 (1911) 307-357, https://doi.org/10.1098/rsta.1911.0009

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> print(problem.solve(force=1.0).area("level-set-richardson"))
    (688 +- 19) µm2, (6.88 +- 0.19) % of nominal [level-set-richardson]
    """

    expects = frozenset({"roots"})

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the extrapolated area; see `AreaEstimator.estimate`."""
        edges = trace_edges(solution)
        common = edges.common_std(_REFINED_EXCESS_STD * float(np.sum(edges.excess)))
        # On grids of a few cells the extrapolation may leave nothing of a patch.
        values = np.where(edges.refined > 0.0, edges.refined, edges.area)
        return total_area(solution, values, edges.alone_std, common, edges, "level-set-richardson")


@attrs.frozen
class Hertz(AreaEstimator):
    r"""Hertz's contact area of each patch, from its load and its curvature.

    .. math:: A = \pi \left(\frac{3F}{4E^*\kappa}\right)^{2/3} f, \quad \kappa = \tfrac12(\kappa_1+\kappa_2)

    with the factor f of an elliptic contact and the curvature averaged over the patch with the
    pressure as weight, which is exact to first order for summits that are not paraboloids. One cell in
    contact suffices; a patch of several summits is estimated far too small. Patches without a summit
    count as in `LevelSet`.

    References
    ----------
    Johnson, Contact Mechanics (1985), section 4.2, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> print(problem.solve(force=1.2).area("hertz"))
    (778.331 +- 0.023) µm2, (7.78331 +- 0.00023) % of nominal [hertz]
    """

    expects = frozenset({"summits", "roots"})
    holds_with = frozenset({"shear"})

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the sum of Hertz's areas; see `AreaEstimator.estimate`."""
        edges = trace_edges(solution)
        summits = hertz_areas(solution)
        valid = np.isfinite(summits.error)
        values = np.where(valid, summits.area, edges.area)
        stds = np.minimum(summits.error, 1.0) * summits.area
        # Nothing of an edge is traced around cells that touch at their corners alone.
        counted = np.concatenate(([0], solution.patches.cells)) * solution.grid.cell_area
        unknown = np.maximum(edges.oblong * edges.std, np.where(edges.area > 0.0, 0.5 * edges.area, counted))
        stds = np.where(valid, np.hypot(stds, summits.tip * summits.area), unknown)
        common = summits.common_std(np.where(valid, values, 0.0))
        return total_area(solution, values, stds, common, edges, "hertz")


@attrs.frozen
class Blend(AreaEstimator):
    r"""Level-set and Hertz's areas of each patch, weighted by the inverse of their variances.

    .. math:: A = \sum_c w A_\mathrm{Hertz} + (1 - w) A_\mathrm{level set},
              \quad w = \sigma_\mathrm{level set}^2 / (\sigma_\mathrm{level set}^2 + \sigma_\mathrm{Hertz}^2)

    Small patches follow from load and curvature (`Hertz`), large ones from their edges (`LevelSet`,
    `LevelSetRichardson`). Patches with sharp edges are counted, and no patch is smaller than its load
    over the pressure limit.

    References
    ----------
    Johnson, Contact Mechanics (1985), sections 4.2 and 5.1, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> print(problem.solve(force=1.2).area("blend"))
    (778.331 +- 0.023) µm2, (7.78331 +- 0.00023) % of nominal [blend]
    """

    expects = frozenset({"summits", "roots"})
    holds_with = frozenset({"shear"})

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the weighted area; see `AreaEstimator.estimate`."""
        edges = trace_edges(solution)
        smooth = edges.sharp <= _MAX_SHARP_FRACTION * max(1.0, edges.curvature_resolution)
        step = np.where(smooth, _extrapolate(edges), 0.0)
        # Full extrapolation leaves nothing of it.
        excess = np.where(smooth, np.minimum(2.0 * (1.0 - step), 1.0) * edges.excess, 0.0)
        traced = step * edges.refined + (1.0 - step) * edges.area - excess
        traced = np.maximum(traced, _smallest_areas(solution))
        traced_std = np.hypot(edges.std, SUBTRACTED_EXCESS_STD * excess + edges.saturated)
        summits = hertz_areas(solution)
        known = smooth & np.isfinite(summits.error)
        # Only the load determines a contact far smaller than a cell; otherwise the larger area is the safer scale.
        tiny = summits.area < solution.grid.cell_area
        scale = np.where(tiny, summits.area, np.maximum(summits.area, traced))
        hertz_std = np.where(known, summits.error, 1.0) * scale
        with np.errstate(invalid="ignore"):
            weight = np.where(known, traced_std**2 / (traced_std**2 + hertz_std**2), 0.0)
        weight = np.where(np.isfinite(weight), weight, 1.0)
        weight[0] = 1.0
        hertzian = weight * summits.area
        values = hertzian + (1.0 - weight) * traced
        stds = np.hypot(np.hypot(weight * hertz_std, summits.tip * hertzian), (1.0 - weight) * edges.blended_std)
        excess_std = edges.average_excess((1.0 - weight) * excess)
        common = math.hypot(edges.common_std(excess_std, 1.0 - weight), summits.common_std(hertzian))
        return total_area(solution, values, stds, common, edges, "blend")


def _extrapolate(edges: TracedEdges) -> Array:
    """Return how far the traced area of each patch is extrapolated, from 0 to 1."""
    halves = zip((edges.width, edges.width * edges.roundness), (_FIRST_HALF_WIDTHS, _SECOND_HALF_WIDTHS), strict=True)
    return np.asarray(sum(0.5 * np.interp(np.log(width), np.log(ends), (0.0, 1.0)) for width, ends in halves))


def _smallest_areas(solution: ContactSolution) -> Array:
    """Return the load of each patch over the pressure limit, shape (count + 1,), m2."""
    if not solution.capped:
        return np.zeros(solution.patches.count + 1)
    needed = solution.patches.sum(solution.pressure / solution.pressure_limit) * solution.grid.cell_area
    return np.concatenate(([0.0], needed))


def _find_edge(solution: ContactSolution) -> tuple[DualCells, IntArray, IntArray, IntArray, Mask, Corners]:
    """Return the dual cells of a solution and, of those at the edge, row, column, corners, contact and distance."""
    dual = find_dual_cells(solution, 1)
    i, j = dual.find_edge(solution.contact)
    k = dual.corners(i, j)
    touching = solution.contact.ravel()[k]
    return dual, i, j, k, touching, find_distances(solution, k, touching)


def edge_law(solution: ContactSolution) -> float:
    r"""Return the slope of the distribution of the pressure over the nominal area at zero pressure, 1/Pa2.

    At the distance d from the edge :math:`p = K\sqrt{d}`, so that the distribution begins with
    :math:`(2 p / A_0) \oint ds / K^2`, along the edge and over the nominal area.
    """
    solution = heal(solution)
    grid = solution.grid
    dual, i, j, k, touching, distance = _find_edge(solution)
    pressure = np.where(solution.saturated.ravel()[k], 0.0, solution.pressure.ravel()[k])
    # In a dual cell all distances follow from one K: the K of the corner furthest inside.
    deepest = np.argmax(pressure, axis=0)
    each = np.arange(i.size)
    square = pressure[deepest, each] ** 2
    depth = distance[deepest, each]
    elastic = (square > 0.0) & (depth > 0.0)
    _, lengths, _ = measure_polygons(distance, touching, find_kinds(touching), grid.spacing)
    weights = dual.weights[0][i] * dual.weights[1][j] * lengths
    return float(np.sum((weights * depth)[elastic] / square[elastic])) * 2.0 / grid.area


def contours(solution: ContactSolution) -> list[Array]:
    """Return the edges of the contact as lines, (x, y) of shape (n, 2), m, the contact on their left.

    The last point of a closed line is its first, or the image of the first if the line runs around a periodic domain.
    Lines that cross a periodic border continue beyond it; lines that reach a free border end there.
    """
    pieces, start, end = trace_pieces(solution)
    if not len(pieces):
        return []
    order = np.argsort(start)
    at = np.minimum(np.searchsorted(start[order], end), start.size - 1)
    following = np.where(start[order][at] == end, order[at], -1)
    lines = []
    size = np.array(solution.grid.size)
    ends = np.array(solution.boundary.free_axes)
    for chain, closed in _chain(following):
        line = np.concatenate((pieces[chain, 0], pieces[chain[-1:], 1]))
        turns = np.cumsum(np.round(np.diff(line, axis=0) / size), axis=0)
        line[1:] -= np.where(ends, 0.0, turns * size)
        if closed:
            # This only removes rounding.
            line[-1] = line[0] + np.round((line[-1] - line[0]) / size) * size
        lines.append(line)
    return lines


def _chain(following: IntArray) -> list[tuple[IntArray, bool]]:
    """Return the lines as pieces in order, and whether the last piece leads to the first."""
    after = following.tolist()
    seen = bytearray(following.size)
    chains = []
    # Lines with ends begin where no piece leads.
    first = np.ones(following.size, dtype=bool)
    first[following[following >= 0]] = False
    for begin in (*np.flatnonzero(first).tolist(), *range(following.size)):
        if seen[begin]:
            continue
        chain = []
        piece = begin
        while piece >= 0 and not seen[piece]:
            seen[piece] = 1
            chain.append(piece)
            piece = after[piece]
        chains.append((np.array(chain), piece == begin))
    return chains


def trace_pieces(solution: ContactSolution) -> tuple[Array, IntArray, IntArray]:
    """Return the pieces of the edge, and the sides of dual cells where each begins and ends.

    They are straight, from one end (x, y) to the other, shape (n, 2, 2), m, with the contact on their left.
    """
    solution = heal(solution)
    grid = solution.grid
    dual, i, j, k, touching, distance = _find_edge(solution)
    sides = _number_sides(dual, i, j)
    crossing = find_crossings(distance)
    # At sharp edges and beside non-measured points the contact ends with the cells.
    counted = find_sharp_edges(solution)
    if solution.non_measured is not None:
        counted = counted | solution.non_measured
    ends_with_cells = counted.ravel()[k]
    crossing[ends_with_cells | np.roll(ends_with_cells, -1, axis=0)] = 0.5
    fraction = _share(crossing, sides, touching)
    ways = _CORNER_OFFSETS[[1, 2, 3, 0]] - _CORNER_OFFSETS
    points = _CORNER_OFFSETS[:, np.newaxis] + fraction[..., np.newaxis] * ways[:, np.newaxis]
    cell, leaving, entering = _pair_sides(touching, distance)
    first = (np.stack((i, j), axis=-1) - dual.before)[cell][:, np.newaxis]
    ends = first + np.stack((points[leaving, cell], points[entering, cell]), axis=1)
    # The outermost dual cells reach beyond a free border, which lies half a cell behind the outermost centres.
    ends = np.where(solution.boundary.free_axes, np.clip(ends, -0.5, np.array(grid.shape) - 0.5), ends)
    origin = np.array((grid.x[0, 0], grid.y[0, 0]))
    return origin + ends * grid.spacing, sides[leaving, cell], sides[entering, cell]


def _number_sides(dual: DualCells, i: IntArray, j: IntArray) -> IntArray:
    """Return a number for each side of dual cells, shape (4, n), the same for both dual cells beside it."""
    m = dual.rows.shape[1] + dual.before[0]
    n = dual.columns.shape[1] + dual.before[1]
    above = (j + 1) % n
    right = (i + 1) % m
    return np.stack((i * n + j, (m + right) * n + j, i * n + above, (m + i) * n + j))


def _share(crossing: Corners, sides: IntArray, touching: Mask) -> Corners:
    """Return where the edge crosses each side, from its first corner: the mean over both dual cells beside it."""
    # The upper and the left side run against the axes.
    along = np.where(np.array((False, False, True, True))[:, np.newaxis], 1.0 - crossing, crossing)
    crossed = touching != np.roll(touching, -1, axis=0)
    _, which, counts = np.unique(sides[crossed], return_inverse=True, return_counts=True)
    along[crossed] = (np.bincount(which, weights=along[crossed]) / counts)[which]
    along[2:] = 1.0 - along[2:]
    return along


def _pair_sides(
    touching: Mask, distance: Corners
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the dual cell of each piece, the side where it begins and the side where it ends.

    Around the dual cell, the contact is left on the first and entered on the second.
    """
    following = np.roll(touching, -1, axis=0)
    cell, leaving = np.nonzero((touching & ~following).T)
    entered = (~touching & following).T
    saddle = np.count_nonzero(entered, axis=1)[cell] == 2
    # At saddles, pieces cut off the corners outside where the corners inside are connected, else the corners inside.
    around = np.where(distance.sum(axis=0)[cell] > 0.0, leaving + 1, leaving - 1) % 4
    return cell, leaving, np.where(saddle, around, np.argmax(entered, axis=1)[cell])
