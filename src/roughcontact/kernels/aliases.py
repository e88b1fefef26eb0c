"""The alias sum of Love's kernel on an infinite periodic grid."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev

from roughcontact.checks import Array

# The sum is analytic in the square of the phase along the longer side. Its next singularity lies, for
# square cells, one interval beyond zero, so that Chebyshev's coefficients fall by 5.8 each.
_NODES = 20
# Terms on each side, the outer ones averaged to make the alternating sum converge.
_TERMS = 32
_ROUNDS = 16


def alias_sum(theta_x: Array, theta_y: Array, aspect: float) -> Array:
    r"""Return the sum over all aliases, for cells of sides (aspect, 1), aspect >= 1.

    .. math:: \sum_{m,n} \frac{\operatorname{sinc}(\theta_x/2 + \pi m)\,
              \operatorname{sinc}(\theta_y/2 + \pi n)}
              {\sqrt{((\theta_x + 2\pi m)/a)^2 + (\theta_y + 2\pi n)^2}}

    Parameters
    ----------
    theta_x, theta_y
        Phases q dx, q dy per cell, 0 .. pi, shapes (m,) and (n,).
    aspect
        The longer side a of the cells, along x.

    Returns
    -------
    Array
        The sum, shape (m, n); the entry at zero phases is not finite.
    """
    half_x, half_y = (np.sinc(theta / (2 * np.pi)) for theta in (theta_x, theta_y))
    with np.errstate(divide="ignore"):
        first = 1.0 / np.hypot((theta_x / aspect)[:, np.newaxis], theta_y[np.newaxis, :])
    nodes = _nodes()
    theta_nodes = np.sqrt(nodes)
    # Without aliases along y the terms are smooth along x only; all others are smooth both ways.
    rest = _same_row(theta_nodes, theta_y, aspect)
    rest += _through(nodes, _other_rows_at_nodes(aspect).T, theta_y).T
    return first * half_x[:, np.newaxis] * half_y[np.newaxis, :] + _through(nodes, rest, theta_x)


def _through(nodes: Array, values: Array, theta: Array) -> Array:
    """Interpolate along the first axis from the Chebyshev nodes in theta^2."""
    vandermonde = chebyshev.chebvander(2.0 * nodes / np.pi**2 - 1.0, nodes.size - 1)
    coefficients = np.linalg.solve(vandermonde, values)
    return np.asarray(chebyshev.chebvander(2.0 * (theta / np.pi) ** 2 - 1.0, nodes.size - 1) @ coefficients)


def _same_row(theta_x: Array, theta_y: Array, aspect: float) -> Array:
    """Sum the aliases along x alone, shape (|theta_x|, |theta_y|)."""
    orders, weights = _alternating()
    others = orders != 0
    orders, weights = orders[others], weights[others]
    x = theta_x[:, np.newaxis] + 2 * np.pi * orders
    factors = weights * _sinc(theta_x, orders)
    total = np.zeros((theta_x.size, theta_y.size))
    for k in range(orders.size):
        total += factors[:, k, np.newaxis] / np.hypot(x[:, k, np.newaxis] / aspect, theta_y[np.newaxis, :])
    return total * np.sinc(theta_y / (2 * np.pi))[np.newaxis, :]


def _nodes() -> Array:
    """Return Chebyshev's nodes in theta^2 on 0 .. pi^2."""
    return np.asarray(0.5 * np.pi**2 * (1.0 + np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)))


@lru_cache(maxsize=16)
def _other_rows_at_nodes(aspect: float) -> Array:
    """Return `_other_rows` at the nodes: it depends on the cells alone, which many grids share."""
    theta = np.sqrt(_nodes())
    return _other_rows(theta, theta, aspect)


def _other_rows(theta_x: Array, theta_y: Array, aspect: float) -> Array:
    """Sum the aliases along y with all those along x, shape (|theta_x|, |theta_y|)."""
    orders, weights = _alternating()
    others = orders != 0
    x, y = (theta[:, np.newaxis] + 2 * np.pi * orders for theta in (theta_x, theta_y))
    across = weights * _sinc(theta_x, orders)
    along = (weights * _sinc(theta_y, orders))[:, others]
    distance = np.hypot(x[:, np.newaxis, :, np.newaxis] / aspect, y[:, others][np.newaxis, :, np.newaxis, :])
    return np.asarray(np.einsum("im,jn,ijmn->ij", across, along, 1.0 / distance, optimize=True))


def _sinc(theta: Array, orders: Array) -> Array:
    """Return sinc(theta/2 + pi m) without its alternating sign, shape (|theta|, |orders|)."""
    theta = theta[:, np.newaxis]
    with np.errstate(invalid="ignore"):
        values = 2.0 * np.sin(0.5 * theta) / (theta + 2 * np.pi * orders)
    return np.where(orders == 0, np.sinc(theta / (2 * np.pi)), values)


def _alternating() -> tuple[Array, Array]:
    """Return the orders -count .. count and weights that sum an alternating series of smooth terms.

    Averaging neighbouring partial sums again and again removes the alternation (Euler's method).
    """
    sums = np.tri(_TERMS + 1)
    for _ in range(_ROUNDS):
        sums = 0.5 * (sums[1:] + sums[:-1])
    orders = np.arange(-_TERMS, _TERMS + 1)
    return orders.astype(np.float64), np.asarray(sums[-1][np.abs(orders)] * (-1.0) ** np.abs(orders))
