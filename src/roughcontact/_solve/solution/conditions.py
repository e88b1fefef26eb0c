"""The conditions of contact, measured on a pressure field.

With the gap g = u + h - approach, of displacement u and initial gap h, the exact solution satisfies
g = 0 where 0 < p < pressure limit, g >= 0 where p = 0 and g <= 0 (plastic overlap) where p = pressure limit.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.arrays import Array, sum_of_products
from roughcontact._base.machine import map_tiles, tiles_of

# Range of the displacement, over the maximum pressure, below which the pressure is uniform up to rounding.
_UNIFORM_RANGE = 1e-12
# Rounding of the gap over its largest term. Transforms of 2048 x 2048 cells round by up to 7 eps
# (docs/studies/solver_constants.py); the rest is margin for the sums.
_GAP_ROUNDING = 16.0 * float(np.finfo(np.float64).eps)


@attrs.frozen
class Violation:
    """The violation of the conditions of contact by a pressure field, and the approach it implies.

    Attributes
    ----------
    approach
        The approach, given or implied by the pressure.
    complementarity
        Pressure-weighted mean of the gaps that should vanish, over `scale`.
    penetration
        Maximum overlap outside the saturated cells, over `scale`.
    scale
        The smaller of the standard deviation of the initial gap and the range of the elastic displacement, so that
        neither a tall surface nor a light load hides an error.
    floor
        The error by rounding in float64, over `scale`.
    """

    approach: float
    complementarity: float
    penetration: float
    scale: float
    floor: float

    @property
    def error(self) -> float:
        """The maximum of complementarity, penetration and `floor`."""
        return max(self.complementarity, self.penetration, self.floor)


class ContactConditions:
    """The conditions of one contact, in float64 and in the units of a `Task`.

    Parameters
    ----------
    initial_gap
        Gap before deformation, from any datum, shape (nx, ny).
    pressure_limit
        Maximum pressure, a number or an array that broadcasts to (nx, ny); `inf` where there is none.
    approach
        The approach if it is given; None if the load is.
    rms
        The standard deviation of the initial gap; None: over all cells.
    """

    def __init__(
        self,
        initial_gap: Array,
        pressure_limit: float | Array = math.inf,
        approach: float | None = None,
        rms: float | None = None,
    ):
        self._initial_gap = initial_gap
        self._limit = pressure_limit
        self._approach = approach
        self._capped = bool(np.isfinite(pressure_limit).any())
        self._rms = standard_deviation(initial_gap) if rms is None else rms

    def measure(self, pressure: Array, displacement: Array) -> Violation:
        """Return the violation by a pressure, within its bounds, and the displacement it causes, shape (nx, ny).

        The approach, if it is not given, is the pressure-weighted mean of u + h over the cells in elastic contact; if
        there are none, a value that separates open from saturated cells.
        """
        tiles = tiles_of(pressure)

        def weigh(tile: slice) -> tuple[float, ...]:
            bearing = pressure[tile]
            moved = displacement[tile]
            elastic = bearing if not self._capped else np.where(bearing >= self._limits(tile), 0.0, bearing)
            load = np.add.reduce(elastic, axis=None)
            weighted = sum_of_products(elastic, moved + self._initial_gap[tile])
            whole = np.add.reduce(bearing, axis=None) if self._capped else load
            sums = load, weighted, whole
            return tuple(float(value) for value in (*sums, bearing.max(), moved.min(), moved.max()))

        loads, weights, totals, peaks, lows, highs = zip(*map_tiles(weigh, tiles), strict=True)
        load = math.fsum(loads)
        total = math.fsum(totals)
        peak = max(peaks)
        low = min(lows)
        high = max(highs)
        approach = self._approach
        if approach is None:
            weighted = math.fsum(weights)
            approach = weighted / load if load > 0.0 else self._separating_approach(pressure, displacement)

        def open_tile(tile: slice) -> tuple[float, float]:
            gap = displacement[tile] + self._initial_gap[tile]
            gap -= approach
            if self._capped:
                # Saturated cells may overlap; only an open gap is an error there.
                np.maximum(gap, 0.0, out=gap, where=pressure[tile] >= self._limits(tile))
            minimum = float(gap.min())
            return minimum, sum_of_products(pressure[tile], np.abs(gap, out=gap))

        minima, opened = zip(*map_tiles(open_tile, tiles), strict=True)
        # Zero pressure may satisfy a given approach, but never a given load.
        without_load = math.inf if self._approach is None else 0.0
        open_gap = math.fsum(opened) / total if total > 0.0 else without_load
        overlap = max(0.0, -min(minima))
        # With lengths in cells and E* = 1, a pressure displaces its own cell by about its own value.
        elastic_range = high - low if high - low > _UNIFORM_RANGE * peak else 0.0
        scale = min(self._rms, elastic_range) or max(self._rms, elastic_range) or 1.0
        if total == 0.0 and overlap > 0.0:
            # Even an approach that is small beside the heights needs pressure.
            scale = min(scale, overlap)
        # On a periodic domain a uniform pressure displaces nothing, but its rounding displaces single cells. Initial
        # gaps larger than displacement and approach are open in any case.
        floor = _GAP_ROUNDING * (max(high, -low, peak) + abs(approach)) / scale
        return Violation(approach, open_gap / scale, overlap / scale, scale, floor)

    def _limits(self, tile: slice) -> float | Array:
        """Return the pressure limits of a tile, in a form that broadcasts to it."""
        limit = self._limit
        return limit if isinstance(limit, float) or limit.ndim < 2 or limit.shape[0] == 1 else limit[tile]

    def _separating_approach(self, pressure: Array, displacement: Array) -> float:
        """Return an approach above u + h of the saturated cells and, if possible, below u + h of the open cells."""
        gap = displacement + self._initial_gap
        lower = float(gap[pressure >= self._limit].max(initial=gap.min()))
        open_cells = pressure <= 0.0
        return min(lower, float(gap[open_cells].min())) if open_cells.any() else lower


def standard_deviation(values: Array) -> float:
    """Return the standard deviation of a field, by tiles."""
    mean = float(values.mean())

    def square(tile: slice) -> float:
        rest = values[tile] - mean
        return sum_of_products(rest, rest)

    return math.sqrt(math.fsum(map_tiles(square, tiles_of(values))) / values.size)
