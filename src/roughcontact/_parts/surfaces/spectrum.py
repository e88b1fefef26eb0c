"""Power spectra of height maps that do not repeat."""

from __future__ import annotations

import math

import attrs
import numpy as np
import numpy.typing as npt
import scipy.fft

from roughcontact._base.checks import Array
from roughcontact._base.units import si
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces.form import polynomial
from roughcontact.errors import InputError

# Degree of the polynomial that is subtracted before the window: tilt and form are not roughness.
_FORM = 2
# Ratio of the longest to the shortest wave through which a power law is fitted, the bands in it, and the sectors of
# direction over half a turn: two octaves of waves, a thousand of them on 128 x 128 cells.
_RANGE = 4.0
_BANDS = 6
_SECTORS = 16
# Waves a side below which window and form change the power, and the smallest ratio of the longest to the shortest wave.
_WAVES = 6.0
_NARROW = 2.0
# Standard deviation of the exponent from the unknown transfer function of a measurement: point samples lower it by 0.1
# to 0.2, means over cells raise it by 0.05 to 0.15 (self-affine surfaces, Hurst exponents 0.3, 0.8; 128 x 128 cells).
_SAMPLING = 0.15
# Modes in a Hann window w for each independent one: the mean of w^4 over the squared mean of w^2, 35/18, along each
# axis, and -q is as q.
_DEPENDENT = 2.0 * (35.0 / 18.0) ** 2


def power_spectrum(heights: Array, steepness: int = 4) -> tuple[Array, Array, Array]:
    r"""Return wave numbers qx, qy, shapes (nx, 1) and (1, ny), rad a cell, and the power there, shape (nx, ny), m2.

    The heights, shape (nx, ny), m, less their quadratic form are windowed by a power of the cosine: the 4th, whose
    leakage falls as :math:`q^{-10}`, faster than any power that matters, or the 2nd (Hann), :math:`q^{-6}`, which
    keeps more independent waves. The power is that of each Fourier mode of a map without window.

    References
    ----------
    Jacobs, Junge, Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001, https://doi.org/10.1088/2051-672X/aa51f8
    """
    rough = heights - polynomial(heights, _FORM, None)
    for axis, count in enumerate(heights.shape):
        window = np.sin(np.pi * (np.arange(count) + 0.5) / count) ** steepness
        rough = rough * np.expand_dims(window / np.sqrt(np.mean(window**2)), 1 - axis)
    power = np.abs(scipy.fft.fft2(rough, norm="forward")) ** 2
    qx, qy = (2.0 * np.pi * scipy.fft.fftfreq(count) for count in heights.shape)
    return qx[:, np.newaxis], qy[np.newaxis, :], power


def mean_in_bands(values: Array, power: Array, edges: Array) -> Array:
    """Return the mean power of the waves whose `values` lie between neighbouring edges; nan where there are none."""
    band = np.digitize(values.ravel(), edges)
    count = np.bincount(band, minlength=edges.size + 1)[1:-1]
    total = np.bincount(band, weights=power.ravel(), minlength=edges.size + 1)[1:-1]
    return np.asarray(np.divide(total, count, out=np.full(count.size, np.nan), where=count > 0))


@attrs.frozen(eq=False)
class PowerLaw:
    """The power of the Fourier modes of a domain: `power` at the wave number `pivot`, falling as q^-`exponent`.

    Attributes
    ----------
    power
        Of each of the sectors of direction over half a turn, m2.
    pivot
        Wave number, rad/m, at which power and exponent are uncorrelated.
    exponent
        2 + 2 Hurst exponent, on self-affine surfaces.
    power_std, exponent_std
        Standard errors of the logarithm of the power at the pivot, and of the exponent.
    """

    power: Array
    pivot: float
    exponent: float
    power_std: float
    exponent_std: float

    def evaluate(self, qx: Array, qy: Array, deviation: float = 0.0) -> Array:
        """Return the power at wave numbers, rad/m, so many standard errors above the law, m2; zero at zero."""
        q = np.hypot(qx, qy) / self.pivot
        logarithm = np.log(q, out=np.zeros_like(q), where=q > 0.0)
        power = np.exp(deviation * np.hypot(self.power_std, self.exponent_std * logarithm) - self.exponent * logarithm)
        power[q == 0.0] = 0.0
        return np.asarray(power * self.power[_sector(qx, qy)])


def fit_power_law(heights: Array, grid: Grid, shortest: float) -> PowerLaw:
    """Return the power law of the spectrum of heights, shape (nx, ny), m, down to waves of `shortest` m.

    The standard errors count the independent modes, the misfit of the bands, and how a map may have been sampled.

    Raises
    ------
    InputError
        If the map is too small, or its spectrum does not fall with the wave number.
    """
    qx, qy, power = power_spectrum(heights, 2)
    qx = qx / grid.spacing[0]
    qy = qy / grid.spacing[1]
    q = np.hypot(qx, qy)
    limit = 2.0 * math.pi / shortest
    start = max(limit / _RANGE, 2.0 * math.pi * _WAVES / min(grid.size))
    if start * _NARROW > limit:
        raise InputError(
            f"The height map of {grid} is too small to extrapolate its spectrum from waves of "
            f"{si(_NARROW * shortest, 'm')} to {si(shortest, 'm')}, of which it must hold at least {_WAVES:g} a side: "
            "give a larger map, or a shorter resolved=."
        )
    edges = np.geomspace(start, limit, _BANDS + 1)
    mean, squares, centre = (
        mean_in_bands(q, values, edges) for values in (power, power**2, np.log(np.maximum(q, start)))
    )
    if not mean.min() > 0.0:
        raise InputError(f"The height map has no waves of {si(shortest, 'm')}, whose spectrum could be extrapolated.")
    # Of independent exponentially distributed powers the mean square is twice the square of the mean.
    weight = 2.0 * np.histogram(q, edges)[0] * mean**2 / squares / _DEPENDENT
    pivot = float(np.average(centre, weights=weight))
    spread = float(np.sum(weight * (centre - pivot) ** 2))
    # The mean logarithm of the mean of n exponentially distributed powers is too small by 1/(2 n).
    level = np.log(mean) + 0.5 / weight
    exponent = -float(np.sum(weight * (centre - pivot) * level)) / spread
    misfit = level - np.average(level, weights=weight) + exponent * (centre - pivot)
    excess = max(1.0, float(np.sum(weight * misfit**2)) / (_BANDS - 2))
    if not exponent > 0.0:
        raise InputError(
            f"The spectrum of the height map does not fall with the wave number down to waves of {si(shortest, 'm')}: "
            "they are noise; give the shortest wave that the map resolves, resolved=."
        )
    stds = math.sqrt(excess / float(np.sum(weight))), math.hypot(math.sqrt(excess / spread), _SAMPLING)
    inside = (q >= start) & (q <= limit)
    sector = _sector(qx, qy)[inside]
    scaled = power[inside] * (q[inside] * math.exp(-pivot)) ** exponent
    modes = np.bincount(sector, minlength=_SECTORS)
    total = np.bincount(sector, weights=scaled, minlength=_SECTORS)
    return PowerLaw(total / np.maximum(modes, 1), math.exp(pivot), exponent, *stds)


def _sector(qx: Array, qy: Array) -> npt.NDArray[np.intp]:
    angle = np.arctan2(qy, qx) / math.pi
    return np.asarray((angle * _SECTORS + 0.5).astype(np.intp) % _SECTORS)
