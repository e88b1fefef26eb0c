"""Temperature of the surface of a half-space that moves below sources of heat: its convolution on the cells."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, Pair, Waves, matrix_product
from roughcontact._base.machine import threads_for
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._solve.convolvers import padded_shape

# Mean step between nodes in the logarithm of sqrt(D t), and step of motion over sqrt(D t): the integrand is a Gaussian
# of sqrt(2 D t) there. Halved they change no temperature by more than 3e-7 of the highest.
_LOGARITHMIC_STEP = 0.2
_MOTION_STEP = 0.6
# First and last sqrt(D t), over a cell and over the domain: what is omitted falls in proportion to the first.
_FIRST_LENGTH = 1e-8
_LAST_LENGTH = 1e7
# Exponent below which a Gaussian counts as zero.
_MAX_EXPONENT = 40.0
# Gauss points of a panel, and panels whose profiles are held at a time.
_POINTS = 16
_PANELS_AT_A_TIME = 16


def sum_sources(shape: tuple[int, int], sides: Pair, peclet: Pair) -> Array:
    r"""Return the temperature at the centres of all cells by a source on one, without a border, in units of q u / k.

    .. math:: T(x, y) = \int_0^\infty \sqrt{\frac{1}{\pi t}}\,X(x - P_x t)\,Y(y - P_y t)\,\mathrm{d}t, \qquad
       X(x) = \frac12 \left[\mathrm{erf}\frac{x + a}{2\sqrt t} - \mathrm{erf}\frac{x - a}{2\sqrt t}\right]

    with Y like X: over nodes of the integral a product of two matrices.

    Parameters
    ----------
    shape
        Number of cells (nx, ny).
    sides
        Sides of a cell in units of length u.
    peclet
        Velocity (x, y) of the surface times u over the diffusivity D. Time is in u^2 / D.

    Returns
    -------
    numpy.ndarray
        Shape (2 nx - 1, 2 ny - 1), of the offsets from -(nx - 1), -(ny - 1) on.
    """
    speed = math.hypot(*peclet)
    reach = math.hypot(shape[0] * sides[0], shape[1] * sides[1])
    last = _LAST_LENGTH * reach
    if speed > 0.0:
        # Behind the domain the heat is carried away: (speed t - reach)^2 = 4 t times the exponent.
        root = math.sqrt(_MAX_EXPONENT)
        last = min(last, (root + math.sqrt(_MAX_EXPONENT + speed * reach)) / speed)
    places = [np.arange(1.0 - n, n) * side for n, side in zip(shape, sides, strict=True)]
    total = np.zeros((places[0].size, places[1].size))
    for lengths, weights in _list_nodes(speed, min(sides), last):
        x, y = (
            _find_profile(at, side, lengths, speed_along * lengths**2)
            for at, side, speed_along in zip(places, sides, peclet, strict=True)
        )
        total += matrix_product(x * weights, y.T)
    return total


def sum_periodic_waves(shape: tuple[int, int], sides: Pair, peclet: Pair) -> Waves:
    r"""Return the waves of `sum_sources` where the domain repeats, shape (nx, ny // 2 + 1), without the mean.

    Sources of up to :math:`\tau` ago are summed over their images, those before over their waves (Ewald):

    .. math:: \int_\tau^\infty \sqrt{\frac{1}{\pi t}}\, e^{-z t}\,\mathrm{d}t = \frac{\mathrm{erfc}\sqrt{z\tau}}
       {\sqrt z}, \qquad z = |q|^2 + i\, q \cdot P
    """
    speed = math.hypot(*peclet)
    # No wave that the cells do not carry outlives it.
    last = math.sqrt(_MAX_EXPONENT) / math.pi * max(sides)
    near = np.zeros(shape)
    for lengths, weights in _list_nodes(speed, min(sides), last):
        x, y = (
            _find_periodic_profile(n, side, lengths, speed_along * lengths**2)
            for n, side, speed_along in zip(shape, sides, peclet, strict=True)
        )
        near += matrix_product(x * weights, y.T)
    waves: Waves = scipy.fft.rfft2(near, workers=threads_for(near.size))
    root = _find_roots(shape, sides, peclet)
    of_cell = np.sinc(scipy.fft.fftfreq(shape[0]))[:, np.newaxis] * np.sinc(scipy.fft.rfftfreq(shape[1]))
    waves += of_cell * scipy.special.erfc(root * last) / root
    waves[0, 0] = 0.0
    return waves


def _find_roots(shape: tuple[int, int], sides: Pair, peclet: Pair) -> Waves:
    """Return the root of z of each wave, 1 over its temperature by a flow of one; that of the mean is half of x's."""
    qx = 2.0 * np.pi / sides[0] * scipy.fft.fftfreq(shape[0])[:, np.newaxis]
    qy = 2.0 * np.pi / sides[1] * scipy.fft.rfftfreq(shape[1])[np.newaxis, :]
    roots: Waves = np.sqrt(qx**2 + qy**2 + 1j * (qx * peclet[0] + qy * peclet[1]))
    roots[0, 0] = np.pi / (sides[0] * shape[0])
    return roots


def _list_nodes(speed: float, side: float, last: float) -> Iterator[tuple[Array, Array]]:
    """Return nodes sqrt(t) up to the last and weights of the integral over sqrt(1 / (pi t)) dt, some at a time.

    They are Gauss's, of panels of ln sqrt(t) + b sqrt(t), which Wright's function inverts.
    """
    growth = speed * _LOGARITHMIC_STEP / _MOTION_STEP
    first = _FIRST_LENGTH * side / (1.0 + speed * side)
    start, end = (math.log(length) + growth * length for length in (first, last))
    count = math.ceil((end - start) / (_LOGARITHMIC_STEP * _POINTS))
    half = 0.5 * (end - start) / count
    points, rule = np.polynomial.legendre.leggauss(_POINTS)
    for begin in range(0, count, _PANELS_AT_A_TIME):
        panels = np.arange(begin, min(begin + _PANELS_AT_A_TIME, count))[:, np.newaxis]
        at = (start + half * (2.0 * panels + 1.0 + points)).ravel()
        motion = scipy.special.wrightomega(at + math.log(growth)) if growth > 0.0 else np.zeros(at.size)
        lengths = np.exp(at - motion)
        yield lengths, np.tile(rule, panels.size) * half * 2.0 / math.sqrt(math.pi) * lengths / (1.0 + motion)


def _find_profile(places: Array, side: float, lengths: Array, moved: Array) -> Array:
    """Return X at all places, shape (n,), after all times, given as sqrt(t) and the way moved, shape (m,): (n, m)."""
    distance = places[:, np.newaxis] - moved
    upper, lower = (scipy.special.erf(0.5 * (distance + sign * 0.5 * side) / lengths) for sign in (1.0, -1.0))
    profile: Array = 0.5 * (upper - lower)
    return profile


def _find_periodic_profile(count: int, side: float, lengths: Array, moved: Array) -> Array:
    """Return the sum of `_find_profile` over all images of a period of some cells, shape (count, m)."""
    period = count * side
    distance = np.arange(count)[:, np.newaxis] * side - moved
    distance -= period * np.round(distance / period)
    reach = 2.0 * math.sqrt(_MAX_EXPONENT) * float(lengths[-1]) + 0.5 * side
    images = math.ceil(reach / period + 0.5)
    total = np.zeros(distance.shape)
    for image in range(-images, images + 1):
        for sign in (0.5, -0.5):
            total += sign * scipy.special.erf(0.5 * (distance + image * period + sign * side) / lengths)
    return total


@attrs.frozen(eq=False)
class Conduction:
    """The temperature of a surface by the heat that flows into a half-space, as a convolution on a grid.

    Attributes
    ----------
    grid
        The grid.
    boundary
        Free or periodic.
    """

    grid: Grid
    boundary: Boundary

    @cached_property
    def _padded(self) -> tuple[int, int]:
        return padded_shape(self.grid, self.boundary)

    @property
    def _threads(self) -> int:
        return threads_for(math.prod(self._padded))

    def find_waves(self, conductivity: float, diffusivity: float, velocity: Pair) -> Waves:
        """Return the waves of the temperature by a unit flow into one cell, K m2/W.

        Parameters
        ----------
        conductivity, diffusivity
            Of the body, W/(m K) and m2/s.
        velocity
            Velocity of its surface past the sources along x and y, m/s.
        """
        unit = self.grid.spacing[0]
        sides = (1.0, self.grid.spacing[1] / unit)
        peclet = (velocity[0] * unit / diffusivity, velocity[1] * unit / diffusivity)
        waves: Waves
        if self.boundary is Boundary.PERIODIC:
            waves = sum_periodic_waves(self.grid.shape, sides, peclet)
        else:
            nx, ny = self.grid.shape
            response = np.zeros(self._padded)
            response[: 2 * nx - 1, : 2 * ny - 1] = sum_sources(self.grid.shape, sides, peclet)
            # The source stands at the first cell; offsets below zero stand at the end.
            response = np.roll(response, (1 - nx, 1 - ny), axis=(0, 1))
            waves = scipy.fft.rfft2(response, workers=self._threads)
        waves *= unit / conductivity
        return waves

    def find_free_waves(self, conductivity: float, diffusivity: float, velocity: Pair) -> Waves:
        """Return about `find_waves`, of an endless surface: no wave is zero, as may be where the response is cut."""
        unit = self.grid.spacing[0]
        sides = (1.0, self.grid.spacing[1] / unit)
        peclet = (velocity[0] * unit / diffusivity, velocity[1] * unit / diffusivity)
        waves: Waves = unit / conductivity / _find_roots(self._padded, sides, peclet)
        return waves

    def apply(self, waves: Waves, flow: Array) -> Array:
        """Return the temperature, K, by a flow of heat, shape (nx, ny), W/m2, from `find_waves`."""
        product = scipy.fft.rfft2(flow, self._padded, workers=self._threads)
        product *= waves
        whole: Array = scipy.fft.irfft2(product, self._padded, overwrite_x=True, workers=self._threads)
        nx, ny = self.grid.shape
        # A view would hold the padded one.
        return whole[:nx, :ny].copy()
