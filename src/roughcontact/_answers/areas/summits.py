"""The summits under the patches: place, curvature and contact ellipse of each, from the heights between the cells."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.cells import split
from roughcontact._answers.areas.ellipse import find_area_factor, find_axes_ratio, points_of_hertz
from roughcontact._answers.areas.far_field import FarField, find_far_field
from roughcontact._answers.areas.spline import Spline
from roughcontact._base.checks import Array, IntArray, Mask
from roughcontact._parts.grid import Boundary, grow
from roughcontact._solve.solution import ContactSolution

# Smallest ratio of the principal curvatures of a summit: longer contacts are not elliptic on a rough surface.
SLENDEREST = 0.05
# Rounds of place and ellipse, and the one from which the far field is known.
_ROUNDS = 3
_FAR = 1
# Rounds of the fixed point for the modulus at the size of a contact: each halves the logarithmic error at least.
_MODULUS_ROUNDS = 20
# Smallest ratio where the curvature varies less than the smaller one, as on rollers.
_SLENDEREST_EVEN = 0.01
# Cells between an ellipse and the outermost centres at a free border.
_MARGIN = 0.0
# Cells between a patch and a non-measured point, which the spline needs.
_REACH = 3


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
        Contact area, m2; of no meaning where `known` is false, as all that follows.
    axes_ratio, angle
        Ratio of the axes, at least one, and angle of the longer one from the x axis, rad.
    curvature
        Half the sum of the principal curvatures, far field included, 1/m.
    spread
        Standard deviation of the curvature over the ellipse, relative to its mean.
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

    The curvature of the initial gap and of the far field is averaged over the ellipse with Hertz's pressure as
    weight, which is exact to first order for summits that are not paraboloids, and the centre lies where the slopes
    balance.
    """
    patches = solution.patches
    dx, dy = solution.grid.spacing
    row, column = find_centroids(solution)
    ones = np.ones(patches.count)
    zeros = np.zeros(patches.count)
    far = FarField.zero(patches.count)
    found = Summits(ones > 0.0, row, column, patches.areas, ones, zeros, ones, zeros, zeros, far)
    u, v, weights = points_of_hertz()
    for turn in range(_ROUNDS):
        if turn == _FAR:
            found = attrs.evolve(found, far=find_far_field(solution, found.row * dx, found.column * dy))
        x, y = found.place(u, v)
        last = turn == _ROUNDS - 1
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
    xx, xy, yy = curvature
    known = found.known & is_elliptic(found.curvature, np.hypot(0.5 * (xx - yy), xy), found.spread)
    return attrs.evolve(found, known=known & ~_near_border(solution, found) & ~find_near_holes(solution))


def find_centroids(solution: ContactSolution) -> tuple[Array, Array]:
    """Return the centre of the pressure of each patch, in cells, shape (count,)."""
    patches = solution.patches
    members = patches.members
    label = patches.member_labels - 1
    weight = solution.pressure.ravel()[members]
    # Around the first cell of each patch, for a patch may cross the border.
    first = np.empty(patches.count, dtype=np.intp)
    first[label[::-1]] = np.arange(members.size)[::-1]
    total = np.bincount(label, weights=weight, minlength=patches.count)
    centres = []
    for at, n in zip(split(members, solution.grid.shape[1]), solution.grid.shape, strict=True):
        origin = at[first]
        step = unwrap(at - origin[label], n, solution.boundary)
        centres.append(origin + np.bincount(label, weights=weight * step, minlength=patches.count) / total)
    return centres[0], centres[1]


def unwrap(steps: Array | IntArray, cells: int, boundary: Boundary) -> Array:
    """Return steps between cells along an axis, by the shorter way around a periodic or wrapped domain."""
    if boundary is Boundary.FREE:
        return np.asarray(steps, dtype=np.float64)
    return np.asarray(steps - cells * np.round(steps / cells))


def _fit_ellipse(solution: ContactSolution, found: Summits, curvature: Array) -> Summits:
    xx, xy, yy = curvature
    middle = 0.5 * (xx + yy)
    difference = np.hypot(0.5 * (xx - yy), xy)
    known = found.known & (middle > 0.0) & (middle - difference > _SLENDEREST_EVEN * (middle + difference))
    middle = np.where(known, middle, 1.0)
    difference = np.where(known, difference, 0.0)
    ratio = (middle - difference) / (middle + difference)
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

    The curvature of the longer ones may vary by the smaller principal one at most; `spread` is relative to the mean.
    """
    smaller = mean - difference
    larger = mean + difference
    even = (smaller > _SLENDEREST_EVEN * larger) & (spread * mean < smaller)
    return np.asarray((mean > 0.0) & ((smaller > SLENDEREST * larger) | even))


def _move(found: Summits, slope: Array, curvature: Array, spacing: tuple[float, float]) -> Summits:
    """Move the centres to where the slopes would balance, by one semi-axis at most."""
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
        length = np.maximum(calibration.HERTZ_LENGTH * np.sqrt(area / np.pi), shortest)
        area = np.sqrt(area * (loaded / solution.effective_modulus(1.0 / length)) ** (2.0 / 3.0))
    change = np.abs(np.log(solution.effective_modulus(0.5 / length) / solution.effective_modulus(2.0 / length)))
    return area, np.asarray(change)


def _near_border(solution: ContactSolution, found: Summits) -> Mask:
    """Mark the ellipses that a free border cuts, or nearly so."""
    near = np.zeros(found.known.shape, dtype=bool)
    if solution.boundary is Boundary.FREE:
        rows = zip((found.row, found.column), found.extents, solution.grid.shape, solution.grid.spacing, strict=True)
        for at, extent, n, step in rows:
            reach = extent / step + _MARGIN
            near |= (at < reach) | (at > n - 1 - reach)
    return near


def find_near_holes(solution: ContactSolution) -> Mask:
    """Mark the patches beside non-measured points, whose heights are not known there, shape (count,)."""
    near = np.zeros(solution.patches.count + 1, dtype=bool)
    if solution.non_measured is not None:
        near[solution.patches.labels[grow(solution.non_measured, _REACH, solution.boundary)]] = True
    return near[1:]
