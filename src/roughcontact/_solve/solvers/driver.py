"""The driver of solvers: one loop, in which a descent in float32 falls and around which float64 verifies it.

A solve starts on coarse grids (`climb`), descends in float32 and is verified in float64. What is solved, the pressure,
the gap or the shear, are values below, each a `Method`: a descent is one whose error is estimated; a problem is one
whose step is a whole descent and whose error is verified.
"""

from __future__ import annotations

import abc
import math
from collections.abc import Callable

import attrs
import numpy as np

from roughcontact._base.arrays import Array, RealArray
from roughcontact._solve.convolvers import InverseConvolution, PreparedConvolution
from roughcontact._solve.solution import ContactConditions, GridLevel, Status, Violation
from roughcontact._solve.solvers.base import Outcome, Step, Task


@attrs.define(eq=False)
class Log:
    """The errors of a solve, each reported as it is found, and whether iterations are left.

    Attributes
    ----------
    shape
        Cells of the grid.
    max_iterations
        Iterations after which the solve is given up.
    on_step
        Called with each error.
    errors
        The errors so far.
    """

    shape: tuple[int, int]
    max_iterations: float = math.inf
    on_step: Callable[[Step], None] | None = None
    errors: list[float] = attrs.Factory(list)

    def record(self, error: float, *, replaces: bool = False) -> None:
        """Record and report an error; it may replace the last one, which was an estimate."""
        if replaces and self.errors:
            self.errors.pop()
        self.errors.append(error)
        if self.on_step is not None:
            self.on_step(Step(self.shape, len(self.errors) - 1, error))

    @property
    def spent(self) -> Status | None:
        """The status of a solve without iterations left; None while there are some."""
        return None if len(self.errors) <= self.max_iterations else Status.MAXIMUM_ITERATIONS

    def outcome(self, pressure: Array, status: Status, work: float, levels: tuple[GridLevel, ...] = ()) -> Outcome:
        """Return the outcome of the solve, with the recorded errors, from its work in convolutions."""
        return Outcome(
            pressure=pressure,
            status=status,
            iterations=max(len(self.errors) - 1, 0),
            convolutions=round(work),
            errors=tuple(self.errors),
            levels=levels,
        )


@attrs.define(eq=False)
class Work:
    """The products of a solve on one grid, counted where they are made; see `GridLevel`."""

    double: int = 0
    single: int = 0
    inverse: float = 0.0

    def convolve(self, convolution: PreparedConvolution, pressure: RealArray) -> RealArray:
        """Return the displacement by a pressure."""
        self.single += pressure.dtype == np.float32
        self.double += pressure.dtype != np.float32
        return convolution.apply(pressure)

    def invert(self, inverse: InverseConvolution, displacement: RealArray) -> RealArray:
        """Return the pressure of a displacement."""
        self.inverse += 1
        return inverse.apply(displacement)

    def level(self, log: Log) -> GridLevel:
        """Return the work, with the iterations of a log."""
        return GridLevel(log.shape, max(len(log.errors) - 1, 0), self.double, self.single, math.ceil(self.inverse))


class Monitor(Log):
    """Measures the iterates of one solve, decides when it ends and records their errors.

    Parameters
    ----------
    task
        The task being solved.
    tolerance
        Error (see `Violation`) to be reached.
    max_iterations
        Iterations after which the solve is given up.
    """

    def __init__(self, task: Task, tolerance: float, max_iterations: int) -> None:
        super().__init__(task.initial_gap.shape, max_iterations, task.on_step)
        self._conditions = ContactConditions(task.initial_gap, task.pressure_limit, task.approach, task.rms)
        self.tolerance = tolerance

    def measure(self, pressure: Array, displacement: Array) -> Violation:
        """Return the violation by an iterate, without recording it."""
        return self._conditions.measure(pressure, displacement)

    def judge(self, pressure: Array, displacement: Array) -> tuple[Violation, Status | None]:
        """Return the violation by an iterate, and the status: None while the solver should continue."""
        violation = self.measure(pressure, displacement)
        self.record(violation.error)
        return violation, judge_error(*judged(violation), self.tolerance) or self.spent


def judged(violation: Violation) -> tuple[float, float]:
    """Return the error of a violation, not a number where the approach is not, and its floor."""
    return violation.error if math.isfinite(violation.approach) else math.nan, violation.floor


def judge_error(error: float, floor: float, tolerance: float) -> Status | None:
    """Return how a solve ends with an error, at least the floor by rounding; None while it should continue."""
    if not math.isfinite(error):
        return Status.NOT_FINITE
    if error > max(tolerance, floor):
        return None
    return Status.CONVERGED.within(floor, tolerance)


class Method(abc.ABC):
    """What `iterate` drives: an iterate whose error falls from step to step.

    Attributes
    ----------
    patience
        Errors in a row that are not below half of the lowest one before them at which it has stalled.
    verifies
        Whether its errors replace those before them, which were estimates.
    error, idle
        The last error, and the number of such errors in a row, which the driver sets.
    """

    patience: float = math.inf
    verifies: bool = False
    error: float = math.inf
    idle: int = 0

    @abc.abstractmethod
    def step(self) -> Status | None:
        """Make one step; return how the solve ends where there is none."""

    @abc.abstractmethod
    def measure(self) -> tuple[float, float]:
        """Return the error of the iterate, and the error by rounding."""


def iterate(method: Method, log: Log, goal: float, start: float | None = None) -> Status:
    """Make steps until the error is at most a goal, or does not fall further; return how that ended.

    Parameters
    ----------
    method
        What is iterated.
    log
        Records the errors.
    goal
        Error to be reached.
    start
        Error at the start, if it is known to be above the goal; None: it is measured.
    """
    method.error = lowest = math.inf if start is None else start
    method.idle = 0
    status = None if start is None else log.spent or method.step()
    while status is None:
        error, floor = method.measure()
        method.error = error
        log.record(error, replaces=method.verifies)
        method.idle = 0 if error < 0.5 * lowest else method.idle + 1
        lowest = min(lowest, error)
        stalled = Status.STALLED if method.idle >= method.patience else None
        status = judge_error(error, floor, goal) or log.spent or stalled or method.step()
    return status


class Refinement(Method):
    """A problem whose error is measured in float64, and lowered by descents in float32.

    Attributes
    ----------
    target
        The error aimed at: the tolerance, or what rounding allows.
    goal_fraction, gain
        Goal of the estimated error of a descent over the target, and its minimum over the error at the start, which is
        what float32 resolves.
    """

    target: float
    goal_fraction: float = 1.0
    gain: float = 0.0

    @abc.abstractmethod
    def descend(self, goal: float) -> Status | None:
        """Lower the estimated error in float32 to a goal, if possible; return how the solve ends if it does there."""

    def step(self) -> Status | None:
        """Make one descent; see `Method.step`."""
        return self.descend(max(self.goal_fraction * self.target, self.gain * self.error))
