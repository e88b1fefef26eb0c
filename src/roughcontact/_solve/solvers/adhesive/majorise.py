"""Adhesion by any solver of contact without adhesion: the tension is given, and renewed."""

from __future__ import annotations

import math
from typing import ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import instance_of
from roughcontact._parts.grid import Boundary
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.base import (
    DEFAULT_TOLERANCE,
    Outcome,
    Solver,
    Task,
    iteration_limit,
    positive_tolerance,
)
from roughcontact._solve.solvers.conjugate import ProjectedConjugateGradient
from roughcontact._solve.solvers.driver import Log

# Tolerance of a contact over that of the whole, and its maximum over the last change of the gap.
_INNER = 0.1
_LOOSE = 0.02
# Estimated rate of convergence at most: a slower one is not told from none.
_SLOWEST = 0.995
# Peak memory of a solve in float64 arrays of the grid: measured as that of `GapDescent`.
_MEMORY_ARRAYS = (20.0, 20.0, 23.0)

_is_solver = instance_of(Solver, "The solver of the contacts without adhesion", "a Solver such as PolonskyKeer()")


@attrs.frozen
class Majorise(Solver):
    """The tension at the gap of one contact acts on the next one: majorise, then minimise.

    The energy of an attraction that falls with the gap lies below its tangents, so that it falls in every round, and
    with a given approach the contact only grows, from that without adhesion to the smallest one in equilibrium. It
    takes several times the products of `GapDescent`, but any kernel and any solver of contact without adhesion.

    Parameters
    ----------
    tolerance
        Error of the gap, over the smaller of the standard deviation of the initial gap and the range of the
        displacement, at the rate of convergence of the last rounds.
    max_rounds
        Contacts to solve at most.
    solver
        Solver of the contacts.

    References
    ----------
    Hunter, Lange, Am. Stat. 58 (2004) 30-37, https://doi.org/10.1198/0003130042836

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.ParaboloidSurface(radius=1e-6), rc.Elastic(young=10e6, poisson=0.5))
    >>> law = rc.Exponential(work="50mJ/m2", range="60nm")
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((24, 24), 2e-6), adhesion=law, solver="majorise")
    >>> problem.solve(force=0.0).status.success
    True
    """

    adhesive: ClassVar[bool] = True

    tolerance: float = attrs.field(converter=positive_tolerance, default=DEFAULT_TOLERANCE)
    max_rounds: int = attrs.field(converter=iteration_limit, default=2000)
    solver: Solver = attrs.field(factory=ProjectedConjugateGradient, kw_only=True, validator=_is_solver)

    def memory_arrays(self, boundary: Boundary) -> float:
        """Return the peak memory of a solve in float64 arrays of the grid."""
        return _MEMORY_ARRAYS[sum(boundary.free_axes)]

    def solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        """Return the pressure and the tension; see `Solver.solve`."""
        if task.interaction is None:
            return self.solver.solve(convolution, task)
        return _Rounds(self, convolution, task).solve()


class _Rounds:
    """The rounds of one solve."""

    def __init__(self, parts: Majorise, convolution: PreparedConvolution, task: Task) -> None:
        assert task.interaction is not None
        self._parts = parts
        self._convolution = convolution
        self._task = task
        self._interaction = task.interaction
        self._limit = np.broadcast_to(task.pressure_limit, task.initial_gap.shape)
        self._convolutions = 0
        self._log = Log(task.initial_gap.shape, parts.max_rounds, task.on_step)
        self._rms = float(task.initial_gap.std()) if task.rms_gap is None else task.rms_gap

    def solve(self) -> Outcome:
        gap, contact = self._first_gap()
        tension = self._interaction.tension(gap)
        inner = 1e-3
        changes = [math.inf]
        for _ in range(self._parts.max_rounds):
            found = self._press(tension, contact, inner)
            if isinstance(found, Status):
                return self._outcome(np.zeros_like(gap), np.zeros_like(gap), found)
            contact, displacement, approach = found
            before = gap
            gap = self._find_gap(displacement, contact, approach)
            scale = min(self._rms, float(np.ptp(displacement))) or self._rms or 1.0
            change = float(np.abs(gap - before).max()) / scale
            if not math.isfinite(change):
                return self._outcome(contact - tension, tension, Status.NOT_FINITE)
            rate = min(change / changes[-1], _SLOWEST) if changes[-1] > 0.0 and math.isfinite(changes[-1]) else 0.9
            changes.append(change)
            error = change * rate / (1.0 - rate)
            self._log.record(error)
            tension = self._interaction.tension(gap)
            finest = _INNER * self._parts.tolerance
            if error <= 0.5 * self._parts.tolerance and inner <= 2.0 * finest:
                return self._finish(contact, tension)
            inner = max(finest, min(inner, _LOOSE * change, _INNER * error))
        return self._outcome(contact - tension, tension, Status.MAXIMUM_ITERATIONS)

    def _first_gap(self) -> tuple[Array, Array]:
        """Return the gap to start from and its contact pressure: of the task, or of a contact without adhesion."""
        task = self._task
        start = task.start
        if start is not None or task.start_gap is not None:
            pressure = np.zeros_like(task.initial_gap) if start is None else start
            gap = task.start_gap
            if gap is None:
                self._convolutions += 1
                displacement = self._apply(pressure)
                bearing = np.maximum(pressure, 0.0)
                approach = task.approach
                if approach is None:
                    moved = displacement + task.initial_gap
                    approach = _find_approach(bearing, moved, float(moved.min()))
                gap = self._find_gap(displacement, bearing, approach)
            return gap, np.maximum(pressure + self._interaction.tension(gap), 0.0) * (gap <= 0.0)
        nothing = np.zeros_like(task.initial_gap)
        first = self._press(nothing, nothing, 1e-3)
        if isinstance(first, Status):
            return task.initial_gap - float(task.initial_gap.min()), nothing
        contact, displacement, approach = first
        return self._find_gap(displacement, contact, approach), contact

    def _find_gap(self, displacement: Array, contact: Array, approach: float) -> Array:
        """Return the gap: zero where the contact pressure is above zero, and nowhere negative."""
        gap = np.maximum(displacement + self._task.initial_gap - approach, 0.0)
        gap[contact > 0.0] = 0.0
        return gap

    def _apply(self, pressure: Array) -> Array:
        return self._convolution.to_numpy(self._convolution.apply(self._convolution.from_numpy(pressure)))

    def _press(self, tension: Array, contact: Array, tolerance: float) -> tuple[Array, Array, float] | Status:
        """Return contact pressure, displacement and approach of the contact under a tension that is given."""
        task = self._task
        lifted = task.initial_gap
        if tension.any():
            self._convolutions += 1
            lifted = task.initial_gap - self._apply(tension)
        lowest = float(lifted.min())
        mean = None if task.mean_pressure is None else task.mean_pressure + float(tension.mean())
        approach = None if task.approach is None else task.approach - lowest
        if mean is not None and not mean > 0.0:
            return Status.SEPARATED
        if approach is not None and not approach > 0.0:
            displacement = lifted - task.initial_gap
            assert task.approach is not None
            return np.zeros_like(tension), displacement, task.approach
        limit = self._limit + tension
        start = np.minimum(contact, limit) if contact.any() else None
        inner = Task(
            initial_gap=lifted - lowest,
            mean_pressure=mean,
            approach=approach,
            pressure_limit=limit if task.capped else math.inf,
            rms_gap=task.rms_gap,
            start=start,
        )
        outcome = self._parts.solver.with_tolerance(max(tolerance, 1e-12)).solve(self._convolution, inner)
        self._convolutions += outcome.convolutions + 1
        if not outcome.status.success:
            return outcome.status
        pressed = self._apply(outcome.pressure)
        if approach is None:
            bearing = np.where(outcome.pressure < limit, outcome.pressure, 0.0)
            moved = pressed + inner.initial_gap
            approach = _find_approach(bearing, moved, float(moved.max()))
        displacement = pressed + (lifted - task.initial_gap)
        return outcome.pressure, displacement, approach + lowest

    def _finish(self, contact: Array, tension: Array) -> Outcome:
        """Return the outcome with the load of the task: the contact pressure is scaled to it."""
        task = self._task
        if task.mean_pressure is not None:
            limit = self._limit + tension
            elastic = contact < limit
            carried = float(contact[elastic].sum())
            needed = task.mean_pressure * contact.size + float(tension.sum()) - float(contact[~elastic].sum())
            if carried > 0.0 and needed > 0.0:
                contact = np.where(elastic, np.minimum(contact * (needed / carried), limit), contact)
        return self._outcome(contact - tension, tension, Status.CONVERGED)

    def _outcome(self, pressure: Array, tension: Array, status: Status) -> Outcome:
        outcome = self._log.outcome(np.minimum(pressure, self._limit), status, self._convolutions)
        return attrs.evolve(outcome, tension=tension, iterations=len(outcome.errors))


def _find_approach(bearing: Array, moved: Array, unloaded: float) -> float:
    """Return the mean of the gap before the approach, weighted by a pressure; without any load, that of no load."""
    load = float(bearing.sum())
    return float((bearing * moved).sum()) / load if load > 0.0 else unloaded
