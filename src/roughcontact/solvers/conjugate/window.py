"""The part of a free domain that can touch.

Pressure pushes every other cell away: with K and p not negative the gap is at least h - approach, so
that the contact lies where the undeformed gap h is below the approach, and nothing else has to be
solved for.
"""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array, IntArray
from roughcontact.convolvers import PlannedConvolution
from roughcontact.grid import Boundary, Grid
from roughcontact.solvers.base import Task

# Room for what the estimate of the approach misses.
_MARGIN = 1.02
# Sides are rounded up to this many cells, so that they can be halved.
_ROUND = 32
# A window that takes more of the domain than this saves nothing.
_WORTH = 0.7


@attrs.frozen(eq=False)
class Window:
    """A rectangle of cells.

    Attributes
    ----------
    rows, columns
        Its cells along x and along y.
    """

    rows: slice
    columns: slice

    def cut(self, values: Array) -> Array:
        """Return the part of a field inside the window."""
        return np.ascontiguousarray(values[self.rows, self.columns])

    def pasted(self, values: Array, shape: tuple[int, int]) -> Array:
        """Return a field of the grid's shape that is zero outside the window."""
        field = np.zeros(shape)
        field[self.rows, self.columns] = values
        return field

    def task(self, task: Task) -> Task:
        """Return the same task for the cells inside: the same load, the same limit, the same start."""
        inside = self.cut(task.undeformed)
        mean = task.mean_pressure
        return attrs.evolve(
            task,
            undeformed=inside,
            mean_pressure=None if mean is None else mean * (task.undeformed.size / inside.size),
            limit=task.limit if isinstance(task.limit, float) else self.cut(task.limit),
            start=None if task.start is None else self.cut(task.start),
        )

    def planned(self, convolution: PlannedConvolution) -> PlannedConvolution:
        """Return the convolution of the window's cells with each other."""
        (dx, dy), shape = convolution.scene.grid.spacing, (_length(self.rows), _length(self.columns))
        return convolution.on(Grid(shape, (shape[0] * dx, shape[1] * dy)))

    def holds(self, undeformed: Array, approach: float) -> bool:
        """Tell whether no cell outside can touch at this approach."""
        touching = undeformed < approach
        inside = np.count_nonzero(touching[self.rows, self.columns])
        return bool(np.count_nonzero(touching) == inside)


def window_for(convolution: PlannedConvolution, task: Task, approach: float) -> Window | None:
    """Return the window of the cells that can touch at about this approach; None if it is no use."""
    if convolution.scene.boundary is not Boundary.FREE:
        return None
    touching = task.undeformed <= _MARGIN * approach
    if not touching.any():
        return None
    rows, columns = (_extent(np.flatnonzero(touching.any(axis=axis)), touching.shape[1 - axis]) for axis in (1, 0))
    if _length(rows) * _length(columns) > _WORTH * task.undeformed.size:
        return None
    window = Window(rows, columns)
    mean = task.mean_pressure
    bearable = mean is None or mean * task.undeformed.size <= np.sum(
        np.broadcast_to(task.limit, touching.shape)[rows, columns]
    )
    return window if bearable else None


def _extent(marked: IntArray, count: int) -> slice:
    """Return the range of the marked of `count` cells, a little longer."""
    first, last = int(marked[0]), int(marked[-1]) + 1
    length = min(-(-(last - first + 2) // _ROUND) * _ROUND, count)
    start = min(max(first - (length - (last - first)) // 2, 0), count - length)
    return slice(start, start + length)


def _length(cells: slice) -> int:
    return int(cells.stop - cells.start)
