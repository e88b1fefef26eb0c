"""The solver of adhesive contacts: starts on coarser grids or from another load, and the refinement of the gap."""

from __future__ import annotations

import math
from functools import cached_property
from typing import ClassVar, Self

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Boundary
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import GridLevel, Status
from roughcontact._solve.solution.attraction import AdhesiveConditions
from roughcontact._solve.solvers.adhesive.descent import AdhesiveDescent, Precision
from roughcontact._solve.solvers.adhesive.gap_problem import GapProblem, gap_scale, hold_mean, make_gap_problem
from roughcontact._solve.solvers.adhesive.stiffness import surface_stiffness
from roughcontact._solve.solvers.base import (
    DEFAULT_TOLERANCE,
    Outcome,
    Solver,
    Task,
    iteration_limit,
    positive_tolerance,
)
from roughcontact._solve.solvers.conjugate import ProjectedConjugateGradient
from roughcontact._solve.solvers.driver import Log, Refinement, iterate
from roughcontact._solve.solvers.grids import GridProblem, Guess, climb, interpolate, repeat_cells

# Error of the contact without adhesion at which a descent starts from it.
_ROUGHLY = 1e-2
# Error of the gap, over the scale, and iterations at which a descent on a coarse grid ends. 5 and 12 iterations change
# the products of 54 rough contacts by 3 %.
_TOLERANCE = 1e-2
_ITERATIONS = 8
# Cells of the cohesive length that a coarse grid needs: a shorter range is stretched to that. Between 0.7 and 2 the
# products change by 5 %.
_RESOLVED = 1.0
# Fraction of the work of adhesion on coarse grids: their contact must stay below that of the fine grid, which only
# grows to the smallest one in equilibrium. With 1 the area of 4 of 54 rough contacts is up to 0.8 % larger, and
# a wave closes at an alpha of 0.55 instead of 0.57; with 0.9, which costs 10 % more products, and 0.6 all are the same.
_WEAKENED = 0.9
# Fraction of the tolerance at which a descent ends, so that its verification in float64 meets it.
_MARGIN = 0.7
# Error, over the scale, that a descent in float32 may reach.
_SINGLE = 2e-6
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
        return _GapRefinement(self, convolution, task, task.interaction).solve()


@attrs.frozen(eq=False, kw_only=True)
class GapGuess(Guess):
    """A gap to start from, in float64, shape (mx, my) of the extended grid."""

    gap: Array


@attrs.frozen(eq=False)
class GapOnGrid(GridProblem[GapGuess]):
    """A contact whose gap is sought, on an extended grid.

    Attributes
    ----------
    extended
        Cells of the extended grid of a free boundary; None: chosen for fast transforms.
    """

    extended: tuple[int, int] | None = None

    @cached_property
    def problem(self) -> GapProblem:
        """What a descent minimises."""
        return make_gap_problem(surface_stiffness(self.convolution, self.extended), self.task)

    def coarser(self) -> Self | None:
        """Return the problem on the next coarser grid, if it divides the extended grid too."""
        coarse = super().coarser()
        if coarse is None:
            return None
        factors = [n // m for n, m in zip(self.task.initial_gap.shape, coarse.task.initial_gap.shape, strict=True)]
        mx, my = (divmod(m, f) for m, f in zip(self.problem.stiffness.extended, factors, strict=True))
        return None if mx[1] or my[1] else attrs.evolve(coarse, extended=(mx[0], my[0]))

    def start_from_task(self) -> GapGuess:
        """Return the start that the task gives by its pressure, and by its gap if there is one."""
        task = self.task
        stiffness = self.problem.stiffness
        if task.start_gap is not None and stiffness.extended == stiffness.shape:
            return self._guess(task.start_gap.copy(), products=0.0)
        gap = self._gap_of_pressure(np.zeros_like(task.initial_gap) if task.start is None else task.start)
        if task.start_gap is not None:
            inside = stiffness.inner(gap)
            gap += float((task.start_gap - inside).mean())
            inside[:] = task.start_gap
        return self._guess(gap, products=1.0)

    def begin(self) -> GapGuess:
        """Return the gap of the contact without adhesion, or of the first touch where the load does not press."""
        task = self.task
        pressure = np.zeros_like(task.initial_gap)
        products = 0
        lowest = float(task.initial_gap.min())
        load = task.mean_pressure if task.approach is None else task.approach - lowest
        if load is not None and load > 0.0:
            plain = attrs.evolve(task, interaction=None, start=None, start_gap=None, on_step=None)
            outcome = ProjectedConjugateGradient(_ROUGHLY).solve(self.convolution, plain)
            pressure = outcome.pressure
            products = outcome.convolutions
        return self._guess(self._gap_of_pressure(pressure), products=products + 1.0)

    def improve(self, guess: GapGuess) -> GapGuess:
        """Return a guess after a few iterations, with a law that this grid resolves."""
        problem = self.problem
        if problem.interaction is not None:
            stretch = math.sqrt(max(_RESOLVED / problem.stiffness.cohesive_cells(problem.interaction), 1.0))
            problem = attrs.evolve(problem, interaction=problem.interaction.stretched(stretch).weakened(_WEAKENED))
        descent = AdhesiveDescent(problem, np.float32)
        descent.start(guess.gap)
        descent.scale = gap_scale(self.task, guess.gap, problem)
        log = Log(self.task.initial_gap.shape, _ITERATIONS)
        iterate(descent, log, _TOLERANCE)
        level = GridLevel(self.task.initial_gap.shape, len(log.errors) - 1, 0, 0, descent.products)
        return guess.after(level, gap=hold_mean(problem, self.task, descent.gap.astype(np.float64)))

    def refine(self, coarse: GapOnGrid, guess: GapGuess, fx: int, fy: int) -> GapGuess:
        """Return a guess from that on the coarser grid: displacements are interpolated, cells in contact stay so.

        A cell of a coarse one in contact may be open, but not by less than half of the range of the law.
        """
        problem = self.problem
        gap = interpolate(guess.gap - coarse.problem.closing, fx, fy)
        gap += problem.closing
        inside = problem.stiffness.inner(gap)
        parent = repeat_cells(coarse.problem.stiffness.inner(guess.gap), fx, fy)
        near = 0.0
        if problem.interaction is not None:
            near = 0.5 * float(np.max(problem.interaction.strength)) / problem.interaction.steepest
        flattened = parent < 0.0
        inside[(parent == 0.0) & (inside < near)] = 0.0
        np.maximum(inside, 0.0, out=inside, where=~flattened)
        np.minimum(inside, 0.0, out=inside, where=flattened)
        return self._guess(gap, guess.products, guess.levels)

    def _guess(self, gap: Array, products: float, levels: tuple[GridLevel, ...] = ()) -> GapGuess:
        return GapGuess(gap=hold_mean(self.problem, self.task, gap), products=products, levels=levels)

    def _gap_of_pressure(self, pressure: Array) -> Array:
        """Return the gap of a pressure, zero where it presses; if need be the pressure implies the approach."""
        problem = self.problem
        stiffness = problem.stiffness
        gap: Array = stiffness.displace(stiffness.embed(pressure))
        gap += problem.closing
        inside = stiffness.inner(gap)
        bearing = np.maximum(pressure, 0.0)
        approach = self.task.approach
        if approach is None:
            load = float(bearing.sum())
            approach = float(np.einsum("ij,ij->", bearing, inside)) / load if load > 0.0 else float(inside.min())
        gap -= approach
        np.maximum(inside, 0.0, out=inside)
        inside[bearing > 0.0] = 0.0
        return gap


class _Descent(AdhesiveDescent):
    """A descent that ends where the surfaces come apart."""

    _apart = 0

    def step(self) -> Status | None:
        """Make one step; see `Method.step`."""
        status = super().step()
        self._apart = self._apart + 1 if self.is_apart() else 0
        return Status.SEPARATED if self._apart >= _APART else status


class _GapRefinement(Refinement):
    """One solve on the finest grid: descents until the conditions hold, or none lowers their violation further."""

    goal_fraction = _MARGIN

    def __init__(
        self, parts: GapDescent, convolution: PreparedConvolution, task: Task, interaction: BoundInteraction
    ) -> None:
        given = task.start is not None or task.start_gap is not None
        start = GapOnGrid(convolution, task)
        self._guess = start.start_from_task() if given else climb(start)
        self._problem = start.problem
        self._convolution = convolution
        self._task = task
        self._interaction = interaction
        self._log = Log(task.initial_gap.shape, parts.max_iterations, task.on_step)
        self.target = parts.tolerance
        self._conditions = AdhesiveConditions(
            initial_gap=task.initial_gap,
            interaction=interaction,
            pressure_limit=task.pressure_limit,
            approach=task.approach,
            rms=task.rms_gap,
        )
        self._gap = self._guess.gap
        self._goal = math.inf
        self._products = self._verifications = 0
        self._begin(np.float32)

    def solve(self) -> Outcome:
        """Return the outcome."""
        status = iterate(self, self._log, self.target, math.inf)
        return attrs.evolve(self._found, status=status)

    def measure(self) -> tuple[float, float]:
        """Return the violation of the conditions, from pressure and tension alone, and that by rounding."""
        self._gap = hold_mean(self._problem, self._task, self._descent.gap.astype(np.float64))
        self._found = found = self._outcome(Status.CONVERGED)
        self._verifications += 1
        convolution = self._convolution
        displacement = convolution.to_numpy(convolution.apply(convolution.from_numpy(found.pressure)))
        assert found.tension is not None
        violation = self._conditions.measure(found.pressure, found.tension, displacement)
        return violation.error, violation.floor

    def step(self) -> Status | None:
        """Make one descent, to a goal that falls by the ratio of both errors and at least by half."""
        goal = self.goal_fraction * self.target
        if self._goal < math.inf:
            goal = 0.0 if self.idle else self._goal * min(0.5, goal / self.error)
            self._descent.set_state(self._gap, self._pressure_of(self._gap))
        self._goal = goal
        return self.descend(goal)

    def descend(self, goal: float) -> Status | None:
        """Lower the estimated error, in float64 where float32 does not reach the goal."""
        if goal < _SINGLE and self._descent.dtype is np.float32:
            self._products += self._descent.products
            self._begin(np.float64)
            self.patience = 1
        self._descent.scale = gap_scale(self._task, self._gap, self._problem)
        status = iterate(self._descent, self._log, goal)
        if status.success or status is Status.STALLED:
            return None
        self._found = self._outcome(status)
        return status

    def _begin(self, dtype: Precision) -> None:
        self._descent = _Descent(self._problem, dtype)
        self._descent.start(self._gap)

    def _pressure_of(self, gap: Array) -> Array:
        """Return the pressure of a gap in float64."""
        self._verifications += 1
        problem = self._problem
        inverse = problem.stiffness.inverse
        displacement = gap - problem.closing
        pressure = inverse.multiply(displacement, inverse.stiffness, inverse.padded)
        pressure += problem.base + problem.mean_stiffness * float(displacement.mean())
        return pressure

    def _outcome(self, status: Status) -> Outcome:
        """Return the outcome of the gap and the pressure of the descent: open cells are left to the tension."""
        inside = self._problem.stiffness.inner(self._gap)
        tension = self._interaction.tension(np.maximum(inside, 0.0))
        pressure = self._problem.stiffness.inner(self._descent.pressure).astype(np.float64)
        pressure -= self._descent.multiplier
        pressure = self._bound(pressure, tension, inside)
        if status is Status.SEPARATED:
            pressure = np.zeros_like(pressure)
            tension = np.zeros_like(tension)
        work = self._products + self._descent.products
        level = GridLevel(inside.shape, len(self._log.errors), self._verifications, 0, work)
        convolutions = self._guess.products + work + self._verifications
        outcome = self._log.outcome(pressure, status, convolutions, (*self._guess.levels, level))
        return attrs.evolve(outcome, tension=tension)

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
