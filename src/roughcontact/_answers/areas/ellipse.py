"""Hertz's elliptic contact: factors of its area and axes, and points to average over it."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy import special

from roughcontact._base.checks import Array

# Ratio of the axes up to which contacts are tabulated, and the number of ratios.
_LONGEST = 30.0
_ENTRIES = 600
# Angles of the points, which are symmetric as the grid is.
_ANGLES = 8


def find_area_factor(ratio: Array) -> Array:
    """Return the area of an elliptic contact over that of the circular one with the same mean curvature."""
    logarithms, factors, _ = _tabulate()
    return np.asarray(np.interp(np.log(ratio), logarithms, factors))


def find_axes_ratio(ratio: Array) -> Array:
    """Return the ratio of the axes, at least one, for ratios of the curvatures, at most one."""
    logarithms, _, axes = _tabulate()
    return np.asarray(np.interp(np.log(ratio), logarithms, axes))


def find_depth(force: Array, semi_axis: Array, axes_ratio: Array, modulus: float) -> Array:
    """Return F K(e) / (pi E* a), m: the depth of a flat punch on an ellipse of major semi-axis a, m.

    It is two thirds of the approach of a paraboloid with the same contact.
    """
    return np.asarray(force * special.ellipk(1.0 - 1.0 / axes_ratio**2) / (np.pi * modulus * semi_axis))


@lru_cache(maxsize=1)
def _tabulate() -> tuple[Array, Array, Array]:
    r"""Return logarithms of the ratio of curvatures, the factors of the area and the ratios k of the axes.

    kappa_1 / kappa_2 = (k^2 E - K) / (K - E), factor = k^(1/3) (2 E / pi)^(2/3), e^2 = 1 - 1 / k^2;
    Johnson, Contact Mechanics (1985), eqs. 4.26 to 4.28, https://doi.org/10.1017/CBO9781139171731.
    """
    k = np.geomspace(1.0 + 1e-4, _LONGEST, _ENTRIES)
    m = 1.0 - 1.0 / k**2
    first = special.ellipk(m)
    second = special.ellipe(m)
    logarithms = -np.log((k**2 * second - first) / (first - second))
    factors = k ** (1.0 / 3.0) * (2.0 * second / np.pi) ** (2.0 / 3.0)
    return (
        np.concatenate((logarithms[::-1], [0.0])),
        np.concatenate((factors[::-1], [1.0])),
        np.concatenate((k[::-1], [1.0])),
    )


@lru_cache(maxsize=1)
def points_of_hertz() -> tuple[Array, Array, Array]:
    """Return points in the unit circle and their weights for a mean by Hertz's pressure, exact to degree 5."""
    return _place_points(2.0 / 5.0, 8.0 / 35.0)


@lru_cache(maxsize=1)
def points_of_punch() -> tuple[Array, Array, Array]:
    """Return points in the unit circle and their weights for a mean by a flat punch's pressure, exact to degree 5."""
    return _place_points(2.0 / 3.0, 8.0 / 15.0)


def _place_points(square: float, fourth: float) -> tuple[Array, Array, Array]:
    """Return points and weights for a pressure over which the means of r^2 and r^4 are these."""
    angles = np.arange(_ANGLES) * (2.0 * np.pi / _ANGLES)
    radius = math.sqrt(fourth / square)
    around = square**2 / fourth
    weights = np.append(np.full(_ANGLES, around / _ANGLES), 1.0 - around)
    return np.append(radius * np.cos(angles), 0.0), np.append(radius * np.sin(angles), 0.0), weights
