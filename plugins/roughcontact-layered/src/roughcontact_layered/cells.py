"""Uniform pressure on a cell: displacement by that around a point force, and the aliases of its waves."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from functools import lru_cache
from typing import Protocol, TypeAlias

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev, legendre

from roughcontact_layered.stack import Array

Orders: TypeAlias = npt.NDArray[np.int_]
Aliases: TypeAlias = tuple[Array, Array, Array]
WaveFunction: TypeAlias = Callable[[Array, Array], Array]

# Cells up to this offset, in shorter sides, are integrated from four corners; beyond it, and beyond the second
# offset, by Gauss points: the errors stay below 1e-11 (tests/test_cells.py).
_NEAR = 10
_FAR = 60
# Gauss points along a corner's angle, and across one shorter side between both offsets and beyond.
_CORNER = 40
_BETWEEN = 5
_BEYOND = 3
# Chebyshev nodes in the square of the phase, in which the sum of all aliases is analytic: see `roughcontact.Love`.
_NODES = 20
# Aliases on each side; the outer ones are averaged, because the sum alternates (Euler's method).
_PLAIN = 8
_AVERAGED = 22


class PointForce(Protocol):
    """The displacement around a point force, even in x and in y."""

    def displacement(self, x: Array, y: Array) -> Array:
        """Return the displacement by a unit force at the offsets `x`, `y`, m/N."""

    def along_ray(self, x: Array, y: Array) -> Array:
        """Return the integral over 0 < t < 1 of t times the displacement at the offsets t `x`, t `y`, m/N."""


def cell_integrals(table: PointForce, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Return the displacement at the centre of the cell (0, 0) by unit pressure on the cell (i, j), m/Pa.

    Parameters
    ----------
    table
        Displacement by a unit force.
    shape
        Number of offsets (nx, ny).
    spacing
        Sides of a cell (dx, dy), m.
    """
    shorter = min(spacing)
    near, far = (
        tuple(min(n, max(math.ceil(count * shorter / side), 1) + 1) for n, side in zip(shape, spacing, strict=True))
        for count in (_NEAR, _FAR)
    )
    result = np.empty(shape)
    integrate_gauss(result, table.displacement, spacing, (slice(far[0], None), slice(None)), _BEYOND)
    integrate_gauss(result, table.displacement, spacing, (slice(0, far[0]), slice(far[1], None)), _BEYOND)
    integrate_gauss(result, table.displacement, spacing, (slice(near[0], far[0]), slice(0, far[1])), _BETWEEN)
    integrate_gauss(result, table.displacement, spacing, (slice(0, near[0]), slice(near[1], far[1])), _BETWEEN)
    result[: near[0], : near[1]] = _integrate_corners(table, (near[0], near[1]), spacing)
    return result


def integrate_gauss(
    result: Array, field: WaveFunction, spacing: tuple[float, float], block: tuple[slice, slice], points: int
) -> None:
    """Integrate a field around a point over the cells of a block, into the last two axes of a result.

    Parameters
    ----------
    result
        Integrals over the cell at each offset, shape (..., nx, ny).
    field
        The field at offsets along x and along y, m, of shapes that broadcast; what it adds stands in front.
    spacing
        Sides of a cell (dx, dy), m.
    block
        Offsets along x and along y.
    points
        Gauss points across one shorter side.
    """
    axes = [np.arange(n)[part] * side for n, part, side in zip(result.shape[-2:], block, spacing, strict=True)]
    if not (axes[0].size and axes[1].size):
        return
    total = np.zeros((*result.shape[:-2], axes[0].size, axes[1].size))
    (ax, wx), (ay, wy) = (_gauss_points(side / min(spacing), points) for side in spacing)
    for a, p in zip(ax * spacing[0], wx * spacing[0], strict=True):
        for b, w in zip(ay * spacing[1], wy * spacing[1], strict=True):
            total += p * w * field((axes[0] + a)[:, np.newaxis], (axes[1] + b)[np.newaxis, :])
    result[..., block[0], block[1]] = total


def _gauss_points(sides: float, points: int) -> tuple[Array, Array]:
    """Return Gauss points and weights on -1/2 .. 1/2: so many points on each part of one shorter side."""
    parts = math.ceil(sides - 1e-9)
    at, weight = legendre.leggauss(points)
    places = (np.arange(parts)[:, np.newaxis] + 0.5 * (at + 1.0)) / parts - 0.5
    return places.ravel(), np.tile(0.5 * weight / parts, parts)


def _integrate_corners(table: PointForce, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Take differences of integrals over rectangles with a corner at the origin, odd in either side."""
    x, y = ((np.arange(n + 1) - 0.5) * side for n, side in zip(shape, spacing, strict=True))
    sign = np.sign(x)[:, np.newaxis] * np.sign(y)[np.newaxis, :]
    x, y = (np.abs(side)[index] for side, index in ((x, (slice(None), None)), (y, (None, slice(None)))))
    corners = sign * (_triangle(table.along_ray, x, y) + _triangle(lambda a, b: table.along_ray(b, a), y, x))
    return np.asarray(np.diff(np.diff(corners, axis=0), axis=1))


def _triangle(along_ray: WaveFunction, base: Array, height: Array) -> Array:
    """Integrate over the triangle (0, 0), (base, 0), (base, height), by angle: (base, base sinh(s)) is its far side."""
    at, weight = legendre.leggauss(_CORNER)
    base, height = np.broadcast_arrays(base, height)
    maximum = np.arcsinh(height / base)[..., np.newaxis]
    s = 0.5 * maximum * (at + 1.0)
    far = base[..., np.newaxis]
    inside = along_ray(far, far * np.sinh(s)) * np.cosh(s)
    return np.asarray(0.5 * maximum[..., 0] * base**2 * (inside @ weight))


class WaveResponse(Hashable, Protocol):
    """A kernel, of which a part is known in Fourier space."""

    def wave_rest(self, qx: Array, qy: Array) -> Array:
        """Return the part for wave vectors of shapes that broadcast, rad/m, even in both, m/Pa."""


def cell_waves(
    kernel: WaveResponse,
    qx: Array,
    qy: Array,
    spacing: tuple[float, float],
    aliased: tuple[WaveResponse, ...] | None = None,
) -> Array:
    """Return the part of a kernel at the cell centres by waves of cell pressures, shape (m, n), m/Pa.

    Parameters
    ----------
    kernel
        The kernel.
    qx, qy
        Wave numbers, shapes (m, 1) and (1, n), rad/m, at most half the sampling wave number.
    spacing
        Sides of a cell (dx, dy), m.
    aliased
        The parts whose aliases count, too; by default the kernel itself.
    """
    x, rows = np.unique(np.abs(qx).ravel() * spacing[0], return_inverse=True)
    y, columns = np.unique(np.abs(qy).ravel() * spacing[1], return_inverse=True)
    half = [np.sinc(theta / (2.0 * np.pi)) for theta in (x, y)]
    values = kernel.wave_rest((x / spacing[0])[:, np.newaxis], (y / spacing[1])[np.newaxis, :])
    values = values * half[0][:, np.newaxis] * half[1][np.newaxis, :]
    for part in (kernel,) if aliased is None else aliased:
        values = values + interpolate_aliases(_sum_aliases(part, spacing, x.tobytes(), y.tobytes()), (x, y))
    return np.asarray(values[np.ix_(rows, columns)])


@lru_cache(maxsize=64)
def _sum_aliases(kernel: WaveResponse, spacing: tuple[float, float], across: bytes, along: bytes) -> Aliases:
    """Return the alias sums at nodes, which are small: the coarse grids of each solve need them again."""
    return sum_aliases(kernel.wave_rest, (np.frombuffer(across), np.frombuffer(along)), spacing)


def sum_aliases(rest: WaveFunction, theta: tuple[Array, Array], spacing: tuple[float, float]) -> Aliases:
    r"""Return the sum over all aliases of a wave but itself, at nodes of the phase, for `interpolate_aliases`.

    .. math:: \sum_{(m,n) \ne 0} f(q + Q_{mn})\,\operatorname{sinc}(\theta_x / 2 + \pi m)\,
              \operatorname{sinc}(\theta_y / 2 + \pi n)

    Parameters
    ----------
    rest
        The function f of the wave numbers along x and along y, rad/m, of shapes that broadcast, even in both.
    theta
        Phases q dx, q dy per cell, 0 .. pi, shapes (m,) and (n,).
    spacing
        Sides of a cell (dx, dy), m.

    Returns
    -------
    Aliases
        The sums over aliases along x, along y and along both, at nodes of the phases in which each is smooth.
    """
    at = np.sqrt(_nodes())
    orders = np.arange(-_PLAIN - _AVERAGED, _PLAIN + _AVERAGED + 1)
    others = orders[orders != 0]
    zero = np.zeros(1, dtype=orders.dtype)
    row = _sum_orders(rest, (at, theta[1]), (others, zero), spacing)
    columns = _sum_orders(rest, (theta[0], at), (zero, others), spacing)
    both = _sum_orders(rest, (at, at), (others, others), spacing)
    return row, columns, both


def interpolate_aliases(aliases: Aliases, theta: tuple[Array, Array]) -> Array:
    """Return the alias sum at the phases, shapes (m,) and (n,), for which it was summed, shape (m, n)."""
    row, columns, both = aliases
    nodes = _nodes()
    along, across = (_interpolation(nodes, values) for values in theta)
    return along @ row + columns @ across.T + along @ both @ across.T


def _nodes() -> Array:
    return np.asarray(0.5 * np.pi**2 * (1.0 + chebyshev.chebpts1(_NODES)))


def _interpolation(nodes: Array, theta: Array) -> Array:
    """Return the matrix that interpolates from the nodes to theta^2."""
    vandermonde = chebyshev.chebvander(2.0 * nodes / np.pi**2 - 1.0, nodes.size - 1)
    values = chebyshev.chebvander(2.0 * (theta / np.pi) ** 2 - 1.0, nodes.size - 1)
    return np.asarray(np.linalg.solve(vandermonde.T, values.T).T)


def _sum_orders(
    rest: WaveFunction,
    theta: tuple[Array, Array],
    orders: tuple[Orders, Orders],
    spacing: tuple[float, float],
) -> Array:
    total = np.zeros((theta[0].size, theta[1].size))
    x, y = (t[:, np.newaxis] + 2.0 * np.pi * k for t, k in zip(theta, orders, strict=True))
    factors = [_weights(k) * np.sinc(phase / (2.0 * np.pi)) for k, phase in zip(orders, (x, y), strict=True)]
    for m in range(orders[0].size):
        qx = x[:, m] / spacing[0]
        qy = y / spacing[1]
        values = rest(qx[:, np.newaxis, np.newaxis], qy)
        total += factors[0][:, m, np.newaxis] * np.einsum("ijn,jn->ij", values, factors[1])
    return total


def _weights(orders: Orders) -> Array:
    """Return the fraction of the averaged partial sums that contain each order."""
    fractions = np.cumsum([math.comb(_AVERAGED, k) for k in range(_AVERAGED, -1, -1)])[::-1] / 2.0**_AVERAGED
    return np.concatenate((np.ones(_PLAIN), fractions))[np.abs(orders)]
