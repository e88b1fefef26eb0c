"""Sampling errors of a contact: how much its answers differ between places of the same rough surface."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import scipy

from roughcontact._base.units import Deferred
from roughcontact._parts.grid import extend
from roughcontact._solve.solution.place import Place, PlaceStatistics, find_window

# All constants were set on the tuned classes of docs/studies/sampling.py.
# Factors of the standard deviation of the area: of the tiles, and of the error of the mean square height.
_AREA_FACTOR = 0.7
_DEPENDENCE = 2.0
# Factors of the unevenness in the standard deviations of stiffness and maximum pressure.
_STIFFNESS_UNEVENNESS = 1.2
_PEAK_UNEVENNESS = 1.3
# Unevenness, and number of summits in contact, from which on the numbers are not relied on.
_MAX_UNEVENNESS = 0.25
_MIN_PATCHES = 3
# Error of the mean square height, and ratio of slopes across and along a lay, from which on few of its marks are known.
_FEW_WAVES = 0.4
_MIN_LAY_RATIO = 1.5
# Factors of the standard deviation of the stiffness: of the error of the mean square height, and of the tiles.
_STIFFNESS_FACTORS = (0.65, 1.5)
# Power of the ratio of slopes across and along a lay with which maxima differ more, as those along it are alike.
_PEAK_LAY_EXPONENT = 0.3
# Stiffness of a square punch over that of an elliptic one, and minimum compliance by the roughness over all.
_SQUARE_PUNCH_FACTOR = 1.02
_MIN_ROUGH_FRACTION = 0.02
# Stiffness of an elliptic punch over that of the rectangle around it.
_ELLIPSE_FACTOR = math.sqrt(math.pi / 4.0) / _SQUARE_PUNCH_FACTOR
# Highest local maxima of the pressure from which the fall of their number is measured, the fraction of all that they
# are at most, the relative fall that is usual, the number of maxima that it counts for, and the factor.
_PEAKS = 8
_PEAK_FRACTION = 3
_USUAL_FALL = 0.12
_PEAK_WEIGHT = 4.0
_PEAK_FACTOR = 0.9
# Relative standard deviation of a maximum where a border cuts the contact.
_CUT_PEAK_STD = 0.27


def defer_area_sampling(solution: Any) -> Deferred | None:
    """Return the standard deviation of the area between places, over the area; None if it is not known."""
    place: Place | None = solution._place
    return None if place is None else place.defer(_vary_area, at_once=not solution.parts.is_whole)


def _vary_area(place: Place, found: PlaceStatistics) -> float | None:
    even = _AREA_FACTOR * found.tiles * (1.0 + _DEPENDENCE * found.height)
    return _keep_known(found.elasticity * math.hypot(even, found.unevenness))


def defer_stiffness_sampling(solution: Any, stiffness: float) -> Deferred | None:
    """Return the standard deviation of the stiffness, N/m, between places, over it; None if it is not known."""
    place: Place | None = solution._place
    free = solution.boundary.free_axes
    if place is None or not math.isfinite(stiffness) or free[0] != free[1]:
        return None
    part = 1.0
    if free[0]:
        # A flat punch as large as the domain, or the ellipse in which a ball touches, yields too, everywhere alike.
        sides = find_window(place).size
        flat = _find_punch_stiffness(sides, float(solution.effective_modulus(1.0 / math.sqrt(sides[0] * sides[1]))))
        flat *= _ELLIPSE_FACTOR if place.has_form else 1.0
        part = max(1.0 - stiffness / flat, _MIN_ROUGH_FRACTION)

    def vary(place: Place, found: PlaceStatistics) -> float | None:
        of_height, of_tiles = _STIFFNESS_FACTORS
        rough = math.hypot(of_height * found.height, of_tiles * found.tiles, _STIFFNESS_UNEVENNESS * found.unevenness)
        return _keep_known(rough * part)

    return place.defer(vary, at_once=not solution.parts.is_whole)


def defer_peak_sampling(solution: Any) -> Deferred | None:
    """Return the standard deviation of the maximum pressure between places, over it; None if it is not known."""
    place: Place | None = solution._place
    if place is None:
        return None
    saturated = bool(solution.saturated.any())

    def vary(place: Place, found: PlaceStatistics) -> float | None:
        if saturated:
            return 0.0
        maxima = _vary_maxima(place, found.lay**_PEAK_LAY_EXPONENT)
        return _keep_known(math.hypot(maxima, _PEAK_UNEVENNESS * found.unevenness))

    return place.defer(vary, at_once=not solution.parts.is_whole)


def _keep_known(relative: float) -> float | None:
    """Return a relative standard deviation; None beyond the number itself, where one place tells nothing of others."""
    return relative if relative <= 1.0 else None


def find_sampling_warning(solution: Any) -> str:
    """Return why other places may differ more than the sampling errors say, empty without a reason."""
    place: Place | None = solution._place
    found = None if place is None else place.statistics
    if found is None:
        return ""
    if found.unevenness > _MAX_UNEVENNESS:
        return "the roughness changes along the map, places far away may differ more"
    if found.height > _FEW_WAVES and found.lay > _MIN_LAY_RATIO:
        return "the map is only a few grooves wide, so that places far away may be rougher or smoother"
    if solution.patches.count < _MIN_PATCHES and not solution.contact.all():
        return "too few summits touch to tell how much others differ"
    return ""


def _vary_maxima(place: Place, dependence: float) -> float:
    """Return the relative standard deviation of the maximum pressure, from the fall of the highest local maxima.

    Of many independent places that have maxima with an exponential tail, the highest one scatters as the mean fall
    from the highest to a lower one; `dependence` is the factor for a lay.
    """
    pressure = place.pressure
    i, j = place.cells
    around = extend(pressure, 1, place.boundary)
    own = place.pressures
    highest = np.ones(own.size, dtype=bool)
    for step in range(9):
        highest &= own >= around[i + step // 3, j + step % 3]
    maxima = np.sort(own[highest])[::-1]
    count = min(_PEAKS, max(1, maxima.size // _PEAK_FRACTION))
    beyond = float(maxima[count]) if maxima.size > count else 0.0
    fall = (float(maxima[:count].mean()) - beyond) / float(maxima[0])
    fall = math.sqrt((count * fall**2 + _PEAK_WEIGHT * _USUAL_FALL**2) / (count + _PEAK_WEIGHT))
    free_x, free_y = place.boundary.free_axes
    nx, ny = pressure.shape
    cut = bool((free_x & ((i == 0) | (i == nx - 1)) | free_y & ((j == 0) | (j == ny - 1))).any())
    return math.hypot(_PEAK_FACTOR * dependence * fall, _CUT_PEAK_STD if cut else 0.0)


def _find_punch_stiffness(sides: tuple[float, float], modulus: float) -> float:
    """Return the stiffness of a flat rectangular punch, from that of an ellipse of its area and sides, N/m."""
    ratio = min(sides) / max(sides)
    longer = max(sides) / math.sqrt(math.pi)
    return _SQUARE_PUNCH_FACTOR * math.pi * modulus * longer / float(scipy.special.ellipk(1.0 - ratio**2))
