"""The rows of one process with rows beside them, on which the answers of one machine are computed."""

from __future__ import annotations

import itertools
from typing import Any, ClassVar, TypeVar, cast

import attrs
import numpy as np
import roughcontact as rc
import scipy.fft
from roughcontact.slabs import SlabArray
from roughcontact.solving import LinearSolution, Whole, solve_on_cells
from roughcontact.typing import Array, IntArray, Mask, PreparedConvolution, RealArray

from roughcontact_mpi.processes import Processes

T = TypeVar("T")

# Rows beside those of a process, on either side: as many as a small patch has cells, and what a spline through the
# heights forgets of its border to rounding, 0.43^45 (the larger pole of a quintic one).
BESIDE = 48
# An odd factor that spreads the bits of keys.
_SPREAD = np.uint64(0x9E3779B97F4A7C15)


@attrs.frozen(eq=False)
class SlabTangent:
    """The kernel of a contact on slabs, restricted to its cells below the pressure limit.

    Attributes
    ----------
    solution
        The contact, on the window of this process.
    """

    solution: Any

    @property
    def cells(self) -> Mask:
        """The cells of the window that it is restricted to."""
        return np.asarray(self.solution.contact & ~self.solution.saturated)

    @property
    def is_rigid(self) -> bool:
        """Whether all cells of a periodic domain are in contact, so that uniform pressure displaces nothing."""
        part = self.solution.parts
        touching = part.total(int(np.count_nonzero(self.cells[part.inside])))
        return self.solution.boundary is rc.Boundary.PERIODIC and touching == self.solution.grid.cells

    def solve(self, right: Array, tolerance: float) -> LinearSolution:
        """Return the solution for a right side on the window, m; its values are on the window too."""
        part = self.solution.parts
        cells, own = (
            SlabArray.field(field[part.inside].copy(), part.processes, part.shape[0]) for field in (self.cells, right)
        )
        convolution = part.convolution
        answer = solve_on_cells(
            convolution,
            convolution.inverse(np.float32),
            cast(Any, cells),
            cast(Any, own),
            tolerance,
            unit=self.solution.grid.spacing[0] / self.solution.modulus,
            rigid=False,
        )
        answer.require(tolerance, self.solution)
        return attrs.evolve(answer, values=part.read(cast(Any, answer.values)))


class Part(Whole):
    """What a process has of a contact: its own rows, and rows beside them.

    Parameters
    ----------
    processes
        The processes.
    shape
        Cells of the domain.
    boundary
        What lies beyond its border.
    convolution
        The convolution that solved the contact.

    Attributes
    ----------
    found
        The patches of the contact.
    """

    is_whole: ClassVar[bool] = False
    found: Any = None

    def __init__(
        self,
        processes: Processes,
        shape: tuple[int, int],
        boundary: rc.Boundary,
        convolution: PreparedConvolution,
    ) -> None:
        self.processes = processes
        self.convolution = convolution
        self.shape = shape
        self.free = boundary.free_axes[0]
        self.bounds = processes.rows(shape[0])
        self.start = self.bounds[processes.rank]
        self.stop = self.bounds[processes.rank + 1]
        # The rows before and behind those of each process.
        self._beside = [_list_beside(*ends, shape[0], free=self.free) for ends in itertools.pairwise(self.bounds)]
        before, behind = self._beside[processes.rank]
        self.window = np.array([*before, *range(self.start, self.stop), *behind], dtype=np.intp)
        self.inside = slice(len(before), len(before) + self.stop - self.start)

    def read(self, field: SlabArray) -> RealArray:
        """Return the rows of the window of a field."""
        own = np.ascontiguousarray(field.part)
        beside = self.processes.fetch_rows(own, self.bounds, [[*before, *behind] for before, behind in self._beside])
        return np.concatenate((beside[: self.inside.start], own, beside[self.inside.start :]))

    def patches(self, solution: Any) -> Any:
        """Return the patches of the contact."""
        return self.found

    def sum(self, field: Array) -> float:
        """Return the sum of a field over all cells; all processes must ask."""
        return self.total(float(field[self.inside].sum()))

    def total(self, values: T) -> T:
        """Return the sum over all processes of a number or an array of the same shape on each."""
        given: Any = values
        if np.ndim(given):
            found: Any = self.processes.total_blocks(np.ascontiguousarray(given))
            return found
        return self.processes.total(given).item()

    def highest(self, values: T) -> T:
        """Return the maximum over all processes; see `total`."""
        return self._extreme(values, "MAX")

    def lowest(self, values: T) -> T:
        """Return the minimum over all processes; see `total`."""
        return self._extreme(values, "MIN")

    def _extreme(self, values: Any, name: str) -> Any:
        from mpi4py import MPI

        own = np.ascontiguousarray(values)
        found = np.empty_like(own)
        self.processes.reductions += 1
        self.processes.communicator.Allreduce(own, found, getattr(MPI, name))
        return found if np.ndim(values) else found.item()

    def mean(self, values: Array) -> float:
        """Return the mean of a list of which each process has some."""
        found, count = self.processes.total(np.array([np.sum(values), values.size], dtype=np.float64))
        return float(found / count)

    def join(self, values: RealArray) -> RealArray:
        """Return the columns of all processes one after the other, of an array of shape (m, n)."""
        return np.stack([self.processes.gather(np.ascontiguousarray(row)) for row in values])

    def own(self, field: RealArray) -> RealArray:
        """Return a field of the window that is zero on the rows of other processes."""
        found = np.zeros_like(field)
        found[self.inside] = field[self.inside]
        return found

    def own_rows(self, rows: IntArray) -> Mask:
        """Return which rows of the window are of this process; the first row stands for negative ones."""
        rows = np.maximum(rows, 0)
        return np.asarray((rows >= self.inside.start) & (rows < self.inside.stop))

    def rows(self, rows: IntArray) -> IntArray:
        """Return the rows in the domain of rows of the window."""
        return np.asarray(self.window[rows])

    def find(self, cells: IntArray) -> tuple[Mask, IntArray]:
        """Return which cells of the domain, flat indices, are of this process, and their flat indices in the window."""
        first, last = (bound * self.shape[1] for bound in (self.start, self.stop))
        mine = (cells >= first) & (cells < last)
        return mine, cells[mine] - first + self.inside.start * self.shape[1]

    def tangent(self, solution: Any) -> Any:
        """Return the linear answer on slabs of the solution that the window was opened on."""
        return SlabTangent(solution)

    def sample(self, cells: IntArray, count: int) -> IntArray:
        """Return every n-th of the cells, so that about `count` remain on all processes together."""
        counts = self.processes.collect(cells.size)
        step = max(1, int(counts.sum()) // count)
        return cells[-int(counts[: self.processes.rank].sum()) % step :: step]

    def lines(self, field: RealArray, axis: int) -> RealArray:
        """Return the own lines of a field of the window along y (axis 0), or along x (axis 1), shape (lines, cells)."""
        own = field[self.inside]
        if axis == 0 or self.processes.count == 1:
            return own if axis == 0 else np.ascontiguousarray(own.T)
        bounds = self.processes.columns(self.shape[1])
        mine = bounds[self.processes.rank + 1] - bounds[self.processes.rank]
        widths = np.diff(bounds).tolist()
        heights = np.diff(self.bounds).tolist()
        packed = np.concatenate([own[:, low:high].ravel() for low, high in itertools.pairwise(bounds)])
        counts = [own.shape[0] * width for width in widths]
        found = self.processes.exchange(packed, counts, [height * mine for height in heights])
        return np.ascontiguousarray(found.reshape(self.shape[0], mine).T)

    def count_equal(self, keys: Array) -> IntArray:
        """Return how many keys of all processes are equal to each of a list."""
        there, order, counts, expected = self._send_by_value(keys)
        back = self.processes.exchange(super().count_equal(there), expected, counts)
        equal = np.empty(keys.size, dtype=np.intp)
        equal[order] = back
        return equal

    def count_distinct(self, values: Array) -> int:
        """Return the number of different values in the lists of all processes."""
        return self.total(super().count_distinct(self._send_by_value(values)[0]))

    def _send_by_value(self, values: Array) -> tuple[Array, IntArray, list[int], list[int]]:
        """Return values, equal ones on one process, with the order and the numbers in which these were sent."""
        # Zero has two signs.
        bits = (values + 0.0).view(np.uint64) * _SPREAD
        target = (bits >> np.uint64(33)) % np.uint64(self.processes.count)
        order = np.argsort(target, kind="stable")
        counts = np.bincount(target.astype(np.intp), minlength=self.processes.count)
        expected = self.processes.collect(counts)[:, self.processes.rank].tolist()
        return self.processes.exchange(values[order], counts.tolist(), expected), order, counts.tolist(), expected

    def evaluating(self, spline: Any) -> Any:
        """Return the spline of the window as one of the whole domain, which all processes evaluate together."""
        return _SharedSpline(spline, self)


@attrs.frozen(eq=False)
class _SharedSpline:
    """A spline of which each process evaluates the points on its own rows."""

    window: Any
    part: Part

    def derivatives(self, i: Array, j: Array, *degrees: int) -> Array:
        """Return derivatives at points of the domain, the same on all processes; see the spline of one machine."""
        count = self.part.shape[0]
        first = np.floor(i).astype(np.intp)
        row = np.clip(first, 0, count - 1) if self.part.free else first % count
        mine = (row >= self.part.start) & (row < self.part.stop)
        # A periodic spline repeats, a free one goes on beyond the border.
        place = i[mine] if self.part.free else i[mine] + (row - first)[mine]
        found = np.zeros((sum(degree + 1 for degree in degrees), *i.shape))
        found[:, mine] = self.window.derivatives(place + (self.part.inside.start - self.part.start), j[mine], *degrees)
        return self.part.total(found)


def _list_beside(start: int, stop: int, count: int, *, free: bool) -> tuple[list[int], list[int]]:
    """Return the rows before and behind those of a process in its window."""
    if free:
        return list(range(max(start - BESIDE, 0), start)), list(range(stop, min(stop + BESIDE, count)))
    # A few more, so that the window is fast to transform.
    rows = scipy.fft.next_fast_len(stop - start + 2 * BESIDE, real=True)
    before = [row % count for row in range(start - BESIDE, start)]
    return before, [row % count for row in range(stop, start - BESIDE + rows)]
