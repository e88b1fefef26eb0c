"""The edge of the contact as closed lines for figures: both dual cells beside a side share one point on it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from roughcontact._answers.areas.cells import find_sharp_edges
from roughcontact._answers.areas.contour import (
    Corners,
    DualCells,
    find_crossings,
    find_distances,
    find_dual_cells,
    find_kinds,
    measure_polygons,
)
from roughcontact._base.arrays import Array, IntArray, Mask
from roughcontact._solve.solution import ContactSolution, heal

# Corners of a dual cell in the order around it, in cells from its lower left one.
_CORNER_OFFSETS = np.array(((0, 0), (1, 0), (1, 1), (0, 1)))


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
