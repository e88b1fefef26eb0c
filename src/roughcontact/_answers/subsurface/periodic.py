"""Stress below a pressure on a periodic domain: a factor for each wave of the pressure, with all its aliases."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import attrs
import numpy as np
import scipy.fft
from numpy.polynomial import chebyshev

from roughcontact._answers.subsurface.field import StressPlanes, coarsen
from roughcontact._answers.subsurface.free import COMPONENTS, ODD_IN_X, ODD_IN_Y
from roughcontact._base.arrays import Array, IntArray, Pair, RealArray, Waves
from roughcontact._base.machine import threads_for

# Depth, in sides of a cell, from which aliases have decayed: exp(-4 pi) = 3e-6.
_ALIAS_FREE_DEPTH = 4.0
# Highest order of the aliases, number of averages of neighbouring partial sums (Euler's method), and Chebyshev nodes of
# their sum in the square of the phase: with half as many of each the stress changes by 1e-6 of the pressure.
_MAX_ALIAS_ORDER = 16
_EULER_AVERAGES = 8
_CHEBYSHEV_NODES = 14
# Depth in sides of a cell, times the order, from which an alias has decayed: exp(-2 pi 3) = 6e-9.
_ALIAS_DEPTH = 3.0
# Terms of a sum that are added at a time.
_TERMS_PER_TILE = 2**20


@attrs.frozen(eq=False)
class PeriodicPlanes(StressPlanes):
    r"""The stress below a periodic pressure, which is constant on each cell: a factor for each of its waves.

    With :math:`k = (1 - 2\nu)/q^2 - z/q` a wave of unit amplitude gives

    .. math:: \sigma_{zz} = -(1 + qz) e^{-qz}, \quad \sigma_{xx} = -(2\nu + k q_x^2) e^{-qz}, \quad
              \sigma_{xy} = -k q_x q_y e^{-qz}, \quad \sigma_{xz} = i z q_x e^{-qz}.

    The mean pressure is not the limit of such waves: the body is confined, :math:`\sigma_{xx} = \sigma_{yy} =
    -\nu/(1-\nu) \langle p \rangle`.

    Attributes
    ----------
    pressure
        Pressure on the cells, float32, shape (nx, ny).
    sides
        Sides of a cell.
    """

    pressure: RealArray
    sides: Pair

    @cached_property
    def waves(self) -> Waves:
        """The waves of the pressure, shape (nx, ny // 2 + 1)."""
        return np.asarray(scipy.fft.rfft2(self.pressure, workers=threads_for(self.pressure.size)))

    def at(self, z: float, poisson: float, steps: tuple[int, int]) -> RealArray:
        nx, ny = self.pressure.shape
        waves = coarsen(coarsen(self.waves, ny, steps[1], 1), nx, steps[0], 0)
        shape = nx // steps[0], ny // steps[1]
        sides = steps[0] * self.sides[0], steps[1] * self.sides[1]
        phases = _phases(np.fft.fftfreq(shape[0])), _phases(np.fft.rfftfreq(shape[1]))
        symbols = find_symbols(phases, sides, z, poisson)
        stress = np.empty((len(COMPONENTS), *shape), dtype=np.float32)
        for place, symbol in enumerate(symbols):
            # Where the wave number is half the sampling one, both signs cancel.
            if ODD_IN_X[place] and shape[0] % 2 == 0:
                symbol[shape[0] // 2] = 0.0
            if ODD_IN_Y[place] and shape[1] % 2 == 0:
                symbol[:, -1] = 0.0
            product = waves * symbol
            if ODD_IN_X[place] != ODD_IN_Y[place]:
                product *= 1j
            stress[place] = scipy.fft.irfft2(product, s=shape, overwrite_x=True, workers=threads_for(product.size))
        return stress


def _phases(frequencies: RealArray) -> Array:
    return np.asarray(2.0 * np.pi * frequencies, dtype=np.float64)


def find_symbols(phases: tuple[Array, Array], sides: Pair, z: float, poisson: float) -> list[RealArray]:
    """Return the factors of all waves for each component, float32; components odd in x or y alone lack the factor i.

    Parameters
    ----------
    phases
        Phases q dx and q dy from cell to cell along both axes, from -pi to pi.
    sides
        Sides of a cell.
    z, poisson
        The depth and Poisson's ratio.
    """
    none = np.zeros(1, dtype=np.intp)
    terms = [_Axis(phase.astype(np.float32), side, none) for phase, side in zip(phases, sides, strict=True)]
    sums = _sum_terms(terms[0], terms[1], z, poisson)
    if z < _ALIAS_FREE_DEPTH * max(sides):
        for one, aliases in zip(sums, _sum_aliases(phases, sides, z, poisson), strict=True):
            one += aliases
    trace, xx, zz, yz, xz, xy = sums
    half_x, half_y = (np.sin(0.5 * phase).astype(np.float32) for phase in phases)
    xx[0, 0] = -poisson / (1.0 - poisson)
    zz[0, 0] = -1.0
    trace[0, 0] = -(1.0 + poisson) / (1.0 - poisson)
    yz *= half_y
    xz *= half_x[:, np.newaxis]
    xy *= half_x[:, np.newaxis]
    xy *= half_y
    trace -= xx
    trace -= zz
    return [xx, trace, zz, yz, xz, xy]


@attrs.frozen(eq=False)
class _Axis:
    """Waves along one axis: their phases, shape (n,), the sides of the cells, and the orders of their aliases."""

    phase: RealArray
    side: float
    orders: IntArray

    @cached_property
    def wavenumbers(self) -> RealArray:
        """Shape (n, orders)."""
        return np.asarray((self.phase[:, np.newaxis] + self._shifts) / self.phase.dtype.type(self.side))

    @cached_property
    def amplitudes(self) -> RealArray:
        """The amplitudes of waves in unit pressure on cells, weighted for the sum, shape (n, orders)."""
        with np.errstate(invalid="ignore"):
            sinc = 2.0 * np.sin(0.5 * self.phase[:, np.newaxis]) / (self.phase[:, np.newaxis] + self._shifts)
        sinc[(self.phase == 0.0)[:, np.newaxis] & (self.orders == 0)] = 1.0
        return np.asarray(sinc * self._weights)

    @cached_property
    def slopes(self) -> RealArray:
        """Wave numbers times amplitudes, over the sine of half the phase, shape (orders,)."""
        return np.asarray(2.0 / self.side * self._weights)

    @property
    def _shifts(self) -> RealArray:
        return (2.0 * np.pi * self.orders).astype(self.phase.dtype)

    @property
    def _weights(self) -> RealArray:
        """Alternating signs, and Euler's weights of the last terms."""
        sums = np.tri(_MAX_ALIAS_ORDER + 1)
        for _ in range(_EULER_AVERAGES):
            sums = 0.5 * (sums[1:] + sums[:-1])
        order = np.abs(self.orders)
        return np.asarray(sums[-1][order] * (1.0 - 2.0 * (order % 2))).astype(self.phase.dtype)


def _sum_terms(along_x: _Axis, along_y: _Axis, z: float, poisson: float) -> list[RealArray]:
    """Return the sums over all orders for the trace, xx, zz, yz, xz and xy, shape (n, m) each.

    Components that are odd along an axis are divided by the sine of half the phase.
    """
    kind = along_x.phase.dtype.type
    sums = [np.zeros((along_x.phase.size, along_y.phase.size), dtype=kind) for _ in COMPONENTS]
    step = max(1, _TERMS_PER_TILE // sums[0].size)
    pairs = [(m, n) for m in range(along_x.orders.size) for n in range(along_y.orders.size)]
    for start in range(0, len(pairs), step):
        m, n = (np.array(side) for side in zip(*pairs[start : start + step], strict=True))
        x = along_x.wavenumbers[:, np.newaxis, m]
        y = along_y.wavenumbers[:, n]
        even_x = along_x.amplitudes[:, np.newaxis, m]
        even_y = along_y.amplitudes[:, n]
        odd_x = along_x.slopes[m]
        odd_y = along_y.slopes[n]
        q = np.sqrt(x * x + y * y)
        decay = np.exp(-kind(z) * q)
        even = even_x * even_y * decay
        with np.errstate(divide="ignore", invalid="ignore"):
            k = (kind(1.0 - 2.0 * poisson) / q - kind(z)) / q
            sums[1] -= (even * (kind(2.0 * poisson) + k * x * x)).sum(axis=-1)
            sums[5] -= (k * decay * odd_x * odd_y).sum(axis=-1)
        sums[0] -= kind(2.0 + 2.0 * poisson) * even.sum(axis=-1)
        sums[2] -= (even * (kind(1.0) + kind(z) * q)).sum(axis=-1)
        sums[3] += kind(z) * (decay * even_x * odd_y).sum(axis=-1)
        sums[4] += kind(z) * (decay * odd_x * even_y).sum(axis=-1)
    # The mean pressure, where k is not finite, is treated apart.
    mean = (along_x.phase == 0.0)[:, np.newaxis] & (along_y.phase == 0.0)
    for one in sums:
        one[mean] = 0.0
    return sums


def _sum_aliases(phases: tuple[Array, Array], sides: Pair, z: float, poisson: float) -> Sequence[Array]:
    """Return the sums over all aliases, which are smooth and even in the phase along each aliased axis."""
    none = np.zeros(1, dtype=np.intp)
    nodes = 0.5 * np.pi**2 * (1.0 + np.cos(np.pi * (np.arange(_CHEBYSHEV_NODES) + 0.5) / _CHEBYSHEV_NODES))
    vandermonde = np.linalg.inv(_vandermonde(nodes))
    to_x, to_y = (_vandermonde(phase**2) @ vandermonde for phase in phases)
    exact = [_Axis(np.abs(phase), side, none) for phase, side in zip(phases, sides, strict=True)]
    smooth = [_Axis(np.sqrt(nodes), side, _list_aliases(z / side)) for side in sides]
    along_x = _sum_terms(smooth[0], exact[1], z, poisson)
    along_y = _sum_terms(exact[0], smooth[1], z, poisson)
    both = _sum_terms(smooth[0], smooth[1], z, poisson)
    return [
        (to_x @ (x + xy @ to_y.T) + y @ to_y.T).astype(np.float32)
        for x, y, xy in zip(along_x, along_y, both, strict=True)
    ]


def _list_aliases(depth: float) -> IntArray:
    """Return the orders of the aliases that have not decayed at a depth, in sides of a cell."""
    most = _MAX_ALIAS_ORDER if depth * _MAX_ALIAS_ORDER <= _ALIAS_DEPTH else math.ceil(_ALIAS_DEPTH / depth)
    return np.array([order for order in range(-most, most + 1) if order != 0], dtype=np.intp)


def _vandermonde(square: Array) -> Array:
    return np.asarray(chebyshev.chebvander(2.0 * square / math.pi**2 - 1.0, _CHEBYSHEV_NODES - 1))
