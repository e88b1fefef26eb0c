"""The homogeneous half-space: Love's solution for a rectangular cell, and its spectrum."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import ClassVar

import attrs
import numpy as np
from numpy.polynomial import chebyshev

from roughcontact._base.arrays import Array, Pair
from roughcontact._parts.kernels.base import InfluenceKernel

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


@attrs.frozen
class Love(InfluenceKernel):
    r"""Homogeneous half-space under pressure that is constant on each cell.

    .. math:: u = \frac{1}{\pi E^*} \iint_\mathrm{cell} \frac{\mathrm{d}\xi\,\mathrm{d}\eta}
              {\sqrt{(x-\xi)^2 + (y-\eta)^2}}

    Love's four logarithms are this integral, but they cancel: their error grows as the square of
    the distance in cells. Near the field point the integral is taken as a sum over the four edges,
    each term without cancellation; elsewhere exactly along the longer side and by Gauss points
    across the shorter, a sum of positive terms. The relative error stays below 1e-14 for cells of
    any aspect ratio up to 1e12 and offsets up to 16384 cells (test_kernels, against mpmath).

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009;
    Johnson, Contact Mechanics (1985), sec. 3.3, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    At the centre of a square cell of side one the integral is 4 ln(1 + sqrt(2)):

    >>> import math
    >>> import roughcontact as rc
    >>> own = rc.Love().coefficients((1, 1), (1.0, 1.0), 1.0).item()
    >>> math.isclose(own, 4 / math.pi * math.log(1 + math.sqrt(2)), rel_tol=1e-15)
    True
    """

    def effective_modulus(self, wavenumber: Array, compliance: float) -> None:
        """Return None: all waves have the modulus 1/compliance."""
        return

    def coefficients(self, shape: tuple[int, int], spacing: Pair, compliance: float) -> Array:
        """Return the influence coefficients, shape (nx, ny), m/Pa; see `SupportsCoefficients`."""
        i = np.arange(shape[0], dtype=np.float64)
        j = np.arange(shape[1], dtype=np.float64)
        dx, dy = spacing
        if dx < dy:
            return np.ascontiguousarray(self.coefficients(shape[::-1], (dy, dx), compliance).T)
        return cell_potential(i, j, dx / dy) * (compliance * dy / np.pi)

    def spectrum(self, qx: Array, qy: Array, spacing: Pair, compliance: float) -> Array:
        r"""Return the response at the cell centres to waves of cell pressures; see `SupportsSpectrum`.

        Pressure that is constant on cells contains all aliases q + Q of a wave q:

        .. math:: \hat K(q) = \sum_Q \frac{2}{E^* |q + Q|}
                  \operatorname{sinc}\frac{(q_x + Q_x)\Delta x}{2}
                  \operatorname{sinc}\frac{(q_y + Q_y)\Delta y}{2}
        """
        dx, dy = spacing
        if dx < dy:
            return self.spectrum(qy.T, qx.T, (dy, dx), compliance).T
        # Rows that differ in sign only have the same values.
        rows, row_of = np.unique(np.abs(qx[:, 0] * dx), return_inverse=True)
        values = alias_sum(rows, np.abs(qy[0, :] * dy), dx / dy)
        return np.asarray((2.0 * compliance * dy * values)[row_of], dtype=np.float64)


def cell_potential(i: Array, j: Array, aspect: float) -> Array:
    """Return the integral of 1/r over cells of sides (aspect, 1), aspect >= 1, along x and y, shape (m, n).

    The offsets of the cells from the origin, shapes (m,) and (n,), are ascending and not negative.
    """
    if i[-1] * aspect <= _NEAR_RANGE and j[-1] <= _NEAR_RANGE:
        return _integrate_edges(i, j, aspect)
    result = _integrate_gauss(i, j, aspect, _FAR_GAUSS_POINTS)
    between = partial(_integrate_gauss, points=_MIDDLE_GAUSS_POINTS)
    for distance, integrate in ((_MIDDLE_RANGE, between), (_NEAR_RANGE, _integrate_edges)):
        m = int(np.searchsorted(i, distance / aspect + 0.5, side="right"))
        n = int(np.searchsorted(j, distance + 0.5, side="right"))
        result[:m, :n] = integrate(i[:m], j[:n], aspect)
    return result


def _integrate_gauss(i: Array, j: Array, aspect: float, points: int) -> Array:
    """Integrate exactly along x and by Gauss points across y; for cells away from the origin."""
    left, right = ((i + side) * aspect for side in (-0.5, 0.5))
    nodes, weights = np.polynomial.legendre.leggauss(points)
    # Beside the middle of a long cell r1 + r2 - a cancels; there r1 = r2.
    beside_long_cells = aspect > 2.0 * _NEAR_RANGE and i[0] == 0.0
    total = np.zeros((i.size, j.size))
    for node, weight in zip(nodes, weights, strict=True):
        square = ((j + 0.5 * node) ** 2)[np.newaxis, :]
        reach = np.sqrt((left**2)[:, np.newaxis] + square)
        reach += np.sqrt((right**2)[:, np.newaxis] + square)
        reach -= aspect
        if beside_long_cells:
            reach[0] = 2.0 * square[0] / (np.sqrt(right[0] ** 2 + square[0]) + right[0])
        # Singular only on cells at the origin, which the sum over edges overwrites.
        with np.errstate(divide="ignore"):
            np.divide(2.0 * aspect, reach, out=reach)
        np.log1p(reach, out=reach)
        reach *= 0.5 * weight
        total += reach
    return total


def _integrate_edges(i: Array, j: Array, aspect: float) -> Array:
    """Add the four edges: signed distance times the logarithm of the edge seen from the origin."""
    x = (i * aspect)[:, np.newaxis]
    y = j[np.newaxis, :]
    across = [side * (x + 0.5 * side * aspect) * _edge_log(x + 0.5 * side * aspect, y, 1.0) for side in (-1, 1)]
    along = [side * (y + 0.5 * side) * _edge_log(y + 0.5 * side, x, aspect) for side in (-1, 1)]
    return np.asarray(across[0] + across[1] + along[0] + along[1], dtype=np.float64)


def _edge_log(distance: Array, middle: Array, length: float) -> Array:
    """Return ln((r1 + r2 + l) / (r1 + r2 - l)) of an edge, r1 and r2 being the distances of its ends."""
    r1 = np.hypot(distance, middle - 0.5 * length)
    r2 = np.hypot(distance, middle + 0.5 * length)
    # Opposite the middle of a long edge r1 + r2 - l cancels; there r1 = r2.
    slack = np.where(middle == 0.0, 2.0 * distance**2 / (r1 + 0.5 * length), r1 + r2 - length)
    return np.asarray(np.log1p(2.0 * length / slack), dtype=np.float64)


def alias_sum(theta_x: Array, theta_y: Array, aspect: float) -> Array:
    r"""Return the sum over all aliases for cells of sides (aspect, 1), aspect >= 1, shape (m, n).

    .. math:: \sum_{m,n} \frac{\operatorname{sinc}(\theta_x/2 + \pi m)\,
              \operatorname{sinc}(\theta_y/2 + \pi n)}
              {\sqrt{((\theta_x + 2\pi m)/a)^2 + (\theta_y + 2\pi n)^2}}

    The phases q dx and q dy per cell, 0 .. pi, have shapes (m,) and (n,). The entry at zero phases is not finite.
    """
    half_x, half_y = (np.sinc(theta / (2 * np.pi)) for theta in (theta_x, theta_y))
    with np.errstate(divide="ignore"):
        first = 1.0 / np.hypot((theta_x / aspect)[:, np.newaxis], theta_y[np.newaxis, :])
    # Without aliases along y the terms are smooth along x only; all others are smooth both ways.
    rest = _aliases_along_x(np.sqrt(_nodes()), theta_y, aspect)
    rest += _interpolate(_other_aliases_at_nodes(aspect).T, theta_y).T
    return first * half_x[:, np.newaxis] * half_y[np.newaxis, :] + _interpolate(rest, theta_x)


def _nodes() -> Array:
    """Return Chebyshev's nodes in theta^2 on 0 .. pi^2."""
    return np.asarray(0.5 * np.pi**2 * (1.0 + np.cos(np.pi * (np.arange(_CHEBYSHEV_NODES) + 0.5) / _CHEBYSHEV_NODES)))


def _interpolate(values: Array, theta: Array) -> Array:
    """Interpolate values at the nodes along the first axis."""
    vandermonde = chebyshev.chebvander(2.0 * _nodes() / np.pi**2 - 1.0, _CHEBYSHEV_NODES - 1)
    coefficients = np.linalg.solve(vandermonde, values)
    return np.asarray(chebyshev.chebvander(2.0 * (theta / np.pi) ** 2 - 1.0, _CHEBYSHEV_NODES - 1) @ coefficients)


def _aliases_along_x(theta_x: Array, theta_y: Array, aspect: float) -> Array:
    """Sum the aliases along x alone, shape (|theta_x|, |theta_y|)."""
    orders, weights = _alternating_weights()
    others = orders != 0
    orders = orders[others]
    weights = weights[others]
    x = theta_x[:, np.newaxis] + 2 * np.pi * orders
    factors = weights * _alias_sinc(theta_x, orders)
    total = np.zeros((theta_x.size, theta_y.size))
    for k in range(orders.size):
        total += factors[:, k, np.newaxis] / np.hypot(x[:, k, np.newaxis] / aspect, theta_y[np.newaxis, :])
    return total * np.sinc(theta_y / (2 * np.pi))[np.newaxis, :]


@lru_cache(maxsize=16)
def _other_aliases_at_nodes(aspect: float) -> Array:
    """Sum all aliases but those along x alone, at the nodes; many grids share an aspect ratio."""
    theta = np.sqrt(_nodes())
    orders, weights = _alternating_weights()
    others = orders != 0
    x = theta[:, np.newaxis] + 2 * np.pi * orders
    across = weights * _alias_sinc(theta, orders)
    distance = np.hypot(x[:, np.newaxis, :, np.newaxis] / aspect, x[:, others][np.newaxis, :, np.newaxis, :])
    return np.asarray(np.einsum("im,jn,ijmn->ij", across, across[:, others], 1.0 / distance, optimize=True))


def _alias_sinc(theta: Array, orders: Array) -> Array:
    """Return sinc(theta/2 + pi m) without its alternating sign, shape (|theta|, |orders|)."""
    theta = theta[:, np.newaxis]
    with np.errstate(invalid="ignore"):
        values = 2.0 * np.sin(0.5 * theta) / (theta + 2 * np.pi * orders)
    return np.where(orders == 0, np.sinc(theta / (2 * np.pi)), values)


def _alternating_weights() -> tuple[Array, Array]:
    """Return the orders of the aliases and the weights that sum an alternating series (Euler's method)."""
    sums = np.tri(_ALIASES_PER_SIDE + 1)
    for _ in range(_EULER_AVERAGES):
        sums = 0.5 * (sums[1:] + sums[:-1])
    orders = np.arange(-_ALIASES_PER_SIDE, _ALIASES_PER_SIDE + 1)
    return orders.astype(np.float64), np.asarray(sums[-1][np.abs(orders)] * (-1.0) ** np.abs(orders))


@attrs.frozen
class FourierHalfSpace(InfluenceKernel):
    r"""Homogeneous half-space whose pressure is the trigonometric polynomial through the cell centres.

    .. math:: \hat u(q) = \frac{2}{E^*\,|q|}\,\hat p(q)

    References
    ----------
    Stanley, Kato, J. Tribol. 119 (1997) 481-485, https://doi.org/10.1115/1.2833523

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> body = rc.Body(wave, rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic", kernel="fourier")
    >>> print(problem.solve(pressure=100e6).status)
    converged: the conditions of contact hold within the tolerance
    """

    edge_shift: ClassVar[float] = 0.0

    def effective_modulus(self, wavenumber: Array, compliance: float) -> None:
        """Return None: all waves have the modulus 1/compliance."""
        return

    def spectrum(self, qx: Array, qy: Array, spacing: Pair, compliance: float) -> Array:
        """Return ``2 / (E* |q|)``, shape (m, n), m/Pa; see `SupportsSpectrum`."""
        return np.asarray(2.0 * compliance / np.hypot(qx, qy), dtype=np.float64)
