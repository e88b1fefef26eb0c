"""The same problem on ever finer grids, and waves beyond the resolution of maps.

Scripts call `on_grid`, `extrapolate` and `beyond_resolution`; reports call `on_grid` and `solve_ladder`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from statistics import NormalDist
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import callback, integer, number
from roughcontact._base.tables import Table, TableResult
from roughcontact._base.units import Estimate, Force, Length, Pressure, ShownAsPrinted, si
from roughcontact._parts.grid import Grid, Load
from roughcontact._parts.surfaces import Continuation, cells_for, find_maps, rms_slope
from roughcontact._solve.problem import (
    Body,
    ContactProblem,
    interpolate_pressure,
    march,
    require_memory_of_solve,
    resample_problem,
)
from roughcontact._solve.solution import DEFAULT_AREA, Area, AreaEstimator, ContactSolution, areas
from roughcontact._solve.solvers import Step
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.extrapolation import Extrapolation, exponential

# Largest number of doublings for which the size of the finest grid is computed: far beyond any memory.
_MAX_DOUBLINGS = 60
# Cells of the shortest wave that the grid of a map can hold, which is the longest cut-off.
_NYQUIST_CELLS = 2.0
# Largest number of realizations: with more, their mean and spread gain nothing.
_MAX_REALIZATIONS = 1000
# Standard deviations on both sides of the mean that the range of the area contains.
_RANGE_STDS = 2.0


def _require_problem(problem: ContactProblem) -> ContactProblem:
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
    return resample_problem(_require_problem(problem), shape, interpolation)


@attrs.frozen(eq=False)
class Ladder(TableResult):
    """Solutions of one contact on ever finer grids.

    Attributes
    ----------
    states
        From coarse to fine.
    estimator
        The area estimator.
    """

    states: tuple[ContactSolution, ...]
    estimator: str | AreaEstimator

    @property
    def cells(self) -> tuple[float, ...]:
        """Square roots of the cell counts."""
        return tuple(math.sqrt(solution.grid.cells) for solution in self.states)

    @property
    def areas(self) -> tuple[Area, ...]:
        """The estimator's area on each grid."""
        return tuple(solution.area(self.estimator) for solution in self.states)

    @property
    def eq_28(self) -> Extrapolation:
        """The paper's exponential through the counted areas, m2."""
        return exponential(
            self.cells, [solution.area("cell-count", uncertainty="model").value for solution in self.states]
        )

    @property
    def area(self) -> Area:
        """The area on the finest grid: extrapolation makes it worse, because its error does not fall steadily."""
        return self.states[-1].area(self.estimator)

    @property
    def convolutions(self) -> int:
        """Convolutions of all solves, each on its own grid."""
        return sum(solution.convolutions for solution in self.states)

    def table(self) -> Table:
        """Return a row for each grid, with its counted and estimated area; see `roughcontact.typing.Table`."""
        shapes = np.array([state.grid.shape for state in self.states])
        counted = np.array([state.area("cell-count", uncertainty="model").value for state in self.states])
        areas = [Estimate(area.value, area.uncertainty, "m2", area.warnings) for area in self.areas]
        return Table({"nx": shapes[:, 0], "ny": shapes[:, 1], "counted": counted, "area": areas}, {"counted": "m2"})

    def short_table(self) -> Table:
        """Return a row for each grid for people, the areas in percent of nominal."""
        percent = 100.0 / self.states[-1].grid.area
        columns: dict[str, Any] = {
            "cells": [" x ".join(map(str, state.grid.shape)) for state in self.states],
            "counted, %": [
                f"{percent * state.area('cell-count', uncertainty='model').value:.5g}" for state in self.states
            ],
            "estimated, %": [Estimate(percent * area.value, percent * area.uncertainty, "") for area in self.areas],
        }
        return Table(columns)

    def _list_results(self) -> Mapping[str, str]:
        return {"eq. 28": f"{100.0 * self.eq_28.value / self.states[-1].grid.area:.5g} %"}


@guarded
def extrapolate(
    problem: ContactProblem,
    *,
    pressure: Pressure | None = None,
    force: Force | None = None,
    approach: Length | None = None,
    levels: int = 3,
    estimator: str | AreaEstimator = DEFAULT_AREA,
    interpolation: str | None = None,
    on_step: Callable[[Step], None] | None = None,
) -> Ladder:
    """Return the solutions on the problem's grid and on grids with twice, four times, ... as many cells a side.

    Counted areas are extrapolated as in the paper. The estimated area is the one on the finest grid; for a wanted
    accuracy, take ``solve(..., area_within=)``, which finds the grid.

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
    on_step
        Called with a `Step` after each iteration.

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
    >>> print(rc.extrapolate(problem, force=1.2).area)
    (778.328 +- 0.023) µm2, (7.78328 +- 0.00023) % of nominal [blend]
    """
    levels = integer(levels, "The number of grids", at_least=2)
    on_step = callback(on_step, "on_step=", "step")
    areas.resolve(estimator)
    nx, ny = _require_problem(problem).plan.grid.shape
    load = Load.of(pressure=pressure, force=force, approach=approach)
    # A finest grid that does not fit into memory is refused before the others are made.
    finest = min(levels - 1, _MAX_DOUBLINGS)
    require_memory_of_solve(
        Grid((nx << finest, ny << finest), problem.plan.grid.size), problem.boundary, problem.memory_limit
    )
    rungs = [problem, *(on_grid(problem, (nx << level, ny << level), interpolation) for level in range(1, levels))]
    return solve_ladder(rungs, load, estimator, on_step)


def solve_ladder(
    problems: Sequence[ContactProblem],
    load: Load,
    estimator: str | AreaEstimator = DEFAULT_AREA,
    on_step: Callable[[Step], None] | None = None,
) -> Ladder:
    """Return the solutions of a problem on ever finer grids, each starting from the pressure of the one before."""

    def refine(coarser: Sequence[ContactSolution], problem: ContactProblem) -> ContactSolution:
        start = interpolate_pressure(coarser[-1], problem) if coarser else None
        return problem.solve(**load.arguments, start=start, on_step=on_step)

    return Ladder(tuple(march(problems, refine)), estimator)


@attrs.frozen(eq=False)
class BeyondResolution(ShownAsPrinted):
    """The contact area of a measured map with random short waves; `str` of it is a table.

    Attributes
    ----------
    wavelengths
        The shortest wave of each part of the ensemble, m, descending.
    areas
        The area of each realization, for each of the wavelengths.
    rms_slopes
        Mean rms slope of the gap, for each of the wavelengths.
    measured
        The area with the maps as given, without random waves.
    cell
        Largest cell of the maps, m.
    """

    wavelengths: tuple[float, ...]
    areas: tuple[tuple[Area, ...], ...]
    rms_slopes: tuple[float, ...]
    measured: Area
    cell: float

    @property
    def means(self) -> Array:
        """Mean area for each of the wavelengths, m2."""
        return np.array([np.mean([area.value for area in areas]) for areas in self.areas])

    @property
    def stds(self) -> Array:
        """Standard deviation of the area for each wavelength, m2: of the realizations and by their uncertainties."""
        spread = [np.std([area.value for area in areas], ddof=1) for areas in self.areas]
        return np.hypot(spread, [np.sqrt(np.mean([area.uncertainty**2 for area in areas])) for areas in self.areas])

    @property
    def range(self) -> tuple[float, float]:
        """The smallest and the largest area for waves down to any of the wavelengths, m2: two standard deviations."""
        low = self.means - _RANGE_STDS * self.stds
        high = self.means + _RANGE_STDS * self.stds
        return max(0.0, float(low.min())), float(high.max())

    def __repr__(self) -> str:
        return f"<BeyondResolution {str(self).splitlines()[-1]}>"

    def __str__(self) -> str:
        nominal = self.measured.value / self.measured.fraction if self.measured.fraction else 0.0
        lines = ["   shortest wave   cells  rms slope         area         +-  of nominal, %"]
        row = "{:>16} {:>7} {:>10} {:>12} {:>10} {:>14.4g}"
        area = si(self.measured.value, "m2")
        std = si(self.measured.uncertainty, "m2", 2)
        lines.append(row.format("as measured", "", "", area, std, 100.0 * self.measured.fraction))
        for wave, slope, mean, std in zip(self.wavelengths, self.rms_slopes, self.means, self.stds, strict=True):
            texts = si(wave, "m"), f"{wave / self.cell:.3g}", f"{slope:.3g}", si(mean, "m2"), si(std, "m2", 2)
            lines.append(row.format(*texts, 100.0 * mean / nominal))
        low, high = self.range
        return "\n".join([*lines, f"area from {si(low, 'm2')} to {si(high, 'm2')}"])


@guarded
def beyond_resolution(
    problem: ContactProblem,
    *,
    pressure: Pressure | None = None,
    force: Force | None = None,
    cutoffs: Sequence[float] = (1.0, 0.5),
    realizations: int = 4,
    resolved: float | None = None,
    seed: int = 0,
) -> BeyondResolution:
    """Return how the contact area depends on waves that the height maps of a problem do not resolve.

    The power law of the spectrum is fitted over two octaves of the shortest resolved waves, and continued. In each
    realization longer waves are as measured, shorter ones random; the power law varies by its standard error. The
    grid has four cells on the shortest wave.

    Parameters
    ----------
    problem
        A problem with height maps.
    pressure, force
        Exactly one: nominal mean pressure, Pa; normal force, N.
    cutoffs
        Where the spectrum ends: shortest wavelengths in cells of the (coarsest) map, at most two.
    realizations
        Random surfaces for each cut-off, at least two.
    resolved
        Shortest wavelength that the maps resolve, m; by default four cells of each map: shorter waves are blurred,
        or aliased, in most measurements.
    seed
        Seed of the random waves.

    Raises
    ------
    InputError
        If the problem has no height maps, their spectrum does not fall, or the finest grid does not fit into memory.
    NotConverged
        If a solution is not certified.

    References
    ----------
    Persson, Surf. Sci. Rep. 61 (2006) 201, https://doi.org/10.1016/j.surfrep.2006.04.001 (area and magnification)

    Jacobs, Junge, Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001, https://doi.org/10.1088/2051-672X/aa51f8
    (spectra, and down to which wavelength they can be relied on)

    Examples
    --------
    >>> import roughcontact as rc
    >>> rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=40e-6, seed=1)
    >>> map_ = rc.HeightMap(rough.heights(rc.Grid((48, 48), 48e-6)), size=48e-6, periodic=True)
    >>> problem = rc.ContactProblem(rc.Body(map_, rc.Elastic(210e9, 0.3)), boundary="periodic")
    >>> found = rc.beyond_resolution(problem, pressure=100e6, cutoffs=(2.0,), realizations=2)
    >>> len(found.areas)
    1
    """
    if not isinstance(problem, ContactProblem):
        raise InputError.about("The problem", problem, "a ContactProblem")
    load = Load.of(pressure=pressure, force=force)
    count = integer(realizations, "The number of realizations", at_least=2)
    if count > _MAX_REALIZATIONS:
        raise InputError.about("The number of realizations", count, f"at most {_MAX_REALIZATIONS}")
    sides = problem.body.surface, problem.counterbody.surface
    maps = [found for surface in sides for found in find_maps(surface)]
    if not maps:
        raise InputError("The problem has no height map: its surfaces are known at every point.")
    cell = max(max(found.grid.resolved.spacing) for found in maps)
    waves = _list_wavelengths(cutoffs, cell)
    if resolved is not None:
        resolved = number(resolved, "The shortest resolved wavelength", "m", at_least=_NYQUIST_CELLS * cell)
    seed = integer(seed, "The seed", at_least=0)
    finest = Grid(cells_for(problem.plan.grid.size, waves[-1]), problem.plan.grid.size)
    require_memory_of_solve(finest, problem.boundary, problem.memory_limit)
    measured = problem.solve(**load.arguments).area(uncertainty="model")
    # Deviations of the spectrum at equal probabilities, so that a few realizations have its standard deviation.
    deviations = [NormalDist().inv_cdf((index + 0.5) / count) for index in range(count)]
    areas = []
    slopes = []
    for wave in waves:
        drawn = [
            _extend(problem, Continuation(wave, waves[-1], resolved, (seed, index), deviation)).solve(**load.arguments)
            for index, deviation in enumerate(deviations)
        ]
        areas.append(tuple(solution.area(uncertainty="model") for solution in drawn))
        slopes.append(float(np.mean([rms_slope(solution.initial_gap, solution.grid) for solution in drawn])))
    return BeyondResolution(waves, tuple(areas), tuple(slopes), measured, cell)


def _list_wavelengths(cutoffs: Sequence[float], cell: float) -> tuple[float, ...]:
    if not isinstance(cutoffs, (tuple, list, np.ndarray)) or np.ndim(cutoffs) != 1:
        raise InputError.about("The cut-offs", cutoffs, "a list of wavelengths in cells of the map, such as [1, 0.5]")
    cells = {number(value, "A cut-off", "cells of the map", above=0.0, at_most=_NYQUIST_CELLS) for value in cutoffs}
    if not cells:
        raise InputError("The list of cut-offs is empty: give at least one.")
    return tuple(sorted((value * cell for value in cells), reverse=True))


def _extend(problem: ContactProblem, continuation: Continuation) -> ContactProblem:
    """Return the problem with continued maps, on a grid that resolves their shortest wave."""
    if problem.plan.pressure_limit.ndim:
        raise InputError("The pressure limit is an array, which is not known between its cells.")
    size = problem.plan.grid.size
    first = continuation.extend(problem.body.surface)
    second = continuation.extend(problem.counterbody.surface, len(find_maps(problem.body.surface)))
    return attrs.evolve(
        problem,
        body=Body(first, problem.body.material),
        counterbody=Body(second, problem.counterbody.material),
        grid=Grid(cells_for(size, continuation.shortest), size),
    )
