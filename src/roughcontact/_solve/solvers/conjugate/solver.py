"""The default solver: windows, starts, and a second method if the first stalls."""

from __future__ import annotations

import math
from functools import reduce
from typing import ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array
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
from roughcontact._solve.solvers.conjugate.field_descent import FieldDescent
from roughcontact._solve.solvers.conjugate.nested_iteration import GridSolution, PressureOnGrid, solve_in_window
from roughcontact._solve.solvers.conjugate.refinement import PressureRefinement
from roughcontact._solve.solvers.driver import Monitor
from roughcontact._solve.solvers.grids import climb
from roughcontact._solve.solvers.spectral_gradient import SpectralGradient

# Maximum iterations for a given approach before a search over loads, if that is possible: 40 and 160 change the
# products of the 26 contacts by -6 and +14 %, all in the one that needs the search.
_MAX_APPROACH_ITERATIONS = 80
# Minimum approach for a search over loads, over full contact: below, each digit of the approach needs one of the load.
_LOAD_SEARCH_APPROACH = 0.5
# Maximum loads to try.
_MAX_LOAD_TRIES = 60
# Maximum loads that may fail; after each, one nearer to the last solved load is tried.
_MAX_LOAD_FAILURES = 6
# First exponent of the power law between the missing load and the remaining gap to full contact.
_FIRST_POWER = 2.0
# Minimum missing load and remaining gap, over their values at zero load, to avoid log(0).
_MIN_MISSING_FRACTION = 1e-9


@attrs.frozen
class ProjectedConjugateGradient(Solver):
    """Projected conjugate gradients, preconditioned by the inverse kernel on the active cells.

    Load or approach control, with or without a pressure limit, on any boundary. The number of
    iterations hardly grows with the grid. The descent runs in float32, every result is verified in float64. If it
    stalls, `SpectralGradient` continues, or, for an approach near the full contact of a periodic surface, a search over
    loads; the status says so. If a start does not lead to the solution, the solve is repeated without it.

    Parameters
    ----------
    tolerance
        Error (see `Violation`) to be reached.
    max_iterations
        Iterations of one attempt on the finest grid after which it is given up.

    References
    ----------
    Polonsky, Keer, Wear 231 (1999) 206-219, https://doi.org/10.1016/S0043-1648(99)00113-1;
    Vollebregt, J. Optim. Theory Appl. 162 (2014) 862-879, https://doi.org/10.1007/s10957-013-0499-x

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), solver=rc.ProjectedConjugateGradient())
    >>> print(problem.solve(force=1.0).status)
    converged: the conditions of contact hold within the tolerance
    """

    climbs_grids: ClassVar[bool] = True
    omitted: ClassVar[tuple[str, ...]] = (
        "double precision inside the iterations: single is enough, and every result is verified in double",
        "cells that cannot touch: only those that can are solved",
    )

    tolerance: float = attrs.field(converter=positive_tolerance, default=DEFAULT_TOLERANCE)
    max_iterations: int = attrs.field(converter=iteration_limit, default=1000)

    def solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        """Return the contact pressure; see `Solver.solve`."""
        # The code below serves any kind of array: new arrays are made like existing ones.
        return self._solve(convolution, task.convert(convolution.from_numpy)).convert(convolution.to_numpy)

    def _solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        """Solve; if the limit shortened steps but no cell reaches it in the end, solve again without it.

        A limit that is not reached then changes no bit of the result.
        """
        found = solve_in_window(convolution, task, self._solve_on_grid)
        limited = found.outcome
        if not found.met_limit or not limited.status.success or (limited.pressure >= task.pressure_limit).any():
            return limited
        unlimited = attrs.evolve(task, pressure_limit=np.full((), math.inf, like=task.pressure_limit))
        free = solve_in_window(convolution, unlimited, self._solve_on_grid).outcome
        if not free.status.success or (free.pressure > task.pressure_limit).any():
            return limited
        return attrs.evolve(free, convolutions=limited.convolutions + free.convolutions)

    def _solve_on_grid(self, convolution: PreparedConvolution, task: Task) -> GridSolution:
        """Solve on all cells of the convolution; again without a start that does not lead to the solution."""
        found = self._descend(convolution, task)
        if task.start is None or found.outcome.status.success:
            return found
        again = self._descend(convolution, attrs.evolve(task, start=None))
        outcome = _append(found.outcome, again.outcome)
        return attrs.evolve(again, outcome=outcome, met_limit=found.met_limit or again.met_limit)

    def _descend(self, convolution: PreparedConvolution, task: Task) -> GridSolution:
        """Solve on all cells of the convolution, by a second method if the first stalls."""
        given = task.start
        pressed = PressureOnGrid(convolution, task)
        start = climb(pressed) if given is None else pressed.start_from(given)
        searchable = _can_search_loads(convolution, task)
        patience = min(self.max_iterations, _MAX_APPROACH_ITERATIONS) if searchable else self.max_iterations
        monitor = Monitor(task, self.tolerance, patience)
        refinement = PressureRefinement(convolution, task, monitor, start.nearly_full)
        start = attrs.evolve(start, nearly_full=None)
        uniform = given is None and not start.levels and not start.closed and FieldDescent.serves(task)
        if uniform:
            start = attrs.evolve(start, pressure=refinement.begin(start.pressure))
        # Far from the solution an approximate gap is enough, but not where a uniform pressure displaces far more than
        # the gap. What is only an argument can be freed by who gets it.
        begins = uniform and not convolution.setup.boundary.has_free_axis
        improves = begins or (bool(start.levels) and not start.closed)
        pressure, violation, status = refinement.run(
            refinement.approximate(start.pressure)[0] if improves else start.pressure
        )
        work = start.after(refinement.level)
        outcome = monitor.outcome(pressure, status, work.products, work.levels)
        if status is Status.STALLED or (searchable and status is Status.MAXIMUM_ITERATIONS):
            outcome = self._rescue(convolution, task, outcome)
        return GridSolution(outcome, violation.approach, start.met_limit or refinement.met_limit)

    def _rescue(self, convolution: PreparedConvolution, task: Task, stalled: Outcome) -> Outcome:
        """Continue with a slower but more robust method."""
        if _can_search_loads(convolution, task):
            rescue = self._search_loads(convolution, task, stalled.pressure)
        else:
            task = attrs.evolve(task, start=stalled.pressure)
            rescue = SpectralGradient(self.tolerance, self.max_iterations).solve(convolution, task)
        status = Status.RESCUED if rescue.status is Status.CONVERGED else rescue.status
        return attrs.evolve(_append(stalled, rescue), status=status, levels=stalled.levels)

    def _search_loads(self, convolution: PreparedConvolution, task: Task, pressure: Array) -> Outcome:
        """Solve for loads until one gives the approach of the task.

        Near full contact the approach hardly depends on the load and determines it badly, but each load determines its
        approach. The logarithms of the missing load and of the remaining gap are nearly proportional: the secant
        through the last two, within a bracket, finds the approach in a few steps. Beyond full contact, with saturated
        cells that overlap, the bracket is halved instead.
        """
        assert task.approach is not None
        monitor = Monitor(task, self.tolerance, self.max_iterations)
        beyond = task.approach >= float(task.initial_gap.mean())
        closing, end = _final_load(convolution, task, beyond=beyond)
        remaining = end - task.approach
        if remaining <= 0.0:
            pressure = np.broadcast_to(task.pressure_limit, pressure.shape).copy()
            _, status = monitor.judge(pressure, convolution.apply(pressure))
            return monitor.outcome(pressure, status or Status.STALLED, 1)
        low = -math.inf
        high = math.log(closing)
        missing = math.log(max(closing - (float(pressure.mean()) or 0.5 * closing), _MIN_MISSING_FRACTION * closing))
        power = _FIRST_POWER
        before = None
        work = []
        for _ in range(_MAX_LOAD_TRIES):
            mean = closing - math.exp(missing)
            start = np.minimum(pressure * (mean / (float(pressure.mean()) or mean)), task.pressure_limit)
            found = self._solve_on_grid(convolution, attrs.evolve(task, approach=None, mean_pressure=mean, start=start))
            outcome = found.outcome
            work.append(outcome)
            failures = sum(not one.status.success for one in work)
            if before is not None and not outcome.status.success and failures <= _MAX_LOAD_FAILURES:
                missing = 0.5 * (missing + before[0])
                continue
            pressure = outcome.pressure
            _, status = monitor.judge(pressure, convolution.apply(pressure))
            if status is not None or not outcome.status.success:
                break
            excess = math.log(max(end - found.approach, _MIN_MISSING_FRACTION * remaining) / remaining)
            low, high = (low, missing) if excess > 0.0 else (missing, high)
            if before is not None and (missing - before[0]) * (excess - before[1]) > 0.0:
                power = (excess - before[1]) / (missing - before[0])
            before = (missing, excess)
            trial = missing - excess / power
            # Between full contact and the first saturated cell the approach is constant: the bracket is halved.
            if beyond or not low < trial < high:
                trial = 0.5 * (low + high) if math.isfinite(low) else high - 1.0
            missing = trial
        whole = attrs.evolve(reduce(_append, work), pressure=pressure, status=status or Status.STALLED, levels=())
        return attrs.evolve(whole, convolutions=whole.convolutions + len(work))


def _append(before: Outcome, after: Outcome) -> Outcome:
    """Return an outcome with the work of an earlier one added."""
    return attrs.evolve(
        after,
        iterations=before.iterations + after.iterations,
        convolutions=before.convolutions + after.convolutions,
        errors=before.errors + after.errors,
    )


def _can_search_loads(convolution: PreparedConvolution, task: Task) -> bool:
    if task.approach is None or convolution.setup.boundary is not Boundary.PERIODIC or not convolution.fixes_mean:
        return False
    full = float(task.initial_gap.mean())
    limited = bool(np.isfinite(task.pressure_limit).all())
    return task.approach > _LOAD_SEARCH_APPROACH * full and (limited or task.approach < full)


def _final_load(convolution: PreparedConvolution, task: Task, *, beyond: bool) -> tuple[float, float]:
    """Return the mean pressure and the approach of full contact or, beyond it, with all cells saturated."""
    maximum = float(task.pressure_limit.mean())
    if beyond:
        limit = np.broadcast_to(task.pressure_limit, task.initial_gap.shape).copy()
        return maximum, float((convolution.apply(limit) + task.initial_gap).max())
    closing = float(convolution.inverse().apply(task.initial_gap).max())
    return min(closing, maximum), float(task.initial_gap.mean())
