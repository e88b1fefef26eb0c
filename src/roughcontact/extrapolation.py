"""Extrapolation of an area, or of any number, from a ladder of grids to infinite resolution, with warnings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import MAX_MAGNITUDE, number
from roughcontact._base.units import WarningText
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Free parameters of the two fitted curves.
_FITTED_PARAMETERS = 3
# Maximum misfit of the data, over the step beyond the finest grid, which is then known to about 10 %.
_MAX_MISFIT = 0.1
# Plausible orders of the error in the cell size: 1 for a counted area, 2 for a corrected one.
_PLAUSIBLE_ORDERS = (0.25, 4.0)
# Orders and numbers of cells that may be given: their powers stay within float64.
_ADMISSIBLE_ORDERS = (1e-3, 10.0)
_ADMISSIBLE_COUNTS = (1e-12, 1e12)


@guarded
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
        Why the value must not be trusted, in sentences; empty if there are no warnings.
    """

    method: str
    value: float
    parameters: dict[str, float]
    residual: float
    warnings: tuple[str, ...]

    @property
    def trustworthy(self) -> bool:
        """Whether there are no warnings."""
        return not self.warnings


@guarded
def exponential(cells: Sequence[float], values: Sequence[float]) -> Extrapolation:
    r"""Return the limit of the paper's eq. 28, fitted by least squares.

    .. math:: A(x) = A_0 + k\,e^{-x/t}

    Parameters
    ----------
    cells, values
        Number of cells x along a side, and the value, on each grid.

    Raises
    ------
    InputError
        If there are fewer than two grids, or the data are not finite numbers.

    Examples
    --------
    >>> from roughcontact.extrapolation import exponential
    >>> print(f"{exponential([64, 128, 256, 512], [1.6, 1.3, 1.1, 1.05]).value:.3f}")
    1.048
    """
    x, y = _sort_data(cells, values)
    scales = np.geomspace(0.05 * x[0], 50.0 * x[-1], 400)
    t, limit, slope, residual, warnings = _fit_curve(x, y, scales, lambda t: np.exp(-x / t))
    if not 0.5 * x[0] <= t <= x[-1]:
        warnings += (WarningText(f"the decay length t = {t:.3g} cells lies outside the data", "decay length", t),)
    return Extrapolation("exponential", limit, {"A0": limit, "k": slope, "t": t}, residual, warnings)


@guarded
def power_law(cells: Sequence[float], values: Sequence[float]) -> Extrapolation:
    r"""Return the limit of a power of the cell size, fitted by least squares; arguments as for `exponential`.

    .. math:: A(x) = A_0 + c\,h^q, \quad h = 1/x

    Examples
    --------
    >>> from roughcontact.extrapolation import power_law
    >>> print(f"{power_law([64, 128, 256], [1.4, 1.2, 1.1]).value:.3f}")
    1.000
    """
    x, y = _sort_data(cells, values)
    h = x[0] / x
    q, limit, slope, residual, warnings = _fit_curve(x, y, np.geomspace(0.05, 20.0, 400), lambda q: h**q)
    if not _PLAUSIBLE_ORDERS[0] <= q <= _PLAUSIBLE_ORDERS[1]:
        warnings += (WarningText(f"the order q = {q:.3g} is not plausible", "order", q),)
    return Extrapolation("power law", limit, {"A0": limit, "c": float(slope * x[0] ** q), "q": q}, residual, warnings)


@guarded
def richardson(cells: Sequence[float], values: Sequence[float], order: float | None = None) -> Extrapolation:
    r"""Return Richardson's extrapolation from the finest grids, at a known or an observed order.

    .. math:: A_0 = A_2 + \frac{A_2 - A_1}{(x_2/x_1)^q - 1}

    Parameters
    ----------
    cells, values
        Number of cells x along a side, and the value, on each grid.
    order
        Order q of the error in the cell size; by default the one observed on the three finest grids.

    Raises
    ------
    InputError
        If there are fewer than two grids (three to observe the order), or the data are not finite.

    Examples
    --------
    Data with the limit 2 and an error proportional to the cell size; then data that do not converge:

    >>> from roughcontact.extrapolation import richardson
    >>> found = richardson([64, 128, 256], [2.4, 2.2, 2.1])
    >>> print(f"{found.value:.6f}, order {found.parameters['q']:.6f}", found.trustworthy)
    2.000000, order 1.000000 True
    >>> richardson([64, 128, 256], [2.4, 2.2, 2.5]).warnings[0]
    'the three finest values do not converge with a positive order; the finest is returned'
    """
    x, y = _sort_data(cells, values)
    if order is None and x.size < 3:
        raise InputError("Richardson extrapolation needs three grids to observe the order; give order= or more grids.")
    warnings: tuple[str, ...] = ()
    if order is not None:
        order = number(order, "The order of the error", at_least=_ADMISSIBLE_ORDERS[0], at_most=_ADMISSIBLE_ORDERS[1])
    q = order if order is not None else _observe_order(x, y)
    if not math.isfinite(q) or q <= 0.0:
        text = "the three finest values do not converge with a positive order; the finest is returned"
        warnings += (WarningText(text, "order", q),)
        return Extrapolation("Richardson", float(y[-1]), {"q": q}, 0.0, warnings)
    growth = (x[-1] / x[-2]) ** q
    value = float(y[-1] + (y[-1] - y[-2]) / (growth - 1.0))
    if order is None and not _PLAUSIBLE_ORDERS[0] <= q <= _PLAUSIBLE_ORDERS[1]:
        warnings += (WarningText(f"the observed order q = {q:.3g} is not plausible", "order", q),)
    # The finest unused grid shows how well one order describes the data.
    used = 2 if order is not None else 3
    misfit = 0.0
    if x.size > used:
        error = float(y[-used - 1]) - value
        misfit = abs(error - (float(y[-1]) - value) * (x[-1] / x[-used - 1]) ** q)
        if misfit > _MAX_MISFIT * abs(error):
            off = misfit / abs(error)
            text = f"the error of the next coarser grid is off by {100 * off:.0f} %"
            warnings += (WarningText(text, "misfit", off),)
    return Extrapolation("Richardson", value, {"q": float(q)}, misfit, warnings + _check_monotone(y))


def _sort_data(cells: Sequence[float], values: Sequence[float]) -> tuple[Array, Array]:
    what = "The data of an extrapolation"
    try:
        x = np.asarray(cells)
        y = np.asarray(values)
    except ValueError:
        raise InputError.about(what, (cells, values), "two lists of numbers") from None
    if x.dtype.kind not in "fiu" or y.dtype.kind not in "fiu":
        raise InputError.about(what, (cells, values), "two lists of numbers")
    x = x.astype(np.float64)
    y = y.astype(np.float64)
    if x.ndim != 1 or x.shape != y.shape or x.size < 2 or np.unique(x).size != x.size:
        raise InputError.about(what, (cells, values), "two lists of equal length, at least two different grids")
    if not (np.abs(y).max() <= MAX_MAGNITUDE and x.max() <= _ADMISSIBLE_COUNTS[1] and x.min() >= _ADMISSIBLE_COUNTS[0]):
        raise InputError.about(what, (cells, values), "finite, and the cell counts above 0")
    order = np.argsort(x)
    return x[order], y[order]


def _fit_line(basis: Array, values: Array) -> tuple[float, float, float]:
    """Fit values = limit + slope * basis; return limit, slope and the rms misfit."""
    mean = basis.mean()
    centre = values.mean()
    spread = basis - mean
    norm = float(spread @ spread)
    slope = float(spread @ (values - centre)) / norm if norm > 0.0 else 0.0
    limit = float(centre - slope * mean)
    return limit, slope, float(np.sqrt(np.mean((values - limit - slope * basis) ** 2)))


def _fit_curve(
    x: Array, y: Array, candidates: Array, basis: Callable[[float], Array]
) -> tuple[float, float, float, float, tuple[str, ...]]:
    """Return the nonlinear parameter, limit, slope and rms misfit of the best fit, and its warnings."""

    def misfit(log_scale: float) -> float:
        return _fit_line(basis(math.exp(log_scale)), y)[2]

    from scipy import optimize

    logs = np.log(candidates)
    best = int(np.argmin([misfit(value) for value in logs]))
    low = logs[max(best - 1, 0)]
    high = logs[min(best + 1, logs.size - 1)]
    found = optimize.minimize_scalar(misfit, bounds=(low, high), method="bounded", options={"xatol": 1e-12})
    scale = math.exp(float(found.x))
    limit, slope, residual = _fit_line(basis(scale), y)
    warnings: tuple[str, ...] = ()
    if x.size <= _FITTED_PARAMETERS:
        exactly = x.size == _FITTED_PARAMETERS
        verb, end = ("determine", " exactly: the misfit says nothing") if exactly else ("cannot determine", "")
        text = f"{x.size} grids {verb} {_FITTED_PARAMETERS} parameters{end}"
        warnings += (WarningText(text, "few grids", x.size),)
    step = abs(limit - float(y[-1]))
    if residual > _MAX_MISFIT * step:
        part = f"{100 * residual / step:.0f} % of" if step > 0.0 else "more than"
        text = f"the curve misses the data by {part} its step beyond the finest grid"
        warnings += (WarningText(text, "misfit", residual),)
    return scale, limit, slope, residual, warnings + _check_monotone(y)


def _check_monotone(y: Array) -> tuple[str, ...]:
    steps = np.diff(y)
    monotone = (steps >= 0.0).all() or (steps <= 0.0).all()
    text = "the values do not change monotonically with the grid"
    return () if monotone else (WarningText(text, "monotony"),)


def _observe_order(x: Array, y: Array) -> float:
    """Return q such that the three finest values lie on A0 + c x^-q; nan if there is none."""
    from scipy import optimize

    far = y[-3] - y[-2]
    near = y[-2] - y[-1]
    if near == 0.0 or far / near <= 0.0:
        return math.nan

    def mismatch(q: float) -> float:
        ratio = ((x[-2] / x[-3]) ** q - 1.0) / (1.0 - (x[-2] / x[-1]) ** q)
        return math.log(ratio) - math.log(far / near)

    low = 1e-3
    high = 30.0
    if mismatch(low) * mismatch(high) > 0.0:
        return math.nan
    return float(optimize.brentq(mismatch, low, high))
