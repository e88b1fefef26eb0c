"""The same problem on other grids, and ladders of ever finer ones."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs

from roughcontact._base.checks import integer
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.load import Load
from roughcontact._parts.surfaces import bilinear
from roughcontact._solve.problem import ContactProblem, require_memory_of_solve, resample_problem
from roughcontact._solve.solution import DEFAULT_AREA, Area, AreaEstimator, ContactSolution, areas
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.extrapolation import Extrapolation, exponential

# Doublings of a grid beyond which the size of the finest one is not computed: far beyond any memory.
_MOST_DOUBLINGS = 60


def require_problem(problem: ContactProblem) -> ContactProblem:
    """Return the problem, or raise `InputError` if it is something else."""
    if not isinstance(problem, ContactProblem):
        raise InputError.about("What is to be refined", problem, "a ContactProblem")
    return problem


@guarded
def on_grid(problem: ContactProblem, shape: tuple[int, int], interpolation: str | None = None) -> ContactProblem:
    """Return the problem on another number of cells over the same domain.

    Parameters
    ----------
    problem
        The problem.
    shape
        Cells (nx, ny).
    interpolation
        How height maps are interpolated between their points, as in `HeightMap.resample`; if None, periodic
        maps are taken as band-limited, and for others it must be given.

    Raises
    ------
    InputError
        If a surface is not known between the points of its grid, or the pressure limit is an array.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> finer = rc.on_grid(problem, (64, 64))
    >>> finer.grid.shape
    (64, 64)
    """
    return resample_problem(require_problem(problem), shape, interpolation)


@attrs.frozen(eq=False)
class Ladder:
    """Solutions of one contact on ever finer grids.

    Attributes
    ----------
    solutions
        From coarse to fine.
    estimator
        The area estimator.
    """

    solutions: tuple[ContactSolution, ...]
    estimator: str | AreaEstimator

    @property
    def cells(self) -> tuple[float, ...]:
        """Square roots of the cell counts."""
        return tuple(math.sqrt(solution.grid.cells) for solution in self.solutions)

    @property
    def areas(self) -> tuple[Area, ...]:
        """The estimator's area on each grid."""
        return tuple(solution.area(self.estimator) for solution in self.solutions)

    @property
    def eq_28(self) -> Extrapolation:
        """The paper's exponential through the counted areas, m2."""
        return exponential(self.cells, [solution.area("cell-count").value for solution in self.solutions])

    @property
    def area(self) -> Area:
        """The area on the finest grid: extrapolation makes it worse, because its error does not fall steadily."""
        return self.solutions[-1].area(self.estimator)

    @property
    def convolutions(self) -> int:
        """Convolutions of all solves, each on its own grid."""
        return sum(solution.convolutions for solution in self.solutions)

    def __str__(self) -> str:
        nominal = self.solutions[-1].grid.area
        rows = [
            (f"{solution.grid.shape[0]} x {solution.grid.shape[1]}", solution.area("cell-count").value, area)
            for solution, area in zip(self.solutions, self.areas, strict=True)
        ]
        lines = [f"{'cells':>12} {'counted, %':>12} {'estimated, %':>14} {'+-':>8}"]
        for name, counted, area in rows:
            values = 100 * counted / nominal, 100 * area.fraction, 100 * area.uncertainty / nominal
            lines.append("{:>12} {:>12.5g} {:>14.5g} {:>8.2g}".format(name, *values))
        return "\n".join((*lines, f"{'eq. 28':>12} {100 * self.eq_28.value / nominal:>12.5g}"))


@guarded
def extrapolate(
    problem: ContactProblem,
    *,
    pressure: float | None = None,
    force: float | None = None,
    approach: float | None = None,
    levels: int = 3,
    estimator: str | AreaEstimator = DEFAULT_AREA,
    interpolation: str | None = None,
) -> Ladder:
    """Return the solutions on the problem's grid and on ones with twice, four times, ... as many cells a side.

    Counted areas are extrapolated as the paper did it. The estimated area is that of the finest grid; where only an
    accuracy is wanted, ``solve(..., area_within=)`` finds the grid.

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
    interpolation
        How height maps are interpolated between their points, as in `on_grid`.

    Raises
    ------
    InputError
        If a surface is not known on the finer grids.
    NotConverged
        If a solution is not certified.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> print(rc.extrapolate(problem, force=1.0).area)
    (689.257 +- 0.017) µm2, (6.89257 +- 0.00017) % of nominal [blend]
    """
    levels = integer(levels, "The number of grids", at_least=2)
    areas.resolve(estimator)
    nx, ny = require_problem(problem).plan.grid.shape
    load = Load.of(pressure=pressure, force=force, approach=approach)
    # A finest grid that does not fit into memory is refused before the others are made.
    finest = min(levels - 1, _MOST_DOUBLINGS)
    require_memory_of_solve(
        Grid((nx << finest, ny << finest), problem.plan.grid.size), problem.boundary, problem.memory_limit
    )
    rungs = [problem, *(on_grid(problem, (nx << level, ny << level), interpolation) for level in range(1, levels))]
    return solve_ladder(rungs, load, estimator)


def solve_ladder(
    problems: Sequence[ContactProblem], load: Load, estimator: str | AreaEstimator = DEFAULT_AREA
) -> Ladder:
    """Return the solutions of a problem on ever finer grids, each starting from the pressure of the one before."""
    solutions: list[ContactSolution] = []
    for problem in problems:
        start = None
        if solutions:
            periodic = problem.boundary is not Boundary.FREE
            start = bilinear(solutions[-1].pressure, problem.plan.grid.shape, periodic=periodic)
        solutions.append(problem.solve(**load.arguments, start=start))
    return Ladder(tuple(solutions), estimator)
