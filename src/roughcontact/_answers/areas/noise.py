"""White noise of measured heights: how much there is, and what it does to every answer.

Differences along both axes leave of heights that the cells resolve little beside the noise of each point. What noise
does is found from the same contact with as much more of it: an answer changes once more by about as much.

References
----------
Cook and Stefanski, J. Am. Stat. Assoc. 89 (1994) 1314-1328, https://doi.org/10.1080/01621459.1994.10476871
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable
from typing import Any, TypeVar

import attrs
import numpy as np

from roughcontact._answers.areas.edges import MAX_RELATIVE_STD
from roughcontact._answers.areas.phases import solve_with
from roughcontact._base.arrays import Array, Mask
from roughcontact._base.units import Estimate, WarningText, percent, si
from roughcontact._parts.grid import Boundary, pad_axes
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.solution import Area, ContactSolution, Response, responses
from roughcontact.errors import InputError

Number = TypeVar("Number", bound=Estimate)

# Cells along an axis from which noise is known from heights.
_MIN_CELLS = 16
# Lower quartile of the magnitude of normal numbers of standard deviation one (exact): creases and steps are above it.
_NORMAL_QUARTILE = 0.3186393639643752
# The differences, along each axis, and their standard deviation on white noise of one, along both (exact).
_ORDERS = {order: math.comb(2 * order, order) for order in (4, 6)}
# The standard deviation by the higher differences over that by the lower ones, of noise: one, and 0.68 to 1.56 on 16 x
# 16 points; heights of waves of 2 cells have 0.6, of 4 cells 0.07.
_NOISE_RATIOS = (0.68, 1.5)
# Lower quartile of the magnitudes over their median, at least: 0.47 of noise, 0.36 to 0.6 on 16 x 16 points, at most
# 0.3 of creases that cross as often as every few cells.
_MIN_QUARTILE_RATIO = 0.36
# Part of the peak-to-valley height below which differences are rounding.
_ROUNDING = 1e-12
# Relative standard deviation of that of the noise, times the root of the number of points. Measured on white noise.
_QUARTILE_STD = 2.7
# Contacts with more noise.
_DRAWS = 3
# Standard deviation by noise over the root mean square of the changes by more of it, for so few draws know it to a
# third. Set on smooth surfaces with noise of 0.3 to 3 % of the rms height.
_STD_FACTOR = 1.5
# Mean change over its standard error from which the area is extrapolated.
_AGREEMENT = 2.0
# Largest growth of the area by extrapolation: beyond, noise alone decides what touches, and the area may be any. Set on
# smooth surfaces, which grow by up to 1.4, and on flat lands and pillars, whose true areas are up to 20 times as large.
_MAX_GROWTH = 1.6
_RULE = "noise"


@attrs.frozen
class Noise(Estimate):
    """White noise of the heights, as a measurement adds it to each point.

    Roughness of waves much shorter than two points, sampled at the points, looks the same and counts as noise.

    Attributes
    ----------
    value
        Its standard deviation, m; zero where none is found.
    uncertainty
        One standard deviation of that, m.
    unit
        ``"m"``.
    fraction
        The noise over the root mean square of the heights about their mean.
    warnings
        Empty.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> grid = rc.Grid((64, 64), 64e-6)
    >>> wave = 1e-7 * np.cos(2e5 * grid.x) * np.cos(2e5 * grid.y)
    >>> measured = rc.HeightMap(wave + np.random.default_rng(0).normal(0.0, 1e-9, grid.shape), size=grid.size)
    >>> solution = rc.ContactProblem(rc.Body(measured, rc.Elastic(210e9, 0.3))).solve(force=0.1)
    >>> print(solution.response("noise"))
    997 pm +- 4.7 %, 2 % of the rms height
    """

    fraction: float = attrs.field(default=0.0, kw_only=True)

    def judge(self, solution: Any, found: Number, ask: Callable[[Any], Estimate]) -> Number:
        """Return an answer with the standard deviation by noise in its own, and an area without what noise takes of it.

        Parameters
        ----------
        solution
            The solution whose heights have the noise. It is solved again with as much more noise, three times, once.
        found
            Its answer.
        ask
            Returns the answer of any solution.

        Returns
        -------
        Number
            As found, where there is no noise. Areas fall as the rms slope rises, to whose square noise adds: where the
            three agree, the inverse square of the area is extrapolated to no noise.
        """
        if self.value == 0.0:
            return found
        before = ask(solution).value
        changes = [ask(other).value - before for other in _solve_noisier(solution, self.value)]
        if isinstance(found, Area):
            corrected: Number = self._correct_area(solution, found, before, changes)
            return corrected
        std = _STD_FACTOR * math.sqrt(statistics.fmean(change**2 for change in changes))
        return self._widen(found, std)

    def _correct_area(self, solution: Any, found: Any, before: float, changes: list[float]) -> Any:
        mean = statistics.fmean(changes)
        scatter = statistics.stdev(changes)
        value = before
        std = abs(mean)
        if std > _AGREEMENT * scatter / math.sqrt(_DRAWS):
            value, std = _extrapolate(before, mean, solution.grid.area)
        if value != before:
            value = min(max(found.value + value - before, 0.0), solution.grid.area)
            found = attrs.evolve(found, value=value, fraction=value / solution.grid.area, patches=None)
        return self._widen(found, math.hypot(std, scatter))

    def _widen(self, found: Number, std: float) -> Number:
        """Return an answer with a standard deviation by noise in its own."""
        warnings = tuple(text for text in found.warnings if getattr(text, "rule", "") != _RULE)
        if std > MAX_RELATIVE_STD * abs(found.value):
            relative = std / abs(found.value) if found.value else math.inf
            noise = si(self.value, "m", 3)
            text = f"noise of {noise} in the heights changes this by about {percent(relative)}: filter it"
            warnings = (*warnings, WarningText(text, _RULE, relative))
        return attrs.evolve(found, uncertainty=math.hypot(found.uncertainty, std), warnings=warnings)

    def __str__(self) -> str:
        if self.value == 0.0:
            return "no noise found in the heights"
        return f"{super().__str__()}, {percent(self.fraction)} of the rms height"


@responses.register("noise")
@attrs.frozen
class FindNoise(Response[Noise]):
    """Standard deviation of white noise of the heights, m, told from heights that are smooth, creased or stepped."""

    def respond(self, solution: ContactSolution) -> Noise:
        """Return the noise of the initial gap, of both bodies together.

        Raises
        ------
        InputError
            If there are fewer than 16 cells along an axis, or the fields are divided among processes.
        """
        if not solution.parts.is_whole:
            raise InputError("The heights here are those of a slab: ask gather() for the whole contact.")
        shape = solution.grid.shape
        if any(n < _MIN_CELLS for n in shape):
            raise InputError(
                f"Noise does not show on a grid of {' x '.join(map(str, shape))} cells: it takes {_MIN_CELLS} along "
                "each axis."
            )
        std, error = find_noise(solution.initial_gap, solution.boundary, solution.non_measured)
        known = True if solution.non_measured is None else ~solution.non_measured
        rms = float(np.std(solution.initial_gap, where=known))
        return Noise(std, error, "m", fraction=std / rms if rms > 0.0 else 0.0)


def find_noise(heights: Array, boundary: Boundary, non_measured: Mask | None = None) -> tuple[float, float]:
    """Return the standard deviation of white noise of heights, m, and that of its own; zero if there is none."""
    height = float(np.ptp(heights))
    if height == 0.0:
        return 0.0, 0.0
    heights = heights / height
    if non_measured is not None:
        heights = np.where(non_measured, np.nan, heights)
    stds = []
    ratios = []
    count = 0
    for order, norm in _ORDERS.items():
        differences = np.abs(_find_differences(heights, boundary, order))
        differences = differences[np.isfinite(differences)]
        count = differences.size
        if count == 0:
            return 0.0, 0.0
        quartile, median = np.quantile(differences, (0.25, 0.5))
        stds.append(float(quartile) / (_NORMAL_QUARTILE * norm))
        ratios.append(float(quartile) > _MIN_QUARTILE_RATIO * float(median))
    lower, higher = stds
    from_ratio, to_ratio = _NOISE_RATIOS
    if lower < _ROUNDING or not all(ratios) or not from_ratio * lower < higher < to_ratio * lower:
        return 0.0, 0.0
    std = height * min(stds)
    return std, _QUARTILE_STD / math.sqrt(count) * std


def _find_differences(heights: Array, boundary: Boundary, order: int) -> Array:
    """Return the differences of an even order along x of those along y."""
    width = (order // 2, order // 2)
    for axis, free in enumerate(boundary.free_axes):
        if not free:
            widths = (width, (0, 0)) if axis == 0 else ((0, 0), width)
            heights = pad_axes(heights, widths, (False, False))
        heights = np.diff(heights, order, axis=axis)
    return heights


def _extrapolate(area: float, change: float, nominal: float) -> tuple[float, float]:
    """Return an area without noise and its standard deviation, given the change of the area by as much more noise."""
    square = 2.0 - (area / (area + change)) ** 2 if area + change > 0.0 else 0.0
    if square < _MAX_GROWTH**-2:
        return area, 0.5 * (nominal - area)
    value = min(area / math.sqrt(square), nominal)
    return value, max(abs(change), abs(value - area))


def _solve_noisier(solution: ContactSolution, std: float) -> tuple[ContactSolution, ...]:
    """Return the contact with as much more noise, solved once for each draw."""
    return solution._keep("noisier", lambda: tuple(_solve_draw(solution, std, draw) for draw in range(_DRAWS)))


def _solve_draw(solution: ContactSolution, std: float, draw: int) -> ContactSolution:
    noise = std * np.random.default_rng(draw).standard_normal(solution.grid.shape)
    heights = HeightMap(
        noise - solution.initial_gap,
        size=solution.grid.size,
        periodic=solution.boundary is Boundary.PERIODIC,
        non_measured=solution.non_measured,
    )
    return solve_with(heights, solution, solution.pressure)
