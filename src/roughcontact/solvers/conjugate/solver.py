"""The default solver, from the top."""

from __future__ import annotations

from functools import partial

import attrs

from roughcontact.convolvers import PlannedConvolution
from roughcontact.grid import Boundary
from roughcontact.solution import Status
from roughcontact.solvers.base import Monitor, Outcome, Solver, Task, iteration_limit, positive_tolerance
from roughcontact.solvers.conjugate import search
from roughcontact.solvers.conjugate.cascade import Start, cascaded, estimated_approach
from roughcontact.solvers.conjugate.refinement import Refinement
from roughcontact.solvers.conjugate.window import window_for
from roughcontact.solvers.spectral_gradient import SpectralGradient

# Iterations for a given approach after which it is searched for through loads, where that can be.
_PATIENT = 80


@attrs.frozen
class ProjectedConjugateGradient(Solver):
    """Projected conjugate gradients, preconditioned by the inverse kernel on the active cells.

    Load or approach control, with or without a pressure limit, on any boundary. The number of
    iterations hardly grows with the grid. The descent runs in float32, every claim in float64.
    Should it stall, `SpectralGradient` goes on from there, or, for an approach near the full contact
    of a periodic surface, a search through loads; the status tells.

    Parameters
    ----------
    tolerance
        Error (see `Optimality`) to be reached.
    max_iterations
        Iterations on the finest grid after which it gives up.

    References
    ----------
    Polonsky, Keer, Wear 231 (1999) 206-219, https://doi.org/10.1016/S0043-1648(99)00113-1;
    Vollebregt, J. Optim. Theory Appl. 162 (2014) 862-879, https://doi.org/10.1007/s10957-013-0499-x
    """

    tolerance: float = attrs.field(converter=positive_tolerance, default=1e-8)
    max_iterations: int = attrs.field(converter=iteration_limit, default=1000)

    def solve(self, convolution: PlannedConvolution, task: Task) -> Outcome:
        """Return the pressure; see `Solver.solve`."""
        if convolution.scene.boundary is not Boundary.FREE:
            return self._solved(convolution, task)[0]
        approach = estimated_approach(convolution, task)
        while approach is not None and (window := window_for(convolution, task, approach)) is not None:
            outcome, approach = self._solved(window.planned(convolution), window.task(task))
            pressure = window.pasted(outcome.pressure, task.undeformed.shape)
            if not outcome.status.success or window.holds(task.undeformed, approach):
                return attrs.evolve(outcome, pressure=pressure)
            # The estimate was too low: the next window is larger, and knows where to start.
            task = attrs.evolve(task, start=pressure)
        return self._solved(convolution, task)[0]

    def _solved(self, convolution: PlannedConvolution, task: Task) -> tuple[Outcome, float]:
        """Solve on all cells of the convolution; return the approach as well."""
        start = cascaded(convolution, task) if task.start is None else Start(task.start.copy(), 0.0)
        searchable = search.searchable(convolution, task)
        monitor = Monitor(
            task, self.tolerance, min(self.max_iterations, _PATIENT) if searchable else self.max_iterations
        )
        refinement = Refinement(convolution, task, monitor)
        pressure, state, status = refinement.run(start.pressure)
        outcome = monitor.outcome(pressure, status, round(start.products + refinement.products))
        outcome = attrs.evolve(outcome, levels=(*start.levels, refinement.level))
        if status is Status.STALLED or (searchable and status is Status.MAXIMUM_ITERATIONS):
            outcome = self._rescued(convolution, task, outcome)
        return outcome, state.approach

    def _rescued(self, convolution: PlannedConvolution, task: Task, stalled: Outcome) -> Outcome:
        """Go on with a method that is slower, but does not stall where this one has."""
        if search.searchable(convolution, task):
            monitor = Monitor(task, self.tolerance, self.max_iterations)
            solve = partial(self._solved, convolution)
            rescue = search.by_load(solve, convolution, task, monitor, stalled.pressure)
        else:
            task = attrs.evolve(task, start=stalled.pressure)
            rescue = SpectralGradient(self.tolerance, self.max_iterations).solve(convolution, task)
        return attrs.evolve(
            rescue,
            status=Status.RESCUED if rescue.status is Status.CONVERGED else rescue.status,
            iterations=stalled.iterations + rescue.iterations,
            convolutions=stalled.convolutions + rescue.convolutions,
            history=stalled.history + rescue.history,
            levels=stalled.levels,
        )
