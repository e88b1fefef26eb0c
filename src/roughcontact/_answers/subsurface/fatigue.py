"""Fatigue numbers of the stress paths through which points of a body pass below a contact that rolls or slides."""

from __future__ import annotations

import math

import numpy as np

from roughcontact._answers.subsurface.field import maximum_shear, mean_stress
from roughcontact._base.arrays import IntArray, RealArray

# Relative error of the square of the radius of a smallest sphere, and number of steps in its search.
_SPHERE_TOLERANCE = 1e-4
_MAX_SPHERE_STEPS = 2000
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

    The centre is a mean of the points, whose weights move towards the farthest point or away from the nearest one that
    has a weight.

    Parameters
    ----------
    points
        Shape (sets, points, dimensions).

    Returns
    -------
    tuple
        Centres, shape (sets, dimensions), and radii, shape (sets,): all points lie inside, and the squares of the radii
        are at most 1e-4 too large.

    References
    ----------
    Yildirim, SIAM J. Optim. 19 (2008) 1368-1391, https://doi.org/10.1137/070690419
    """
    sets = np.arange(points.shape[0])
    first = _square_distances(points, points[:, 0]).argmax(axis=1)
    second = _square_distances(points, points[sets, first]).argmax(axis=1)
    weights = np.zeros(points.shape[:2])
    weights[sets, first] += 0.5
    weights[sets, second] += 0.5
    centres = 0.5 * (points[sets, first] + points[sets, second])
    radii = np.zeros(sets.size)
    active: IntArray = sets
    for _ in range(_MAX_SPHERE_STEPS):
        near = points[active]
        weight = weights[active]
        square = _square_distances(near, centres[active])
        radii[active] = np.sqrt(square.max(axis=1))
        # The mean square distance is a lower bound of the square of the radius.
        bound = np.einsum("ij,ij->i", weight, square)
        farthest = square.argmax(axis=1)
        nearest = np.where(weight > 0.0, square, np.inf).argmin(axis=1)
        rows = np.arange(active.size)
        scale = np.where(bound > 0.0, bound, 1.0)
        excess = square[rows, farthest] / scale - 1.0
        lack = 1.0 - square[rows, nearest] / scale
        going = (bound > 0.0) & (np.maximum(excess, lack) > _SPHERE_TOLERANCE)
        if not going.any():
            break
        forward = excess >= lack
        chosen = np.where(forward, farthest, nearest)
        share = weight[rows, chosen]
        back = np.minimum(
            0.5 * lack / np.maximum(1.0 - lack, 1e-12), share / np.maximum(1.0 - share, 1e-12)
        )
        step = np.where(forward, 0.5 * excess / (1.0 + excess), -back)
        weight *= (1.0 - step)[:, np.newaxis]
        weight[rows, chosen] += step
        weight[rows, chosen] = np.where(weight[rows, chosen] < 1e-12, 0.0, weight[rows, chosen])
        centre = centres[active]
        centre += step[:, np.newaxis] * (near[rows, chosen] - centre)
        weights[active[going]] = weight[going]
        centres[active[going]] = centre[going]
        active = active[going]
    return centres, radii


def _square_distances(points: RealArray, centres: RealArray) -> RealArray:
    """Return the squares of the distances of points, shape (sets, points, dimensions), to the centre of each set."""
    apart = points - centres[:, np.newaxis]
    return np.asarray(np.einsum("ijk,ijk->ij", apart, apart))
