"""The edge of the contact between cell centres: polygons in dual cells, traced and corrected."""

from __future__ import annotations

import math
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.cells import count_saturated
from roughcontact._answers.areas.dual_cells import (
    CORNER_COUNTS,
    CORNERS_INSIDE,
    CellOwners,
    DualCells,
    find_dual_cells,
    find_kinds,
)
from roughcontact._base.arrays import Array, IntArray, Mask, Pair
from roughcontact._parts.kernels import InfluenceKernel
from roughcontact._solve.solution import ContactSolution, Whole

Corners: TypeAlias = npt.NDArray[np.float64]

_TWO_INSIDE = CORNER_COUNTS == 2
_THREE_INSIDE = CORNER_COUNTS == 3
_DIAGONAL_INSIDE = (CORNERS_INSIDE[0] == CORNERS_INSIDE[2]) & (CORNERS_INSIDE[1] == CORNERS_INSIDE[3]) & _TWO_INSIDE
# Of two corners in contact: whether both lie along x, and the edge too.
_EDGE_ALONG_X = CORNERS_INSIDE[0] == CORNERS_INSIDE[1]
# The corner at which a polygon begins: the one that differs from the others, or the first of two in contact.
_ODD_CORNERS = np.where(_THREE_INSIDE, ~CORNERS_INSIDE, CORNERS_INSIDE)
_FIRST_CORNERS = np.where(_ODD_CORNERS[0] & _ODD_CORNERS[3] & _TWO_INSIDE, 3, np.argmax(_ODD_CORNERS, axis=0))
_BEGINS_EVEN = _FIRST_CORNERS % 2 == 0
# The corner before it, itself and both behind it, shape (4, 16).
_CORNERS_AROUND = np.stack([_FIRST_CORNERS + step & 3 for step in (-1, 0, 1, 2)])
_EULER_NUMBERS = np.select([CORNER_COUNTS == 1, _THREE_INSIDE, _DIAGONAL_INSIDE], [0.25, -0.25, -0.5], 0.0)
# Upper bound of the distance at the corners of a dual cell, in cells; at a smooth edge it is below sqrt(2).
_MAX_DISTANCE_CELLS = 16.0
# Distance of the furthest corner, in cells, where no y gives the gradient one, as at saddles: half a diagonal.
_SADDLE_DISTANCE_CELLS = 0.7
# Difference up to which distances from the edge count as the same, over the side of a dual cell: rounding and the
# tolerance of the solution; the largest number of such steps; and an offset, so that half a cell does not lie at the
# limit between two steps.
_KEY_STEP = 1e-3
_KEY_COUNT = 10_000
_KEY_OFFSET = 0.382
# Cells of a grid up to which the edges between neighbouring cells and between those two apart are measured together:
# then the number of calls decides, on larger ones the memory.
_MOST_CELLS_AT_ONCE = 2**14
# Newton steps for y^2 from a start within 9 % (quadratic convergence, rounding after 4), and inside a bracket.
_NEWTON_STEPS = 4
_BRACKETED_STEPS = 16


def find_crossings(distance: Corners) -> Corners:
    """Return where the edge crosses each side, as a fraction of the side from its first corner."""
    away = np.abs(distance)
    return _divide(away, away[[1, 2, 3, 0]])


def measure_polygons(
    distance: Corners, contact: Mask, kind: npt.NDArray[np.uint8], size: tuple[float, float]
) -> tuple[Array, Array, Array]:
    """Return the area inside (m2), the length (m) and the Euler number of the edge in each dual cell."""
    n = kind.size
    kind = kind.astype(np.intp)
    # Distances at the corner before the one to begin at, at that one and at both behind it.
    around = np.abs(distance).ravel().take(_CORNERS_AROUND.take(kind, axis=1) * n + np.arange(n))
    rest, middle, end = _divide(around.take((1, 1, 2), axis=0), around.take((0, 2, 3), axis=0))
    along, across = (np.where(_BEGINS_EVEN, *sides).take(kind) for sides in (size, size[::-1]))
    pair = _TWO_INSIDE.take(kind)
    triangle = 0.5 * rest * middle
    one = np.where(pair, 1.0, middle) * along
    other = np.where(pair, end - rest, rest) * across
    # Much faster than `numpy.hypot`; no side of a cell leaves the range of its square.
    chord = np.sqrt(one * one + other * other)
    area = np.where(pair, 0.5 * (rest + end), np.where(_THREE_INSIDE.take(kind), 1.0 - triangle, triangle))
    area *= size[0] * size[1]
    diagonal = np.flatnonzero(_DIAGONAL_INSIDE.take(kind))
    if diagonal.size:
        saddles = distance[:, diagonal]
        area[diagonal], chord[diagonal] = _measure_saddles(saddles, contact[:, diagonal], find_crossings(saddles), size)
    return area, chord, _EULER_NUMBERS.take(kind)


def _divide(one: Array, other: Array) -> Array:
    """Return the fraction of a side from one corner to the edge, for the distances of both corners from the edge."""
    with np.errstate(invalid="ignore"):
        part = one / (one + other)
    np.copyto(part, 0.5, where=np.isnan(part))
    return np.asarray(part)


def _measure_saddles(
    distance: Corners, contact: Mask, crossing: Corners, size: tuple[float, float]
) -> tuple[Array, Array]:
    """Return area and length where opposite corners are inside: connected if the distances have a positive sum."""
    connected = distance.sum(axis=0) > 0.0
    area = np.zeros(distance.shape[1])
    chord = np.zeros(distance.shape[1])
    for corner in range(4):
        # Separate corners inside have a triangle each; if they are connected, each corner outside has one instead.
        one = 1.0 - crossing[corner - 1]
        other = crossing[corner]
        triangle = contact[corner] != connected
        area += np.where(triangle, 0.5 * one * other, 0.0)
        before, after = (size[1], size[0]) if corner % 2 == 0 else (size[0], size[1])
        chord += np.where(triangle, np.hypot(one * before, other * after), 0.0)
    area = np.where(connected, 1.0 - area, area) * (size[0] * size[1])
    return area, chord


@attrs.frozen(eq=False)
class Contour:
    """The edge of each patch, arrays of shape (count + 1,); the first entry stands for no patch and is zero.

    Attributes
    ----------
    area, length
        Area inside the edge, m2, and its length, m.
    euler
        Euler number: the number of pieces less the number of holes.
    sharp, sharp_length
        Fraction of the edge that is sharp, and the length of that part on the cells, through the middles of their
        sides, m. These and the following are found between neighbouring cells alone.
    alike
        Mean number of dual cells with the same edge as one of them.
    meeting
        Number of dual cells in which the edge of the contact meets non-measured points.
    straight
        Where all edges are straight and run along the grid, with a known error that is corrected: side of a cell across
        them, m; else zero.
    """

    area: Array
    length: Array
    euler: Array
    sharp: Array
    sharp_length: Array
    alike: Array
    meeting: Array
    straight: Array


def trace_contour(solution: ContactSolution, sharp: Mask, stride: int = 1) -> Contour:
    """Return the edge of each patch between neighbouring cells, or between cells `stride` apart.

    With a stride it is the mean over all choices of cells. At the cells `sharp` of sharp edges, shape (nx, ny), cells
    are counted instead.
    """
    return _trace(solution, sharp, (stride,))[0]


def trace_both(solution: ContactSolution, sharp: Mask) -> tuple[Contour, Contour]:
    """Return `trace_contour` between neighbouring cells, and between cells two apart."""
    if solution.grid.cells > _MOST_CELLS_AT_ONCE:
        return trace_contour(solution, sharp, 1), trace_contour(solution, sharp, 2)
    one, two = _trace(solution, sharp, (1, 2))
    return one, two


def _trace(solution: ContactSolution, sharp: Mask, strides: tuple[int, ...]) -> list[Contour]:
    """Return the edges for strides, powers of two in ascending order, whose dual cells are measured together."""
    duals = [find_dual_cells(solution, stride) for stride in strides]
    patches = solution.patches
    edges = [_find_own_edge(solution, dual) for dual in duals]
    counts = [i.size for i, _ in edges]
    k = np.concatenate([dual.corners(i, j) for dual, (i, j) in zip(duals, edges, strict=True)], axis=1)
    weight = np.concatenate([dual.weigh(i, j) for dual, (i, j) in zip(duals, edges, strict=True)])
    stride = np.repeat(np.array(strides, dtype=np.float64), counts) if len(strides) > 1 else float(strides[0])
    label = patches.labels.ravel().take(k)
    touching = label > 0
    kind = find_kinds(touching)
    jagged = np.asarray(sharp.ravel().take(k).any(axis=0)) if sharp.any() else np.zeros(kind.size, dtype=bool)
    beside, meeting = _find_non_measured(solution, k, touching)
    # Beside non-measured points the contact ends with the cells.
    counted = jagged | beside
    size = solution.grid.spacing
    distance = find_distances(solution, k, touching, stride)
    parts, chords, euler = measure_polygons(distance, touching, kind, size)
    parts *= stride * stride
    chords *= stride
    # The corners in contact have a quarter each.
    quarters = CORNER_COUNTS.take(kind) / 4.0 * (size[0] * size[1] * stride * stride)
    parts = np.where(counted, quarters, parts)
    straight = np.zeros(patches.count + 1)
    # The edges between neighbouring cells are the first.
    is_fine = strides[0] == 1
    fine = slice(counts[0] if is_fine else 0)
    if is_fine and _has_known_edge(solution):
        straight, parts[fine] = _place_straight_edges(
            solution, label[:, fine], kind[fine], distance[:, fine], parts[fine], counted[fine]
        )
    alike = _count_alike(solution.parts, parts[fine] / (size[0] * size[1]), chords[fine] / size[0], distance[:, fine])
    smooth = weight * ~counted
    # Each of the strides has its own sums.
    width = patches.count + 1
    if len(strides) > 1:
        label = np.where(touching, label + np.repeat(np.arange(len(strides)) * width, counts), 0)
    owners = CellOwners.find(label, kind, len(strides) * width - 1)
    # At the edge the area of the polygon replaces the quarters of the corners in contact.
    found = [owners.sum(term) for term in ((parts - quarters) * weight, chords * smooth, euler * smooth)]
    if is_fine:
        equal = np.zeros(kind.size)
        equal[fine] = alike
        found += [owners.sum(weight), owners.sum(equal * weight)]
        found += [owners.sum(term * weight) for term in (jagged, _measure_steps(kind, size, jagged), meeting)]
    sums = np.stack(found).reshape(len(found), len(strides), width)
    sums = solution.parts.total(sums)
    contours = []
    for number, dual in enumerate(duals):
        replaced, length, euler_sum = sums[:3, number]
        total, equal_sum, jagged_part, steps, met = sums[3:, 0] if strides[number] == 1 else np.zeros((5, width))
        contours.append(
            Contour(
                area=solution.grid.cell_area * dual.cover(solution) + replaced,
                length=length,
                euler=euler_sum,
                sharp=_divide_or(jagged_part, total, 0.0),
                sharp_length=steps,
                alike=_divide_or(equal_sum, total, 1.0),
                meeting=met,
                straight=straight if strides[number] == 1 else np.zeros(width),
            )
        )
    return contours


def _find_own_edge(solution: ContactSolution, dual: DualCells) -> tuple[IntArray, IntArray]:
    """Return rows and columns of the dual cells at the edge that belong to this part of the contact alone."""
    i, j = dual.find_edge(solution.contact)
    mine = solution.parts.own_rows(i - dual.before[0])
    return i[mine], j[mine]


def _measure_steps(kind: npt.NDArray[np.uint8], size: Pair, chosen: Mask) -> Array:
    """Return the length of the edge in chosen dual cells through the middles of their sides, shape (n,), m."""
    steps = np.zeros(kind.size)
    at = np.flatnonzero(chosen)
    if at.size == 0:
        return steps
    diagonal = 0.5 * math.hypot(*size)
    lengths = np.where(_EDGE_ALONG_X, size[0], size[1])
    lengths[(CORNER_COUNTS == 1) | _THREE_INSIDE] = diagonal
    lengths[_DIAGONAL_INSIDE] = 2.0 * diagonal
    steps[at] = lengths.take(kind[at])
    return steps


def _has_known_edge(solution: ContactSolution) -> bool:
    """Return whether the pressure near a straight edge is that of `calibration.STRAIGHT_EDGE_PLACES`."""
    return solution.edge_shift == InfluenceKernel.edge_shift and not solution._laws


def _place_straight_edges(
    solution: ContactSolution,
    label: IntArray,
    kind: npt.NDArray[np.uint8],
    distance: Corners,
    parts: Array,
    counted: Mask,
) -> tuple[Array, Array]:
    """Return the side of a cell across the edges of patches that have only straight ones along the grid, and all areas.

    There all parts of an edge have the same place in a cell, and the same error, which is known.
    """
    grid = solution.grid
    count = solution.patches.count + 1
    even = (_TWO_INSIDE & ~_DIAGONAL_INSIDE).take(kind) & ~counted
    patch = label.max(axis=0)
    sides, corners = _count_sides(solution, patch, ~even)
    if (corners[1:] > 0).all():
        return np.zeros(count), parts
    inside = label > 0
    ordered = np.sort(distance, axis=0)
    uneven = np.maximum(ordered[1] - ordered[0], ordered[3] - ordered[2])
    even &= uneven <= _KEY_STEP * (ordered[3] - ordered[0])
    _, uneven_sides = _count_sides(solution, patch, ~even)
    # Patches of a single row of cells, with a row of sides on either side, have no edge that is known.
    cells = np.concatenate(([0], solution.patches.cells))
    straight = (sides > 0) & (cells >= sides)
    straight[uneven_sides > 0] = False
    straight[count_saturated(solution) > 0] = False
    straight[0] = False
    chosen = np.flatnonzero(straight[patch])
    places, traced = calibration.STRAIGHT_EDGE_PLACES
    found = np.interp(parts[chosen] / grid.cell_area, traced, places)
    # The polygons are to be enlarged by the mean shift of edges in all directions.
    across = np.where(inside[0] == inside[3], *grid.spacing)[chosen]
    parts = parts.copy()
    parts[chosen] = (found - solution.edge_shift * math.sqrt(grid.resolved.cell_area) / across) * grid.cell_area
    across_edges = np.zeros(straight.size)
    across_edges[patch[chosen]] = across
    return solution.parts.highest(across_edges), parts


def _count_sides(solution: ContactSolution, patch: IntArray, chosen: Mask) -> IntArray:
    """Return the numbers of dual cells, and of chosen ones, at the edge of each patch, shape (2, count + 1)."""
    count = solution.patches.count + 1
    return solution.parts.total(np.stack([np.bincount(of, minlength=count) for of in (patch, patch[chosen])]))


def _find_non_measured(solution: ContactSolution, k: IntArray, touching: Mask) -> tuple[Mask, Mask]:
    """Return which dual cells have non-measured corners, and which of these have open corners too, shape (n,)."""
    if solution.non_measured is None:
        none = np.zeros(k.shape[1], dtype=bool)
        return none, none
    unknown = solution.non_measured.ravel()[k]
    beside = np.asarray(unknown.any(axis=0))
    return beside, np.asarray(beside & ~(unknown | touching).all(axis=0))


def _divide_or(sums: Array, counts: Array, otherwise: float) -> Array:
    return np.divide(sums, counts, out=np.full_like(sums, otherwise), where=counts > 0.0)


def _count_alike(whole: Whole, parts: Array, chords: Array, distance: Corners) -> IntArray:
    """Return how many dual cells have the same edge as each, shape (n,).

    Where the contact repeats on the grid, or is symmetric in it, the errors of its parts are the same.
    """
    highest = np.abs(distance).max(axis=0)
    highest = highest / np.maximum(whole.highest(highest.max(initial=0.0)), np.finfo(float).tiny)
    first, second, third = (np.floor(part / _KEY_STEP + _KEY_OFFSET) for part in (parts, chords, highest))
    return whole.count_equal((first * _KEY_COUNT + second) * _KEY_COUNT + third)


def find_modulus_change(solution: ContactSolution) -> float:
    """Return the logarithm of the change of E* over two octaves of wavelength at the edge; zero without layers."""
    if solution.moduli is None:
        return 0.0
    length = calibration.MODULUS_LENGTH * math.sqrt(solution.grid.resolved.cell_area)
    shorter, longer = solution.effective_modulus(np.array([2.0, 0.5]) / length)
    return abs(math.log(longer / shorter))


def find_distances(solution: ContactSolution, k: IntArray, contact: Mask, stride: float | Array = 1) -> Corners:
    """Return the signed distance from the edge at the corners `k`, `stride` apart, of dual cells, shape (4, n), m.

    The stride is that of all dual cells, or of each, shape (n,).
    """
    dx, dy = solution.grid.resolved.spacing
    size = (stride * dx, stride * dy)
    step = np.sqrt(size[0] * size[1])
    modulus = solution.effective_modulus(1.0 / (calibration.MODULUS_LENGTH * step))
    inside = np.square(solution.pressure.ravel().take(k) / modulus)
    outside = np.zeros_like(inside)
    open_ = np.flatnonzero(~contact)
    outside.ravel()[open_] = _cube_root(np.square(0.75 * np.maximum(solution.gap.ravel().take(k.ravel()[open_]), 0.0)))
    ax, ay = _differentiate(inside, size)
    bx, by = _differentiate(outside, size)
    if solution.directional_moduli is not None:
        softer = (modulus / _find_edge_moduli(solution.directional_moduli, (ax, ay), (bx, by))) ** 2
        inside = inside * softer
        ax = ax * softer
        ay = ay * softer
    # |grad phi|^2 is a cubic in w = y^2.
    cubic = ax * ax + ay * ay
    square = -2.0 * (ax * bx + ay * by)
    linear = bx * bx + by * by
    w = _approach_root(cubic, square, linear, 1.0)
    longest = np.broadcast_to(_MAX_DISTANCE_CELLS * step, w.shape)
    most = inside.max(axis=0), outside.max(axis=0)
    with np.errstate(invalid="ignore", over="ignore"):
        y = np.sqrt(w)
        usual = (square >= 0.0) & (y < np.inf) & (w * y * most[0] <= longest) & (y * most[1] <= longest)
    few = np.flatnonzero(~usual)
    if few.size:
        terms = cubic[few], square[few], linear[few]
        found = _find_unusual_root(terms, (most[0][few], most[1][few]), longest[few])
        w[few] = found
        y[few] = np.sqrt(found)
    return np.asarray(inside * (w * y) - outside * y)


def _find_unusual_root(terms: tuple[Array, Array, Array], most: tuple[Array, Array], longest: Array) -> Array:
    """Return w of dual cells where Newton's method does not find it, or finds no edge near them.

    `terms` are those of the cubic, `most` the largest terms inside and outside, and `longest` the largest distance.
    """
    with np.errstate(divide="ignore"):
        highest = np.minimum(_cube_root(longest / most[0]) ** 2, (longest / most[1]) ** 2)
    highest = np.where(np.isfinite(highest), highest, 1.0)
    w = _find_root(*terms, highest)
    cubic, square, linear = terms
    rootless = ((cubic * highest + square) * highest + linear) * highest < 1.0
    if rootless.any():
        inside, outside = (part[rootless] for part in most)
        # The square of P y^3 + G y is a cubic in w too.
        saddle = (_SADDLE_DISTANCE_CELLS / _MAX_DISTANCE_CELLS * longest[rootless]) ** 2
        w[rootless] = _find_root(inside**2, 2 * inside * outside, outside**2, highest[rootless], saddle)
    return w


def _cube_root(values: Array) -> Array:
    """Return the cube roots of values that are not negative, up to rounding; a quarter of the time of `numpy.cbrt`."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.exp(np.log(values) / 3.0))


def _find_edge_moduli(moduli: tuple[float, ...], inward: tuple[Array, Array], outward: tuple[Array, Array]) -> Array:
    """Return the moduli of waves at right angles to the edge, by the gradients inside and outside, shape (n,), Pa."""
    normals = [parts / np.maximum(np.hypot(*parts), np.finfo(float).tiny) for parts in map(np.stack, (inward, outward))]
    x, y = normals[0] - normals[1]
    turns = np.arctan2(y, x) / np.pi
    return np.asarray(np.interp(turns % 1.0, np.arange(len(moduli) + 1) / len(moduli), (*moduli, moduli[0])))


def _differentiate(values: Corners, size: tuple[float | Array, float | Array]) -> tuple[Array, Array]:
    low_left, high_left, high_right, low_right = values
    along_x = (high_left + high_right - low_left - low_right) / (2.0 * size[0])
    along_y = (high_right + low_right - low_left - high_left) / (2.0 * size[1])
    return along_x, along_y


def _find_root(cubic: Array, square: Array, linear: Array, highest: Array, value: float | Array = 1.0) -> Array:
    """Return w in [0, highest] where the polynomial reaches a value, by Newton's method."""
    w = _approach_root(cubic, square, linear, value)
    wild = (square < 0.0) | ~((w >= 0.0) & (w < np.inf))
    if wild.any():
        w[wild] = _find_bracketed_root(
            cubic[wild], square[wild], linear[wild], highest[wild], np.broadcast_to(value, wild.shape)[wild]
        )
    return w


def _approach_root(cubic: Array, square: Array, linear: Array, value: float | Array) -> Array:
    """Return the positive w where a polynomial without negative terms reaches a value, by Newton's method."""
    triple = 3.0 * cubic
    double = 2.0 * square
    with np.errstate(divide="ignore", invalid="ignore"):
        # Each term alone reaches the value at the inverse of one of these; their sum near the inverse of the norm.
        w = 1.0 / np.sqrt(_cube_root(cubic / value) ** 2 + square / value + (linear / value) ** 2)
        for _ in range(_NEWTON_STEPS):
            excess = ((cubic * w + square) * w + linear) * w - value
            w = w - excess / ((triple * w + double) * w + linear)
    return np.asarray(w)


def _find_bracketed_root(cubic: Array, square: Array, linear: Array, highest: Array, value: Array) -> Array:
    low = np.zeros_like(highest)
    high = highest.copy()
    w = 0.5 * highest
    for _ in range(_BRACKETED_STEPS):
        excess = ((cubic * w + square) * w + linear) * w - value
        above = excess > 0.0
        np.copyto(high, w, where=above)
        np.copyto(low, w, where=~above)
        slope = (3.0 * cubic * w + 2.0 * square) * w + linear
        with np.errstate(divide="ignore", invalid="ignore"):
            trial = w - excess / slope
        # A root that is found is an end of the bracket.
        w = np.where((trial >= low) & (trial <= high), trial, 0.5 * (low + high))
    return w
