"""The solver interface: a dimensionless task in, a pressure out."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable
from typing import ClassVar

import attrs
import numpy as np

from roughcontact.checks import Array, integer, number
from roughcontact.convolvers import PlannedConvolution
from roughcontact.optimality import Conditions, Optimality
from roughcontact.solution import Level, Status


@attrs.frozen
class Step:
    """How far a solver has come.

    Attributes
    ----------
    shape
        Cells of the grid it is working on.
    iteration
        Iterations on that grid so far.
    error
        Error (see `Optimality`), estimated or proved.
    """

    shape: tuple[int, int]
    iteration: int
    error: float


@attrs.frozen(eq=False, kw_only=True)
class Task:
    """A contact problem in dimensionless variables.

    Attributes
    ----------
    undeformed
        Undeformed gap, shape (nx, ny), at least zero; its maximum, the relief, is one.
    mean_pressure
        Mean pressure to be carried, above zero and at most the mean of `limit`; None if the approach
        is given instead.
    approach
        Approach since first touch, above zero; None if the mean pressure is given.
    limit
        Greatest pressure, a number or an array of shape (nx, ny); `inf` where there is none.
    start
        A pressure to start from, shape (nx, ny), within the bounds; None if there is none.
    on_step
        Called after each iteration, on coarse grids too.
    """

    undeformed: Array
    mean_pressure: float | None = None
    approach: float | None = None
    limit: float | Array = math.inf
    start: Array | None = None
    on_step: Callable[[Step], None] | None = None


@attrs.frozen(eq=False, kw_only=True)
class Outcome:
    """What a solver returns.

    Attributes
    ----------
    pressure
        Pressure, shape (nx, ny), between zero and the limit.
    status
        How it ended.
    iterations, convolutions
        What it took.
    history
        The error (see `Optimality`) at the start of each iteration.
    levels
        The work on each grid, from coarse to fine; may be left out.
    """

    pressure: Array
    status: Status
    iterations: int
    convolutions: int
    history: tuple[float, ...]
    levels: tuple[Level, ...] = ()


class Solver(abc.ABC):
    """A way to find the pressure. It knows a planned convolution, never a kernel."""

    leaves_out: ClassVar[tuple[str, ...]] = ()
    """What it leaves out of a solve and why, for ``explain()``."""

    @property
    @abc.abstractmethod
    def tolerance(self) -> float:
        """The error (see `Optimality`) at which the solver calls a pressure converged."""

    @abc.abstractmethod
    def solve(self, convolution: PlannedConvolution, task: Task) -> Outcome:
        """Return the pressure that carries the load.

        Raises
        ------
        InputError
            If this solver cannot treat such a task.
        """


class Monitor:
    """Judges the iterates of one solve and remembers their errors.

    Parameters
    ----------
    task
        What is being solved.
    tolerance, max_iterations
        When to stop.
    """

    def __init__(self, task: Task, tolerance: float, max_iterations: int) -> None:
        self._conditions = Conditions(task.undeformed, task.limit, task.approach)
        self.tolerance = tolerance
        self._max_iterations = max_iterations
        self._task = task
        self.history: list[float] = []

    def judge(self, pressure: Array, displacement: Array) -> tuple[Optimality, Status | None]:
        """Measure an iterate; the status is None as long as the solver should go on."""
        state = self._conditions.measure(pressure, displacement)
        self.note(state.error)
        return state, self._status(state)

    def prove(self, pressure: Array, displacement: Array) -> tuple[Optimality, Status | None]:
        """Measure an iterate whose error has been noted as an estimate; see `judge`."""
        if self.history:
            self.history.pop()
        return self.judge(pressure, displacement)

    def note(self, error: float) -> None:
        """Remember the error after an iteration, and tell those who watch."""
        self.history.append(error)
        if self._task.on_step is not None:
            self._task.on_step(Step(self._task.undeformed.shape, len(self.history) - 1, error))

    def goes_on(self) -> bool:
        """Tell whether there are iterations left."""
        return len(self.history) <= self._max_iterations

    def _status(self, state: Optimality) -> Status | None:
        if not (math.isfinite(state.error) and math.isfinite(state.approach)):
            return Status.NOT_FINITE
        if state.error <= self.tolerance:
            return Status.CONVERGED
        if state.error <= state.floor:
            return Status.CONVERGED_TO_ROUNDING if state.resolved else Status.UNRESOLVED
        if not self.goes_on():
            return Status.MAXIMUM_ITERATIONS
        return None

    def outcome(self, pressure: Array, status: Status, convolutions: int) -> Outcome:
        """Return the outcome of the solve."""
        return Outcome(
            pressure=pressure,
            status=status,
            iterations=len(self.history) - 1,
            convolutions=convolutions,
            history=tuple(self.history),
        )


def starting_pressure(task: Task) -> Array:
    """Return the task's own start, or else its mean pressure everywhere, within the limit; none for an approach."""
    if task.start is not None:
        return task.start
    mean = 0.0 if task.mean_pressure is None else task.mean_pressure
    return np.asarray(np.minimum(np.full(task.undeformed.shape, mean), task.limit))


def positive_tolerance(value: float) -> float:
    """Check a tolerance."""
    return number(value, "The tolerance of the solver", above=0.0)


def iteration_limit(value: int) -> int:
    """Check a maximum number of iterations."""
    return integer(value, "The maximum number of iterations", at_least=1)
