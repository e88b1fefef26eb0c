"""Ladders of grids, and what they tell of the infinitely fine one."""

from __future__ import annotations

import math

import attrs

from roughcontact.checks import integer
from roughcontact.extrapolation import Extrapolation, exponential, richardson
from roughcontact.grid import Boundary, Grid
from roughcontact.problem import ContactProblem
from roughcontact.refinement.finer import on_grid, require_problem
from roughcontact.registry import areas
from roughcontact.solution import DEFAULT_AREA, Area, ContactSolution, EstimatesArea
from roughcontact.surfaces.resampling import bilinear

# Corrected areas gain this order or more when a grid is refined; the least keeps the error honest.
_ORDER = 2.0


@attrs.frozen(eq=False)
class Ladder:
    """Solutions of one contact on ever finer grids.

    Attributes
    ----------
    solutions
        From coarse to fine.
    estimator
        The area estimator that is extrapolated.
    """

    solutions: tuple[ContactSolution, ...]
    estimator: str | EstimatesArea

    @property
    def cells(self) -> tuple[float, ...]:
        """Square roots of the cell counts."""
        return tuple(math.sqrt(solution.grid.cells) for solution in self.solutions)

    @property
    def areas(self) -> tuple[Area, ...]:
        """The estimator's area on each grid."""
        return tuple(solution.area(self.estimator) for solution in self.solutions)

    @property
    def richardson(self) -> Extrapolation:
        """Richardson's extrapolation of those areas at second order, m2."""
        return richardson(self.cells, [area.value for area in self.areas], _ORDER)

    @property
    def eq_28(self) -> Extrapolation:
        """The paper's exponential through the counted areas, m2."""
        return exponential(self.cells, [solution.area("cell-count").value for solution in self.solutions])

    @property
    def area(self) -> Area:
        """The extrapolated area.

        Where the finest two grids agree within the finest one's uncertainty there is nothing to
        extrapolate, and the finest stands. The uncertainty is the step beyond it, and no less than its own.
        """
        coarse, fine = self.areas[-2:]
        nominal = self.solutions[-1].grid.area
        if abs(fine.value - coarse.value) <= fine.uncertainty:
            return attrs.evolve(fine, estimator=f"{fine.estimator}, finest of {len(self.solutions)}")
        value = min(max(self.richardson.value, 0.0), nominal)
        bar = max(abs(value - fine.value), fine.uncertainty)
        doubts = tuple(dict.fromkeys((*fine.doubts, *self.richardson.warnings)))
        return Area(value, value / nominal, bar, f"{fine.estimator}, extrapolated", doubts=doubts)

    @property
    def convolutions(self) -> int:
        """Convolutions of all solves, each on its own grid."""
        return sum(solution.convolutions for solution in self.solutions)

    def __str__(self) -> str:
        lines = [f"{'cells':>12} {'counted, %':>12} {'estimated, %':>14} {'+-':>8}"]
        for solution, area in zip(self.solutions, self.areas, strict=True):
            nx, ny = solution.grid.shape
            counted = 100 * solution.area("cell-count").fraction
            bar = 100 * area.uncertainty / solution.grid.area
            lines.append(f"{f'{nx} x {ny}':>12} {counted:>12.5g} {100 * area.fraction:>14.5g} {bar:>8.2g}")
        nominal = self.solutions[-1].grid.area
        bar = 100 * self.area.uncertainty / nominal
        eq_28 = 100 * self.eq_28.value / nominal
        lines.append(f"{'extrapolated':>12} {eq_28:>12.5g} {100 * self.area.fraction:>14.5g} {bar:>8.2g}")
        return "\n".join(lines)


def extrapolate(
    problem: ContactProblem,
    *,
    pressure: float | None = None,
    force: float | None = None,
    approach: float | None = None,
    levels: int = 3,
    estimator: str | EstimatesArea = DEFAULT_AREA,
    between: str | None = None,
) -> Ladder:
    """Solve on the problem's grid and on ones with twice, four times, ... as many cells a side.

    Each starts from the pressure of the one before, so that all together cost little more than the
    finest.

    Parameters
    ----------
    problem
        The problem on the coarsest grid.
    pressure, force, approach
        Exactly one: nominal mean pressure, Pa; normal force, N; approach since first touch, m.
    levels
        Number of grids, at least two.
    estimator
        Registered name or instance of the area estimator.
    between
        How height maps go on between their points, as in `HeightMap.resample`.

    Raises
    ------
    InputError
        If a surface is not known on the finer grids.
    NotConverged
        If a solution is not certified.
    """
    levels = integer(levels, "The number of grids", at_least=2)
    areas.resolve(estimator, EstimatesArea)
    nx, ny = require_problem(problem).plan.grid.shape
    # A finest grid that memory does not bear is refused before the others are made.
    finest = min(levels - 1, 60)
    Grid((nx << finest, ny << finest), problem.plan.grid.size)
    rungs = [problem, *(on_grid(problem, (nx << level, ny << level), between) for level in range(1, levels))]
    solutions: list[ContactSolution] = []
    for rung in rungs:
        start = None
        if solutions:
            closed = rung.boundary is not Boundary.FREE
            start = bilinear(solutions[-1].pressure, rung.plan.grid.shape, periodic=closed)
        solutions.append(rung.solve(pressure=pressure, force=force, approach=approach, start=start))
    return Ladder(tuple(solutions), estimator)
