"""Constants of Greenwood and Tripp, Persson, and Patir and Cheng that are nearest to the columns of a film law."""

from __future__ import annotations

import math
from collections.abc import Mapping

import attrs
import numpy as np

from roughcontact._answers.laws.columns import LawColumn
from roughcontact._base.arrays import Array, Pair
from roughcontact._base.units import ShownAsPrinted, percent
from roughcontact.errors import InputError

# Smallest number of separations with contact of a fit, and smallest relative uncertainty of a row.
_MIN_ROWS = 4
_MIN_RELATIVE_STD = 0.02
# Offset over Sq, and logarithm of sigma over Sq, that Greenwood and Tripp's constants have by themselves, one standard
# deviation: without them the three constants grow without end where an exponential is nearer.
_OFFSET_STD = 1.0
_LOG_SIGMA_STD = 0.3
# Separation over Sq from which Patir and Cheng's construction, without deformation, is meant.
_MIN_PATIR_CHENG = 1.5
# Their fits by Peklenik's number: 1 - C exp(-r H) up to 1, and 1 + C H^-r beyond.
_PATIR_CHENG = {
    1 / 9: (1.48, 0.42),
    1 / 6: (1.38, 0.42),
    1 / 3: (1.18, 0.42),
    1.0: (0.90, 0.56),
    3.0: (0.225, 1.5),
    6.0: (0.520, 1.5),
    9.0: (0.870, 1.5),
}


@attrs.frozen
class FilmFit(ShownAsPrinted):
    """Constants of a model that is nearest to columns of a film law, and how near it is.

    Attributes
    ----------
    model
        ``"greenwood-tripp"``, ``"persson"`` or ``"patir-cheng"``.
    constants
        Its constants by name; lengths over Sq.
    separations
        The smallest and the largest separation that were fitted, over Sq.
    misfit
        Maximum relative misfit there.
    """

    model: str
    constants: Mapping[str, float]
    separations: Pair
    misfit: float

    def __str__(self) -> str:
        found = ", ".join(f"{name} {value:.4g}" for name, value in self.constants.items())
        low, high = self.separations
        return f"{self.model}: {found}; from {low:g} to {high:g} Sq, within {percent(self.misfit)}"


def fit_pressure(model: str, separations: Array, column: LawColumn, modulus: float) -> FilmFit:
    """Return the constants of a law of the asperity pressure, by least squares of its logarithm.

    Rows weigh by their relative uncertainty, by grid and places, of 2 % at least. Greenwood and Tripp: p = factor E*
    F_5/2((H - offset) / sigma); Persson: p = factor E* exp(-H / decay).
    """
    carries = column.values > 0.0
    if np.count_nonzero(carries) < _MIN_ROWS:
        raise InputError(f"A fit of the asperity pressure needs {_MIN_ROWS} separations with contact: give more.")
    x = separations[carries]
    pressures = column.values[carries]
    y = np.log(pressures / modulus)
    spread = column.uncertainties if column.sampling is None else np.hypot(column.uncertainties, column.sampling)
    weights = 1.0 / np.maximum(spread[carries] / pressures, _MIN_RELATIVE_STD)
    found, fitted = (_fit_greenwood_tripp if model == "greenwood-tripp" else _fit_persson)(x, y, weights)
    misfit = float(np.abs(np.expm1(fitted - y)).max())
    return FilmFit(model, found, (float(x.min()), float(x.max())), misfit)


def _fit_persson(x: Array, y: Array, weights: Array) -> tuple[dict[str, float], Array]:
    slope, level = np.polyfit(x, y, 1, w=weights)
    return {"factor": math.exp(level), "decay": -1.0 / float(slope)}, np.asarray(level + slope * x)


def _fit_greenwood_tripp(x: Array, y: Array, weights: Array) -> tuple[dict[str, float], Array]:
    from scipy.optimize import least_squares

    def miss(constants: Array) -> Array:
        return np.append(weights * (predict(constants) - y), constants[1:] / (_OFFSET_STD, _LOG_SIGMA_STD))

    def predict(constants: Array) -> Array:
        level, offset, log_sigma = constants
        return np.asarray(level + log_five_halves((x - offset) / math.exp(log_sigma)))

    start = np.array([float(np.mean(y - log_five_halves(x))), 0.0, 0.0])
    found = least_squares(miss, start, x_scale=(1.0, 0.3, 0.1)).x
    constants = {"factor": math.exp(found[0]), "offset": float(found[1]), "sigma": math.exp(found[2])}
    return constants, predict(found)


def log_five_halves(x: Array) -> Array:
    r"""Return the logarithm of F_5/2 of Greenwood and Tripp.

    .. math:: F_n(x) = \frac{1}{\sqrt{2 \pi}} \int_x^\infty (t - x)^n e^{-t^2 / 2} dt
       = \frac{\Gamma(n + 1)}{\sqrt{2 \pi}} e^{-x^2 / 4} D_{-n-1}(x)

    References
    ----------
    Abramowitz and Stegun, Handbook of Mathematical Functions (1964), 19.5.3
    """
    from scipy.special import gamma, pbdv

    value = pbdv(-3.5, x)[0]
    return np.asarray(math.log(gamma(3.5) / math.sqrt(2.0 * math.pi)) - 0.25 * x**2 + np.log(value))


def fit_peklenik(separations: Array, along: Array, across: Array) -> FilmFit:
    """Return Peklenik's number of which Patir and Cheng's pressure flow factors are nearest, by least squares.

    Above 1 for a lay along x, along which liquid flows easily; fitted where H is at least 1.5, from 1/9 to 9.
    """
    from scipy.optimize import minimize_scalar

    far = separations >= _MIN_PATIR_CHENG
    if not far.any():
        raise InputError(
            f"A Peklenik number needs a separation of {_MIN_PATIR_CHENG:g} Sq or more: give one, such as 2 and 3."
        )
    x = separations[far]
    factors = np.concatenate((along[far], across[far]))

    def predict(log_peklenik: float) -> Array:
        return np.concatenate([patir_cheng(x, sign * log_peklenik) for sign in (1.0, -1.0)])

    def squares(one: float) -> float:
        return float(np.sum((predict(one) - factors) ** 2))

    limit = math.log(9.0)
    starts = np.linspace(-limit, limit, 25)
    best = starts[int(np.argmin([squares(one) for one in starts]))]
    bounds = max(best - 0.2, -limit), min(best + 0.2, limit)
    found = float(minimize_scalar(squares, bounds=bounds, method="bounded").x)
    flows = factors > 0.0
    misfit = float(np.abs(predict(found)[flows] / factors[flows] - 1.0).max(initial=0.0))
    return FilmFit("patir-cheng", {"peklenik": math.exp(found)}, (float(x.min()), float(x.max())), misfit)


def patir_cheng(separations: Array, log_peklenik: float) -> Array:
    """Return Patir and Cheng's pressure flow factor along x, between their fits linear in the logarithm of the number.

    References
    ----------
    Patir and Cheng, Journal of Lubrication Technology 100 (1978) 12-17, https://doi.org/10.1115/1.3453103
    """
    known = np.log(list(_PATIR_CHENG))
    curves = [
        1.0 - factor * np.exp(-rate * separations) if number <= 1.0 else 1.0 + factor * separations**-rate
        for number, (factor, rate) in _PATIR_CHENG.items()
    ]
    table = np.stack(curves)
    return np.array([np.interp(log_peklenik, known, table[:, row]) for row in range(separations.size)])
