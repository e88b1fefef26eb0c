"""Stress below a load on a periodic domain: a factor for each wave of the load, with all its aliases."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, TypeAlias

import attrs
import numpy as np
import scipy.fft
from numpy.polynomial import chebyshev

from roughcontact._answers.subsurface.field import COMPONENTS, LoadedPlanes, is_odd
from roughcontact._base.arrays import Array, IntArray, Pair, RealArray, Waves, matrix_product
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
class PeriodicPlanes(LoadedPlanes):
    r"""The stress below a periodic load, which is constant on each cell: a factor for each of its waves.

    With :math:`k = (1 - 2\nu)/q^2 - z/q` a wave of the pressure of unit amplitude gives

    .. math:: \sigma_{zz} = -(1 + qz) e^{-qz}, \quad \sigma_{xx} = -(2\nu + k q_x^2) e^{-qz}, \quad
              \sigma_{xy} = -k q_x q_y e^{-qz}, \quad \sigma_{xz} = i z q_x e^{-qz}

    and one of a traction along x

    .. math:: \sigma_{xx} &= \frac{i q_x}{q} \left(2 + \frac{2\nu q_y^2 - z q q_x^2}{q^2}\right) e^{-qz}, &
              \sigma_{yy} &= \frac{i q_x}{q^3} (2\nu q_x^2 - z q q_y^2)\, e^{-qz}, &
              \sigma_{zz} &= i z q_x e^{-qz}, \\
              \sigma_{xy} &= \frac{i q_y}{q} \left(1 - \frac{(2\nu + qz)\, q_x^2}{q^2}\right) e^{-qz}, &
              \sigma_{xz} &= -\left(1 - \frac{z q_x^2}{q}\right) e^{-qz}, &
              \sigma_{yz} &= \frac{z q_x q_y}{q} e^{-qz}.

    The mean pressure is not the limit of such waves: the body is confined, :math:`\sigma_{xx} = \sigma_{yy} =
    -\nu/(1-\nu) \langle p \rangle`. The mean traction gives :math:`\sigma_{xz} = -\langle q_x \rangle` alone.
    """

    @property
    def padded(self) -> tuple[int, int]:
        """The cells themselves."""
        nx, ny = self.pressure.shape
        return nx, ny

    def add(
        self, stress: RealArray, load: str, waves: Waves, shape: tuple[int, int], sides: Pair, z: float, poisson: float
    ) -> None:
        phases = _phases(np.fft.fftfreq(shape[0])), _phases(np.fft.rfftfreq(shape[1]))
        symbols = find_symbols(phases, sides, z, poisson, load)
        if self.layers is not None:
            added = self.layers.find_symbols(load, phases, sides, z).astype(np.float32)
            symbols = [symbol + one for symbol, one in zip(symbols, added, strict=True)]
        add_stress(stress, waves, symbols, load, shape)


def add_stress(
    stress: RealArray, waves: Waves, symbols: Sequence[RealArray], load: str, shape: tuple[int, int]
) -> None:
    """Add the stress of a load, of which waves and factors are given, on a periodic grid of `shape`, its first rows."""
    for place, symbol in enumerate(symbols):
        odd_in_x, odd_in_y = (is_odd(axis, COMPONENTS[place], load) for axis in "xy")
        # Where the wave number is half the sampling one, both signs cancel.
        if odd_in_x and shape[0] % 2 == 0:
            symbol[shape[0] // 2] = 0.0
        if odd_in_y and shape[1] % 2 == 0:
            symbol[:, -1] = 0.0
        product = waves * symbol
        if odd_in_x != odd_in_y:
            product *= 1j
        workers = threads_for(product.size)
        stress[place] += scipy.fft.irfft2(product, s=shape, overwrite_x=True, workers=workers)[: stress.shape[1]]


def _phases(frequencies: RealArray) -> Array:
    return np.asarray(2.0 * np.pi * frequencies, dtype=np.float64)


def find_symbols(
    phases: tuple[Array, Array], sides: Pair, z: float, poisson: float, load: str = "z"
) -> list[RealArray]:
    """Return the factors of all waves for each component, float32; components odd in x or y alone lack the factor i.

    Parameters
    ----------
    phases
        Phases q dx and q dy from cell to cell along both axes, from -pi to pi.
    sides
        Sides of a cell.
    z, poisson
        The depth and Poisson's ratio.
    load
        ``"z"``, a pressure, or ``"x"`` or ``"y"``, a traction along this axis.
    """
    if load == "y":
        yy, xx, zz, xz, yz, xy = (symbol.T for symbol in find_symbols(phases[::-1], sides[::-1], z, poisson, "x"))
        return [xx, yy, zz, yz, xz, xy]
    none = np.zeros(1, dtype=np.intp)
    find_terms = _find_pressure_terms if load == "z" else _find_shear_terms
    terms = [_Axis(phase.astype(np.float32), side, none) for phase, side in zip(phases, sides, strict=True)]
    sums = _sum_terms(terms[0], terms[1], z, poisson, find_terms)
    if z < _ALIAS_FREE_DEPTH * max(sides):
        for one, aliases in zip(sums, _sum_aliases(phases, sides, z, poisson, find_terms), strict=True):
            one += aliases
    trace, xx, zz, yz, xz, xy = sums
    if load == "z":
        xx[0, 0] = -poisson / (1.0 - poisson)
        zz[0, 0] = -1.0
        trace[0, 0] = -(1.0 + poisson) / (1.0 - poisson)
    else:
        xz[0, 0] = -1.0
    half_x, half_y = (np.sin(0.5 * phase).astype(np.float32) for phase in phases)
    for component, one in zip(("xx", "xx", "zz", "yz", "xz", "xy"), sums, strict=True):
        if is_odd("x", component, load):
            one *= half_x[:, np.newaxis]
        if is_odd("y", component, load):
            one *= half_y
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


@attrs.frozen(eq=False)
class _Terms:
    """Terms of a sum: wave numbers along x and y, and along each axis the even and the odd amplitude; see `_Axis`."""

    x: RealArray
    y: RealArray
    even_x: RealArray
    even_y: RealArray
    odd_x: RealArray
    odd_y: RealArray
    z: Any
    poisson: Any

    @cached_property
    def q(self) -> RealArray:
        return np.asarray(np.sqrt(self.x * self.x + self.y * self.y))

    @cached_property
    def decay(self) -> RealArray:
        return np.asarray(np.exp(-self.z * self.q))


_FindTerms: TypeAlias = Callable[[_Terms], tuple[RealArray, ...]]


def _find_pressure_terms(terms: _Terms) -> tuple[RealArray, ...]:
    """Return the trace, xx, zz, yz, xz and xy of waves of a pressure."""
    z = terms.z
    double = 2 * terms.poisson
    even = terms.even_x * terms.even_y * terms.decay
    k = ((1 - double) / terms.q - z) / terms.q
    return (
        -(2 + double) * even,
        -even * (double + k * terms.x * terms.x),
        -even * (1 + z * terms.q),
        z * (terms.decay * terms.even_x * terms.odd_y),
        z * (terms.decay * terms.odd_x * terms.even_y),
        -(k * terms.decay * terms.odd_x * terms.odd_y),
    )


def _find_shear_terms(terms: _Terms) -> tuple[RealArray, ...]:
    """Return the trace, xx, zz, yz, xz and xy of waves of a traction along x."""
    depth = terms.z * terms.q
    double = 2 * terms.poisson
    decay = terms.decay
    along = (terms.x / terms.q) ** 2
    across = (terms.y / terms.q) ** 2
    odd = terms.odd_x * terms.even_y * decay
    slope = odd / terms.q
    return (
        (2 + double) * slope,
        slope * (2 + double * across - depth * along),
        terms.z * odd,
        terms.z * (decay * terms.odd_x * terms.odd_y) / terms.q,
        -terms.even_x * terms.even_y * decay * (1 - depth * along),
        terms.even_x * terms.odd_y * decay / terms.q * (1 - (double + depth) * along),
    )


def _sum_terms(along_x: _Axis, along_y: _Axis, z: float, poisson: float, find_terms: _FindTerms) -> list[RealArray]:
    """Return the sums over all orders for the trace, xx, zz, yz, xz and xy, shape (n, m) each.

    Components that are odd along an axis are divided by the sine of half the phase.
    """
    kind = along_x.phase.dtype.type
    sums = [np.zeros((along_x.phase.size, along_y.phase.size), dtype=kind) for _ in COMPONENTS]
    step = max(1, _TERMS_PER_TILE // sums[0].size)
    pairs = [(m, n) for m in range(along_x.orders.size) for n in range(along_y.orders.size)]
    for start in range(0, len(pairs), step):
        m, n = (np.array(side) for side in zip(*pairs[start : start + step], strict=True))
        terms = _Terms(
            along_x.wavenumbers[:, np.newaxis, m],
            along_y.wavenumbers[:, n],
            along_x.amplitudes[:, np.newaxis, m],
            along_y.amplitudes[:, n],
            along_x.slopes[m],
            along_y.slopes[n],
            kind(z),
            kind(poisson),
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            for one, term in zip(sums, find_terms(terms), strict=True):
                one += term.sum(axis=-1)
    # The mean load, where the direction of a wave is not defined, is treated apart.
    mean = (along_x.phase == 0.0)[:, np.newaxis] & (along_y.phase == 0.0)
    for one in sums:
        one[mean] = 0.0
    return sums


def _sum_aliases(
    phases: tuple[Array, Array], sides: Pair, z: float, poisson: float, find_terms: _FindTerms
) -> Sequence[Array]:
    """Return the sums over all aliases, which are smooth and even in the phase along each aliased axis."""
    none = np.zeros(1, dtype=np.intp)
    nodes = 0.5 * np.pi**2 * (1.0 + np.cos(np.pi * (np.arange(_CHEBYSHEV_NODES) + 0.5) / _CHEBYSHEV_NODES))
    vandermonde = np.linalg.inv(_vandermonde(nodes))
    to_x, to_y = (matrix_product(_vandermonde(phase**2), vandermonde) for phase in phases)
    exact = [_Axis(np.abs(phase), side, none) for phase, side in zip(phases, sides, strict=True)]
    smooth = [_Axis(np.sqrt(nodes), side, _list_aliases(z / side)) for side in sides]
    along_x = _sum_terms(smooth[0], exact[1], z, poisson, find_terms)
    along_y = _sum_terms(exact[0], smooth[1], z, poisson, find_terms)
    both = _sum_terms(smooth[0], smooth[1], z, poisson, find_terms)
    return [
        (matrix_product(to_x, x + matrix_product(xy, to_y.T)) + matrix_product(y, to_y.T)).astype(np.float32)
        for x, y, xy in zip(along_x, along_y, both, strict=True)
    ]


def _list_aliases(depth: float) -> IntArray:
    """Return the orders of the aliases that have not decayed at a depth, in sides of a cell."""
    most = _MAX_ALIAS_ORDER if depth * _MAX_ALIAS_ORDER <= _ALIAS_DEPTH else math.ceil(_ALIAS_DEPTH / depth)
    return np.array([order for order in range(-most, most + 1) if order != 0], dtype=np.intp)


def _vandermonde(square: Array) -> Array:
    return np.asarray(chebyshev.chebvander(2.0 * square / math.pi**2 - 1.0, _CHEBYSHEV_NODES - 1))
