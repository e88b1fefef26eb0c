"""The same problem with its surfaces half a cell aside."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.body import Body
from roughcontact.checks import Array
from roughcontact.errors import InputError
from roughcontact.grid import Boundary, Grid
from roughcontact.problem import ContactProblem
from roughcontact.relief import repeats
from roughcontact.surfaces import HeightMap, PlacedMap, Surface
from roughcontact.surfaces.base import own_grid
from roughcontact.surfaces.sum import SurfaceSum

# Two evaluations of one surface at one place agree to this share of its range.
_SAME = 1e-9


def half_a_cell_aside(problem: ContactProblem) -> ContactProblem:
    """Return the problem with both surfaces moved by half a cell along both axes.

    Raises
    ------
    InputError
        If a surface is not known between its points or has holes, or the pressure limit is an array.
    """
    grid = problem.plan.grid
    if not isinstance(problem.plan.limit, float):
        raise InputError("The pressure limit is an array, which is not known between its cells.")
    if problem.plan.holes is not None:
        raise InputError("A surface has holes, whose place between the points is not known.")
    closed = problem.boundary is not Boundary.FREE
    body, counter = (
        Body(HeightMap(_moved(side.surface, grid, closed), size=grid.size), side.material)
        for side in (problem.body, problem.counter)
    )
    return attrs.evolve(problem, body=body, counter=counter, grid=grid)


def _moved(surface: Surface, grid: Grid, closed: bool) -> Array:
    """Return the heights of a surface, shape (nx, ny), m, half a cell aside."""
    aside = (0.5 * grid.spacing[0], 0.5 * grid.spacing[1])
    if isinstance(surface, SurfaceSum):
        return np.asarray(sum(_moved(part, grid, closed) for part in surface.parts))
    if isinstance(surface, PlacedMap):
        offset = (surface.offset[0] + aside[0], surface.offset[1] + aside[1])
        return attrs.evolve(surface, offset=offset).heights(grid)
    if isinstance(surface, HeightMap) and (surface.periodic or (closed and repeats(surface.values))):
        return PlacedMap(attrs.evolve(surface, periodic=True), offset=aside, method="fourier").heights(grid)
    name = type(surface).__name__
    if own_grid(surface) is not None:
        raise InputError(f"The surface {name} is not known between its points; of a periodic map it would be.")
    heights = surface.heights(grid)
    if _by_place(surface, grid, heights):
        # On one cell more along each axis the centres lie half a cell aside.
        return _enlarged(surface, grid, 1)[:-1, :-1]
    if not closed:
        raise InputError(f"The heights of {name} hang on the size of the domain, so that it cannot be moved.")
    return PlacedMap(HeightMap(heights, grid.size, periodic=True), offset=aside, method="fourier").heights(grid)


def _by_place(surface: Surface, grid: Grid, heights: Array) -> bool:
    """Tell whether the heights are a function of the place alone."""
    inner = _enlarged(surface, grid, 2)[1:-1, 1:-1]
    return bool(np.abs(inner - heights).max() <= _SAME * max(float(np.ptp(heights)), float(np.ptp(inner))))


def _enlarged(surface: Surface, grid: Grid, more: int) -> Array:
    (nx, ny), (dx, dy) = grid.shape, grid.spacing
    return surface.heights(Grid((nx + more, ny + more), ((nx + more) * dx, (ny + more) * dy)))
