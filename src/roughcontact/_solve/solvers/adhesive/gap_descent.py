"""The solver of adhesive contacts, from the top."""

from __future__ import annotations

import math
from typing import ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import GridLevel, Status
from roughcontact._solve.solvers.adhesive.descent import AdhesiveDescent
from roughcontact._solve.solvers.adhesive.nested_start import (
    GapGuess,
    gap_scale,
    hold_mean,
    nested_start,
    start_from_task,
)
from roughcontact._solve.solvers.base import (
    DEFAULT_TOLERANCE,
    Outcome,
    Solver,
    Step,
    Task,
    iteration_limit,
    positive_tolerance,
)

# Fraction of the tolerance at which a descent ends, so that its verification in float64 meets it.
_MARGIN = 0.7
# Error, over the scale, that a descent in float32 may reach.
_SINGLE = 2e-6
# Verifications that may pass without the error being halved, and iterations of a descent.
_STALLED = 4
_IDLE = 400
# Iterations in a row without a contact, pulled apart by the load, after which the surfaces count as separated.
_APART = 6


@attrs.frozen
class GapDescent(Solver):
    """Conjugate gradients on the gap, preconditioned by the stiffness, for surfaces that attract each other.

    Load, also zero or tensile, or approach, with or without a pressure limit, on any boundary. The descent runs in
    float32, its result is verified in float64. Which of several states of equilibrium it finds depends on the start:
    by default the contact without adhesion, from which attraction closes gaps.

    Parameters
    ----------
    tolerance
        Error of the gap, over the smaller of the standard deviation of the initial gap and the range of the
        displacement.
    max_iterations
        Iterations on the finest grid after which the solve is given up.

    Examples
    --------
    """

    adhesive: ClassVar[bool] = True
    omitted: ClassVar[tuple[str, ...]] = (
        "float64 inside the iterations: float32 is enough, and every result is verified in float64",
    )

    tolerance: float = attrs.field(converter=positive_tolerance, default=DEFAULT_TOLERANCE)
    max_iterations: int = attrs.field(converter=iteration_limit, default=3000)

    def solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        """Return the pressure and the tension; see `Solver.solve`."""
        given = task.start is not None or task.start_gap is not None
        guess = start_from_task(convolution, task) if given else nested_start(convolution, task)
        return _Run(guess, task, self.tolerance, self.max_iterations).solve()


class _Run:
    """One solve on the finest grid."""

    def __init__(self, guess: GapGuess, task: Task, tolerance: float, max_iterations: int) -> None:
        self._guess = guess
        self._problem = guess.problem
        self._task = task
        self._tolerance = tolerance
        self._left = max_iterations
        self._errors: list[float] = []
        self._products = 0
        self._verifications = 0
        self._apart = 0

    def solve(self) -> Outcome:
        gap = self._guess.gap
        dtype: type = np.float32
        best = math.inf
        idle = 0
        descent = self._begin(gap, dtype)
        pressure = None
        while True:
            scale = gap_scale(self._task, gap, self._problem)
            status = self._descend(descent, scale)
            gap = hold_mean(self._problem, self._task, descent.gap.astype(np.float64))
            if status is not None:
                break
            pressure = self._pressure_of(gap)
            descent.set_state(gap, pressure)
            error = descent.measure() / scale
            self._record(error)
            if error <= self._tolerance:
                status = Status.CONVERGED
                break
            idle = 0 if error < 0.5 * best else idle + 1
            best = min(best, error)
            if idle > _STALLED:
                if dtype is np.float64:
                    status = Status.STALLED
                    break
            if idle and dtype is np.float32:
                self._products += descent.products
                dtype = np.float64
                descent = self._begin(gap, dtype)
                idle = 0
        self._products += descent.products
        return self._outcome(gap, descent, status)

    def _begin(self, gap: Array, dtype: type) -> AdhesiveDescent:
        descent = AdhesiveDescent(self._problem, dtype)
        descent.start(gap)
        return descent

    def _pressure_of(self, gap: Array) -> Array:
        self._verifications += 1
        problem = self._problem
        displacement = gap - problem.closing
        pressure = problem.stiffness.inverse.multiply(
            displacement, problem.stiffness.inverse.stiffness, problem.stiffness.extended
        )
        pressure += problem.base + problem.mean_stiffness * float(displacement.mean())
        return pressure

    def _record(self, error: float) -> None:
        self._errors.append(error)
        if self._task.on_step is not None:
            self._task.on_step(Step(self._task.initial_gap.shape, len(self._errors) - 1, error))

    def _descend(self, descent: AdhesiveDescent, scale: float) -> Status | None:
        """Iterate until the error is below the tolerance, or cannot be lowered: None, or how the solve ended."""
        goal = _MARGIN * self._tolerance
        if descent.dtype is np.float32:
            goal = max(goal, _SINGLE)
        best = math.inf
        idle = 0
        while True:
            error = descent.measure() / scale
            self._record(error)
            if not math.isfinite(error):
                return Status.NOT_FINITE
            if error <= goal:
                return None
            if self._left == 0:
                return Status.MAXIMUM_ITERATIONS
            self._left -= 1
            idle = 0 if error < 0.5 * best else idle + 1
            best = min(best, error)
            if idle > _IDLE or not descent.advance(error * scale):
                return None
            self._apart = self._apart + 1 if descent.is_apart() else 0
            if self._apart >= _APART and self._task.mean_pressure is not None:
                return Status.SEPARATED

    def _outcome(self, gap: Array, descent: AdhesiveDescent, status: Status) -> Outcome:
        inside = self._problem.stiffness.inner(gap)
        task = self._task
        shape = task.initial_gap.shape
        interaction = task.interaction
        opened = np.maximum(inside, 0.0)
        tension = np.zeros(shape) if interaction is None else interaction.tension(opened)
        if status is Status.SEPARATED:
            pressure = np.zeros(shape)
            tension = np.zeros(shape)
        else:
            full = self._pressure_of(gap)
            pressure = self._problem.stiffness.inner(full) - descent.multiplier
            pressure = self._bound(pressure, tension, inside)
        products = self._guess.products + self._products + self._verifications
        level = GridLevel(shape, len(self._errors), self._verifications, 0, self._products)
        return Outcome(
            pressure=pressure,
            tension=tension,
            status=status,
            iterations=max(len(self._errors) - 1, 0),
            convolutions=round(products),
            errors=tuple(self._errors),
            levels=(*self._guess.levels, level),
        )

    def _bound(self, pressure: Array, tension: Array, gap: Array) -> Array:
        """Return the pressure that leaves open cells to the tension, within the limit, and of the load if it is given."""
        task = self._task
        limit = np.broadcast_to(task.pressure_limit, pressure.shape)
        closed = gap <= 0.0
        contact = np.where(closed, np.maximum(pressure + tension, 0.0), 0.0)
        saturated = closed & ((gap < 0.0) | (contact >= limit + tension))
        bounded = np.where(saturated, limit, contact - tension)
        if task.mean_pressure is None:
            return bounded
        elastic = closed & ~saturated
        carried = float(contact[elastic].sum())
        needed = task.mean_pressure * pressure.size - float(np.where(saturated, limit, -tension).sum())
        if carried > 0.0 and needed > 0.0:
            bounded[elastic] = np.minimum(contact[elastic] * (needed / carried) - tension[elastic], limit[elastic])
        return bounded
