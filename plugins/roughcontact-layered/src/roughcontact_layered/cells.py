"""Uniform pressure on a cell: displacement by that around a point force."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol, TypeAlias

import numpy as np
from numpy.polynomial import legendre

from roughcontact_layered.stack import Array

WaveFunction: TypeAlias = Callable[[Array, Array], Array]

# Cells up to this offset, in shorter sides, are integrated from four corners; beyond it, and beyond the second
# offset, by Gauss points: the errors stay below 1e-11 (tests/test_cells.py).
_NEAR = 10
_FAR = 60
# Gauss points along a corner's angle, and across one shorter side between both offsets and beyond.
_CORNER = 40
_BETWEEN = 5
_BEYOND = 3


class PointForce(Protocol):
    """The displacement around a point force, even in x and in y."""

    def displacement(self, x: Array, y: Array) -> Array:
        """Return the displacement by a unit force at the offsets `x`, `y`, m/N."""

    def along_ray(self, x: Array, y: Array) -> Array:
        """Return the integral over 0 < t < 1 of t times the displacement at the offsets t `x`, t `y`, m/N."""


def cell_integrals(table: PointForce, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Return the displacement at the centre of the cell (0, 0) by unit pressure on the cell (i, j), m/Pa.

    Parameters
    ----------
    table
        Displacement by a unit force.
    shape
        Number of offsets (nx, ny).
    spacing
        Sides of a cell (dx, dy), m.
    """
    shorter = min(spacing)
    near, far = (
        tuple(min(n, max(math.ceil(count * shorter / side), 1) + 1) for n, side in zip(shape, spacing, strict=True))
        for count in (_NEAR, _FAR)
    )
    result = np.empty(shape)
    integrate_gauss(result, table.displacement, spacing, (slice(far[0], None), slice(None)), _BEYOND)
    integrate_gauss(result, table.displacement, spacing, (slice(0, far[0]), slice(far[1], None)), _BEYOND)
    integrate_gauss(result, table.displacement, spacing, (slice(near[0], far[0]), slice(0, far[1])), _BETWEEN)
    integrate_gauss(result, table.displacement, spacing, (slice(0, near[0]), slice(near[1], far[1])), _BETWEEN)
    result[: near[0], : near[1]] = _integrate_corners(table, (near[0], near[1]), spacing)
    return result


def integrate_gauss(
    result: Array, field: WaveFunction, spacing: tuple[float, float], block: tuple[slice, slice], points: int
) -> None:
    """Integrate a field around a point over the cells of a block, into the last two axes of a result.

    Parameters
    ----------
    result
        Integrals over the cell at each offset, shape (..., nx, ny).
    field
        The field at offsets along x and along y, m, of shapes that broadcast; what it adds stands in front.
    spacing
        Sides of a cell (dx, dy), m.
    block
        Offsets along x and along y.
    points
        Gauss points across one shorter side.
    """
    axes = [np.arange(n)[part] * side for n, part, side in zip(result.shape[-2:], block, spacing, strict=True)]
    if not (axes[0].size and axes[1].size):
        return
    total = np.zeros((*result.shape[:-2], axes[0].size, axes[1].size))
    (ax, wx), (ay, wy) = (_gauss_points(side / min(spacing), points) for side in spacing)
    for a, p in zip(ax * spacing[0], wx * spacing[0], strict=True):
        for b, w in zip(ay * spacing[1], wy * spacing[1], strict=True):
            total += p * w * field((axes[0] + a)[:, np.newaxis], (axes[1] + b)[np.newaxis, :])
    result[..., block[0], block[1]] = total


def _gauss_points(sides: float, points: int) -> tuple[Array, Array]:
    """Return Gauss points and weights on -1/2 .. 1/2: so many points on each part of one shorter side."""
    parts = math.ceil(sides - 1e-9)
    at, weight = legendre.leggauss(points)
    places = (np.arange(parts)[:, np.newaxis] + 0.5 * (at + 1.0)) / parts - 0.5
    return places.ravel(), np.tile(0.5 * weight / parts, parts)


def _integrate_corners(table: PointForce, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Take differences of integrals over rectangles with a corner at the origin, odd in either side."""
    x, y = ((np.arange(n + 1) - 0.5) * side for n, side in zip(shape, spacing, strict=True))
    sign = np.sign(x)[:, np.newaxis] * np.sign(y)[np.newaxis, :]
    x, y = (np.abs(side)[index] for side, index in ((x, (slice(None), None)), (y, (None, slice(None)))))
    corners = sign * (_triangle(table.along_ray, x, y) + _triangle(lambda a, b: table.along_ray(b, a), y, x))
    return np.asarray(np.diff(np.diff(corners, axis=0), axis=1))


def _triangle(along_ray: WaveFunction, base: Array, height: Array) -> Array:
    """Integrate over the triangle (0, 0), (base, 0), (base, height), by angle: (base, base sinh(s)) is its far side."""
    at, weight = legendre.leggauss(_CORNER)
    base, height = np.broadcast_arrays(base, height)
    maximum = np.arcsinh(height / base)[..., np.newaxis]
    s = 0.5 * maximum * (at + 1.0)
    far = base[..., np.newaxis]
    inside = along_ray(far, far * np.sinh(s)) * np.cosh(s)
    return np.asarray(0.5 * maximum[..., 0] * base**2 * (inside @ weight))
