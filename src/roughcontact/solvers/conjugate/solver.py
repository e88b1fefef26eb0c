"""The default solver, from the top."""

from __future__ import annotations

import math
from functools import partial
from typing import ClassVar

import attrs

from roughcontact.convolvers import PlannedConvolution
from roughcontact.grid import Boundary
from roughcontact.solution import Status
from roughcontact.solvers.base import Monitor, Outcome, Solver, Task, iteration_limit, positive_tolerance
from roughcontact.solvers.conjugate import search
from roughcontact.solvers.conjugate.cascade import Start, cascaded, estimated_approach
from roughcontact.solvers.conjugate.refinement import Refinement
from roughcontact.solvers.conjugate.search import Found
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

    leaves_out: ClassVar[tuple[str, ...]] = (
        "float64 inside the iterations: float32 serves, and every claim is proved in float64",
        "cells that cannot touch: vectors hold the others, and a free domain is cut down to them",
    )

    tolerance: float = attrs.field(converter=positive_tolerance, default=1e-8)
    max_iterations: int = attrs.field(converter=iteration_limit, default=1000)

    def solve(self, convolution: PlannedConvolution, task: Task) -> Outcome:
        """Return the pressure; see `Solver.solve`.

        A limit that cut steps short, but is nowhere reached in the end, leaves no trace: the contact
        is solved again without it.
        """
        found = self._windowed(convolution, task)
        limited = found.outcome
        if not found.met_limit or not limited.status.success or (limited.pressure >= task.limit).any():
            return limited
        free = self._windowed(convolution, attrs.evolve(task, limit=math.inf)).outcome
        if not free.status.success or (free.pressure > task.limit).any():
            return limited
        return attrs.evolve(free, convolutions=limited.convolutions + free.convolutions)

    def _windowed(self, convolution: PlannedConvolution, task: Task) -> Found:
        """Solve on the part of a free domain that can touch, or on all of it."""
        if convolution.scene.boundary is not Boundary.FREE:
            return self._solved(convolution, task)
        approach, met_limit = estimated_approach(convolution, task)
        while approach is not None and (window := window_for(convolution, task, approach)) is not None:
            found = self._solved(window.planned(convolution), window.task(task))
            approach, met_limit = found.approach, met_limit or found.met_limit
            pressure = window.pasted(found.outcome.pressure, task.undeformed.shape)
            if not found.outcome.status.success or window.holds(task.undeformed, approach):
                return Found(attrs.evolve(found.outcome, pressure=pressure), approach, met_limit)
            # The estimate was too low: the next window is larger, and knows where to start.
            task = attrs.evolve(task, start=pressure)
        found = self._solved(convolution, task)
        return attrs.evolve(found, met_limit=met_limit or found.met_limit)

    def _solved(self, convolution: PlannedConvolution, task: Task) -> Found:
        """Solve on all cells of the convolution."""
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
        return Found(outcome, state.approach, start.met_limit or refinement.met_limit)

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
