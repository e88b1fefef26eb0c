"""The solver of adhesive contacts, from the top."""

from __future__ import annotations

import math
from typing import ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Boundary
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import GridLevel, Status
from roughcontact._solve.solution.attraction import AdhesiveConditions, AdhesiveViolation
from roughcontact._solve.solvers.adhesive.descent import AdhesiveDescent
from roughcontact._solve.solvers.adhesive.gap_problem import gap_scale, hold_mean
from roughcontact._solve.solvers.adhesive.nested_start import nested_start, start_from_task
from roughcontact._solve.solvers.base import (
    DEFAULT_TOLERANCE,
    IdleCount,
    Outcome,
    Solver,
    Task,
    iteration_limit,
    judge_error,
    positive_tolerance,
    record_error,
)
from roughcontact._solve.solvers.conjugate import ProjectedConjugateGradient

# Error of the gap, over the scale, below which no step leaps to another state.
_NEAR = 1e-2
# Fraction of the tolerance at which a descent ends, so that its verification in float64 meets it.
_MARGIN = 0.7
# Error, over the scale, that a descent in float32 may reach.
_SINGLE = 2e-6
# Iterations of a descent that may pass without the error being halved.
_IDLE = 400
# ... and of one in float32 whose error has fallen below the second number: rounding keeps it from falling further.
_IDLE_SINGLE = 15
_ROUNDED = 1e-3
# Iterations in a row without a contact, pulled apart by the load, after which the surfaces count as separated.
_APART = 6
# Peak memory of a solve in float64 arrays of the grid, by the number of free axes: measured at 1024 x 1024 cells
# (docs/studies/memory.py).
_MEMORY_ARRAYS = (21.5, 29.0, 51.0)


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

    References
    ----------
    Rey, Anciaux, Molinari, Comput. Mech. 60 (2017) 69-81, https://doi.org/10.1007/s00466-017-1392-5

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.ParaboloidSurface(radius=1e-6), rc.Elastic(young=10e6, poisson=0.5))
    >>> law = rc.Exponential(work="50mJ/m2", range="60nm")
    >>> solver = rc.GapDescent(tolerance=1e-6)
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((48, 48), 2e-6), adhesion=law, solver=solver)
    >>> problem.solve(force=0.0).residuals.error < 1e-6
    True
    """

    adhesive: ClassVar[bool] = True
    climbs_grids: ClassVar[bool] = True
    omitted: ClassVar[tuple[str, ...]] = (
        "double precision inside the iterations: single is enough, and every result is verified in double",
    )

    tolerance: float = attrs.field(converter=positive_tolerance, default=DEFAULT_TOLERANCE)
    max_iterations: int = attrs.field(converter=iteration_limit, default=3000)

    def memory_arrays(self, boundary: Boundary) -> float:
        """Return the peak memory of a solve in float64 arrays of the grid, which does not depend on the contact."""
        return _MEMORY_ARRAYS[sum(boundary.free_axes)]

    def solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        """Return the pressure and the tension; see `Solver.solve`."""
        if task.interaction is None:
            return ProjectedConjugateGradient(self.tolerance).solve(convolution, task)
        return _Run(self, convolution, task, task.interaction).solve()


class _Run:
    """One solve on the finest grid."""

    def __init__(
        self, parts: GapDescent, convolution: PreparedConvolution, task: Task, interaction: BoundInteraction
    ) -> None:
        given = task.start is not None or task.start_gap is not None
        guess = start_from_task(convolution, task) if given else nested_start(convolution, task)
        self._guess = guess
        self._problem = guess.problem
        self._convolution = convolution
        self._task = task
        self._interaction = interaction
        self._tolerance = parts.tolerance
        self._left = parts.max_iterations
        self._conditions = AdhesiveConditions(
            initial_gap=task.initial_gap,
            interaction=interaction,
            pressure_limit=task.pressure_limit,
            approach=task.approach,
            rms=task.rms_gap,
        )
        self._errors: list[float] = []
        self._products = 0.0
        self._verifications = 0
        self._apart = 0

    def solve(self) -> Outcome:
        """Descend and verify until the conditions hold, or no descent lowers their violation further."""
        gap = self._guess.gap
        descent = self._begin(gap, np.float32)
        goal = _MARGIN * self._tolerance
        idles = IdleCount()
        while True:
            if goal < _SINGLE and descent.dtype is np.float32:
                self._products += descent.products
                descent = self._begin(gap, np.float64)
            status = self._descend(descent, gap, goal)
            if status is not None:
                return self._outcome(gap, descent, status)
            gap = hold_mean(self._problem, self._task, descent.gap.astype(np.float64))
            outcome = self._outcome(gap, descent, Status.CONVERGED)
            violation = self._verify(outcome)
            status = judge_error(violation.error, violation.floor, self._tolerance)
            is_idle = idles.add(violation.error) > 0
            if status is None and is_idle and descent.dtype is np.float64:
                status = Status.STALLED
            if status is not None:
                return attrs.evolve(outcome, status=status)
            goal = 0.0 if is_idle else goal * min(0.5, _MARGIN * self._tolerance / violation.error)
            descent.set_state(gap, self._pressure_of(gap))

    def _begin(self, gap: Array, dtype: type) -> AdhesiveDescent:
        descent = AdhesiveDescent(self._problem, dtype)
        descent.start(gap)
        return descent

    def _pressure_of(self, gap: Array) -> Array:
        """Return the pressure of a gap in float64."""
        self._verifications += 1
        problem = self._problem
        inverse = problem.stiffness.inverse
        displacement = gap - problem.closing
        pressure = inverse.multiply(displacement, inverse.stiffness, inverse.padded)
        pressure += problem.base + problem.mean_stiffness * float(displacement.mean())
        return pressure

    def _verify(self, outcome: Outcome) -> AdhesiveViolation:
        """Return the violation of the conditions by an outcome, from its pressure and tension alone."""
        self._verifications += 1
        convolution = self._convolution
        displacement = convolution.to_numpy(convolution.apply(convolution.from_numpy(outcome.pressure)))
        assert outcome.tension is not None
        violation = self._conditions.measure(outcome.pressure, outcome.tension, displacement)
        record_error(self._task, self._errors, violation.error)
        return violation

    def _descend(self, descent: AdhesiveDescent, gap: Array, goal: float) -> Status | None:
        """Iterate until the error is below a goal, or cannot be lowered: None, or how the solve ended."""
        scale = gap_scale(self._task, gap, self._problem)
        idles = IdleCount()
        while True:
            error = descent.measure() / scale
            record_error(self._task, self._errors, error)
            if not math.isfinite(error):
                return Status.NOT_FINITE
            if error <= goal:
                return None
            if self._left == 0:
                return Status.MAXIMUM_ITERATIONS
            self._left -= 1
            descent.cautious = error > _NEAR
            idle = idles.add(error)
            rounded = descent.dtype is np.float32 and idles.lowest < _ROUNDED
            if idle > (_IDLE_SINGLE if rounded else _IDLE) or not descent.advance():
                return None
            self._apart = self._apart + 1 if descent.is_apart() else 0
            if self._apart >= _APART and self._task.mean_pressure is not None:
                return Status.SEPARATED

    def _outcome(self, gap: Array, descent: AdhesiveDescent, status: Status) -> Outcome:
        """Return the outcome of a gap and the pressure of the descent: open cells are left to the tension."""
        inside = self._problem.stiffness.inner(gap)
        tension = self._interaction.tension(np.maximum(inside, 0.0))
        pressure = self._problem.stiffness.inner(descent.pressure).astype(np.float64)
        pressure -= descent.multiplier
        pressure = self._bound(pressure, tension, inside)
        if status is Status.SEPARATED:
            pressure = np.zeros_like(pressure)
            tension = np.zeros_like(tension)
        work = self._products + descent.products
        level = GridLevel(inside.shape, len(self._errors), self._verifications, 0, round(work))
        return Outcome(
            pressure=pressure,
            tension=tension,
            status=status,
            iterations=max(len(self._errors) - 1, 0),
            convolutions=round(self._guess.products + work + self._verifications),
            errors=tuple(self._errors),
            levels=(*self._guess.levels, level),
        )

    def _bound(self, pressure: Array, tension: Array, gap: Array) -> Array:
        """Return the pressure of the load: minus the tension on open cells, at most the limit on the others."""
        limit = np.broadcast_to(self._task.pressure_limit, pressure.shape)
        closed = gap <= 0.0
        contact = np.where(closed, np.maximum(pressure + tension, 0.0), 0.0)
        saturated = closed & ((gap < 0.0) | (contact >= limit + tension))
        bounded = np.where(saturated, limit, contact - tension)
        if self._task.mean_pressure is None:
            return bounded
        elastic = closed & ~saturated
        carried = float(contact[elastic].sum())
        needed = self._task.mean_pressure * pressure.size - float(np.where(saturated, limit, -tension).sum())
        if carried > 0.0 and needed > 0.0:
            bounded[elastic] = np.minimum(contact[elastic] * (needed / carried) - tension[elastic], limit[elastic])
        return bounded
