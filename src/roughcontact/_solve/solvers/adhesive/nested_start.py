"""Starts of an adhesive contact: from the contact without adhesion, from a coarser grid, or from another load."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Self

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._solve.solution import GridLevel
from roughcontact._solve.solvers.adhesive.descent import (
    AdhesiveDescent,
    GapProblem,
    gap_scale,
    hold_mean,
    make_gap_problem,
)
from roughcontact._solve.solvers.adhesive.stiffness import surface_stiffness
from roughcontact._solve.solvers.conjugate import ProjectedConjugateGradient
from roughcontact._solve.solvers.driver import Log, iterate
from roughcontact._solve.solvers.grids import GridProblem, Guess, interpolate, repeat_cells

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
        gap = self._gap_of_pressure(np.zeros_like(task.initial_gap) if task.start is None else task.start)
        if task.start_gap is not None:
            inside = self.problem.stiffness.inner(gap)
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
