"""Sampling errors of a contact: how much its answers differ between places of the same rough surface."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from scipy import special

from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Grid, extend
from roughcontact._parts.surfaces import FORM_DEGREE, polynomial
from roughcontact.reference.roughness import transform_waves

if TYPE_CHECKING:
    from roughcontact._solve.solution.contact import ContactSolution

# All constants were set on the tuned classes of docs/studies/sampling.py.
# Tiles of a square domain along each side, between which the load is compared with the area, and cells along a side
# of the coarse heights, which hold the longest waves.
_TILES = 8
_COARSE_CELLS = 64
# Standard deviation of the area of one loaded tile at a given load, and the number of such tiles that it counts for.
_TILE_STD = 0.2
_TILE_WEIGHT = 3.0
# Factors of the standard deviation of the area: of the tiles, and of the error of the mean square height.
_AREA_FACTOR = 0.75
_DEPENDENCE = 2.0
# Factors of the standard deviation of the stiffness: of the error of the mean square height, and of the tiles.
_STIFFNESS_FACTORS = (0.6, 1.5)
# Maximum relative error of the mean square height that counts.
_MAX_HEIGHT_ERROR = 0.6
# Highest local maxima of the pressure from which the fall of their number is measured, the fraction of all that they
# are at most, the relative fall that is usual, the number of maxima that it counts for, and the factor.
_PEAKS = 8
_PEAK_FRACTION = 3
_USUAL_FALL = 0.12
_PEAK_WEIGHT = 4.0
_PEAK_FACTOR = 0.9
# Relative standard deviation of a maximum where a border cuts the contact.
_CUT_PEAK_STD = 0.27


@attrs.frozen
class PlaceStatistics:
    """Numbers of one place that tell how much others differ, without units.

    Attributes
    ----------
    tiles
        Standard deviation of the area at a given load by the differences of the tiles.
    height
        Sampling error of the mean square height.
    peak
        Standard deviation of the maximum pressure.
    """

    tiles: float
    height: float
    peak: float


@attrs.frozen(eq=False)
class Postponed:
    """A number that is computed when it is asked for; a copy and a pickle hold the number."""

    compute: Callable[[], float | None]

    def __call__(self) -> float | None:
        return self.compute()

    def __reduce__(self) -> tuple[Any, ...]:
        return _keep, (self.compute(),)


def _keep(value: float | None) -> float | None:
    return value


def postpone_sampling(solution: ContactSolution, quantity: str, value: float = 0.0) -> Postponed | None:
    """Return the relative sampling error of a quantity, computed when it is asked for; None if it has none.

    Parameters
    ----------
    solution
        The contact.
    quantity
        ``"area"``, ``"stiffness"`` or ``"peak pressure"``.
    value
        The stiffness, N/m.
    """
    if not _is_sampled(solution):
        return None
    rules = {"area": _vary_area, "stiffness": _vary_stiffness, "peak pressure": _vary_peak}
    return Postponed(lambda: rules[quantity](solution, value))


def _is_sampled(solution: ContactSolution) -> bool:
    return bool(
        solution.origin is not None
        and solution.origin.is_random
        and solution.tension is None
        and solution.status.success
    )


def _vary_area(solution: ContactSolution, _: float) -> float | None:
    found = solution._place
    if found is None:
        return None
    return _AREA_FACTOR * found.tiles * (1.0 + _DEPENDENCE * found.height)


def _vary_stiffness(solution: ContactSolution, stiffness: float) -> float | None:
    found = solution._place
    free = solution.boundary.free_axes
    if found is None or not math.isfinite(stiffness) or free[0] != free[1]:
        return None
    of_height, of_tiles = _STIFFNESS_FACTORS
    rough = math.hypot(of_height * found.height, of_tiles * found.tiles)
    if not free[0]:
        return rough
    # A flat punch as large as the domain yields too, everywhere alike.
    flat = _find_punch_stiffness(solution.grid, solution.modulus)
    return rough * max(1.0 - stiffness / flat, 0.0)


def _vary_peak(solution: ContactSolution, _: float) -> float | None:
    if solution.saturated.any():
        return 0.0
    found = solution._place
    return None if found is None else found.peak


def find_place_statistics(solution: ContactSolution) -> PlaceStatistics | None:
    """Return the statistics of the place; None without a contact or roughness."""
    if not solution.contact.any():
        return None
    height = _find_height_error(solution)
    if height is None:
        return None
    return PlaceStatistics(_compare_tiles(solution), height, _vary_maxima(solution))


def _sum_tiles(field: Array, shape: tuple[int, int]) -> Array:
    """Return the sums of a field over tiles, shape `shape`, which differ by a cell where they must."""
    for axis, count in enumerate(shape):
        starts = np.arange(count) * field.shape[axis] // count
        field = np.add.reduceat(field, starts, axis=axis)
    return field


def _compare_tiles(solution: ContactSolution) -> float:
    r"""Return the standard deviation of the area at a given load, by tiles of the domain.

    With loads F and areas A of independent tiles the ratio of the sums, :math:`r = \sum A / \sum F`, has

    .. math:: \left(\frac{s_r}{r}\right)^2 = \frac{\sum (A_i - r F_i)^2}{(\sum A_i)^2}
    """
    sides = solution.grid.size
    ratio = math.sqrt(sides[0] / sides[1])
    nx, ny = (
        max(1, min(round(_TILES * scale), cells))
        for scale, cells in zip((ratio, 1.0 / ratio), solution.grid.shape, strict=True)
    )
    loads = _sum_tiles(solution.pressure, (nx, ny))
    loads /= loads.sum()
    areas = _sum_tiles(solution.contact.astype(np.float64), (nx, ny))
    covered = min(float(areas.sum()) / solution.grid.cells, 1.0)
    areas /= areas.sum()
    found = float(np.sum((areas - loads) ** 2))
    count = 1.0 / float(np.sum(loads**2))
    usual = (_TILE_STD * _find_elasticity(covered)) ** 2 / count
    return math.sqrt((count * found + _TILE_WEIGHT * usual) / (count + _TILE_WEIGHT))


def _find_elasticity(fraction: float) -> float:
    """Return by how much per cent the area falls if the slopes grow by one, after Persson: 1 light, 0 in full contact."""
    if fraction >= 1.0:
        return 0.0
    ratio = float(special.erfinv(fraction))
    return 2.0 / math.sqrt(math.pi) * ratio * math.exp(-(ratio**2)) / fraction


def _find_height_error(solution: ContactSolution) -> float | None:
    """Return the relative sampling error of the mean square height, from coarse heights; None for flat surfaces."""
    cells = solution.grid.shape
    shape = (min(cells[0], _COARSE_CELLS), min(cells[1], _COARSE_CELLS))
    gap = solution.initial_gap
    counts = np.outer(*(np.diff(np.arange(n + 1) * full // n) for n, full in zip(shape, cells, strict=True)))
    coarse = _sum_tiles(gap, shape) / counts
    repeats = not solution.boundary.has_free_axis
    if not repeats:
        if min(shape) <= FORM_DEGREE:
            return None
        form = polynomial(coarse, FORM_DEGREE, None)
        coarse = coarse - form
    scale = float(np.ptp(gap))
    if not scale > 0.0 or float(np.ptp(coarse)) <= 1e-12 * scale:
        return None
    waves = transform_waves(coarse, Grid(shape, solution.grid.size), repeats)
    return min(waves.spread(1.0) / waves.sum(1.0), _MAX_HEIGHT_ERROR)


def _vary_maxima(solution: ContactSolution) -> float:
    """Return the standard deviation of the maximum pressure, from the fall of the highest local maxima."""
    pressure = solution.pressure
    cells = solution.patches.members
    i, j = np.divmod(cells, pressure.shape[1])
    around = extend(pressure, 1, solution.boundary)
    own = pressure.ravel()[cells]
    highest = np.ones(cells.size, dtype=bool)
    for step in range(9):
        highest &= own >= around[i + step // 3, j + step % 3]
    maxima = np.sort(own[highest])[::-1]
    count = min(_PEAKS, max(1, maxima.size // _PEAK_FRACTION))
    beyond = float(maxima[count]) if maxima.size > count else 0.0
    fall = (float(maxima[:count].mean()) - beyond) / float(maxima[0])
    fall = math.sqrt((count * fall**2 + _PEAK_WEIGHT * _USUAL_FALL**2) / (count + _PEAK_WEIGHT))
    free_x, free_y = solution.boundary.free_axes
    nx, ny = pressure.shape
    cut = bool((free_x & ((i == 0) | (i == nx - 1)) | free_y & ((j == 0) | (j == ny - 1))).any())
    return math.hypot(_PEAK_FACTOR * fall, _CUT_PEAK_STD if cut else 0.0)


def _find_punch_stiffness(grid: Grid, modulus: float) -> float:
    """Return the stiffness of a flat elliptic punch with the area and the aspect ratio of the domain, N/m."""
    ratio = min(grid.size) / max(grid.size)
    longer = math.sqrt(grid.area / (math.pi * ratio))
    return math.pi * modulus * longer / float(special.ellipk(1.0 - ratio**2))
