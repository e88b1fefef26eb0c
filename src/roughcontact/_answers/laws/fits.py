"""Power laws over the load, where they hold."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.checks import Array, Pair
from roughcontact._base.units import si

# Misfit that is allowed whatever the uncertainties, over the value and over its change, and the fewest loads and their
# smallest ratio: a straight line through any smooth curve fits in a shorter range, and a logarithm has a small change.
_MISFIT = 0.01
_LOADS = 4
_RATIO = 10.0


@attrs.frozen
class PowerFit:
    """A power law of the pressure, value = `factor` (pressure / `pivot`)^`exponent`, and where it holds.

    Attributes
    ----------
    exponent, exponent_std
        The exponent and its standard deviation, from the uncertainties of the values and the misfit.
    factor
        The value at the pivot, in the unit of the column.
    pivot
        The geometric mean of the loads that were fitted, Pa.
    pressures
        The lowest and highest load of the range, Pa, in which the law is within the uncertainties or 1 %.
    loads
        Loads in it.
    misfit
        Maximum relative misfit in it.
    """

    exponent: float
    exponent_std: float
    factor: float
    pivot: float
    pressures: Pair
    loads: int
    misfit: float

    def __str__(self) -> str:
        low, high = (si(pressure, "Pa") for pressure in self.pressures)
        exponent = f"pressure^({self.exponent:.3f} +- {self.exponent_std:.1g})"
        return f"{exponent} from {low} to {high}, within {100.0 * self.misfit:.1g} %"


def fit_power(pressures: Array, values: Array, uncertainties: Array) -> PowerFit | None:
    """Return the power law over the widest range of neighbouring loads in which it holds; None without one.

    It holds where every value is within its uncertainty of the weighted least-squares line of the logarithms, or within
    1 % of the value and of its change over the range.
    """
    usable = np.isfinite(values) & (values > 0.0) & np.isfinite(uncertainties)
    best: PowerFit | None = None
    widest = 0.0
    for first in range(pressures.size):
        for last in range(pressures.size, first + _LOADS - 1, -1):
            chosen = slice(first, last)
            ratio = float(pressures[last - 1] / pressures[first])
            if ratio < _RATIO * (1.0 - 1e-9) or ratio <= widest or not usable[chosen].all():
                continue
            found = _fit(pressures[chosen], values[chosen], uncertainties[chosen] / values[chosen])
            if found is not None:
                best = found
                widest = ratio
                break
    return best


def _fit(pressures: Array, values: Array, relative: Array) -> PowerFit | None:
    """Return the line through the logarithms of all these values; None if one of them is off."""
    x = np.log(pressures)
    y = np.log(values)
    allowed = np.maximum(relative, _MISFIT)
    weights = 1.0 / allowed**2
    pivot, level = (float(np.average(each, weights=weights)) for each in (x, y))
    spread = float(np.sum(weights * (x - pivot) ** 2))
    exponent = float(np.sum(weights * (x - pivot) * (y - level))) / spread
    misfit = y - level - exponent * (x - pivot)
    change = min(1.0, abs(exponent) * float(x[-1] - x[0]))
    if (np.abs(misfit) > np.maximum(relative, _MISFIT * change)).any():
        return None
    variance = relative**2 + float(np.sum(misfit**2)) / (x.size - 2)
    std = math.sqrt(float(np.sum((weights * (x - pivot)) ** 2 * variance))) / spread
    middle = float(np.mean(x))
    factor = math.exp(level + exponent * (middle - pivot))
    ends = float(pressures[0]), float(pressures[-1])
    return PowerFit(exponent, std, factor, math.exp(middle), ends, x.size, float(np.abs(misfit).max()))
