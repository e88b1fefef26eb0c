"""The alias sum of a spectrum that falls with the wave number."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev

from roughcontact_layered.stack import Array

Orders: TypeAlias = npt.NDArray[np.int_]
Parts: TypeAlias = tuple[Array, Array, Array]

# Chebyshev nodes in the square of the phase, in which the sum of all aliases is analytic.
_NODES = 20
# Aliases on each side; the outer ones are averaged, for the sum alternates (Euler's method).
_PLAIN, _AVERAGED = 8, 22


def alias_parts(rest: Callable[[Array], Array], theta: tuple[Array, Array], spacing: tuple[float, float]) -> Parts:
    r"""Return what `joined` makes the sum over all aliases but the wave itself from.

    .. math:: \sum_{(m,n) \ne 0} f(|q + Q_{mn}|)\,\operatorname{sinc}(\theta_x / 2 + \pi m)\,
              \operatorname{sinc}(\theta_y / 2 + \pi n)

    Parameters
    ----------
    rest
        The function f of the wave number, of any shape, rad/m.
    theta
        Phases q dx, q dy per cell, 0 .. pi, shapes (m,) and (n,).
    spacing
        Sides of a cell (dx, dy), m.

    Returns
    -------
    Parts
        The sums along x, along y and over all others, at the nodes where they are smooth.
    """
    at = np.sqrt(_nodes())
    orders = np.arange(-_PLAIN - _AVERAGED, _PLAIN + _AVERAGED + 1)
    others = orders[orders != 0]
    zero = np.zeros(1, dtype=orders.dtype)
    row = _sum(rest, (at, theta[1]), (others, zero), spacing)
    columns = _sum(rest, (theta[0], at), (zero, others), spacing)
    both = _sum(rest, (at, at), (others, others), spacing)
    return row, columns, both


def joined(parts: Parts, theta: tuple[Array, Array]) -> Array:
    """Return the alias sum at phases of shapes (m,) and (n,), those the parts were made for, shape (m, n)."""
    row, columns, both = parts
    nodes = _nodes()
    along, across = (_through(nodes, values) for values in theta)
    return along @ row + columns @ across.T + along @ both @ across.T


def _nodes() -> Array:
    return np.asarray(0.5 * np.pi**2 * (1.0 + chebyshev.chebpts1(_NODES)))


def _through(nodes: Array, theta: Array) -> Array:
    """Return the matrix that interpolates from the nodes to theta^2."""
    vandermonde = chebyshev.chebvander(2.0 * nodes / np.pi**2 - 1.0, nodes.size - 1)
    values = chebyshev.chebvander(2.0 * (theta / np.pi) ** 2 - 1.0, nodes.size - 1)
    return np.asarray(np.linalg.solve(vandermonde.T, values.T).T)


def _sum(
    rest: Callable[[Array], Array],
    theta: tuple[Array, Array],
    orders: tuple[Orders, Orders],
    spacing: tuple[float, float],
) -> Array:
    total = np.zeros((theta[0].size, theta[1].size))
    x, y = (t[:, np.newaxis] + 2.0 * np.pi * k for t, k in zip(theta, orders, strict=True))
    factors = [_weights(k) * np.sinc(phase / (2.0 * np.pi)) for k, phase in zip(orders, (x, y), strict=True)]
    for m in range(orders[0].size):
        qx, qy = x[:, m] / spacing[0], y / spacing[1]
        values = rest(np.hypot(qx[:, np.newaxis, np.newaxis], qy))
        total += factors[0][:, m, np.newaxis] * np.einsum("ijn,jn->ij", values, factors[1])
    return total


def _weights(orders: Orders) -> Array:
    """Return the share of the averaged partial sums that hold each order."""
    shares = np.cumsum([math.comb(_AVERAGED, k) for k in range(_AVERAGED, -1, -1)])[::-1] / 2.0**_AVERAGED
    return np.concatenate((np.ones(_PLAIN), shares))[np.abs(orders)]
