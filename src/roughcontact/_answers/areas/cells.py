"""Cells at the edge of the contact: the sides between contact and open cells, sharp edges, and creases beside them."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.areas import calibration
from roughcontact._base.arrays import Array, IntArray, Mask, RealArray
from roughcontact._parts.grid import Boundary, extend, list_borders
from roughcontact._solve.solution import ContactSolution

# Cells of the smallest patch that may have a sharp edge: in smaller ones the pressure rises outward by chance.
MIN_SHARP_PATCH_CELLS = 9
# Height of a step over the differences of height before and behind it, from which it is sharp.
_MIN_STEP_RATIO = 4.0
# Steps, in cells, to the neighbours of a cell at its four sides, at its four corners, and at both. Every second of
# them, from the first on, is opposite to the next.
SIDE_STEPS = np.array(((1, 0), (-1, 0), (0, 1), (0, -1)))
CORNER_STEPS = np.array(((1, 1), (-1, -1), (1, -1), (-1, 1)))
NEIGHBOUR_STEPS = np.concatenate((SIDE_STEPS, CORNER_STEPS))
# Which of these run along an axis, shape (8, 1), and the two neighbours beside each direction by their places there,
# shape (2, 8): across an axis on both sides, and beside a diagonal those along both axes.
_IS_STRAIGHT = (NEIGHBOUR_STEPS == 0).any(axis=1)[:, np.newaxis]
_BESIDE = np.where(_IS_STRAIGHT.T, np.arange(8) ^ [[2], [3]], (NEIGHBOUR_STEPS.T < 0) + [[0], [2]])
# Second differences beside the two at a crease, in cells from the first of both, that must be small.
_BESIDE_CREASE = (-2, -1, 2, 3)
# Cells on each side that the second differences at a cell and beside it need.
_REACH = 4
# Cells in a list whose neighbours are in the cache of a core at once.
_CELLS_AT_ONCE = 2**13
# Cells in contact across a crease up to which its height counts in full: two lie at it. In a wider contact it is a part
# of a line, whose sampling is of second order.
_NARROW_RUN = 2.0


@attrs.frozen(eq=False)
class Neighbourhood:
    """The cells around chosen cells; beyond the border these are periodic images, or the outermost cells.

    Attributes
    ----------
    cells
        Flat indices of the cells, shape (n,).
    width
        Cells in a row.
    near
        Positions of those near the border in `cells`, shape (m,).
    rows, columns
        Flat indices of the rows, and numbers of the columns, from `reach` cells before the cells near the border to
        `reach` cells behind them, shape (2 reach + 1, m).
    reach
        Largest distance from a cell along an axis, in cells.
    """

    cells: IntArray
    width: int
    near: IntArray
    rows: IntArray
    columns: IntArray
    reach: int

    @classmethod
    def of(cls, i: IntArray, j: IntArray, shape: tuple[int, int], boundary: Boundary, reach: int) -> Neighbourhood:
        """Return the neighbourhood of the cells (i, j), shape (n,)."""
        nx, ny = shape
        near = np.flatnonzero((i < reach) | (i >= nx - reach) | (j < reach) | (j >= ny - reach))
        steps = np.arange(-reach, reach + 1)[:, np.newaxis]
        ends = []
        for at, n, free in zip((i, j), shape, boundary.free_axes, strict=True):
            around = at[near] + steps
            ends.append(np.clip(around, 0, n - 1) if free else around % n)
        return cls(i * ny + j, ny, near, ends[0] * ny, ends[1], reach)

    @classmethod
    def inside(cls, solution: ContactSolution, chosen: IntArray, reach: int) -> Neighbourhood:
        """Return the neighbourhood of cells of flat index, moved inside near a free border that it would cross."""
        shape = solution.contact.shape
        axes = zip(split(chosen, shape[1]), shape, solution.boundary.free_axes, strict=True)
        i, j = (np.clip(k, reach, n - 1 - reach) if free and n > 2 * reach else k for k, n, free in axes)
        return cls.of(i, j, shape, solution.boundary, reach)

    def at(self, steps: IntArray) -> IntArray:
        """Return the flat indices of the cells by steps (i, j), shape (m, 2), from each cell, shape (m, n)."""
        found = self.cells + (steps @ (self.width, 1))[:, np.newaxis]
        if self.near.size:
            i, j = (steps + self.reach).T
            found[:, self.near] = self.rows[i] + self.columns[j]
        return np.asarray(found)


def gather_around(field: RealArray, cells: IntArray, reach: int, boundary: Boundary) -> RealArray:
    """Return a field around cells of flat index, shape (2 reach + 1, 2 reach + 1, n); beyond a border as `extend`."""
    steps = np.arange(-reach, reach + 1)[:, np.newaxis]
    rows, columns = (
        np.clip(at + steps, 0, n - 1) if free else (at + steps) % n
        for at, n, free in zip(split(cells, field.shape[1]), field.shape, boundary.free_axes, strict=True)
    )
    return np.asarray(field[rows[:, np.newaxis], columns])


def split(cells: IntArray, width: int) -> tuple[IntArray, IntArray]:
    """Return the rows and columns of flat indices; faster than `numpy.divmod`."""
    i = cells // width
    return i, cells - i * width


def find_cut_cells(solution: ContactSolution) -> Mask:
    """Return the cells at a free border that cuts the contact where its pressure is below the limit, shape (nx, ny).

    The square of the pressure, linear in the distance from an edge, then does not vanish before the border.
    """
    shape = solution.contact.shape
    cut = np.zeros(shape, dtype=bool)
    if not solution.boundary.has_free_axis:
        return cut
    limit = np.broadcast_to(solution.pressure_limit, shape)
    for axis, cells in enumerate(shape):
        if not solution.boundary.free_axes[axis]:
            continue
        pressure, highest, marked = (np.moveaxis(field, axis, 0) for field in (solution.pressure, limit, cut))
        for pair in ((0, min(1, cells - 1)), (cells - 1, max(cells - 2, 0))):
            outer, inner = (np.where(pressure[k] < highest[k], pressure[k], 0.0) ** 2 for k in pair)
            marked[pair[0]] |= 3.0 * outer > inner
    return solution.parts.own(cut)


def find_cut_patches(solution: ContactSolution) -> Mask:
    """Return which patches a free border cuts, shape (count,)."""
    return find_patches_of(solution, find_cut_cells(solution))


def find_spanning_patches(solution: ContactSolution) -> Mask:
    """Return which patches have cells all along a periodic axis, as lines have, shape (count,)."""
    patches = solution.patches
    spanning = np.zeros(patches.count, dtype=bool)
    places = split(patches.members, solution.grid.shape[1])
    for axis, free in enumerate(solution.boundary.free_axes):
        side = solution.grid.shape[axis]
        long = np.flatnonzero(patches.cells >= side)
        if free or long.size == 0:
            continue
        number = np.full(patches.count, -1)
        number[long] = np.arange(long.size)
        owner = number[patches.member_labels - 1]
        at = places[axis] if axis else solution.parts.rows(places[axis])
        reached = np.zeros((long.size, side))
        reached[owner[owner >= 0], at[owner >= 0]] = 1.0
        spanning[long] |= (solution.parts.total(reached) > 0.0).all(axis=1)
    return spanning


def find_patches_of(solution: ContactSolution, marked: Mask) -> Mask:
    """Return which patches have marked cells, shape (count,)."""
    counts = np.bincount(solution.patches.labels[marked], minlength=solution.patches.count + 1)
    return np.asarray(solution.parts.total(counts)[1:] > 0)


def count_saturated(solution: ContactSolution) -> IntArray:
    """Return the number of saturated cells of each patch, shape (count + 1,), from zero for no patch."""
    patches = solution.patches
    if not solution.capped:
        return np.zeros(patches.count + 1, dtype=np.intp)
    saturated = patches.member_labels[solution.saturated.ravel()[patches.members]]
    return solution.parts.total(np.bincount(saturated, minlength=patches.count + 1))


def count_crossings(solution: ContactSolution) -> int:
    """Return the number of places where the edge of the contact meets a free border that cuts it."""
    contact = solution.contact
    cut = find_cut_cells(solution)
    borders = [list_borders(field, solution.boundary) for field in (contact, cut)]
    crossings = [(line[1:] != line[:-1]) & (marked[1:] | marked[:-1]) for line, marked in zip(*borders, strict=True)]
    return sum(int(np.count_nonzero(crossing)) for crossing in crossings)


def count_sides(solution: ContactSolution, of: Mask | None = None) -> int:
    """Return the number of cell sides between contact and open cells, or of those at the cells `of`."""
    return int(_count_both(solution, of).sum())


def measure_sides(solution: ContactSolution) -> float:
    """Return the total length of the cell sides between contact and open cells, m."""
    across, along = _count_both(solution, None)
    dx, dy = solution.grid.spacing
    return float(across * dy + along * dx)


def measure_obliqueness(solution: ContactSolution) -> float:
    """Return how oblique the edge is to the grid: |sin 2t| of its mean direction t; zero without an edge."""
    across, along = _count_both(solution, None) * np.array(solution.grid.spacing[::-1])
    squares = float(across**2 + along**2)
    return 2.0 * float(across * along) / squares if squares > 0.0 else 0.0


def _count_both(solution: ContactSolution, of: Mask | None) -> IntArray:
    """Return the numbers of sides that face x, and y, shape (2,)."""
    both = _mark_sides(solution.contact, solution.boundary, of)
    return solution.parts.total(np.array([np.count_nonzero(solution.parts.own(sides)) for sides in both]))


def find_straight_rows(solution: ContactSolution) -> IntArray:
    """Return the lengths, in sides, of the straight rows of sides that form the edge of the contact."""
    return solution._keep("straight rows", lambda: _find_straight_rows(solution))


def _find_straight_rows(solution: ContactSolution) -> IntArray:
    boundary = solution.boundary
    lengths = []
    for axis, sides in enumerate(_mark_sides(solution.contact, boundary, None)):
        lines = solution.parts.lines(sides, axis)
        if not boundary.free_axes[1 - axis]:
            # A row that crosses the border is one row: rotate its line so that it begins at a gap.
            crossing = np.flatnonzero(lines[:, 0] & lines[:, -1])
            crossing = crossing[~lines[crossing].all(axis=1)]
            first = np.argmin(lines[crossing], axis=1)[:, np.newaxis]
            order = (np.arange(lines.shape[1]) + first) % lines.shape[1]
            lines[crossing] = np.take_along_axis(lines[crossing], order, axis=1)
        # With a gap before the first line and behind each.
        padded = np.zeros(lines.shape[0] * (lines.shape[1] + 1) + 1, dtype=bool)
        padded[1:].reshape(lines.shape[0], -1)[:, :-1] = lines
        starts, stops = np.flatnonzero(padded[1:] != padded[:-1]).reshape(-1, 2).T
        lengths.append(stops - starts)
    return np.concatenate(lengths)


def _mark_sides(contact: Mask, boundary: Boundary, of: Mask | None) -> tuple[Mask, Mask]:
    """Mark the sides of the edge between each cell and the next along x, then along y."""
    marked = []
    for axis in (0, 1):
        sides = contact != np.roll(contact, -1, axis=axis)
        if of is not None:
            sides &= of | np.roll(of, -1, axis=axis)
        if boundary.free_axes[axis]:
            sides[(-1,) if axis == 0 else (slice(None), -1)] = False
        marked.append(sides)
    return marked[0], marked[1]


def find_sharp_edges(solution: ContactSolution) -> Mask:
    """Return the cells of the contact at a sharp edge, as of a flat punch, shape (nx, ny).

    There the pressure does not decay towards the edge over three cells. Along an axis both lateral neighbours must be
    in contact, along a diagonal both cells beside the outer one must be open: otherwise the edge passes at an angle.
    The pressure of saturated cells does not depend on the distance from the edge: they are marked where the heights
    have a step.
    """
    return solution._keep("sharp edges", lambda: _find_sharp_edges(solution))


def _find_sharp_edges(solution: ContactSolution) -> Mask:
    shape = solution.contact.shape
    patches = solution.patches
    sharp = np.zeros(solution.contact.size, dtype=bool)
    edge = find_edge_cells(solution)
    one, other = edge.touching[_BESIDE]
    sides = np.where(_IS_STRAIGHT, one & other, ~(one | other))
    sides &= ~edge.touching
    sides &= (patches.cells >= MIN_SHARP_PATCH_CELLS)[patches.labels.ravel().take(edge.cells) - 1]
    direction, facing = np.nonzero(sides)
    if facing.size == 0:
        return sharp.reshape(shape)
    pressure = solution.pressure.ravel()
    outer, inner, innermost = pressure.take(edge.walk(direction, facing, (0, -1, -2)))
    marked = (outer >= inner) & (inner >= innermost) & (innermost > 0.0)
    if solution.capped:
        saturated = solution.saturated.ravel()[edge.cells[facing]]
        gap = solution.initial_gap.ravel()
        before, level, after, beyond = gap.take(edge.walk(direction, facing, (-1, 0, 1, 2)))
        stepped = after - level > _MIN_STEP_RATIO * np.maximum(np.abs(beyond - after), np.abs(level - before))
        marked = np.where(saturated, stepped, marked)
    sharp[edge.cells[facing[marked]]] = True
    return sharp.reshape(shape)


@attrs.frozen(eq=False)
class EdgeCells:
    """The cells in contact that have an open neighbour; beyond a free border nothing is open.

    Attributes
    ----------
    rows, columns, cells
        Their places, and their flat indices, shape (n,).
    touching
        Whether each of the eight neighbours is in contact, those along an axis first, shape (8, n).
    shape, free_axes
        Shape of the grid, and along which of its axes it is free.
    """

    rows: IntArray
    columns: IntArray
    cells: IntArray
    touching: Mask
    shape: tuple[int, int]
    free_axes: tuple[bool, bool]

    def walk(self, direction: IntArray, start: IntArray, distances: tuple[int, ...]) -> IntArray:
        """Return the flat indices of the cells so many steps from cells of these in directions, shape (distances, m).

        Beyond the border these are periodic images, or the outermost cells.
        """
        steps = NEIGHBOUR_STEPS[direction].T
        apart = np.array(distances)[:, np.newaxis]
        reach = max(map(abs, distances))
        places = []
        for at, step, n, free in zip((self.rows, self.columns), steps, self.shape, self.free_axes, strict=True):
            around = np.arange(-reach, n + reach)
            # A table is faster than a remainder of each place.
            known = np.clip(around, 0, n - 1) if free else around % n
            places.append(known.take((at[start] + reach) + apart * step))
        return np.asarray(places[0] * self.shape[1] + places[1])


def find_edge_cells(solution: ContactSolution) -> EdgeCells:
    """Return the cells at the edge of the contact."""
    return solution._keep("edge cells", lambda: _find_edge_cells(solution))


def _find_edge_cells(solution: ContactSolution) -> EdgeCells:
    contact = solution.contact
    nx, ny = contact.shape
    cells = np.flatnonzero(contact & ~find_interior(solution))
    rows, columns = split(cells, ny)
    width = ny + 2
    here = (rows + 1) * width + (columns + 1)
    extended = extend(contact, 1, solution.boundary).ravel()
    touching = extended.take(here + (NEIGHBOUR_STEPS @ (width, 1))[:, np.newaxis])
    return EdgeCells(rows, columns, cells, touching, (nx, ny), solution.boundary.free_axes)


def find_interior(solution: ContactSolution) -> Mask:
    """Return the cells in contact whose eight neighbours are in contact too, shape (nx, ny)."""
    return solution._keep("interior", lambda: _find_interior(solution.contact, solution.boundary))


def _find_interior(contact: Mask, boundary: Boundary) -> Mask:
    extended = extend(contact, 1, boundary)
    rows = extended[:-2] & extended[1:-1]
    rows &= extended[2:]
    interior = rows[:, :-2] & rows[:, 1:-1]
    interior &= rows[:, 2:]
    return np.asarray(interior)


def find_lost_std(solution: ContactSolution) -> float:
    r"""Return the standard deviation of the approach by creases and sharp edges between the cells, m.

    The top of a crease lies between the cells, which know only its flanks. With the falls a and b from cell to cell on
    both sides it is :math:`ab / (2(a + b))` above the higher of two cells on average. At a sharp edge the pressure
    rises as :math:`K / \sqrt{2 \pi x}`. An edge that is moved outwards by s along the length b lowers the approach by

    .. math:: \frac{K^2 s b}{E^* F}, \qquad K^2 = \frac{\pi}{2} p^2 h,

    with the pressure p of the outermost cells, of width h: the derivative of the energy by the position of the edge.

    References
    ----------
    Johnson, Contact Mechanics (1985), section 5.3, https://doi.org/10.1017/CBO9781139171731
    """
    # Approach, mean gap and leakage ask for the same.
    return solution._keep("lost heights", lambda: math.hypot(_find_crease_std(solution), _find_sharp_std(solution)))


def _find_crease_std(solution: ContactSolution) -> float:
    """Return the standard deviation of the approach by creases between the cells in contact, m."""
    chosen = np.flatnonzero(solution.contact)
    load = np.maximum(solution.pressure.ravel()[chosen], 0.0)
    if not load.any():
        return 0.0
    lost = np.zeros(chosen.shape)
    for first in range(0, chosen.size, _CELLS_AT_ONCE):
        part = slice(first, first + _CELLS_AT_ONCE)
        lost[part] = _find_lost_heights(solution, chosen[part])
    return calibration.CREASE_STD * float(np.sum(load * lost) / np.sum(load))


def _find_lost_heights(solution: ContactSolution, chosen: IntArray) -> Array:
    """Return the mean heights of creases across both axes above chosen cells as far as they count, m."""
    lost = np.zeros(chosen.shape)
    shape = solution.grid.shape
    near = Neighbourhood.inside(solution, chosen, _REACH)
    for step, cells in zip(((1, 0), (0, 1)), shape, strict=True):
        if cells > 2 * _REACH:
            height = _find_lost_height(solution, near, step)
            creased = np.flatnonzero(height)
            places = split(chosen[creased], shape[1])
            touching = Neighbourhood.of(*places, shape, solution.boundary, _REACH)
            narrow = np.minimum(_NARROW_RUN / _count_run(solution, touching, step), 1.0)
            lost[creased] += narrow**2 * height[creased]
    return lost


def _find_lost_height(solution: ContactSolution, near: Neighbourhood, step: tuple[int, int]) -> Array:
    """Return the mean height of a crease across an axis above the cells, m; zero where there is none."""
    line = solution.initial_gap.ravel().take(near.at(np.outer(np.arange(-_REACH, _REACH + 1), step)))
    lost = np.zeros(line.shape[1])
    bends = np.diff(line, 2, axis=0)
    for there, around in ((line, bends), (line[::-1], bends[::-1])):
        jump = find_jumps(around, _BESIDE_CREASE, calibration.MAX_BEND_BESIDE)
        before, here, after, beyond = there[_REACH - 1 : _REACH + 3]
        slopes = np.maximum(before - here, 0.0) * np.maximum(beyond - after, 0.0)
        found = np.flatnonzero(jump)
        lost[found] = np.maximum(lost[found], 0.5 * slopes[found] / jump[found])
    return lost


def find_jumps(bends: Array, beside: tuple[int, ...], most: float) -> Array:
    """Return the jumps of the slope between the middle of lines and the next cell; zero where the line bends elsewhere.

    `bends` are the second differences, an odd number along the first axis; those at steps `beside` from the middle must
    be smaller than a fraction `most` of the jump.
    """
    middle = len(bends) // 2
    jump = bends[middle] + bends[middle + 1]
    others = np.abs(bends[[middle + step for step in beside]]).max(axis=0)
    return np.where(others < most * jump, jump, 0.0)


def _count_run(solution: ContactSolution, near: Neighbourhood, step: tuple[int, int]) -> IntArray:
    """Return how many cells are in contact in line through each cell, up to `_REACH` on both sides."""
    contact = solution.contact.ravel()
    count = np.ones(near.cells.shape, dtype=np.intp)
    for side in (1, -1):
        beside = contact[near.at(np.outer(side * np.arange(1, _REACH + 1), step))]
        count += np.logical_and.accumulate(beside).sum(axis=0)
    return count


def _find_sharp_std(solution: ContactSolution) -> float:
    """Return the standard deviation of the approach by sharp edges, which lie anywhere between two cells, m."""
    if solution.force == 0.0:
        return 0.0
    closed = solution.contact if solution.non_measured is None else solution.contact | solution.non_measured
    # Beyond a free border nothing is open: where it cuts the contact is counted apart.
    around = extend(closed, 1, solution.boundary)
    pressure = np.where(find_sharp_edges(solution) & ~solution.saturated, solution.pressure, 0.0)
    energy = 0.0
    for step, before, after in (
        (solution.grid.spacing[0], around[:-2, 1:-1], around[2:, 1:-1]),
        (solution.grid.spacing[1], around[1:-1, :-2], around[1:-1, 2:]),
    ):
        count = (~before).astype(np.intp) + ~after
        energy += step * solution.grid.cell_area * float(np.sum(count * pressure**2))
    modulus = float(solution.effective_modulus(1.0 / math.sqrt(solution.grid.resolved.cell_area)))
    return calibration.SHARP_EDGE_STD * energy / (modulus * abs(solution.force))
