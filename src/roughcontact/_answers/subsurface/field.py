"""The stress in one plane below a surface, its points, its invariants, and the fatigue numbers of paths through it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, Mask, Pair, RealArray, read_only
from roughcontact._base.units import ShownAsPrinted, si
from roughcontact._parts.grid import Grid

# Returns a scalar of stress components, shape (6, ...).
Measure: TypeAlias = Callable[[RealArray], RealArray]
# Cells of a block in the depth: the waves that blocks of side s do not resolve have decayed to exp(-pi z / s) at the
# depth z, which is 5e-5 for a quarter of the depth.
_MIN_STEPS_IN_DEPTH = 4.0
# Smallest number of points along an axis.
_MIN_POINTS = 16
# Relative error of the square of the radius of a smallest sphere, and number of spheres in its search.
_SPHERE_TOLERANCE = 1e-6
_MAX_SPHERES = 200
# Points that a smallest sphere in the five dimensions of deviators needs, and the choices of them beside another one.
_MAX_HELD = 6
_CHOICES = np.array(
    [choice for choice in itertools.product((False, True), repeat=_MAX_HELD) if sum(choice) < _MAX_HELD]
)
# Smallest eigenvalue, over the largest square, of the equations of a sphere.
_RIDGE = 1e-12
# Weights of the components, in the order of `COMPONENTS`, with which the norm of a vector is that of the tensor.
_WEIGHTS = np.sqrt(np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0]))


def find_steps(shape: tuple[int, int], sides: Pair, z: float) -> tuple[int, int]:
    """Return the cells of a block along each axis that resolve the stress at a depth."""
    return _find_step(shape[0], z / sides[0]), _find_step(shape[1], z / sides[1])


def _find_step(count: int, cells: float) -> int:
    step = 1
    while count % (2 * step) == 0 and count >= 2 * step * _MIN_POINTS and 2.0 * step * _MIN_STEPS_IN_DEPTH <= cells:
        step *= 2
    return step


def common_step(steps: Sequence[tuple[int, int]]) -> tuple[int, int]:
    """Return the largest of several steps along each axis: powers of two, so that each divides it."""
    along_x, along_y = zip(*steps, strict=True)
    return max(along_x), max(along_y)


@attrs.frozen(eq=False)
class StressField(ShownAsPrinted):
    """The stress at one depth below a surface; tension is positive.

    Attributes
    ----------
    depth
        Depth below the surface, m.
    grid
        The points, centres of its cells: the cells of the solution near the surface, fewer where the stress is smooth.
    values
        The components xx, yy, zz, yz, xz, xy over `scale`, float32, shape (6, nx, ny); z points into the body.
    scale
        The maximum contact pressure, Pa.
    """

    depth: float
    grid: Grid
    values: RealArray = attrs.field(converter=read_only, repr=False)
    scale: float

    @property
    def components(self) -> Array:
        """The components xx, yy, zz, yz, xz, xy, shape (6, nx, ny), Pa."""
        return np.asarray(self.values * np.float64(self.scale))

    @property
    def von_mises(self) -> Array:
        """Von Mises equivalent stress, shape (nx, ny), Pa."""
        return np.asarray(von_mises(self.values) * np.float64(self.scale))

    @property
    def shear(self) -> Array:
        """Maximum shear stress, half the difference of the extreme principal stresses, shape (nx, ny), Pa."""
        return np.asarray(maximum_shear(self.values) * np.float64(self.scale))

    @property
    def principal(self) -> Array:
        """Maximum principal stress, shape (nx, ny), Pa; tension is positive."""
        return np.asarray(maximum_principal(self.values) * np.float64(self.scale))

    def __str__(self) -> str:
        return (
            f"stress at a depth of {si(self.depth, 'm')} on {self.grid}: "
            f"von Mises up to {si(float(self.von_mises.max()), 'Pa')}"
        )


def find_largest(values: RealArray) -> tuple[int, int]:
    """Return the place of the largest value in a plane."""
    i, j = (int(place) for place in np.unravel_index(int(np.argmax(values)), values.shape))
    return i, j


def locate(grid: Grid, i: int, j: int) -> Pair:
    """Return the place (x, y) of a point, m."""
    return float(grid.x[i, 0]), float(grid.y[0, j])


def shear_invariant(values: RealArray) -> RealArray:
    """Return the second invariant J2 of the deviator of stresses, Voigt's components along the first axis."""
    xx, yy, zz, yz, xz, xy = values
    normal = (xx - yy) ** 2
    normal += (yy - zz) ** 2
    normal += (zz - xx) ** 2
    normal /= 6.0
    for shear in (yz, xz, xy):
        normal += shear * shear
    return np.asarray(normal)


def von_mises(values: RealArray) -> RealArray:
    """Return the von Mises equivalent stress of stresses, Voigt's components along the first axis."""
    return np.asarray(np.sqrt(3.0 * shear_invariant(values)))


def maximum_shear(values: RealArray) -> RealArray:
    r"""Return the maximum shear stress of stresses, Voigt's components along the first axis.

    .. math:: \tau = \sqrt{J_2} \sin(\theta + \pi/3), \quad \cos 3\theta = \frac{3\sqrt 3}{2} \frac{J_3}{J_2^{3/2}}
    """
    root, angle = _find_lode_angle(values)
    return np.asarray(root * np.sin(angle + math.pi / 3.0))


def maximum_principal(values: RealArray) -> RealArray:
    r"""Return the maximum principal stress of stresses, Voigt's components along the first axis.

    .. math:: \sigma_1 = \tfrac13 \operatorname{tr}\sigma + 2 \sqrt{J_2/3} \cos\theta
    """
    root, angle = _find_lode_angle(values)
    return np.asarray(mean_stress(values) + 2.0 / math.sqrt(3.0) * root * np.cos(angle))


def mean_stress(values: RealArray) -> RealArray:
    """Return the mean of the normal stresses of stresses, Voigt's components along the first axis."""
    return np.asarray((values[0] + values[1] + values[2]) / 3.0)


def _find_lode_angle(values: RealArray) -> tuple[RealArray, RealArray]:
    """Return the root of the second invariant of the deviator and the angle of `maximum_shear`."""
    root = np.sqrt(shear_invariant(values))
    # Over the root, so that the third invariant does not leave the range of float32.
    size = np.where(root > 0.0, root, 1.0)
    mean = mean_stress(values)
    xx, yy, zz = ((normal - mean) / size for normal in values[:3])
    yz, xz, xy = (shear / size for shear in values[3:])
    cube = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    return root, np.asarray(np.arccos(np.clip(1.5 * math.sqrt(3.0) * cube, -1.0, 1.0)) / 3.0)


def list_paths(values: RealArray, axis: int, starts_unloaded: bool) -> RealArray:
    """Return the stresses along each line of an axis, shape (6, lines, points), with a point without stress if asked.

    Parameters
    ----------
    values
        Stresses in a plane, shape (6, nx, ny), in the order `COMPONENTS`.
    axis
        Axis along which the points pass: 0 or 1.
    starts_unloaded
        Whether they come from where there is no stress.
    """
    paths = values.swapaxes(1, 2) if axis == 0 else values
    if starts_unloaded:
        paths = np.concatenate((paths, np.zeros_like(paths[:, :, :1])), axis=2)
    return np.asarray(paths, dtype=np.float64)


def find_crossland(paths: RealArray, alpha: float) -> float:
    """Return Crossland's number, the largest of all paths of shape (6, lines, points)."""
    radius = find_spheres(_deviators(paths))[1]
    return float(np.max(radius / math.sqrt(2.0) + alpha * mean_stress(paths).max(axis=1)))


def find_dang_van(paths: RealArray, alpha: float) -> float:
    """Return Dang Van's number, the largest of all paths of shape (6, lines, points)."""
    centre = find_spheres(_deviators(paths))[0].T / _WEIGHTS[:, np.newaxis]
    shear = maximum_shear(paths - centre[:, :, np.newaxis])
    return float(np.max(shear + alpha * mean_stress(paths)))


def _deviators(paths: RealArray) -> RealArray:
    """Return the deviators as vectors, shape (lines, points, 6)."""
    deviators = paths.copy()
    deviators[:3] -= mean_stress(paths)
    return np.asarray(deviators.transpose(1, 2, 0) * _WEIGHTS)


def find_spheres(points: RealArray) -> tuple[RealArray, RealArray]:
    """Return the centres and radii of the smallest spheres around sets of points.

    A sphere grows until no point lies outside: the farthest point joins those on it, and of their smallest spheres,
    found for each choice of them, the largest is the next one.

    Parameters
    ----------
    points
        Deviators as vectors, shape (sets, points, 6).

    Returns
    -------
    tuple
        Centres, shape (sets, 6), and radii, shape (sets,).
    """
    count = points.shape[0]
    centres = points[:, 0].copy()
    squares = np.zeros(count)
    held = np.zeros((count, _MAX_HELD, points.shape[2]))
    is_held = np.zeros((count, _MAX_HELD), dtype=bool)
    active: IntArray = np.arange(count)
    for _ in range(_MAX_SPHERES):
        distances = _square_distances(points[active], centres[active])
        farthest = distances.argmax(axis=1)
        outside = distances.max(axis=1) > squares[active] * (1.0 + _SPHERE_TOLERANCE) + np.finfo(np.float64).tiny
        active = active[outside]
        if active.size == 0:
            break
        added = points[active, farthest[outside]]
        apart = held[active] - added[:, np.newaxis]
        weights, kept, square = _enclose(apart, is_held[active])
        centres[active] = added + np.einsum("ij,ijk->ik", weights, apart)
        squares[active] = square
        free = kept.argmin(axis=1)
        held[active, free] = added
        kept[np.arange(active.size), free] = True
        is_held[active] = kept
    return centres, np.sqrt(_square_distances(points, centres).max(axis=1))


def _enclose(apart: RealArray, is_held: Mask) -> tuple[RealArray, Mask, RealArray]:
    """Return the smallest sphere through the origin around other points, for several sets.

    Parameters
    ----------
    apart
        The points, shape (sets, held, dimensions).
    is_held
        Which of them there are, shape (sets, held).

    Returns
    -------
    tuple
        The weights of the points in the centre and which of them lie on the sphere, shape (sets, held) each; the square
        of its radius, shape (sets,).
    """
    products = np.einsum("ijk,ilk->ijl", apart, apart)
    squares = np.einsum("ijj->ij", products)
    chosen = _CHOICES & is_held[:, np.newaxis]
    both = chosen[..., :, np.newaxis] & chosen[..., np.newaxis, :]
    smallest = _RIDGE * squares.max(axis=1)[:, np.newaxis, np.newaxis]
    diagonal = np.where(chosen, smallest, 1.0)
    matrix = np.where(both, products[:, np.newaxis], 0.0) + diagonal[..., np.newaxis] * np.eye(_MAX_HELD)
    right = np.where(chosen, 0.5 * squares[:, np.newaxis], 0.0)
    weights = np.linalg.solve(matrix, right[..., np.newaxis])[..., 0]
    # A sphere is the smallest one of its points where its centre lies between them.
    inside = (weights >= 0.0).all(axis=2) & (weights.sum(axis=2) <= 1.0)
    square = np.where(inside, np.einsum("ijk,ijk->ij", weights, right), -1.0)
    best = square.argmax(axis=1)
    sets = np.arange(best.size)
    return weights[sets, best], chosen[sets, best], square[sets, best]


def _square_distances(points: RealArray, centres: RealArray) -> RealArray:
    """Return the squares of the distances of points, shape (sets, points, dimensions), to the centre of each set."""
    apart = points - centres[:, np.newaxis]
    return np.asarray(np.einsum("ijk,ijk->ij", apart, apart))
