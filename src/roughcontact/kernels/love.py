"""Love's solution: uniform pressure on a rectangular cell of a half-space."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array, Pair
from roughcontact.kernels.aliases import alias_sum
from roughcontact.kernels.base import InfluenceKernel

# Gauss points across a cell, by the least distance to the cell in units of its shorter side: the
# integrand is analytic up to the field point, so the error falls as (4 distance)^(-2 points).
_NEAR = 10
_FAR = 110
_POINTS_BETWEEN = 5
_POINTS_FAR = 3


@attrs.frozen
class Love(InfluenceKernel):
    r"""Homogeneous half-space under pressure that is constant on each cell.

    .. math:: u = \frac{1}{\pi E^*} \iint_\mathrm{cell} \frac{\mathrm{d}\xi\,\mathrm{d}\eta}
              {\sqrt{(x-\xi)^2 + (y-\eta)^2}}

    Love's four logarithms are this integral, but they cancel: their error grows as the square of
    the distance in cells. Here the cells around the field point use the sum over the four edges,
    whose terms are each exact; all others integrate exactly along the longer side and by Gauss
    points across the shorter, a sum of positive terms. The relative error stays below 1e-13 at any
    distance and any aspect ratio of the cells.

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

    def coefficients(self, shape: tuple[int, int], spacing: Pair, compliance: float) -> Array:
        """Return the influence coefficients, shape (nx, ny), m/Pa; see `OffersCoefficients`."""
        i, j = np.arange(shape[0], dtype=np.float64), np.arange(shape[1], dtype=np.float64)
        dx, dy = spacing
        if dx < dy:
            return np.ascontiguousarray(self.coefficients(shape[::-1], (dy, dx), compliance).T)
        return cell_potential(i, j, dx / dy) * (compliance * dy / np.pi)

    def spectrum(self, qx: Array, qy: Array, spacing: Pair, compliance: float) -> Array:
        r"""Return the response at the cell centres to waves of cell pressures; see `OffersSpectrum`.

        The pressure is a staircase, so a wave q carries all its aliases q + Q with it:

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
    """Integrate 1/r over cells of sides (aspect, 1), aspect >= 1.

    Parameters
    ----------
    i, j
        Offsets of the cells in numbers of cells, ascending and not negative, shapes (m,) and (n,).
    aspect
        Longer side along x, the shorter along y being one.

    Returns
    -------
    Array
        The potential at the origin of unit density on the cell (i, j), shape (m, n).
    """
    result = _between(i, j, aspect, _POINTS_FAR)
    for distance, integrate in ((_FAR, _between_points), (_NEAR, _edges)):
        m = int(np.searchsorted(i, distance / aspect + 0.5, side="right"))
        n = int(np.searchsorted(j, distance + 0.5, side="right"))
        result[:m, :n] = integrate(i[:m], j[:n], aspect)
    return result


def _between(i: Array, j: Array, aspect: float, points: int) -> Array:
    """Integrate exactly along x and by Gauss points across y; for cells away from the origin."""
    left, right = ((i + side) * aspect for side in (-0.5, 0.5))
    nodes, weights = np.polynomial.legendre.leggauss(points)
    total = np.zeros((i.size, j.size))
    for node, weight in zip(nodes, weights, strict=True):
        square = ((j + 0.5 * node) ** 2)[np.newaxis, :]
        reach = np.sqrt((left**2)[:, np.newaxis] + square)
        reach += np.sqrt((right**2)[:, np.newaxis] + square)
        reach -= aspect
        # Singular only on cells at the origin, which the edges' form overwrites.
        with np.errstate(divide="ignore"):
            np.divide(2.0 * aspect, reach, out=reach)
        np.log1p(reach, out=reach)
        reach *= 0.5 * weight
        total += reach
    return total


def _between_points(i: Array, j: Array, aspect: float) -> Array:
    return _between(i, j, aspect, _POINTS_BETWEEN)


def _edges(i: Array, j: Array, aspect: float) -> Array:
    """Add the four edges: signed distance times the logarithm of the edge seen from the origin."""
    x, y = (i * aspect)[:, np.newaxis], j[np.newaxis, :]
    across = [side * (x + 0.5 * side * aspect) * _edge_log(x + 0.5 * side * aspect, y, 1.0) for side in (-1, 1)]
    along = [side * (y + 0.5 * side) * _edge_log(y + 0.5 * side, x, aspect) for side in (-1, 1)]
    return np.asarray(across[0] + across[1] + along[0] + along[1], dtype=np.float64)


def _edge_log(distance: Array, middle: Array, length: float) -> Array:
    """Return ln((r1 + r2 + l) / (r1 + r2 - l)) of an edge, r1 and r2 being the distances of its ends."""
    r1, r2 = np.hypot(distance, middle - 0.5 * length), np.hypot(distance, middle + 0.5 * length)
    # Opposite the edge's middle r1 + r2 - l cancels where the edge is long; there r1 = r2.
    slack = np.where(middle == 0.0, 2.0 * distance**2 / (r1 + 0.5 * length), r1 + r2 - length)
    return np.asarray(np.log1p(2.0 * length / slack), dtype=np.float64)
