"""Refinement around the contacts alone.

Each contact and its surroundings, a patch, is solved on a finer grid, while the coarse grid carries
what the patches do to each other. Where patches are too many to gain anything the whole domain is
solved on the finer grid instead.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact.checks import Array, integer
from roughcontact.errors import InputError
from roughcontact.grid import Boundary
from roughcontact.kernels import OffersCoefficients
from roughcontact.problem import ContactProblem
from roughcontact.refinement.finer import on_grid, require_problem
from roughcontact.refinement.patches import Field, Patch, boxes_around
from roughcontact.solution import DEFAULT_AREA, Area, ContactSolution, EstimatesArea

# Passes are about so many; each costs a patch as much as so many cells of the whole domain, and as twice
# its own cells, for its boundary is free.
_EXPECTED = 5
_START = 10_000
_PADDED = 2
_PASSES = 25
# Relative error of the load at which the passes end.
_LOAD = 2e-5
# Share of the load that the last pass may have moved.
_SETTLED = 1e-4


@attrs.frozen(eq=False)
class Refined:
    """A contact on a grid that is finer where it touches.

    Attributes
    ----------
    solutions
        The patches' solutions, or the one of the whole domain.
    factor
        Fine cells in a coarse one, along each axis.
    passes
        How often the patches were solved; zero where the whole domain was.
    nominal
        Nominal area of the domain, m2.
    approach
        Approach of the bodies, m.
    """

    solutions: tuple[ContactSolution, ...]
    factor: int
    passes: int
    nominal: float
    approach: float

    @property
    def local(self) -> bool:
        """Whether only patches were solved."""
        return self.passes > 0

    @property
    def force(self) -> float:
        """Normal force, N."""
        return sum(solution.force for solution in self.solutions)

    def area(self, estimator: str | EstimatesArea = DEFAULT_AREA) -> Area:
        """Return the real contact area of all patches; the uncertainties add up as if they were alike."""
        areas = [solution.area(estimator) for solution in self.solutions]
        if len(areas) == 1 and not self.local:
            return areas[0]
        value = math.fsum(area.value for area in areas)
        bar = math.fsum(area.uncertainty for area in areas)
        name = areas[0].estimator if areas else str(estimator)
        doubts = tuple(dict.fromkeys(doubt for area in areas for doubt in area.doubts))
        perimeter = math.fsum(area.perimeter for area in areas)
        return Area(value, value / self.nominal, bar, f"{name}, refined", perimeter=perimeter, doubts=doubts)


def refine(
    problem: ContactProblem,
    *,
    pressure: float | None = None,
    force: float | None = None,
    approach: float | None = None,
    factor: int = 4,
    between: str | None = None,
) -> Refined:
    """Solve, and solve again around the contacts on a grid that is finer by a factor.

    Parameters
    ----------
    problem
        The problem on the coarse grid.
    pressure, force, approach
        Exactly one: nominal mean pressure, Pa; normal force, N; approach since first touch, m.
    factor
        Fine cells in a coarse one, along each axis.
    between
        How height maps go on between their points, as in `HeightMap.resample`; if left out, periodic
        maps are taken as band-limited, and for others it must be said.

    Raises
    ------
    InputError
        If a surface is not known between the points of its grid.
    NotConverged
        If a solution is not certified.
    """
    factor = integer(factor, "The factor of the refinement", at_least=2)
    nx, ny = require_problem(problem).plan.grid.shape
    finer = on_grid(problem, (nx * factor, ny * factor), between)
    coarse = problem.solve(pressure=pressure, force=force, approach=approach)
    found = None
    if isinstance(problem.plan.kernel, OffersCoefficients) and problem.boundary is not Boundary.WRAPPED:
        found = _by_patches(problem, finer, coarse, factor, approach)
    if found is not None:
        return found
    whole = finer.solve(pressure=pressure, force=force, approach=approach)
    return Refined((whole,), factor, 0, problem.plan.grid.area, whole.approach)


def _by_patches(
    problem: ContactProblem, finer: ContactProblem, coarse: ContactSolution, factor: int, approach: float | None
) -> Refined | None:
    """Return the contact refined by patches; None where that is no use or does not settle."""
    field = Field(problem, finer, coarse, factor)
    reached = field.approach if approach is None else approach
    boxes = boxes_around(field.touching(reached), problem.boundary)
    if boxes is None or not _worth(sum(box.cells for box in boxes) * factor**2, len(boxes), finer.plan.grid.cells):
        return None
    patches = [Patch(field, box) for box in boxes]
    history: list[tuple[float, float]] = []
    before: Array = field.pressure
    for passes in range(1, _PASSES + 1):
        displacement = field.displacement
        solutions = [found for patch in patches if (found := patch.solved(reached, displacement)) is not None]
        if not all(solution.status.success for solution in solutions):
            return None
        field.pressure = field.gathered(patches)
        carried = math.fsum(solution.force for solution in solutions)
        change = float(np.abs(field.pressure - before).sum()) * problem.plan.grid.cell_area
        before = field.pressure
        missing = 0.0 if approach is not None else coarse.force - carried
        if change <= _SETTLED * carried and abs(missing) <= _LOAD * coarse.force:
            whole = field.covers(boxes, reached)
            return Refined(tuple(solutions), factor, passes, problem.plan.grid.area, reached) if whole else None
        if missing:
            history.append((reached, carried))
            reached += missing / _stiffness(history, solutions)
    return None


def _worth(cells: int, patches: int, whole: int) -> bool:
    """Tell whether patches of so many fine cells are less work than the whole domain."""
    return _EXPECTED * (patches * _START + _PADDED * cells) < whole


def _stiffness(history: list[tuple[float, float]], solutions: list[ContactSolution]) -> float:
    """Return how the load grows with the approach: by the last two passes, or as for separate punches, N/m."""
    punches = sum(
        2.0 * solution.modulus * float(np.sum(np.sqrt(solution.clusters.areas / np.pi))) for solution in solutions
    )
    if len(history) > 1:
        (one, first), (other, second) = history[-2:]
        if one != other and 0.1 * punches < (second - first) / (other - one) < 10.0 * punches:
            return (second - first) / (other - one)
    if punches == 0.0:
        raise InputError("No patch of the refinement is in contact: choose a finer grid to begin with.")
    return punches
