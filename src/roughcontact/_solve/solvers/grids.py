"""Nested grids: a problem starts from the next coarser grid, on which it starts from the next one."""

from __future__ import annotations

import abc
from typing import Any, Generic, Self, TypeVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, RealArray
from roughcontact._base.machine import map_tiles, tiles_of
from roughcontact._parts.grid import Grid, grid_shape
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import GridLevel
from roughcontact._solve.solvers.base import Task
from roughcontact.errors.door import guarded

Values = TypeVar("Values", RealArray, Mask)

# Minimum cells along a halved axis.
_MIN_COARSE_CELLS = 32
# Minimum cells of a grid that starts on a coarser one: 64 x 64 cells take a tenth less time without.
_MIN_HALVED_CELLS = 2**13


@attrs.frozen(eq=False, kw_only=True)
class Guess:
    """A field to start from on one grid, and the work on coarser ones.

    Attributes
    ----------
    products
        Cost in convolutions on the grid of the field.
    levels
        The work on each coarser grid.
    """

    products: float = 0.0
    levels: tuple[GridLevel, ...] = ()

    def after(self, level: GridLevel, **changes: Any) -> Self:
        """Return a guess after further work on its grid."""
        products = self.products + level.double + level.single + level.inverse
        return attrs.evolve(self, products=products, levels=(*self.levels, level), **changes)


Found = TypeVar("Found", bound=Guess)


@attrs.frozen(eq=False)
class GridProblem(abc.ABC, Generic[Found]):
    """A problem on one grid, which can be started on coarser ones."""

    convolution: PreparedConvolution
    task: Task

    def coarser(self) -> Self | None:
        """Return the problem on the next coarser grid; None if there is none."""
        half = coarsen(self.convolution.setup.grid, self.task)
        return None if half is None else attrs.evolve(self, convolution=self.convolution.on(half[0]), task=half[1])

    @abc.abstractmethod
    def begin(self) -> Found:
        """Return a start without coarser grids."""

    @abc.abstractmethod
    def improve(self, guess: Found) -> Found:
        """Return a guess after a few iterations."""

    @abc.abstractmethod
    def refine(self, coarse: Self, guess: Found, fx: int, fy: int) -> Found:
        """Return a guess from that on the coarser grid, whose cells have fx x fy ones here."""


def climb(problem: GridProblem[Found]) -> Found:
    """Return the start of a problem from the next coarser grid, itself found so."""
    coarse = problem.coarser()
    if coarse is None:
        return problem.begin()
    guess = coarse.improve(climb(coarse))
    fx, fy = (n // m for n, m in zip(problem.task.initial_gap.shape, coarse.task.initial_gap.shape, strict=True))
    return problem.refine(coarse, attrs.evolve(guess, products=guess.products / (fx * fy)), fx, fy)


@guarded
def halve_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return the cells of the next coarser grid: even axes of at least 64 cells are halved.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rc.solving.halve_shape((128, 45))
    (64, 45)
    """
    nx, ny = (n // 2 if n % 2 == 0 and n // 2 >= _MIN_COARSE_CELLS else n for n in grid_shape(shape))
    return nx, ny


def coarser_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return the cells of the grid on which a solve starts: `halve_shape`, or the shape itself of a small grid."""
    return halve_shape(shape) if shape[0] * shape[1] >= _MIN_HALVED_CELLS else shape


def coarsen(grid: Grid, task: Task) -> tuple[Grid, Task] | None:
    """Return the grid with all even and long axes halved, and its task; None if there is none, or the grid is small."""
    shape = coarser_shape(grid.shape)
    if shape == grid.shape:
        return None
    gap, limit = (_average(values, shape) for values in (task.initial_gap, task.pressure_limit))
    interaction = None if task.interaction is None else task.interaction.convert(lambda values: _average(values, shape))
    return Grid(shape, grid.size), attrs.evolve(task, initial_gap=gap, pressure_limit=limit, interaction=interaction)


def repeat_cells(values: Values, fx: int, fy: int) -> Values:
    """Return the values on the grid with fx x fy cells for each."""
    return np.repeat(np.repeat(values, fy, axis=1), fx, axis=0)


def _average(values: Array, shape: tuple[int, int]) -> Array:
    """Return the means of fine cells on a grid of `shape`, with one or both axes halved; one entry stays."""
    if values.size == 1:
        return values
    cells = values.size
    if values.shape[0] > shape[0]:
        values = values[0::2] + values[1::2]
    if values.shape[1] > shape[1]:
        values = values[:, 0::2] + values[:, 1::2]
    return values / (cells // values.size)


def interpolate(values: RealArray, fx: int, fy: int) -> RealArray:
    """Interpolate by parabolas through three cell centres along the axes that were halved; the values repeat."""
    # The second axis, whose steps are not contiguous, comes first, while there are fewer rows.
    if fy == 2:
        coarse = values
        fine = np.empty((values.shape[0], 2 * values.shape[1]), dtype=values.dtype, like=values)

        def double_rows(rows: slice) -> None:
            own = coarse[rows]
            target = fine[rows]
            low, high = _double(own, np.roll(own, 1, axis=1), np.roll(own, -1, axis=1))
            target[:, 0::2] = low
            target[:, 1::2] = high

        map_tiles(double_rows, tiles_of(coarse))
        values = fine
    if fx == 2:
        rough = values
        smooth = np.empty((2 * values.shape[0], values.shape[1]), dtype=values.dtype, like=values)

        def double_columns(rows: slice) -> None:
            low, high = _double(rough[rows], _move_rows(rough, rows, 1), _move_rows(rough, rows, -1))
            target = smooth[2 * rows.start : 2 * rows.stop]
            target[0::2] = low
            target[1::2] = high

        map_tiles(double_columns, tiles_of(rough))
        values = smooth
    return values


def _move_rows(values: RealArray, rows: slice, step: int) -> RealArray:
    """Return a copy of the rows that are some steps before a tile of rows; the first follows the last."""
    if rows.stop - rows.start == values.shape[0]:
        return np.roll(values, step, axis=0)
    return values.take(np.arange(rows.start, rows.stop) - step, axis=0, mode="wrap")


def _double(coarse: RealArray, before: RealArray, after: RealArray) -> tuple[RealArray, RealArray]:
    """Interpolate a quarter of a coarse cell to both sides of its centre, in the place of the values before it."""
    rise = before - after
    rise *= 0.125
    mean = before
    mean += after
    mean *= 0.03125
    mean += 0.9375 * coarse
    low = mean + rise
    mean -= rise
    return low, mean
