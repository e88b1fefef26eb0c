"""The waves of heights on a grid: their discrete power spectrum."""

from __future__ import annotations

import math

import attrs
import numpy as np
import scipy.fft

from roughcontact._base.checks import SMALLEST, Array, flag, heights_array
from roughcontact._parts.grid import Grid
from roughcontact.errors import InputError

# Modes in a Hann window w for each independent one: the mean of w^4 over the squared mean of w^2, along each axis.
_DEPENDENT = (35.0 / 18.0) ** 2

# Power over that of the strongest wave below which it is rounding.
_ROUNDING = 1e-28


@attrs.frozen(eq=False)
class Waves:
    """The waves of heights, without their mean, in cells along x and units of `height`; -q is counted with q.

    Attributes
    ----------
    qx, qy
        Wave numbers, shape (waves,), rad a cell along x.
    power
        Mean square of the mode q or -q, shape (waves,).
    count
        Modes that an entry stands for, two or one, shape (waves,).
    height, cell
        Units of the heights and lengths, m.
    dependent
        Modes for each independent one.
    """

    qx: Array
    qy: Array
    power: Array
    count: Array
    height: float
    cell: float
    dependent: float

    @property
    def square(self) -> Array:
        """Squared wave numbers, shape (waves,)."""
        return np.asarray(self.qx**2 + self.qy**2)

    def sum(self, weight: Array | float) -> float:
        """Return the sum over all modes of weight times power."""
        return float(np.sum(self.count * weight * self.power))

    def spread(self, weight: Array | float) -> float:
        r"""Return the standard deviation of the weighted sum over surfaces of the same spectrum.

        The power of a pair of modes of a Gaussian surface is exponentially distributed: the variance of the sum is
        the sum of the squares of the pairs' expected parts, of which the squares found are on average twice as large.
        """
        return math.sqrt(self.dependent * float(np.sum(self.count * (weight * self.power) ** 2)))


def list_waves(heights: Array, grid: Grid, periodic: bool) -> Waves:
    """Return the waves of heights, shape `grid.shape`, m; those that do not repeat are windowed (Hann)."""
    if not isinstance(grid, Grid):
        raise InputError.about("The grid", grid, "a Grid(shape, size)")
    heights = heights_array(heights)
    if heights.shape != grid.shape:
        raise InputError.about("The heights", heights, f"of the shape of the grid, {grid.shape}")
    return transform_waves(heights, grid, flag(periodic, "periodic="))


def transform_waves(heights: Array, grid: Grid, periodic: bool = True) -> Waves:
    """Return the waves of heights that have been checked; see `list_waves`."""
    largest = max(float(heights.max()), -float(heights.min()))
    if largest < SMALLEST:
        raise InputError(f"The heights are below {SMALLEST:g} m: there is no roughness.")
    scaled = heights / largest
    scaled -= scaled.mean()
    unit = max(float(scaled.max()), -float(scaled.min()))
    if unit <= 16.0 * float(np.finfo(np.float64).eps):
        raise InputError("All heights are equal: there is no roughness.")
    scaled /= unit
    modes = scipy.fft.rfft2(scaled if periodic else _window(scaled), norm="forward")
    power = modes.real**2
    power += modes.imag**2
    power[0, 0] = 0.0
    # Of a band-limited surface most modes are rounding.
    i, j = np.nonzero(power > _ROUNDING * power.max())
    nx, ny = grid.shape
    ratio = grid.spacing[0] / grid.spacing[1]
    qx = 2.0 * np.pi * scipy.fft.fftfreq(nx)[i]
    qy = 2.0 * np.pi * ratio * scipy.fft.rfftfreq(ny)[j]
    count = np.where((j == 0) | (2 * j == ny), 1.0, 2.0)
    return Waves(qx, qy, power[i, j], count, unit * largest, grid.spacing[0], 1.0 if periodic else _DEPENDENT)


def _window(heights: Array) -> Array:
    """Return heights times a Hann window of mean square one, without their mean."""
    windows = [np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 if n > 1 else np.ones(1) for n in heights.shape]
    window = windows[0][:, np.newaxis] * windows[1][np.newaxis, :]
    window /= np.sqrt(np.mean(window**2))
    return np.asarray((heights - np.sum(heights * window) / np.sum(window)) * window)
