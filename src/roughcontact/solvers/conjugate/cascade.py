"""From coarse grids to fine ones."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array
from roughcontact.convolvers import PlannedConvolution
from roughcontact.convolvers.inverse import inverse_of
from roughcontact.grid import Boundary, Grid
from roughcontact.solution import Level
from roughcontact.solvers.base import Monitor, Task, starting_pressure
from roughcontact.solvers.conjugate.refinement import Refinement

# Axes are halved as long as they keep this many cells; less is not worth a level.
_COARSEST = 32
# The approach is estimated on a grid with no more cells along an axis.
_ESTIMATE = 64
# A coarse pressure is as good as its grid, so that more than this is wasted on it.
_TOLERANCE = 1e-2
_ITERATIONS = 60


@attrs.frozen(eq=False)
class Start:
    """A pressure to start from.

    Attributes
    ----------
    pressure
        Pressure, shape (nx, ny), within the bounds.
    products
        Convolutions it took, in convolutions of the grid it is for.
    levels
        The work on each coarser grid.
    closed
        Whether it closes every gap, and is the solution.
    met_limit
        Whether a step on any coarser grid was cut short by the limit of the pressure.
    """

    pressure: Array
    products: float
    levels: tuple[Level, ...] = ()
    closed: bool = False
    met_limit: bool = False


def cascaded(convolution: PlannedConvolution, task: Task) -> Start:
    """Return the pressure of ever finer grids, down to the one of `task`."""
    grid = convolution.scene.grid
    halved = coarser(grid, task)
    if halved is None:
        return _first(convolution, task)
    coarse_grid, coarse_task = halved
    coarse = convolution.on(coarse_grid)
    fx, fy = _factors(grid, coarse_grid)
    start = cascaded(coarse, coarse_task)
    pressure, products, levels, met_limit = start.pressure, start.products, start.levels, start.met_limit
    if not start.closed:
        refinement = Refinement(coarse, coarse_task, Monitor(coarse_task, _TOLERANCE, _ITERATIONS))
        pressure, _, _ = refinement.run(start.pressure)
        products += refinement.products
        levels = (*levels, refinement.level)
        met_limit |= refinement.met_limit
    products /= fx * fy
    if pressure.min() > 0.0:
        full = full_contact(convolution, task)
        products += 1
        if full is not None:
            return Start(full, products, levels, closed=True)
    prolonged = np.minimum(_prolonged(pressure, fx, fy), task.limit)
    return Start(prolonged, products, levels, met_limit=met_limit)


def coarser(grid: Grid, task: Task) -> tuple[Grid, Task] | None:
    """Return the grid with every even axis halved that stays long enough, and its task; None if there is none."""
    shape = tuple(n // 2 if n % 2 == 0 and n // 2 >= _COARSEST else n for n in grid.shape)
    if shape == grid.shape:
        return None
    half = Grid(shape, grid.size)
    factors = _factors(grid, half)
    limit = task.limit if isinstance(task.limit, float) else _averaged(task.limit, *factors)
    return half, attrs.evolve(task, undeformed=_averaged(task.undeformed, *factors), limit=limit)


def estimated_approach(convolution: PlannedConvolution, task: Task) -> tuple[float | None, bool]:
    """Return the approach that a coarse grid gives for the load, and whether the limit cut its steps short.

    The approach is None if there is no coarse grid.
    """
    if task.approach is not None:
        return task.approach, False
    half = coarser(convolution.scene.grid, attrs.evolve(task, start=None))
    if half is None:
        return None, False
    while max(half[0].shape) > _ESTIMATE and (further := coarser(*half)) is not None:
        half = further
    coarse, coarse_task = convolution.on(half[0]), half[1]
    refinement = Refinement(coarse, coarse_task, Monitor(coarse_task, _TOLERANCE, _ITERATIONS))
    _, state, _ = refinement.run(_first(coarse, coarse_task).pressure)
    return state.approach, refinement.met_limit


def full_contact(convolution: PlannedConvolution, task: Task) -> Array | None:
    """Return the pressure that closes every gap of a periodic surface, if it is within the bounds."""
    if convolution.scene.boundary is not Boundary.PERIODIC or task.mean_pressure is None:
        return None
    pressure = task.mean_pressure - inverse_of(convolution.scene).apply(task.undeformed)
    within = pressure.min() >= 0.0 and not (pressure > task.limit).any()
    return pressure if within else None


def _first(convolution: PlannedConvolution, task: Task) -> Start:
    full = full_contact(convolution, task)
    tried = 1 if convolution.scene.boundary is Boundary.PERIODIC else 0
    return Start(starting_pressure(task) if full is None else full, tried, closed=full is not None)


def _factors(fine: Grid, coarse: Grid) -> tuple[int, int]:
    return fine.shape[0] // coarse.shape[0], fine.shape[1] // coarse.shape[1]


def _averaged(values: Array, fx: int, fy: int) -> Array:
    """Take the means of cells along the axes that are halved."""
    if fx == 2:
        values = values[0::2] + values[1::2]
    if fy == 2:
        values = values[:, 0::2] + values[:, 1::2]
    return np.ascontiguousarray(values) / (fx * fy)


def _prolonged(values: Array, fx: int, fy: int) -> Array:
    """Interpolate linearly between cell centres along the axes that were halved."""
    # The second axis first, while there are fewer rows: its steps are not contiguous.
    for axis, factor in ((1, fy), (0, fx)):
        if factor == 2:
            moved = np.moveaxis(values, axis, 0)
            fine = np.moveaxis(np.empty([n * (1 + (k == axis)) for k, n in enumerate(values.shape)]), axis, 0)
            quarter = 0.25 * moved
            np.multiply(moved, 0.75, out=fine[0::2])
            fine[1::2] = fine[0::2]
            fine[2::2] += quarter[:-1]
            fine[0] += quarter[-1]
            fine[1:-1:2] += quarter[1:]
            fine[-1] += quarter[0]
            values = np.moveaxis(fine, 0, axis)
    return values
