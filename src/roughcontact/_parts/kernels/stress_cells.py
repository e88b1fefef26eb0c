"""Stress below cells of a half-space with a uniform load: Love's and Cerruti's solutions, and waves with aliases."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeAlias

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, Pair, RealArray
from roughcontact._base.machine import map_tiles, split
from roughcontact._parts.kernels.base import odd_axes
from roughcontact._parts.kernels.cells import alternating_weights, chebyshev_nodes, interpolate

# The components of the stress, in Voigt's order.
STRESS_COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
# Their places after an exchange of the axes x and y.
_EXCHANGED_COMPONENTS = [1, 0, 2, 4, 3, 5]
# Values of a table that are computed at a time.
_TILE_VALUES = 2**16
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


def cell_stress(
    z: float, poisson: float, shape: tuple[int, int], sides: Pair, dtype: type[Any], load: str = "z"
) -> RealArray:
    r"""Return the stress by a unit load on one cell, tension positive, `STRESS_COMPONENTS`, shape (6, nx, ny).

    With the corners :math:`X = x \pm a, Y = y \pm b` of the cell seen from the point, :math:`R^2 = X^2 + Y^2 + z^2`,
    :math:`V = -\arctan(XY / zR)` and :math:`C = \arctan(Y/X) - \arctan(zY / XR)`, a pressure gives

    .. math:: 2\pi\sigma_{xx} = \sum \pm [2\nu V - (1 - 2\nu) C - z V_{xx}], \quad
              2\pi\sigma_{zz} = \sum \pm [V + z (V_{xx} + V_{yy})], \ldots

    and a traction along x, by integration of Cerruti's point force,

    .. math:: 2\pi\sigma_{xx} &= \sum \pm \left[2\ln(R + Y) + \frac{2\nu Y}{R + z} + \frac{zY}{R(R + z)}
              - \frac{z^2 Y}{R (X^2 + z^2)}\right], \\
              2\pi\sigma_{xy} &= \sum \pm \left[\ln(R + X) - \frac{2\nu X}{R + z} - \frac{zX}{R(R + z)}\right], \quad
              2\pi\sigma_{xz} = \sum \pm \left[V + \frac{zXY}{R (X^2 + z^2)}\right], \ldots

    Parameters
    ----------
    z
        Depth, in sides of a cell along x.
    poisson
        Poisson's ratio of the body.
    shape
        Offsets (nx, ny) of the point from the centre of the cell: 0 .. nx-1 cells along x, 0 .. ny-1 along y.
    sides
        Sides of the cell.
    dtype
        Precision of the table: float32 or float64.
    load
        ``"z"``, a pressure, or ``"x"`` or ``"y"``, a traction along this axis.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009;
    Johnson, Contact Mechanics (1985), sec. 3.6, https://doi.org/10.1017/CBO9781139171731
    """
    if load == "y":
        exchanged = cell_stress(z, poisson, shape[::-1], sides[::-1], dtype, "x")
        return np.ascontiguousarray(exchanged[_EXCHANGED_COMPONENTS].transpose(0, 2, 1))
    # One corner more than there are cells, from half a cell before the centre of the first cell.
    x = ((np.arange(shape[0] + 1) - 0.5) * sides[0]).astype(dtype)[:, np.newaxis]
    y = ((np.arange(shape[1] + 1) - 0.5) * sides[1]).astype(dtype)[np.newaxis, :]
    table = np.empty((len(STRESS_COMPONENTS), *shape), dtype=dtype)
    sum_corners = _sum_corners if load == "z" else _sum_shear_corners

    def work(rows: slice) -> None:
        for place, corners in enumerate(sum_corners(x[rows.start : rows.stop + 1], y, dtype(z), poisson)):
            across = np.subtract(corners[1:], corners[:-1])
            np.subtract(across[:, 1:], across[:, :-1], out=table[place, rows])

    map_tiles(work, split(shape[0], max(1, _TILE_VALUES // shape[1])))
    return table


def _sum_corners(x: RealArray, y: RealArray, z: Any, poisson: float) -> tuple[RealArray, ...]:
    """Return the terms of a corner under pressure for each component, without those of x or of y alone."""
    scale = 0.5 / math.pi
    shear = 1.0 - 2.0 * poisson
    xx = x * x
    yy = y * y
    xy = x * y
    square = xx + yy
    r = np.sqrt(square + z * z)
    # At the surface the quotient is infinite and its arc tangent a right angle.
    with np.errstate(divide="ignore", over="ignore"):
        v = np.arctan(xy / (z * r))
    beyond = r + z
    # The difference of both arc tangents as one of them, R - z without cancellation.
    c = np.arctan(xy * (square / beyond) / (xx * r + z * yy))
    along_x = 1.0 / (r * (xx + z * z))
    along_y = 1.0 / (r * (yy + z * z))
    bend_x = (z * scale) * xy * along_x
    bend_y = (z * scale) * xy * along_y
    v *= scale
    c *= scale * shear
    # V_xx + V_yy and both C together follow from Laplace's equation.
    return (
        bend_x - 2.0 * poisson * v - c,
        bend_y - v + c,
        -(v + bend_x + bend_y),
        (z * z * scale) * x * along_y,
        (z * z * scale) * y * along_x,
        -scale * (shear * np.log(beyond) + z / r),
    )


def _sum_shear_corners(x: RealArray, y: RealArray, z: Any, poisson: float) -> tuple[RealArray, ...]:
    """Return the terms of a corner under traction along x for each component, without those of x or of y alone."""
    scale = 0.5 / math.pi
    xx = x * x
    yy = y * y
    depth = z * z
    r = np.sqrt(xx + yy + depth)
    with np.errstate(divide="ignore", over="ignore"):
        v = np.arctan(x * y / (z * r))
    along_x = scale * z / (r * (xx + depth))
    beyond = r + z
    bend = scale * z / (r * beyond)
    lateral = scale * 2.0 * poisson / beyond
    # ln(R + Y) without its part in X, odd in Y; ln(R + X) likewise.
    log_y = scale * np.arcsinh(y / np.sqrt(xx + depth))
    log_x = scale * np.arcsinh(x / np.sqrt(yy + depth))
    return (
        2.0 * log_y + y * (lateral + bend - z * along_x),
        2.0 * poisson * log_y - y * (lateral + bend),
        z * y * along_x,
        -scale * z / r,
        x * y * along_x - scale * v,
        log_x - x * (lateral + bend),
    )


def wave_stress(phases: tuple[Array, Array], sides: Pair, z: float, poisson: float, load: str = "z") -> RealArray:
    r"""Return the stress at the centres of cells by waves of unit load, float32, shape (6, m, n).

    The order is `STRESS_COMPONENTS`; of components that are odd in one axis it is the imaginary part. With
    :math:`k = (1 - 2\nu)/q^2 - z/q` a wave of the pressure of unit amplitude gives

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

    Parameters
    ----------
    phases
        Phases q dx and q dy from cell to cell along both axes, from -pi to pi, shapes (m,) and (n,).
    sides
        Sides of a cell.
    z, poisson
        The depth and Poisson's ratio.
    load
        ``"z"``, a pressure, or ``"x"`` or ``"y"``, a traction along this axis.
    """
    if load == "y":
        exchanged = wave_stress(phases[::-1], sides[::-1], z, poisson, "x")
        return exchanged[_EXCHANGED_COMPONENTS].transpose(0, 2, 1)
    none = np.zeros(1, dtype=np.intp)
    find_terms = _find_pressure_terms if load == "z" else _find_shear_terms
    terms = [_Axis(phase.astype(np.float32), side, none) for phase, side in zip(phases, sides, strict=True)]
    sums = _sum_terms(terms[0], terms[1], z, poisson, find_terms)
    if z < _ALIAS_FREE_DEPTH * max(sides):
        _add_aliases(sums, phases, sides, z, poisson, find_terms)
    trace, xx, zz, yz, xz, xy = sums
    mean = np.ix_(phases[0] == 0.0, phases[1] == 0.0)
    if load == "z":
        xx[mean] = -poisson / (1.0 - poisson)
        zz[mean] = -1.0
        trace[mean] = -(1.0 + poisson) / (1.0 - poisson)
    else:
        xz[mean] = -1.0
    half_x, half_y = (np.sin(0.5 * phase).astype(np.float32) for phase in phases)
    for component, one in zip(("xx", "xx", "zz", "yz", "xz", "xy"), sums, strict=True):
        odd_in_x, odd_in_y = odd_axes(component + load)
        if odd_in_x:
            one *= half_x[:, np.newaxis]
        if odd_in_y:
            one *= half_y
    trace -= xx
    trace -= zz
    return np.array([xx, trace, zz, yz, xz, xy])


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
        """The weights of an alternating series, shape (orders,)."""
        weights = alternating_weights(_MAX_ALIAS_ORDER, _EULER_AVERAGES)[1]
        return weights[self.orders + _MAX_ALIAS_ORDER].astype(self.phase.dtype)


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


def _sum_terms(along_x: _Axis, along_y: _Axis, z: float, poisson: float, find_terms: _FindTerms) -> RealArray:
    """Return the sums over all orders for the trace, xx, zz, yz, xz and xy, shape (6, n, m).

    Components that are odd along an axis are divided by the sine of half the phase.
    """
    kind = along_x.phase.dtype.type
    sums = np.zeros((len(STRESS_COMPONENTS), along_x.phase.size, along_y.phase.size), dtype=kind)
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
    sums[:, mean] = 0.0
    return sums


def _add_aliases(
    sums: RealArray, phases: tuple[Array, Array], sides: Pair, z: float, poisson: float, find_terms: _FindTerms
) -> None:
    """Add the sums over all aliases, which are smooth and even in the phase along each aliased axis."""
    none = np.zeros(1, dtype=np.intp)
    nodes = np.sqrt(chebyshev_nodes(_CHEBYSHEV_NODES))
    theta_x, theta_y = (np.abs(phase) for phase in phases)
    exact = [_Axis(theta, side, none) for theta, side in zip((theta_x, theta_y), sides, strict=True)]
    smooth = [_Axis(nodes, side, _list_aliases(z / side)) for side in sides]
    along_x = _sum_terms(smooth[0], exact[1], z, poisson, find_terms)
    along_y = _sum_terms(exact[0], smooth[1], z, poisson, find_terms)
    both = _sum_terms(smooth[0], smooth[1], z, poisson, find_terms)
    along_x += _interpolate(both, theta_y, 2)
    sums += _interpolate(along_x, theta_x, 1)
    sums += _interpolate(along_y, theta_y, 2)


def _interpolate(values: Array, theta: Array, axis: int) -> Array:
    """Interpolate values at the nodes along an axis of an array of three."""
    ahead = np.moveaxis(values, axis, 0)
    found = interpolate(ahead.reshape(ahead.shape[0], -1), theta)
    return np.moveaxis(found.reshape(theta.size, *ahead.shape[1:]), 0, axis)


def _list_aliases(depth: float) -> IntArray:
    """Return the orders of the aliases that have not decayed at a depth, in sides of a cell."""
    most = _MAX_ALIAS_ORDER if depth * _MAX_ALIAS_ORDER <= _ALIAS_DEPTH else math.ceil(_ALIAS_DEPTH / depth)
    return np.array([order for order in range(-most, most + 1) if order != 0], dtype=np.intp)
