"""What the other contacts do to the surface around each contact: slope and curvature of their displacement."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._solution import ContactSolution
from roughcontact.checks import Array, IntArray
from roughcontact.grid import Boundary

# Contacts around each one that are summed as point loads; beyond, the load is spread over the plane.
_NEAR = 24
# Nearest distance over the farthest: below it a contact is its own image.
_SAME = 1e-6


@attrs.frozen(eq=False)
class FarField:
    """Slope, shape (2, count), and xx, yy and xy curvature, shape (3, count), 1/m, of the displacement by others."""

    slope: Array
    curvature: Array

    @classmethod
    def zero(cls, count: int) -> FarField:
        """Return that of contacts alone."""
        return cls(np.zeros((2, count)), np.zeros((3, count)))


def find_far_field(solution: ContactSolution, x: Array, y: Array) -> FarField:
    r"""Return the far field at contacts in (x, y), m, that carry the forces of the solution's patches.

    A point load displaces the surface by F / (pi E* r), whose second derivatives are
    F (3 x^2 / r^5 - 1 / r^3) / (pi E*) and the like (Johnson, Contact Mechanics, section 3.2,
    https://doi.org/10.1017/CBO9781139171731).
    """
    forces, count = solution.patches.forces, x.size
    if solution.moduli is not None or count == 0:
        return FarField.zero(count)
    one, other, dx, dy, radius = _pair(solution, x, y)
    r = np.hypot(dx, dy)
    load = forces[other] / (np.pi * solution.modulus)
    parts = (-dx / r**3, -dy / r**3, 3 * dx**2 / r**5 - 1 / r**3, 3 * dy**2 / r**5 - 1 / r**3, 3 * dx * dy / r**5)
    sums = np.stack([np.bincount(one, load * part, minlength=count).astype(np.float64) for part in parts])
    if solution.boundary is Boundary.PERIODIC:
        # A uniform pressure outside of a circle bends the surface alike in all directions.
        sums[2:4] += solution.mean_pressure / (radius * solution.modulus)
    return FarField(sums[:2], sums[2:])


def _pair(solution: ContactSolution, x: Array, y: Array) -> tuple[IntArray, IntArray, Array, Array, float]:
    """Return the contacts and those near them, with periodic images: both numbers, dx and dy, m, and the radius."""
    from scipy.spatial import cKDTree

    size = np.array(solution.grid.size)
    points = np.stack((x, y), axis=1)
    radius = math.sqrt(_NEAR * solution.grid.area / (np.pi * x.size))
    places, numbers = points, np.arange(x.size)
    if solution.boundary is Boundary.PERIODIC:
        points = points % size
        reach = [range(-math.ceil(radius / side), math.ceil(radius / side) + 1) for side in size]
        shifts = size * np.array([(i, j) for i in reach[0] for j in reach[1]])
        places = (points + shifts[:, np.newaxis]).reshape(-1, 2)
        numbers = np.tile(numbers, len(shifts))
        near = ((places >= -radius) & (places <= size + radius)).all(axis=1)
        places, numbers = places[near], numbers[near]
    pairs = cKDTree(points).sparse_distance_matrix(cKDTree(places), radius, output_type="ndarray")
    pairs = pairs[pairs["v"] > _SAME * radius]
    step = points[pairs["i"]] - places[pairs["j"]]
    return pairs["i"], numbers[pairs["j"]], step[:, 0], step[:, 1], radius
