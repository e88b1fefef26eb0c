"""Integrals over rectangular cells, and sums over the aliases of waves on them."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import TypeAlias

import numpy as np
from numpy.polynomial import chebyshev

from roughcontact._base.arrays import Array, matrix_product

# Cells with an offset up to _NEAR_RANGE or _MIDDLE_RANGE, in shorter sides, are integrated by edges or by
# _MIDDLE_GAUSS_POINTS Gauss points across, all others by _FAR_GAUSS_POINTS. The integrand is analytic up to the field
# point, so that the error falls as (4 offset)^(-2 points): below 2e-16 (test_kernels: 1e-14 of mpmath).
_NEAR_RANGE = 10
_MIDDLE_RANGE = 110
_MIDDLE_GAUSS_POINTS = 5
_FAR_GAUSS_POINTS = 3
# Chebyshev nodes of the alias sum in the square of the phase along the longer side. The nearest
# singularity, for square cells, makes the coefficients fall by 5.8 each: 5.8^-20 = 5e-16.
_CHEBYSHEV_NODES = 20
# Aliases on each side, and averages of neighbouring partial sums (Euler's method): each average more than
# halves the alternating rest (test_kernels: 1e-12 of plain sums).
_ALIASES_PER_SIDE = 32
_EULER_AVERAGES = 16


def cell_potential(i: Array, j: Array, aspect: float) -> Array:
    """Return the integral of 1/r over cells of sides (aspect, 1), aspect >= 1, along x and y, shape (m, n).

    The offsets of the cells from the origin, shapes (m,) and (n,), are ascending and not negative.
    """
    return integrate_by_distance(i, j, aspect, _add_edges, _log_of_line)


def integrate_by_distance(
    i: Array,
    j: Array,
    aspect: float,
    add_edges: Callable[[Array, Array, float], Array],
    integrate_line: Callable[[Array, Array, float], Array],
) -> Array:
    """Return the integral of a function over cells, near the origin by their edges, elsewhere by Gauss points across.

    Parameters
    ----------
    i, j, aspect
        As for `cell_potential`.
    add_edges
        Function of the centres, shapes (m, 1) and (1, n), and the aspect: the integral over each cell, shape (m, n).
    integrate_line
        Function of the offsets along x, shape (m,), the distances of lines along x, shape (1, n), and the aspect: the
        integral along each, shape (m, n).
    """

    def edges(i: Array, j: Array) -> Array:
        return add_edges((i * aspect)[:, np.newaxis], j[np.newaxis, :], aspect)

    def gauss(i: Array, j: Array, points: int) -> Array:
        nodes, weights = np.polynomial.legendre.leggauss(points)
        total = np.zeros((i.size, j.size))
        for node, weight in zip(nodes, weights, strict=True):
            line = integrate_line(i, (j + 0.5 * node)[np.newaxis, :], aspect)
            line *= 0.5 * weight
            total += line
        return total

    if i[-1] * aspect <= _NEAR_RANGE and j[-1] <= _NEAR_RANGE:
        return edges(i, j)
    result = gauss(i, j, _FAR_GAUSS_POINTS)
    between = partial(gauss, points=_MIDDLE_GAUSS_POINTS)
    for distance, integrate in ((_MIDDLE_RANGE, between), (_NEAR_RANGE, edges)):
        m = int(np.searchsorted(i, distance / aspect + 0.5, side="right"))
        n = int(np.searchsorted(j, distance + 0.5, side="right"))
        result[:m, :n] = integrate(i[:m], j[:n])
    return result


def ends_of_lines(i: Array, aspect: float) -> tuple[Array, Array]:
    """Return both ends of the cells along x, shapes (m, 1)."""
    left, right = ((i + side) * aspect for side in (-0.5, 0.5))
    return left[:, np.newaxis], right[:, np.newaxis]


def _log_of_line(i: Array, y: Array, aspect: float) -> Array:
    """Integrate 1/r exactly along x; for cells away from the origin."""
    left, right = ends_of_lines(i, aspect)
    square = y**2
    reach = np.sqrt(left**2 + square)
    reach += np.sqrt(right**2 + square)
    reach -= aspect
    # Beside the middle of a long cell r1 + r2 - a cancels; there r1 = r2.
    if aspect > 2.0 * _NEAR_RANGE and i.size and i[0] == 0.0:
        reach[0] = 2.0 * square[0] / (np.sqrt(right[0] ** 2 + square[0]) + right[0])
    # Singular only on cells at the origin, which the sum over edges overwrites.
    with np.errstate(divide="ignore"):
        np.divide(2.0 * aspect, reach, out=reach)
    return np.asarray(np.log1p(reach, out=reach))


def _add_edges(x: Array, y: Array, aspect: float) -> Array:
    """Add the four edges: signed distance times the logarithm of the edge seen from the origin."""
    across = edges_across(x, y, aspect)
    along = [side * (y + 0.5 * side) * _edge_log(y + 0.5 * side, x, aspect) for side in (-1, 1)]
    return np.asarray(across[0] + across[1] + along[0] + along[1], dtype=np.float64)


def edges_across(x: Array, y: Array, aspect: float) -> list[Array]:
    """Return the part of each of the two edges along y, whose sum is the integral of y^2/r^3 over the cell."""
    return [side * (x + 0.5 * side * aspect) * _edge_log(x + 0.5 * side * aspect, y, 1.0) for side in (-1, 1)]


def _edge_log(distance: Array, middle: Array, length: float) -> Array:
    """Return ln((r1 + r2 + l) / (r1 + r2 - l)) of an edge, r1 and r2 being the distances of its ends."""
    r1 = np.hypot(distance, middle - 0.5 * length)
    r2 = np.hypot(distance, middle + 0.5 * length)
    # Opposite the middle of a long edge r1 + r2 - l cancels; there r1 = r2.
    slack = np.where(middle == 0.0, 2.0 * distance**2 / (r1 + 0.5 * length), r1 + r2 - length)
    return np.asarray(np.log1p(2.0 * length / slack), dtype=np.float64)


def _length(x: Array, y: Array) -> Array:
    """Return the length of vectors whose squares are in the range of float64, in a third of the time of `hypot`."""
    return np.asarray(np.sqrt(x * x + y * y))


# Of each function f(k) of a wave's vector that is summed: 1/f, and whether it is odd in x and in y.
_Inverse: TypeAlias = Callable[[Array, Array], Array]
_ALIAS_TERMS: dict[str, tuple[_Inverse, bool, bool]] = {
    "1/k": (_length, False, False),
    "xx/k3": (lambda x, y: _length(x, y) * (1.0 + (y / x) ** 2), False, False),
    "yy/k3": (lambda x, y: _length(x, y) * (1.0 + (x / y) ** 2), False, False),
    "xy/k3": (lambda x, y: _length(x, y) * (x / y + y / x), True, True),
    "x/k2": (lambda x, y: x + y * (y / x), True, False),
    "y/k2": (lambda x, y: y + x * (x / y), False, True),
}


def alias_sum(theta_x: Array, theta_y: Array, aspect: float, term: str = "1/k") -> Array:
    r"""Return the sum over all aliases for cells of sides (aspect, 1), aspect >= 1, shape (m, n).

    .. math:: \sum_{m,n} \operatorname{sinc}(\theta_x/2 + \pi m)\,\operatorname{sinc}(\theta_y/2 + \pi n)\,
              f\left(\frac{\theta_x + 2\pi m}{a}, \theta_y + 2\pi n\right)

    The phases q dx and q dy per cell, 0 .. pi, have shapes (m,) and (n,). The function f(k) is 1/k, or the one that
    `term` names. The entry at zero phases is not finite.
    """
    inverse, odd_x, odd_y = _ALIAS_TERMS[term]
    half_x, half_y = (np.sinc(theta / (2 * np.pi)) for theta in (theta_x, theta_y))
    # Along an axis the inverse of a term may be infinite.
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        first = 1.0 / inverse((theta_x / aspect)[:, np.newaxis], theta_y[np.newaxis, :])
    # Without aliases along y the terms are smooth along x only; all others are smooth both ways.
    rest = _aliases_along_x(np.sqrt(chebyshev_nodes(_CHEBYSHEV_NODES)), theta_y, aspect, term)
    rest += interpolate(_other_aliases_at_nodes(aspect, term).T, theta_y, odd_y).T
    first *= half_x[:, np.newaxis]
    first *= half_y[np.newaxis, :]
    first += interpolate(rest, theta_x, odd_x)
    return first


def chebyshev_nodes(count: int) -> Array:
    """Return Chebyshev's nodes in the square of a phase, on 0 .. pi^2."""
    return np.asarray(0.5 * np.pi**2 * (1.0 + np.cos(np.pi * (np.arange(count) + 0.5) / count)))


def interpolate(values: Array, theta: Array, odd: bool = False) -> Array:
    """Interpolate values at the nodes, of a function of the phase that is even or odd, along the first axis."""
    count = values.shape[0]
    nodes = chebyshev_nodes(count)
    if odd:
        # An odd function over theta is even.
        return interpolate(values / np.sqrt(nodes)[:, np.newaxis], theta) * theta[:, np.newaxis]
    vandermonde = chebyshev.chebvander(2.0 * nodes / np.pi**2 - 1.0, count - 1)
    coefficients = matrix_product(np.linalg.inv(vandermonde), values)
    return matrix_product(chebyshev.chebvander(2.0 * (theta / np.pi) ** 2 - 1.0, count - 1), coefficients)


def _aliases_along_x(theta_x: Array, theta_y: Array, aspect: float, term: str) -> Array:
    """Sum the aliases along x alone, shape (|theta_x|, |theta_y|)."""
    orders, weights = alternating_weights(_ALIASES_PER_SIDE, _EULER_AVERAGES)
    others = orders != 0
    orders = orders[others]
    weights = weights[others]
    x = theta_x[:, np.newaxis] + 2 * np.pi * orders
    factors = weights * _alias_sinc(theta_x, orders)
    inverse = _ALIAS_TERMS[term][0]
    total = np.zeros((theta_x.size, theta_y.size))
    with np.errstate(divide="ignore", over="ignore"):
        for k in range(orders.size):
            total += factors[:, k, np.newaxis] / inverse(x[:, k, np.newaxis] / aspect, theta_y[np.newaxis, :])
    return total * np.sinc(theta_y / (2 * np.pi))[np.newaxis, :]


@lru_cache(maxsize=64)
def _other_aliases_at_nodes(aspect: float, term: str) -> Array:
    """Sum all aliases but those along x alone, at the nodes; many grids share an aspect ratio."""
    theta = np.sqrt(chebyshev_nodes(_CHEBYSHEV_NODES))
    orders, weights = alternating_weights(_ALIASES_PER_SIDE, _EULER_AVERAGES)
    others = orders != 0
    x = theta[:, np.newaxis] + 2 * np.pi * orders
    across = weights * _alias_sinc(theta, orders)
    inverse = _ALIAS_TERMS[term][0]
    terms = 1.0 / inverse(x[:, np.newaxis, :, np.newaxis] / aspect, x[:, others][np.newaxis, :, np.newaxis, :])
    return np.asarray(np.einsum("im,jn,ijmn->ij", across, across[:, others], terms, optimize=True))


def _alias_sinc(theta: Array, orders: Array) -> Array:
    """Return sinc(theta/2 + pi m) without its alternating sign, shape (|theta|, |orders|)."""
    theta = theta[:, np.newaxis]
    with np.errstate(invalid="ignore"):
        values = 2.0 * np.sin(0.5 * theta) / (theta + 2 * np.pi * orders)
    return np.where(orders == 0, np.sinc(theta / (2 * np.pi)), values)


def alternating_weights(most: int, averages: int) -> tuple[Array, Array]:
    """Return the orders -most .. most of aliases and the weights that sum an alternating series (Euler's method)."""
    sums = np.tri(most + 1)
    for _ in range(averages):
        sums = 0.5 * (sums[1:] + sums[:-1])
    orders = np.arange(-most, most + 1)
    return orders.astype(np.float64), np.asarray(sums[-1][np.abs(orders)] * (-1.0) ** np.abs(orders))
