"""Elimination of the cells of a grid by nested dissection, in dense blocks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray

# Cells along the sides of the smallest patches, which are halved no further.
_PATCH_SIDE = 4
# Sides of the blocks of products, and columns with two right sides: for so many OpenBLAS takes one thread (see
# `matrix_product`), and rounds the same whatever their number.
_BLOCK = 60
_COLUMNS = 2048
# Numbers of the matrices of patches that are held at a time.
_HELD_NUMBERS = 2**20


@attrs.frozen(eq=False)
class _Step:
    """What eliminates the same nodes of some patches of one shape.

    Attributes
    ----------
    inside, border
        Cells that are eliminated, and those that are joined to them, shape (patches, nodes).
    parts
        Of each part of the first the inverse of its Cholesky factor, and the factors of those behind it and of the
        second.
    """

    inside: IntArray
    border: IntArray
    parts: list[tuple[Array, Array, Array]]

    def go_down(self, values: Array) -> list[Array]:
        """Eliminate from right sides, shape (cells, 2); return what `go_up` takes."""
        found = []
        start = 0
        for inverse, behind, beside in self.parts:
            end = start + inverse.shape[1]
            given = inverse @ values[self.inside[:, start:end]]
            _spread(values, self.inside[:, end:], behind, given)
            _spread(values, self.border, beside, given)
            found.append(given)
            start = end
        return found

    def go_up(self, values: Array, found: list[Array]) -> None:
        """Set the nodes from those that are eliminated after them."""
        end = self.inside.shape[1]
        for (inverse, behind, beside), given in zip(reversed(self.parts), reversed(found), strict=True):
            _gather(given, values, self.inside[:, end:], behind)
            _gather(given, values, self.border, beside)
            start = end - inverse.shape[1]
            values[self.inside[:, start:end]] = inverse.transpose(0, 2, 1) @ given
            end = start


def _spread(values: Array, nodes: IntArray, factor: Array, given: Array) -> None:
    """Subtract the product of the transposed factor from values at nodes, which patches share."""
    flat = values.reshape(-1)
    for part in _list_parts(factor.shape[2], _COLUMNS):
        change = factor[:, :, part].transpose(0, 2, 1) @ given
        places = 2 * nodes[:, part, np.newaxis] + np.arange(2)
        np.subtract.at(flat, places.ravel(), change.ravel())


def _gather(given: Array, values: Array, nodes: IntArray, factor: Array) -> None:
    """Subtract the product of the factor with values at nodes."""
    for part in _list_parts(factor.shape[2], _COLUMNS):
        given -= factor[:, :, part] @ values[nodes[:, part]]


def _list_parts(count: int, step: int) -> Iterator[slice]:
    """Return the slices of some numbers at a time."""
    return (slice(start, min(start + step, count)) for start in range(0, count, step))


@attrs.frozen(eq=False)
class _Front:
    """Matrices of some patches of one shape, of which the nodes inside are eliminated.

    Attributes
    ----------
    inside, beside, border
        Matrices that join the nodes inside, these with those on the border, and the latter, of which those below the
        diagonal are not used: shapes (patches, nodes, nodes).
    """

    inside: Array
    beside: Array
    border: Array

    def choose(self, rows: slice, columns: slice) -> Array:
        """Return a block, by places among all nodes, those inside first; it is empty below those inside."""
        count = self.inside.shape[1]
        if rows.start < count:
            return (
                self.inside[:, rows, columns] if columns.start < count else self.beside[:, rows, _shift(columns, count)]
            )
        return self.border[:, _shift(rows, count), _shift(columns, count) if columns.start >= count else slice(0)]

    def add(self, matrices: Array, order: IntArray) -> None:
        """Add matrices of nodes, whose places among all nodes are given."""
        runs = _list_runs(order, self.inside.shape[1])
        for (rows, source), (columns, other) in itertools.product(runs, repeat=2):
            block = self.choose(rows, columns)
            if block.size:
                block += matrices[:, source, other]

    def eliminate(self) -> list[tuple[Array, Array, Array]]:
        """Eliminate the nodes inside; return the parts of a `_Step`."""
        found = []
        for part in _list_parts(self.inside.shape[1], _BLOCK):
            inverse = np.linalg.inv(np.linalg.cholesky(self.inside[:, part, part]))
            rest = self.inside[:, part.stop :, part.stop :]
            behind = _multiply(inverse, self.inside[:, part, part.stop :])
            beside = _multiply(inverse, self.beside[:, part])
            _subtract(rest, [behind], [behind], is_symmetric=True)
            _subtract(self.beside[:, part.stop :], [behind], [beside])
            found.append((inverse, behind, beside))
        factors = [beside for _, _, beside in found]
        _subtract(self.border, factors, factors, is_symmetric=True)
        _mirror(self.border)
        return found


def _shift(part: slice, count: int) -> slice:
    return slice(part.start - count, part.stop - count)


def _multiply(inverse: Array, columns: Array) -> Array:
    """Return the product with an inverse factor."""
    product = np.empty(columns.shape)
    for part in _list_parts(columns.shape[2], _BLOCK):
        np.matmul(inverse, columns[:, :, part], out=product[:, :, part])
    return product


def _subtract(matrices: Array, ones: list[Array], others: list[Array], *, is_symmetric: bool = False) -> None:
    """Subtract the products of the first transposed and the second; of symmetric ones only above the diagonal."""
    pairs = list(zip(ones, others, strict=True))
    for rows, columns in itertools.product(*(list(_list_parts(count, _BLOCK)) for count in matrices.shape[1:])):
        if not pairs or (is_symmetric and columns.start < rows.start):
            continue
        one, other = pairs[0]
        total = one[:, :, rows].transpose(0, 2, 1) @ other[:, :, columns]
        # In place: the sum stays in the cache.
        for one, other in pairs[1:]:
            total += one[:, :, rows].transpose(0, 2, 1) @ other[:, :, columns]
        matrices[:, rows, columns] -= total


def _mirror(matrices: Array) -> None:
    """Copy the blocks above the diagonal below it."""
    for part in _list_parts(matrices.shape[1], _BLOCK):
        matrices[:, part.stop :, part] = matrices[:, part, part.stop :].transpose(0, 2, 1)


@attrs.define(eq=False)
class Dissection:
    """The factors of the matrix of flows between the cells of a periodic grid.

    The domain is halved again and again, down to patches of some cells that share the nodes on their borders; nodes
    are centres of cells. Nodes inside patches are eliminated first, then those between two neighbours, up to the whole
    domain (George 1973, doi:10.1137/0710032).

    Attributes
    ----------
    shape
        Cells (nx, ny).
    cuts
        Borders of the patches along both axes; the last is the first of the next period.
    closed
        Whether the patches close around the domain, along each axis.
    matrices
        Of patches of each shape, (cells along x, along y), the matrices that join the nodes on their borders.
    places
        Position of each patch among those of its shape.
    steps
        What has been eliminated.
    """

    shape: tuple[int, int]
    cuts: list[IntArray]
    closed: list[bool] = attrs.Factory(lambda: [False, False])
    matrices: dict[tuple[int, int], Array] = attrs.Factory(dict)
    places: IntArray = attrs.Factory(lambda: np.zeros((0, 0), dtype=np.intp))
    steps: list[_Step] = attrs.Factory(list)
    _memory: list[Array] = attrs.Factory(lambda: [np.zeros(0), np.zeros(0)])

    def clear(self) -> dict[tuple[int, int], Array]:
        """Return the matrices, and make zero ones for the patches as they are now, in the memory of those before."""
        before = self.matrices
        counts = {sides: (i.size, len(_list_border(sides, self.closed))) for sides, i, _ in self.list_shapes()}
        total = sum(count * width**2 for count, width in counts.values())
        memory = self._memory.pop(0)
        memory = memory if memory.size >= total else np.empty(total)
        memory[:total] = 0.0
        self._memory.append(memory)
        self.matrices = {}
        start = 0
        for sides, (count, width) in counts.items():
            self.matrices[sides] = memory[start : start + count * width**2].reshape(count, width, width)
            start += count * width**2
        return before

    def solve(self, right: Array) -> Array:
        """Return the solution for two right sides, shape (cells, 2)."""
        values = right.copy()
        found = [step.go_down(values) for step in self.steps]
        for step in reversed(self.steps):
            step.go_up(values, found.pop())
        return values

    def list_shapes(self) -> Iterator[tuple[tuple[int, int], IntArray, IntArray]]:
        """Return each shape of patches with their numbers along both axes."""
        along, across = (np.diff(cuts) for cuts in self.cuts)
        for a, b in itertools.product(np.unique(along).tolist(), np.unique(across).tolist()):
            i, j = np.meshgrid(np.flatnonzero(along == a), np.flatnonzero(across == b), indexing="ij")
            yield (a, b), i.ravel(), j.ravel()

    def make_fronts(
        self, i: IntArray, j: IntArray, nodes: IntArray, border: Array
    ) -> Iterator[tuple[slice, _Front, tuple[IntArray, IntArray]]]:
        """Give zero matrices of some patches (i, j) at a time, with their first cells, and eliminate once they are set.

        Parameters
        ----------
        i, j
            Numbers of the patches along both axes.
        nodes
            Their nodes, those on the border last, from the first on, shape (nodes, 2).
        border
            Where the matrices of those on the border go, shape (patches, nodes, nodes).
        """
        width = border.shape[1]
        count = len(nodes) - width
        for part in _list_parts(i.size, max(1, _HELD_NUMBERS // max(len(nodes), 1) ** 2)):
            first = self.cuts[0][i[part]], self.cuts[1][j[part]]
            size = part.stop - part.start
            front = _Front(np.zeros((size, count, count)), np.zeros((size, count, width)), border[part])
            yield part, front, first
            parts = front.eliminate()
            if count:
                x, y = (start[:, np.newaxis] + nodes[:, axis] for axis, start in enumerate(first))
                cells = x % self.shape[0] * self.shape[1] + y % self.shape[1]
                self.steps.append(_Step(cells[:, :count], cells[:, count:], parts))


def dissect(leak: Array, conductances: tuple[Array, Array]) -> Dissection:
    """Return the factors of the matrix of the flows out of the cells of a periodic grid.

    Parameters
    ----------
    leak
        Flow out of each cell by its own pressure, beside that to its neighbours, shape (nx, ny).
    conductances
        Conductance from each cell to the next one along x, and along y, over the borders too, shape (nx, ny).

    Raises
    ------
    numpy.linalg.LinAlgError
        If rounding makes the matrix indefinite.
    """
    nx, ny = leak.shape
    made = Dissection((nx, ny), [_cut(nx), _cut(ny)])
    _start(made, leak, conductances)
    while not all(made.closed):
        # The shorter sides are joined first; a single patch meets itself.
        waiting = [axis for axis in (0, 1) if not made.closed[axis]]
        single = [axis for axis in waiting if made.cuts[axis].size == 2]
        if single:
            _close(made, single[0])
        else:
            _join(made, min(waiting, key=lambda axis: int(made.cuts[axis][1])))
    # What has been joined is no longer needed.
    made.matrices.clear()
    made._memory.clear()
    return made


def _cut(count: int) -> IntArray:
    """Return the borders of the smallest patches along an axis."""
    halvings = max(0, math.ceil(math.log2(count / _PATCH_SIDE)))
    return np.asarray((count * np.arange(2**halvings + 1)) >> halvings)


def _list_border(sides: tuple[int, int], closed: list[bool]) -> IntArray:
    """Return the nodes on the border of a patch of some cells, line by line, shape (nodes, 2)."""
    x, y = (np.arange(side + (not one)) for side, one in zip(sides, closed, strict=True))
    inner = x if closed[0] else x[1:-1]
    lines = [np.zeros((0, 2), dtype=np.intp)]
    lines += [] if closed[0] else [np.stack((np.full(y.size, at), y), axis=1) for at in (0, sides[0])]
    lines += [] if closed[1] else [np.stack((inner, np.full(inner.size, at)), axis=1) for at in (0, sides[1])]
    return np.concatenate(lines)


def _start(made: Dissection, leak: Array, conductances: tuple[Array, Array]) -> None:
    """Make the smallest patches, and eliminate the nodes inside."""
    made.places = np.zeros([cuts.size - 1 for cuts in made.cuts], dtype=np.intp)
    made.clear()
    for sides, i, j in made.list_shapes():
        made.places[i, j] = np.arange(i.size)
        x, y = np.indices([side + 1 for side in sides])
        border = _list_border(sides, made.closed)
        nodes, (order,) = _order(sides, [np.stack((x.ravel(), y.ravel()), axis=1)], border)
        spots = [[slice(one, one + 1) for one in line] for line in order.reshape(x.shape).tolist()]
        for _, front, first in made.make_fronts(i, j, nodes, made.matrices[sides]):
            for dx, dy in np.ndindex(*sides):
                one = spots[dx][dy]
                at = first[0] + dx, first[1] + dy
                front.choose(one, one)[:, 0, 0] += leak[at]
                for other, conductance in zip((spots[dx + 1][dy], spots[dx][dy + 1]), conductances, strict=True):
                    given = conductance[at][:, np.newaxis, np.newaxis]
                    for row, column in itertools.product((one, other), repeat=2):
                        front.choose(row, column)[:] += given if row == column else -given


def _join(made: Dissection, axis: int) -> None:
    """Join each two patches along an axis."""
    places = made.places
    lengths = np.diff(made.cuts[axis])
    made.cuts[axis] = made.cuts[axis][::2]
    matrices = made.clear()
    made.places = np.zeros([cuts.size - 1 for cuts in made.cuts], dtype=np.intp)
    for sides, i, j in made.list_shapes():
        border = _list_border(sides, made.closed)
        # Of an odd number of cells either half may be the longer one.
        halves = lengths[2 * (i, j)[axis]]
        done = 0
        for half in np.unique(halves).tolist():
            chosen = halves == half
            one = i[chosen]
            other = j[chosen]
            made.places[one, other] = done + np.arange(one.size)
            pair = [(length, sides[1]) if axis == 0 else (sides[0], length) for length in (half, sides[axis] - half)]
            parts = [_list_border(shape, made.closed) for shape in pair]
            parts[1][:, axis] += half
            nodes, orders = _order(sides, parts, border)
            spots = [places[(2 * one + k, other) if axis == 0 else (one, 2 * other + k)] for k in (0, 1)]
            for part, front, _ in made.make_fronts(one, other, nodes, made.matrices[sides][done : done + one.size]):
                for shape, spot, order in zip(pair, spots, orders, strict=True):
                    front.add(matrices[shape][spot[part]], order)
            done += one.size


def _close(made: Dissection, axis: int) -> None:
    """Join the two ends of patches that reach around the domain."""
    before = made.closed.copy()
    made.closed[axis] = True
    matrices = made.clear()
    for sides, i, j in made.list_shapes():
        joined = _list_border(sides, before)
        joined[:, axis] %= sides[axis]
        border = _list_border(sides, made.closed)
        nodes, (order,) = _order(sides, [joined], border)
        for part, front, _ in made.make_fronts(i, j, nodes, made.matrices[sides]):
            front.add(matrices[sides][part], order)


def _order(sides: tuple[int, int], parts: list[IntArray], border: IntArray) -> tuple[IntArray, list[IntArray]]:
    """Return the nodes of parts, those on the border last, and the places of the nodes of each part among them."""
    width = sides[1] + 1
    keys = [nodes[:, 0] * width + nodes[:, 1] for nodes in parts]
    last = border[:, 0] * width + border[:, 1]
    ordered = np.concatenate((np.setdiff1d(np.concatenate(keys), last), last))
    sorting = np.argsort(ordered)
    places = [sorting[np.searchsorted(ordered, key, sorter=sorting)] for key in keys]
    return np.stack(np.divmod(ordered, width), axis=1), places


def _list_runs(order: IntArray, count: int) -> list[tuple[slice, slice]]:
    """Return the slices of places that ascend by one, on one side of a number, and of where they stand."""
    breaks = np.flatnonzero((np.diff(order) != 1) | (order[1:] == count)) + 1
    starts = [0, *breaks.tolist(), order.size]
    pairs = itertools.pairwise(starts)
    return [(slice(int(order[one]), int(order[one]) + other - one), slice(one, other)) for one, other in pairs]
