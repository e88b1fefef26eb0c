"""Extrapolation of an area, or of any number, from a ladder of grids to the infinitely fine one.

Each rule returns an `Extrapolation` that says when it must not be trusted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import attrs
import numpy as np

from roughcontact.checks import Array, number
from roughcontact.errors import InputError

# Free parameters of the two fitted curves.
_PARAMETERS = 3
# Share of the step beyond the finest grid that the data may miss the curve by.
_MISFIT = 0.1


@attrs.frozen
class Extrapolation:
    """A value at infinite resolution.

    Attributes
    ----------
    method
        The rule.
    value
        The extrapolated value, in the unit of the data.
    parameters
        Fitted parameters by name.
    residual
        Root mean square misfit of the data, in their unit.
    warnings
        Why the value must not be trusted; empty if nothing speaks against it.
    """

    method: str
    value: float
    parameters: dict[str, float]
    residual: float
    warnings: tuple[str, ...]

    @property
    def trustworthy(self) -> bool:
        """Whether nothing speaks against the value."""
        return not self.warnings


def exponential(cells: Sequence[float], values: Sequence[float]) -> Extrapolation:
    r"""Fit the paper's eq. 28 by least squares.

    .. math:: A(x) = A_0 + k\,e^{-x/t}

    Parameters
    ----------
    cells
        Number of cells x along a side, for each grid.
    values
        The values found on them.

    Raises
    ------
    InputError
        If there are fewer than two grids, or the data are not finite numbers.
    """
    x, y = _data(cells, values)
    scales = np.geomspace(0.05 * x[0], 50.0 * x[-1], 400)
    t = _best_scale(scales, lambda t: np.exp(-x / t), y)
    limit, slope, residual = _linear(np.exp(-x / t), y)
    warnings = _complaints(x, y, limit, residual)
    if not 0.5 * x[0] <= t <= x[-1]:
        warnings += (f"the decay length t = {t:.3g} cells lies outside the data",)
    return Extrapolation("exponential", limit, {"A0": limit, "k": slope, "t": t}, residual, warnings)


def power_law(cells: Sequence[float], values: Sequence[float]) -> Extrapolation:
    r"""Fit a power of the cell size by least squares.

    .. math:: A(x) = A_0 + c\,h^q, \quad h = 1/x

    Parameters
    ----------
    cells
        Number of cells x along a side, for each grid.
    values
        The values found on them.

    Raises
    ------
    InputError
        If there are fewer than two grids, or the data are not finite numbers.
    """
    x, y = _data(cells, values)
    h = x[0] / x
    q = _best_scale(np.geomspace(0.05, 20.0, 400), lambda q: h**q, y)
    limit, slope, residual = _linear(h**q, y)
    warnings = _complaints(x, y, limit, residual)
    if not 0.25 <= q <= 4.0:
        warnings += (f"the order q = {q:.3g} is not plausible",)
    return Extrapolation("power law", limit, {"A0": limit, "c": float(slope * x[0] ** q), "q": q}, residual, warnings)


def richardson(cells: Sequence[float], values: Sequence[float], order: float | None = None) -> Extrapolation:
    r"""Extrapolate from the finest grids, at a known or an observed order.

    .. math:: A_0 = A_2 + \frac{A_2 - A_1}{(x_2/x_1)^q - 1}

    Parameters
    ----------
    cells
        Number of cells x along a side, for each grid.
    values
        The values found on them.
    order
        Order q of the error in the cell size; observed on the three finest grids if left out.

    Raises
    ------
    InputError
        If there are fewer than two grids (three to observe the order), or the data are not finite.

    Examples
    --------
    Data of the limit 2 and an error that falls as the cell size; then data that do not fall so:

    >>> from roughcontact.extrapolation import richardson
    >>> found = richardson([64, 128, 256], [2.4, 2.2, 2.1])
    >>> print(f"{found.value:.6f}, order {found.parameters['q']:.6f}", found.trustworthy)
    2.000000, order 1.000000 True
    >>> richardson([64, 128, 256], [2.4, 2.2, 2.5]).warnings[0]
    'the three finest values do not converge with a positive order; the finest is returned'
    """
    x, y = _data(cells, values)
    if order is None and x.size < 3:
        raise InputError("Richardson extrapolation needs three grids to observe the order; give order= or more grids.")
    warnings: tuple[str, ...] = ()
    if order is not None:
        order = number(order, "The order of the error", above=0.0)
    q = order if order is not None else _observed_order(x, y)
    if not math.isfinite(q) or q <= 0.0:
        warnings += ("the three finest values do not converge with a positive order; the finest is returned",)
        return Extrapolation("Richardson", float(y[-1]), {"q": q}, 0.0, warnings)
    growth = (x[-1] / x[-2]) ** q
    value = float(y[-1] + (y[-1] - y[-2]) / (growth - 1.0))
    if order is None and not 0.25 <= q <= 4.0:
        warnings += (f"the observed order q = {q:.3g} is not plausible",)
    # The finest grid that was not used tells how well one order describes the data.
    used = 2 if order is not None else 3
    misfit = 0.0
    if x.size > used:
        error = float(y[-used - 1]) - value
        misfit = abs(error - (float(y[-1]) - value) * (x[-1] / x[-used - 1]) ** q)
        if misfit > _MISFIT * abs(error):
            warnings += (f"the error of the next coarser grid is off by {100 * misfit / abs(error):.0f} %",)
    return Extrapolation("Richardson", value, {"q": float(q)}, misfit, warnings + _monotone(y))


def _data(cells: Sequence[float], values: Sequence[float]) -> tuple[Array, Array]:
    try:
        x, y = np.array(cells, dtype=np.float64), np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError.about("The data of an extrapolation", (cells, values), "two lists of numbers") from None
    if x.ndim != 1 or x.shape != y.shape or x.size < 2 or np.unique(x).size != x.size:
        raise InputError.about(
            "The data of an extrapolation",
            (cells, values),
            "two lists of equal length, at least two different grids",
        )
    if not (np.isfinite(x).all() and np.isfinite(y).all() and x.min() > 0.0):
        raise InputError.about("The data of an extrapolation", (cells, values), "finite, and the cell counts above 0")
    order = np.argsort(x)
    return x[order], y[order]


def _linear(basis: Array, values: Array) -> tuple[float, float, float]:
    """Fit values = limit + slope * basis; return limit, slope and the rms misfit."""
    mean, centre = basis.mean(), values.mean()
    spread = basis - mean
    norm = float(spread @ spread)
    slope = float(spread @ (values - centre)) / norm if norm > 0.0 else 0.0
    limit = float(centre - slope * mean)
    return limit, slope, float(np.sqrt(np.mean((values - limit - slope * basis) ** 2)))


def _best_scale(candidates: Array, basis: Callable[[float], Array], values: Array) -> float:
    """Return the nonlinear parameter of the best fit: the others are linear and follow from it."""

    def misfit(log_scale: float) -> float:
        return _linear(basis(math.exp(log_scale)), values)[2]

    from scipy import optimize

    logs = np.log(candidates)
    best = int(np.argmin([misfit(value) for value in logs]))
    low, high = logs[max(best - 1, 0)], logs[min(best + 1, logs.size - 1)]
    found = optimize.minimize_scalar(misfit, bounds=(low, high), method="bounded", options={"xatol": 1e-12})
    return math.exp(float(found.x))


def _complaints(x: Array, y: Array, limit: float, residual: float) -> tuple[str, ...]:
    """Say what speaks against a fit of three parameters."""
    warnings: tuple[str, ...] = ()
    if x.size < _PARAMETERS:
        warnings += (f"{x.size} grids cannot determine {_PARAMETERS} parameters",)
    elif x.size == _PARAMETERS:
        warnings += (f"{x.size} grids determine {_PARAMETERS} parameters exactly: the misfit tells nothing",)
    step = abs(limit - float(y[-1]))
    if residual > _MISFIT * step:
        share = f"{100 * residual / step:.0f} % of" if step > 0.0 else "more than"
        warnings += (f"the curve misses the data by {share} its step beyond the finest grid",)
    return warnings + _monotone(y)


def _monotone(y: Array) -> tuple[str, ...]:
    steps = np.diff(y)
    if (steps >= 0.0).all() or (steps <= 0.0).all():
        return ()
    return ("the values do not change monotonically with the grid",)


def _observed_order(x: Array, y: Array) -> float:
    """Return q such that the three finest values lie on A0 + c x^-q; nan if none does."""
    from scipy import optimize

    far, near = y[-3] - y[-2], y[-2] - y[-1]
    if near == 0.0 or far / near <= 0.0:
        return math.nan

    def mismatch(q: float) -> float:
        ratio = ((x[-2] / x[-3]) ** q - 1.0) / (1.0 - (x[-2] / x[-1]) ** q)
        return math.log(ratio) - math.log(far / near)

    low, high = 1e-3, 30.0
    if mismatch(low) * mismatch(high) > 0.0:
        return math.nan
    return float(optimize.brentq(mismatch, low, high))
