"""The summits under the patches: place, curvature and contact ellipse of each, beside the other contacts."""

from __future__ import annotations

import math
from functools import lru_cache

import attrs
import numpy as np
import scipy

from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.cells import find_patches_of, split
from roughcontact._answers.areas.ellipses import find_ellipses
from roughcontact._answers.areas.initial_gap import ROUNDING, SPLINE_REACH, Spline, combine_principal
from roughcontact._base.arrays import Array, IntArray, Mask, RealArray
from roughcontact._parts.grid import Boundary, grow
from roughcontact._solve.solution import ContactSolution

# Ratio of the axes up to which contacts are tabulated, and the number of ratios.
_MAX_AXES_RATIO = 30.0
_TABLE_ENTRIES = 600
# Number of angles of the points in an ellipse, which have the symmetry of the grid.
_POINT_ANGLES = 8
# Number of contacts around each one that are summed as point loads; beyond, the load is spread over the plane.
_NEAR_CONTACTS = 24
# Smallest ratio of the principal curvatures of a summit: longer contacts are not elliptic on a rough surface.
MIN_CURVATURE_RATIO = 0.05
# The same where the curvature varies by less than the smaller principal curvature, as on rollers.
_MIN_EVEN_CURVATURE_RATIO = 0.01
# Rounds of place and ellipse; the far field is known from the second on.
_ELLIPSE_ROUNDS = 3
# Rounds of the fixed point for the modulus at the size of a contact: each at least halves the logarithmic error.
_MODULUS_ROUNDS = 20


def find_area_factor(ratio: Array) -> Array:
    """Return the area of an elliptic contact over the area of the circular one with the same mean curvature."""
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
    return np.asarray(force * scipy.special.ellipk(1.0 - 1.0 / axes_ratio**2) / (np.pi * modulus * semi_axis))


@lru_cache(maxsize=1)
def _tabulate() -> tuple[Array, Array, Array]:
    r"""Return logarithms of the ratio of curvatures, the factors of the area and the ratios k of the axes.

    kappa_1 / kappa_2 = (k^2 E - K) / (K - E), factor = k^(1/3) (2 E / pi)^(2/3), e^2 = 1 - 1 / k^2;
    Johnson, Contact Mechanics (1985), eqs. 4.26 to 4.28, https://doi.org/10.1017/CBO9781139171731.
    """
    k = np.geomspace(1.0 + 1e-4, _MAX_AXES_RATIO, _TABLE_ENTRIES)
    m = 1.0 - 1.0 / k**2
    first = scipy.special.ellipk(m)
    second = scipy.special.ellipe(m)
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
    angles = np.arange(_POINT_ANGLES) * (2.0 * np.pi / _POINT_ANGLES)
    radius = math.sqrt(fourth / square)
    around = square**2 / fourth
    weights = np.append(np.full(_POINT_ANGLES, around / _POINT_ANGLES), 1.0 - around)
    return np.append(radius * np.cos(angles), 0.0), np.append(radius * np.sin(angles), 0.0), weights


@attrs.frozen(eq=False)
class FarField:
    """Displacement by the other patches: slope, (2, count), and xx, xy and yy curvature, (3, count), 1/m.

    `error` is the standard deviation of the curvature, (count,), 1/m, because the loads are no points.
    """

    slope: Array
    curvature: Array
    error: Array

    @classmethod
    def zero(cls, count: int) -> FarField:
        """Return the far field of contacts without others."""
        return cls(np.zeros((2, count)), np.zeros((3, count)), np.zeros(count))


def find_far_field(solution: ContactSolution, x: Array, y: Array, semi_axis: Array) -> FarField:
    r"""Return the far field at contacts in (x, y), m, that carry the forces of the solution's patches.

    A point load displaces the surface by F / (pi E* r), whose second derivatives are
    F (3 x^2 / r^5 - 1 / r^3) / (pi E*) and the like (Johnson, Contact Mechanics, section 3.2,
    https://doi.org/10.1017/CBO9781139171731). On layers E* is that of waves as long as the distance. The major
    semi-axes of the contacts, m, tell how far they are from points.
    """
    forces = solution.patches.forces
    count = x.size
    if count == 0:
        return FarField.zero(count)
    radius = math.sqrt(_NEAR_CONTACTS * solution.grid.area / (np.pi * count))
    if solution.boundary.mixed:
        # A narrow domain repeats as a row, in which contacts are further apart than in the plane.
        row = solution.grid.size[1 - solution.boundary.free_axis]
        radius = max(radius, 0.5 * _NEAR_CONTACTS * row / count)
    one, other, dx, dy = _pair_contacts(solution, x, y, radius)
    square = dx * dx + dy * dy
    distance = np.sqrt(square)
    cube = 1.0 / (np.pi * solution.effective_modulus(1.0 / distance) * square * distance)
    parts = (-dx, -dy, 3.0 * dx * dx / square - 1.0, 3.0 * dx * dy / square, 3.0 * dy * dy / square - 1.0)
    sums = np.zeros((len(parts), count))
    error = np.zeros(count)
    relative = np.minimum(
        calibration.FAR_FIELD_ERROR[0] * (semi_axis[one] ** 2 + semi_axis[other] ** 2) / square,
        calibration.FAR_FIELD_ERROR[1],
    )
    # Each pair counts from both sides; from the other one the slope has the opposite sign.
    for here, there, sign in ((one, other, 1.0), (other, one, -1.0)):
        load = forces[there] * cube
        for k, part in enumerate(parts):
            sums[k] += np.bincount(here, load * part, minlength=count) * (sign if k < 2 else 1.0)
        unsure = relative
        if solution.boundary is Boundary.WRAPPED:
            unsure = relative + _find_kinks(solution, dx, dy, semi_axis[here], semi_axis[there])
        error += np.bincount(here, load * unsure, minlength=count)
    if solution.boundary is Boundary.PERIODIC:
        # A uniform pressure outside of a circle bends the surface alike in all directions.
        sums[2::2] += solution.mean_pressure / (radius * float(solution.effective_modulus(1.0 / radius)))
    return FarField(sums[:2], sums[2:], error)


def _find_kinks(solution: ContactSolution, dx: Array, dy: Array, here: Array, there: Array) -> Array:
    """Return the standard deviation of the curvature at contacts by those half of a wrapped domain away, as a factor.

    Beyond half the domain the other way around is the shorter one: the slope of the displacement by a point load jumps
    by 2 F d / (pi E* r^3) over the contact, whose semi-axis is `here`, m; `there` is that of the loads.
    """
    factor = np.zeros(dx.shape)
    for step, side in zip((dx, dy), solution.grid.size, strict=True):
        missed = np.abs(0.5 * side - np.abs(step))
        met = np.maximum(1.0 - missed / (here + there), 0.0)
        factor += calibration.KINK_ERROR * met * 0.5 * side / here
    return factor


def _pair_contacts(
    solution: ContactSolution, x: Array, y: Array, radius: float
) -> tuple[IntArray, IntArray, Array, Array]:
    """Return the pairs of contacts within a radius, with periodic images: both numbers, dx and dy, m."""
    from scipy.spatial import cKDTree

    size = np.array(solution.grid.size)
    points = np.stack((x, y), axis=1)
    # In a wrapped domain as well, but only the nearest image counts.
    repeats = ~np.array(solution.boundary.free_axes)
    # Rounding may leave the size itself.
    inside = points % size
    points = np.where(repeats, np.where(inside < size, inside, 0.0), points)
    if any(solution.boundary.repeats) and 2.0 * radius >= size[repeats].min():
        return _pair_images(points, size, radius, repeats)
    pairs = cKDTree(points, boxsize=np.where(repeats, size, 0.0)).query_pairs(radius, output_type="ndarray")
    one, other = np.ascontiguousarray(pairs.T)
    dx, dy = (at[one] - at[other] for at in np.ascontiguousarray(points.T))
    axes = zip((dx, dy), size, repeats, strict=True)
    dx, dy = (step - side * np.round(step / side) if repeated else step for step, side, repeated in axes)
    apart = np.maximum(np.abs(dx), np.abs(dy)) > ROUNDING * radius
    return (one, other, dx, dy) if apart.all() else (one[apart], other[apart], dx[apart], dy[apart])


def _pair_images(points: Array, size: Array, radius: float, repeats: Mask) -> tuple[IntArray, IntArray, Array, Array]:
    """Return the pairs of the few contacts of a small domain, which may have several images within the radius."""
    from scipy.spatial import cKDTree

    images = [math.ceil(radius / side) if repeated else 0 for side, repeated in zip(size, repeats, strict=True)]
    reach = [range(-count, count + 1) for count in images]
    shifts = size * np.array([(i, j) for i in reach[0] for j in reach[1]])
    places = (points + shifts[:, np.newaxis]).reshape(-1, 2)
    near = np.flatnonzero((((places >= -radius) & (places <= size + radius)) | ~repeats).all(axis=1))
    pairs = cKDTree(points).sparse_distance_matrix(cKDTree(places[near]), radius, output_type="ndarray")
    pairs = pairs[pairs["v"] > ROUNDING * radius]
    one = pairs["i"]
    image = near[pairs["j"]]
    other = image % len(points)
    shift = image // len(points)
    # Each pair once; of the images of a contact itself, those on one side.
    once = (one < other) | ((one == other) & (shift > len(shifts) // 2))
    step = (points[one] - places[image])[once]
    return one[once], other[once], step[:, 0], step[:, 1]


@attrs.frozen(eq=False)
class Summits:
    """The ellipse of each patch after Hertz, arrays of shape (count,).

    Attributes
    ----------
    known
        Whether there is a summit with an ellipse that is not too slender.
    row, column
        Centre, in cells from the first centre of a cell.
    area
        Contact area, m2; without meaning where `known` is false, as all other attributes.
    axes_ratio, angle
        Ratio of the axes, at least one, and angle of the longer one from the x axis, rad.
    curvature
        Half the sum of the principal curvatures, far field included, 1/m.
    spread
        Standard deviation of the curvature over the ellipse, relative to its mean.
    crowding
        Standard deviation of the curvature by the other patches over the smaller principal curvature; in a wrapped
        domain also by the contact itself.
    change
        Logarithm of the change of the modulus over two octaves at the size of the contact.
    far
        Slope and curvature of the displacement by the other patches.
    """

    known: Mask
    row: Array
    column: Array
    area: Array
    axes_ratio: Array
    angle: Array
    curvature: Array
    spread: Array
    crowding: Array
    change: Array
    far: FarField

    @property
    def semi_axis(self) -> Array:
        """Major semi-axis, m."""
        return np.asarray(np.sqrt(self.area * self.axes_ratio / np.pi))

    @property
    def extents(self) -> tuple[Array, Array]:
        """Distances from the centre to which the ellipses extend along x and y, m."""
        major = self.semi_axis
        minor = self.semi_axis / self.axes_ratio
        cos = np.cos(self.angle)
        sin = np.sin(self.angle)
        return np.hypot(major * cos, minor * sin), np.hypot(major * sin, minor * cos)

    def place(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Return points (u, v) of the unit circle, shape (n,), on the ellipses: from their centres, m."""
        major = self.semi_axis[:, np.newaxis]
        along = major * u
        across = major / self.axes_ratio[:, np.newaxis] * v
        cos = np.cos(self.angle)[:, np.newaxis]
        sin = np.sin(self.angle)[:, np.newaxis]
        return cos * along - sin * across, sin * along + cos * across


def find_summits(solution: ContactSolution, spline: Spline) -> Summits:
    """Return the summits of all patches.

    The curvature of the initial gap and of the far field is averaged over the ellipse with Hertz's pressure as weight,
    which is exact to first order for summits that are not paraboloids. The mean slope at the centre is zero.
    """
    patches = solution.patches
    dx, dy = solution.grid.spacing
    row, column = find_centroids(solution)
    ones = np.ones(patches.count)
    zeros = np.zeros(patches.count)
    far = FarField.zero(patches.count)
    found = Summits(ones > 0.0, row, column, patches.areas, ones, zeros, ones, zeros, zeros, zeros, far)
    u, v, weights = points_of_hertz()
    for turn in range(_ELLIPSE_ROUNDS):
        if turn == 1:
            far = find_far_field(solution, found.row * dx, found.column * dy, found.semi_axis)
            found = attrs.evolve(found, far=far)
        x, y = found.place(u, v)
        last = turn == _ELLIPSE_ROUNDS - 1
        degrees = (2,) if last else (2, 1)
        parts = spline.derivatives(found.row[:, None] + x / dx, found.column[:, None] + y / dy, *degrees)
        mean = parts @ weights
        curvature = mean[:3] + found.far.curvature
        found = _fit_ellipse(solution, found, curvature)
        if not last:
            found = _move(found, mean[3:] + found.far.slope, curvature, (dx, dy))
    squares = (parts - mean[..., np.newaxis]) ** 2 @ weights
    variance = squares[0] + 2.0 * squares[1] + squares[2]
    found = attrs.evolve(found, spread=np.sqrt(variance) / found.curvature)
    _, difference = combine_principal(*curvature)
    known = found.known & is_elliptic(found.curvature, difference, found.spread)
    known &= ~_find_near_border(solution, found) & ~find_beside_non_measured(solution)
    smaller = np.where(known, found.curvature - difference, 1.0)
    return attrs.evolve(found, known=known, crowding=_find_crowding(solution, found, smaller))


def find_lowest(solution: ContactSolution, field: RealArray) -> IntArray:
    """Return the flat index in the domain of the cell of the lowest value in each patch, shape (count,)."""
    patches = solution.patches
    label = patches.member_labels - 1
    values = field.ravel()[patches.members]
    lowest = np.full(patches.count, np.inf)
    np.minimum.at(lowest, label, values)
    chosen = values == solution.parts.lowest(lowest)[label]
    i, j = split(patches.members[chosen], solution.grid.shape[1])
    found = np.full(patches.count, solution.grid.cells, dtype=np.intp)
    np.minimum.at(found, label[chosen], solution.parts.rows(i) * solution.grid.shape[1] + j)
    return solution.parts.lowest(found)


def find_centroids(solution: ContactSolution) -> tuple[Array, Array]:
    """Return the centre of the pressure of each patch, in cells, shape (count,)."""
    patches = solution.patches
    members = patches.members
    label = patches.member_labels - 1
    weight = solution.pressure.ravel()[members]
    # Around the first cell of each patch, for a patch may cross the border.
    nx, ny = solution.grid.shape
    row, column = split(members, ny)
    row = solution.parts.rows(row)
    cell = row * ny + column
    first = np.full(patches.count, nx * ny, dtype=np.intp)
    np.minimum.at(first, label, cell)
    sums = [np.bincount(label, weights=weight, minlength=patches.count)]
    origins = split(solution.parts.lowest(first), ny)
    for at, origin, n, free in zip((row, column), origins, (nx, ny), solution.boundary.free_axes, strict=True):
        step = unwrap(at - origin[label], n, free=free)
        sums.append(np.bincount(label, weights=weight * step, minlength=patches.count))
    # Sums over no cells are whole numbers.
    total, *moments = solution.parts.total(np.array(sums, dtype=np.float64))
    return origins[0] + moments[0] / total, origins[1] + moments[1] / total


def unwrap(steps: Array | IntArray | float, length: float, *, free: bool) -> Array:
    """Return steps along an axis of a length, by the shorter way around unless the domain ends at its border."""
    if free:
        return np.asarray(steps, dtype=np.float64)
    return np.asarray(steps - length * np.round(steps / length))


def _fit_ellipse(solution: ContactSolution, found: Summits, curvature: Array) -> Summits:
    xx, xy, yy = curvature
    middle, difference = combine_principal(xx, xy, yy)
    known = found.known & (middle > 0.0) & (middle - difference > _MIN_EVEN_CURVATURE_RATIO * (middle + difference))
    middle = np.where(known, middle, 1.0)
    difference = np.where(known, difference, 0.0)
    ratio = (middle - difference) / (middle + difference)
    if solution.directional_moduli is not None:
        deviator = np.where(known, np.stack((0.5 * (xx - yy), xy)), 0.0)
        ellipses = find_ellipses(solution.directional_moduli, solution.patches.forces, middle, deviator)
        return attrs.evolve(
            found,
            known=known & ellipses.known,
            area=ellipses.area,
            axes_ratio=ellipses.axes_ratio,
            angle=ellipses.angle,
            curvature=middle,
        )
    area, change = solve_for_area(solution, solution.patches.forces, middle, ratio)
    return attrs.evolve(
        found,
        known=known,
        area=area,
        axes_ratio=find_axes_ratio(ratio),
        angle=0.5 * np.arctan2(2.0 * xy, xx - yy) + 0.5 * np.pi,
        curvature=middle,
        change=change,
    )


def is_elliptic(mean: Array, difference: Array, spread: Array) -> Mask:
    """Return which summits have elliptic contacts, by half the sum and difference of their principal curvatures.

    In long contacts the curvature may vary by the smaller principal one at most; `spread` is relative to the mean.
    """
    smaller = mean - difference
    larger = mean + difference
    even = (smaller > _MIN_EVEN_CURVATURE_RATIO * larger) & (spread * mean < smaller)
    return np.asarray((mean > 0.0) & ((smaller > MIN_CURVATURE_RATIO * larger) | even))


def _move(found: Summits, slope: Array, curvature: Array, spacing: tuple[float, float]) -> Summits:
    """Return the summits with centres where the mean slope vanishes, moved by one semi-axis at most."""
    xx, xy, yy = curvature
    determinant = np.where(found.known, xx * yy - xy**2, 1.0)
    x, y = (
        np.where(found.known, (one * a - xy * b) / determinant, 0.0)
        for one, a, b in ((yy, slope[0], slope[1]), (xx, slope[1], slope[0]))
    )
    length = np.hypot(x, y)
    part = np.where(length > found.semi_axis, found.semi_axis / np.where(length > 0.0, length, 1.0), 1.0)
    return attrs.evolve(found, row=found.row - part * x / spacing[0], column=found.column - part * y / spacing[1])


def solve_for_area(solution: ContactSolution, force: Array, curvature: Array, ratio: Array) -> tuple[Array, Array]:
    """Return Hertz's areas, m2, with E* at the size of each contact, and the logarithm of how E* changes there."""
    loaded = 0.75 * np.pi**1.5 * force * find_area_factor(ratio) ** 1.5 / curvature
    area = (loaded / solution.modulus) ** (2.0 / 3.0)
    if solution.moduli is None:
        return area, np.zeros_like(area)
    shortest = solution.moduli[0][0]
    for _ in range(_MODULUS_ROUNDS):
        length = np.maximum(calibration.MODULUS_LENGTH * np.sqrt(area / np.pi), shortest)
        area = np.sqrt(area * (loaded / solution.effective_modulus(1.0 / length)) ** (2.0 / 3.0))
    change = np.abs(np.log(solution.effective_modulus(0.5 / length) / solution.effective_modulus(2.0 / length)))
    return area, np.asarray(change)


def _find_near_border(solution: ContactSolution, found: Summits) -> Mask:
    """Return which ellipses reach beyond the outermost cell centres at a free border."""
    near = np.zeros(found.known.shape, dtype=bool)
    rows = zip((found.row, found.column), found.extents, solution.grid.shape, solution.grid.spacing, strict=True)
    for free, (at, extent, n, step) in zip(solution.boundary.free_axes, rows, strict=True):
        reach = extent / step
        near |= free & ((at < reach) | (at > n - 1 - reach))
    return near


def _find_crowding(solution: ContactSolution, found: Summits, smaller: Array) -> Array:
    """Return the standard deviation of the curvature by others, and by a contact itself around a wrapped domain."""
    crowding = found.far.error / smaller
    if solution.boundary is not Boundary.WRAPPED:
        return np.asarray(crowding)
    # The ends of contacts longer than half the domain act on each other around it, and not along the contact.
    parts = (4.0 * extent / side - 1.0 for extent, side in zip(found.extents, solution.grid.size, strict=True))
    longest = np.maximum.reduce([np.zeros_like(crowding), *parts])
    return np.asarray(np.maximum(crowding, calibration.WRAPPED_ERROR * longest))


def find_beside_non_measured(solution: ContactSolution) -> Mask:
    """Return which patches lie beside non-measured points, shape (count,): their heights are not known there."""
    if solution.non_measured is None:
        return np.zeros(solution.patches.count, dtype=bool)
    return find_patches_of(solution, grow(solution.non_measured, SPLINE_REACH, solution.boundary))
