"""Hertz's area for each cluster, from its load and its curvature."""

from __future__ import annotations

from functools import lru_cache

import attrs
import numpy as np
from scipy import special

from roughcontact.areas.base import AreaEstimator
from roughcontact.areas.curvature import Curvature, curvature
from roughcontact.areas.edges import drawn, few_cells
from roughcontact.areas.total import summed
from roughcontact.checks import Array, Mask
from roughcontact.grid import Boundary
from roughcontact.solution import Area, ContactSolution

# Flatter summits than this, by the smaller over the greater curvature, are no ellipses.
SLENDEREST = 0.05
# Relative error of the area where the curvature spreads by v: a + b v^2 + c v^4, measured on clusters
# of self-affine contacts.
_ERROR = (0.003, 0.2, 0.1)
# Share of that error that alike summits have in common.
_ALIKE = 1.0 / 3.0
# Area over Hertz's at a pressure limit, by Hertz's greatest pressure over the limit; two thirds of it beyond.
_OVERLOAD = (1.0, 1.05, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7, 1.85, 2.0, 2.2, 2.6, 3.0)
# Where the modulus depends on the length of waves: the inverse wave number that a contact of radius one meets,
# the rounds that find both, and the relative error of the area where the modulus changes by e over two octaves.
_WIDE = 0.5
_ROUNDS = 20
_VARIES = 0.4
# A cell without a limit among others counts as one with this, Pa.
_UNLIMITED = 1e150
_GROWTH = (1.0, 1.0006, 1.003, 1.0143, 1.034, 1.0625, 1.098, 1.187, 1.267, 1.355, 1.4805, 1.737, 2.0)


@attrs.frozen(eq=False)
class HertzAreas:
    """Areas of the clusters after Hertz; first entry zero.

    Attributes
    ----------
    area
        Area, shape (count + 1,), m2; zero where there is no summit.
    error
        Relative standard deviation; infinite where there is no summit.
    curvature
        What they were made from.
    """

    area: Array
    error: Array
    curvature: Curvature


def hertz_areas(solution: ContactSolution, largest: float = np.inf) -> HertzAreas:
    """Return Hertz's areas of the clusters of at most so many cells.

    Parameters
    ----------
    solution
        The solved contact.
    largest
        Clusters of more cells are passed over.
    """
    clusters = solution.clusters
    small = np.concatenate(([False], clusters.cells <= largest)) & ~_cut(solution)
    chosen = np.flatnonzero(small[clusters.labels])
    found = curvature(solution, chosen)
    force = np.concatenate(([0.0], clusters.forces))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (found.mean - found.difference) / (found.mean + found.difference)
        valid = small & (found.mean > 0.0) & (ratio >= SLENDEREST)
        ratio = np.where(valid, ratio, 1.0)
        curved = np.where(valid, found.mean, 1.0)
    area, varies = _by_scale(solution, 0.75 * np.pi**1.5 * force * _ellipse(ratio) ** 1.5 / curved)
    area = area * _growth(solution, force, area)
    error = _ERROR[0] + _ERROR[1] * found.spread**2 + _ERROR[2] * found.spread**4 + _VARIES * varies
    return HertzAreas(np.where(valid, area, 0.0), np.where(valid, error, np.inf), found)


def _by_scale(solution: ContactSolution, loaded: Array) -> tuple[Array, Array]:
    """Return the areas (loaded / E*)^(2/3), shape (count + 1,), m2, and how fast E* varies at their size.

    Where E* depends on the length of waves, it is that of waves as long as the contact is wide.
    """
    area = (loaded / solution.modulus) ** (2.0 / 3.0)
    if solution.moduli is None:
        return area, np.zeros_like(area)
    smallest = solution.moduli[0][0]
    for _ in range(_ROUNDS):
        length = np.maximum(_WIDE * np.sqrt(area / np.pi), smallest)
        area = np.sqrt(area * (loaded / solution.modulus_at(length)) ** (2.0 / 3.0))
    varies = np.abs(np.log(solution.modulus_at(2.0 * length) / solution.modulus_at(0.5 * length)))
    return area, np.asarray(varies)


def _cut(solution: ContactSolution) -> Mask:
    """Mark the clusters that a free border cuts, shape (count + 1,): they are parts of an ellipse at best."""
    labels, found = solution.clusters.labels, np.zeros(solution.clusters.count + 1, dtype=bool)
    if solution.boundary is Boundary.FREE:
        for edge in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
            found[edge] = True
    return found


def common_error(found: HertzAreas, areas: Array) -> float:
    """Return the error that Hertz's share of the areas has in common, m2: alike summits err alike."""
    known = np.isfinite(found.error)
    return _ALIKE * float(np.sum(np.minimum(found.error[known], 1.0) * areas[known]))


def _ellipse(ratio: Array) -> Array:
    """Return the area of an elliptic contact over that of the circular one with the same mean curvature."""
    curvatures, factors = _ellipses()
    return np.asarray(np.interp(np.log(ratio), curvatures, factors))


@lru_cache(maxsize=1)
def _ellipses() -> tuple[Array, Array]:
    r"""Tabulate the factor by the logarithm of the ratio of curvatures, with the axes ratio k as parameter.

    kappa_1 / kappa_2 = (k^2 E - K) / (K - E), factor = k^(1/3) (2 E / pi)^(2/3), e^2 = 1 - 1 / k^2;
    Johnson, Contact Mechanics (1985), eqs. 4.26 to 4.28.
    """
    k = np.geomspace(1.0 + 1e-4, 12.0, 400)
    m = 1.0 - 1.0 / k**2
    first, second = special.ellipk(m), special.ellipe(m)
    curvatures = -np.log((k**2 * second - first) / (first - second))
    factors = k ** (1.0 / 3.0) * (2.0 * second / np.pi) ** (2.0 / 3.0)
    return np.concatenate((curvatures[::-1], [0.0])), np.concatenate((factors[::-1], [1.0]))


def _growth(solution: ContactSolution, force: Array, area: Array) -> Array:
    """Return the factor by which a pressure limit widens the contact."""
    limit = np.asarray(solution.limit)
    if np.isinf(limit).all():
        return np.ones_like(area)
    if limit.ndim:
        clusters = solution.clusters
        finite = np.where(np.isfinite(limit), limit, _UNLIMITED)
        limit = np.concatenate(([1.0], clusters.sums(finite) / clusters.cells))
    with np.errstate(divide="ignore", invalid="ignore"):
        overload = np.where(area > 0.0, 1.5 * force / (area * limit), 0.0)
    return np.where(overload > _OVERLOAD[-1], 2.0 * overload / 3.0, np.interp(overload, _OVERLOAD, _GROWTH))


@attrs.frozen
class Hertz(AreaEstimator):
    r"""Hertz's contact area of each cluster, from its load and its curvature.

    .. math:: A = \pi \left(\frac{3F}{4E^*\kappa}\right)^{2/3} f, \quad \kappa = \tfrac12(\kappa_1+\kappa_2)

    with the curvature averaged by the pressure, which is exact to first order for summits that are
    no paraboloids, and the factor f of an elliptic contact. It needs no more than a cell in contact,
    and fails for clusters of several summits. Clusters without a summit count as level sets.

    References
    ----------
    Johnson, Contact Mechanics (1985), section 4.2, https://doi.org/10.1017/CBO9781139171731
    """

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the sum of Hertz's areas; see `AreaEstimator.estimate`."""
        edges, found = drawn(solution), hertz_areas(solution)
        valid = np.isfinite(found.error)
        values = np.where(valid, found.area, edges.area)
        drawn_bars = np.maximum(few_cells(solution, edges), 0.5 * edges.area)
        bars = np.where(valid, np.minimum(found.error, 1.0) * found.area, drawn_bars)
        common = common_error(found, np.where(valid, values, 0.0))
        return summed(solution, values, bars, common, edges, "hertz")
