"""The same problem on another grid."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.body import Body
from roughcontact.checks import choice
from roughcontact.errors import InputError
from roughcontact.grid import Grid
from roughcontact.problem import ContactProblem
from roughcontact.surfaces import HeightMap, Surface
from roughcontact.surfaces.base import own_grid
from roughcontact.surfaces.sum import SurfaceSum


def on_grid(problem: ContactProblem, shape: tuple[int, int], between: str | None = None) -> ContactProblem:
    """Return the problem on another number of cells over the same domain.

    Parameters
    ----------
    problem
        The problem.
    shape
        Cells (nx, ny).
    between
        How height maps go on between their points, as in `HeightMap.resample`; if left out, periodic
        maps are taken as band-limited, and for others it must be said.

    Raises
    ------
    InputError
        If a surface is not known between the points of its grid, or the pressure limit is an array.
    """
    grid = Grid(shape, problem.plan.grid.size)
    if between is not None:
        choice(between, "The way a map goes on between its points", ("bilinear", "cubic", "fourier", "mean"))
    if np.ndim(problem.plan.limit) > 0:
        raise InputError("The pressure limit is an array, which is not known between its cells.")
    body, counter = (
        Body(_known(side.surface, grid, between), side.material) for side in (problem.body, problem.counter)
    )
    return attrs.evolve(problem, body=body, counter=counter, grid=grid)


def require_problem(problem: ContactProblem) -> ContactProblem:
    """Raise `InputError` if it is no problem."""
    if not isinstance(problem, ContactProblem):
        raise InputError.about("What is to be refined", problem, "a ContactProblem")
    return problem


def _known(surface: Surface, grid: Grid, between: str | None) -> Surface:
    """Return the surface in a form that has heights on the grid."""
    if isinstance(surface, HeightMap):
        if surface.grid.matches(grid):
            return surface
        if between is None and not surface.periodic:
            raise InputError(
                "A height map that is not periodic is not known between its points: say between='bilinear' to "
                "take it as linear there, or periodic=True if the map is."
            )
        return surface.resample(grid.shape, between or "fourier")
    if isinstance(surface, SurfaceSum):
        return SurfaceSum(tuple(_known(part, grid, between) for part in surface.parts))
    if own_grid(surface) is not None:
        raise InputError(f"The surface {type(surface).__name__} is not known between the points of its grid.")
    return surface
