"""Fatigue numbers of the stress paths through which points of a body pass below a contact that rolls or slides."""

from __future__ import annotations

import itertools
import math

import numpy as np

from roughcontact._answers.subsurface.field import maximum_shear, mean_stress
from roughcontact._base.arrays import IntArray, Mask, RealArray

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
