"""The states of a film law: contact and flow of a rough pair at separations of its mean planes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import attrs
import numpy as np

from roughcontact._answers.flow.faces import find_creases
from roughcontact._answers.flow.factors import FlowFactors, find_flow_factors
from roughcontact._base.arrays import Array, Mask
from roughcontact._base.units import WarningText
from roughcontact._parts.grid import Load
from roughcontact._parts.surfaces import FlatSurface, HeightMap
from roughcontact._solve.problem import Body, ContactProblem, run_solve, solve_from_largest
from roughcontact._solve.solution import ContactSolution

# Relative uncertainty from which a flow factor gets a warning, and the factor below which nothing flows to speak of.
_MAX_RELATIVE_STD = 0.1
_MIN_FACTOR = 0.05
# Difference from its mirror image, over the rms height, up to which a map was mirrored at its borders.
_MIRRORED = 1e-6


@attrs.frozen(eq=False)
class FilmRow:
    """The pair at one separation.

    Attributes
    ----------
    pressure, area, film
        Mean pressure of the asperities, Pa, real over nominal area, and mean gap that liquid fills, m.
    area_std, film_std
        Their uncertainties.
    gap_std
        The uncertainty of the separation at this pressure, m.
    factors
        Flow factors, with wall 1 rough.
    texts
        Warnings.
    """

    pressure: float
    area: float
    film: float
    area_std: float
    film_std: float
    gap_std: float
    factors: FlowFactors
    texts: tuple[str, ...]


def solve_rows(
    problem: ContactProblem, separations: Sequence[float], tell: Callable[[], object] | None = None
) -> list[FilmRow]:
    """Return the rows at separations in m, solved from the smallest up."""
    mean = float(np.mean(problem.initial_gap))
    rows: dict[int, FilmRow] = {}
    touching = [place for place, separation in enumerate(separations) if separation < mean]
    loads = [Load("approach", mean - separations[place]) for place in touching]
    for index, solution in solve_from_largest(partial(run_solve, problem), loads) if loads else ():
        place = touching[index]
        rows[place] = _read_state(solution, separations[place])
        if tell:
            tell()
    for place in sorted(set(range(len(separations))) - set(touching)):
        rows[place] = _read_open_gap(problem, separations[place], mean)
        if tell:
            tell()
    return [rows[place] for place in range(len(separations))]


def _read_state(solution: ContactSolution, separation: float) -> FilmRow:
    area = solution.area(uncertainty="model")
    nominal = solution.grid.area
    open_cells = ~solution.contact & (solution.gap > 0.0)
    error = solution.residuals.error * solution.residuals.scale
    factors = find_flow_factors(
        solution.gap,
        open_cells,
        solution.grid,
        separation,
        creased=find_creases(solution.initial_gap),
        gap_error=error,
    )
    mean_gap = solution.response("mean-gap", uncertainty="model")
    # The law itself says what a tip has not touched of the points.
    of_state = [text for text in solution.warnings if getattr(text, "rule", "") != "stylus"]
    texts = tuple(dict.fromkeys(map(str, (*of_state, *area.warnings, *_judge_factors(factors)))))
    return FilmRow(
        pressure=solution.mean_pressure,
        area=area.fraction,
        film=_fill(solution.gap, open_cells),
        area_std=area.uncertainty / nominal,
        film_std=error,
        gap_std=mean_gap.uncertainty,
        factors=factors,
        texts=texts,
    )


def _read_open_gap(problem: ContactProblem, separation: float, mean: float) -> FilmRow:
    gap = problem.initial_gap + (separation - mean)
    open_cells = gap > 0.0
    factors = find_flow_factors(gap, open_cells, problem.plan.grid, separation, creased=find_creases(gap))
    return FilmRow(0.0, 0.0, _fill(gap, open_cells), 0.0, 0.0, 0.0, factors, tuple(_judge_factors(factors)))


def _fill(gap: Array, open_cells: Mask) -> float:
    return float(np.sum(gap, where=open_cells)) / gap.size


def _judge_factors(factors: FlowFactors) -> list[str]:
    """Return why the flow along an axis must not be trusted."""
    found: list[str] = []
    for axis, name in enumerate("xy"):
        value = float(factors.pressure[axis, axis])
        relative = float(factors.pressure_std[axis, axis]) / value if value > _MIN_FACTOR else 0.0
        if relative > _MAX_RELATIVE_STD:
            text = f"The grid hardly determines the flow along {name}: refine the grid."
            found.append(WarningText(text, f"flow along {name}", relative))
    return found


def make_quarters(problem: ContactProblem) -> list[ContactProblem]:
    """Return the problems of the four quarters of the pair, each repeated beyond its borders; none of small grids.

    Mirror images are no other places: of a pair that was mirrored at its borders the quarters are those of one image.
    """
    grid = problem.plan.grid
    heights = _take_one_image(-problem.initial_gap)
    halves = tuple(count // 2 for count in heights.shape)
    if min(halves) < 2:
        return []
    size = tuple(half * step for half, step in zip(halves, grid.spacing, strict=True))
    found = []
    for i in (0, heights.shape[0] - halves[0]):
        for j in (0, heights.shape[1] - halves[1]):
            part = heights[i : i + halves[0], j : j + halves[1]]
            body = Body(HeightMap(part, size=size, periodic=True), problem.body.material)
            counterbody = Body(FlatSurface(), problem.counterbody.material)
            found.append(attrs.evolve(problem, body=body, counterbody=counterbody, grid=None))
    return found


def _take_one_image(heights: Array) -> Array:
    """Return the half along each axis of heights that are their own mirror image there."""
    for axis in _list_mirrored_axes(heights):
        heights = np.take(heights, range((heights.shape[axis] + 1) // 2), axis)
    return heights


def _list_mirrored_axes(heights: Array) -> list[int]:
    """Return the axes along which heights are their own mirror image."""
    limit = _MIRRORED * float(np.std(heights))
    return [axis for axis in (0, 1) if np.abs(heights - np.flip(heights, axis)).max() <= limit]


def find_wall_shear(heights: Array, separation: float, problem: ContactProblem) -> FlowFactors | None:
    """Return the factors of a wall alone at a separation, m, from a smooth one; None if they would touch."""
    gap = separation - (heights - np.mean(heights))
    if not gap.min() > 0.0:
        return None
    open_cells = np.ones(gap.shape, dtype=bool)
    return find_flow_factors(gap, open_cells, problem.plan.grid, separation, creased=find_creases(gap))


def count_waves(heights: Array) -> tuple[float, float]:
    """Return the mean number of waves along each side, weighted with the power of the heights.

    Of a domain that was mirrored at its borders those of one image count: the others are the same once more.
    """
    power = np.abs(np.fft.fft2(heights - np.mean(heights))) ** 2
    total = float(power.sum())
    if total == 0.0:
        return math.inf, math.inf
    numbers = [np.abs(np.fft.fftfreq(count, 1.0 / count)) for count in heights.shape]
    along = float(np.sum(power.sum(axis=1) * numbers[0])) / total
    across = float(np.sum(power.sum(axis=0) * numbers[1])) / total
    mirrored = _list_mirrored_axes(heights)
    return along / (2.0 if 0 in mirrored else 1.0), across / (2.0 if 1 in mirrored else 1.0)
