"""What the other contacts do to the surface around each contact: slope and curvature of their displacement."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.checks import Array, IntArray
from roughcontact._parts.grid import Boundary
from roughcontact._solve.solution import ContactSolution

# Contacts around each one that are summed as point loads; beyond, the load is spread over the plane.
_NEAR = 24
# Nearest distance over the farthest: below it a contact is its own image.
_SAME = 1e-6


@attrs.frozen(eq=False)
class FarField:
    """Slope, shape (2, count), and xx, xy and yy curvature, shape (3, count), 1/m, of the displacement by others."""

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
    forces = solution.patches.forces
    count = x.size
    if solution.moduli is not None or count == 0:
        return FarField.zero(count)
    radius = math.sqrt(_NEAR * solution.grid.area / (np.pi * count))
    one, other, dx, dy = _pair(solution, x, y, radius)
    square = dx * dx + dy * dy
    cube = 1.0 / (np.pi * solution.modulus * square * np.sqrt(square))
    parts = (-dx, -dy, 3.0 * dx * dx / square - 1.0, 3.0 * dx * dy / square, 3.0 * dy * dy / square - 1.0)
    sums = np.zeros((len(parts), count))
    # Each pair counts from both sides; from the other one the slope has the opposite sign.
    for here, there, sign in ((one, other, 1.0), (other, one, -1.0)):
        load = forces[there] * cube
        for k, part in enumerate(parts):
            sums[k] += np.bincount(here, load * part, minlength=count) * (sign if k < 2 else 1.0)
    if solution.boundary is Boundary.PERIODIC:
        # A uniform pressure outside of a circle bends the surface alike in all directions.
        sums[2::2] += solution.mean_pressure / (radius * solution.modulus)
    return FarField(sums[:2], sums[2:])


def _pair(solution: ContactSolution, x: Array, y: Array, radius: float) -> tuple[IntArray, IntArray, Array, Array]:
    """Return the pairs of contacts within a radius, with periodic images: both numbers, dx and dy, m."""
    from scipy.spatial import cKDTree

    size = np.array(solution.grid.size)
    points = np.stack((x, y), axis=1)
    periodic = solution.boundary is Boundary.PERIODIC
    if periodic:
        points = points % size
        # Rounding may leave the size itself.
        points = np.where(points < size, points, 0.0)
    if periodic and 2.0 * radius >= size.min():
        return _pair_images(points, size, radius)
    pairs = cKDTree(points, boxsize=size if periodic else None).query_pairs(radius, output_type="ndarray")
    one, other = np.ascontiguousarray(pairs.T)
    dx, dy = (at[one] - at[other] for at in np.ascontiguousarray(points.T))
    if periodic:
        dx, dy = (step - side * np.round(step / side) for step, side in zip((dx, dy), size, strict=True))
    apart = np.maximum(np.abs(dx), np.abs(dy)) > _SAME * radius
    return (one, other, dx, dy) if apart.all() else (one[apart], other[apart], dx[apart], dy[apart])


def _pair_images(points: Array, size: Array, radius: float) -> tuple[IntArray, IntArray, Array, Array]:
    """Return the same for the few contacts of a small domain, which may have several images within the radius."""
    from scipy.spatial import cKDTree

    reach = [range(-math.ceil(radius / side), math.ceil(radius / side) + 1) for side in size]
    shifts = size * np.array([(i, j) for i in reach[0] for j in reach[1]])
    places = (points + shifts[:, np.newaxis]).reshape(-1, 2)
    near = np.flatnonzero(((places >= -radius) & (places <= size + radius)).all(axis=1))
    pairs = cKDTree(points).sparse_distance_matrix(cKDTree(places[near]), radius, output_type="ndarray")
    pairs = pairs[pairs["v"] > _SAME * radius]
    one = pairs["i"]
    image = near[pairs["j"]]
    other = image % len(points)
    shift = image // len(points)
    # Once each: of a contact's own images those on one side.
    once = (one < other) | ((one == other) & (shift > len(shifts) // 2))
    step = (points[one] - places[image])[once]
    return one[once], other[once], step[:, 0], step[:, 1]
