"""The same problem on another number of cells."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from roughcontact._base.checks import choice
from roughcontact._parts.grid import Grid
from roughcontact._solve.problem.body import Body
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._solve.problem.problem import ContactProblem


def resample_problem(
    problem: ContactProblem, shape: tuple[int, int], interpolation: str | None = None
) -> ContactProblem:
    """Return the problem on another number of cells; see `roughcontact.on_grid`."""
    grid = Grid(shape, problem.plan.grid.size)
    if interpolation is not None:
        choice(interpolation, "The interpolation of a map between its points", ("bilinear", "cubic", "fourier", "mean"))
    if problem.plan.pressure_limit.ndim:
        raise InputError("The pressure limit is an array, which is not known between its cells.")
    body, counterbody = (
        Body(side.surface.resample_to(grid, interpolation), side.material)
        for side in (problem.body, problem.counterbody)
    )
    return attrs.evolve(problem, body=body, counterbody=counterbody, grid=grid)
