"""The displacement by uniform pressure on a cell, for a radial function of the distance."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import legendre

from roughcontact_layered.radial import Radial
from roughcontact_layered.stack import Array

# Cells up to this offset, in shorter sides, are summed from four corners; Gauss points across one shorter
# side of those beyond, and beyond the second distance.
_NEAR, _FAR = 10, 60
_CORNER, _BETWEEN, _BEYOND = 40, 5, 3


def cell_integrals(table: Radial, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Integrate the displacement over cells.

    Parameters
    ----------
    table
        Displacement by a unit force.
    shape
        Number of offsets (nx, ny).
    spacing
        Sides of a cell (dx, dy), m.

    Returns
    -------
    Array
        The displacement at the centre of the cell (0, 0) by unit pressure on the cell (i, j),
        shape `shape`, m/Pa.
    """
    shorter = min(spacing)
    near, far = (
        tuple(min(n, max(math.ceil(count * shorter / side), 1) + 1) for n, side in zip(shape, spacing, strict=True))
        for count in (_NEAR, _FAR)
    )
    result = np.empty(shape)
    _by_gauss(result, table, spacing, (slice(far[0], None), slice(None)), _BEYOND)
    _by_gauss(result, table, spacing, (slice(0, far[0]), slice(far[1], None)), _BEYOND)
    _by_gauss(result, table, spacing, (slice(near[0], far[0]), slice(0, far[1])), _BETWEEN)
    _by_gauss(result, table, spacing, (slice(0, near[0]), slice(near[1], far[1])), _BETWEEN)
    result[: near[0], : near[1]] = _by_corners(table, (near[0], near[1]), spacing)
    return result


def _by_gauss(
    result: Array, table: Radial, spacing: tuple[float, float], block: tuple[slice, slice], points: int
) -> None:
    axes = [np.arange(n)[part] * side for n, part, side in zip(result.shape, block, spacing, strict=True)]
    if not (axes[0].size and axes[1].size):
        return
    total = np.zeros((axes[0].size, axes[1].size))
    (ax, wx), (ay, wy) = (_across(side / min(spacing), points) for side in spacing)
    for a, p in zip(ax * spacing[0], wx * spacing[0], strict=True):
        for b, w in zip(ay * spacing[1], wy * spacing[1], strict=True):
            r = np.hypot((axes[0] + a)[:, np.newaxis], (axes[1] + b)[np.newaxis, :])
            total += p * w * table.displacement(r)
    result[block] = total


def _across(sides: float, points: int) -> tuple[Array, Array]:
    """Return Gauss points and weights on -1/2 .. 1/2, as many on each part that is one shorter side long."""
    parts = math.ceil(sides - 1e-9)
    at, weight = legendre.leggauss(points)
    places = (np.arange(parts)[:, np.newaxis] + 0.5 * (at + 1.0)) / parts - 0.5
    return places.ravel(), np.tile(0.5 * weight / parts, parts)


def _by_corners(table: Radial, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Take differences of integrals over rectangles with a corner at the origin, odd in either side."""
    x, y = ((np.arange(n + 1) - 0.5) * side for n, side in zip(shape, spacing, strict=True))
    sign = np.sign(x)[:, np.newaxis] * np.sign(y)[np.newaxis, :]
    x, y = (np.abs(side)[index] for side, index in ((x, (slice(None), None)), (y, (None, slice(None)))))
    corners = sign * (_triangle(table, x, y) + _triangle(table, y, x))
    return np.asarray(np.diff(np.diff(corners, axis=0), axis=1))


def _triangle(table: Radial, base: Array, height: Array) -> Array:
    """Integrate over the triangle (0, 0), (base, 0), (base, height), by angle: base cosh(s) is its far side."""
    at, weight = legendre.leggauss(_CORNER)
    base, height = np.broadcast_arrays(base, height)
    greatest = np.arcsinh(height / base)[..., np.newaxis]
    cosh = np.cosh(0.5 * greatest * (at + 1.0))
    inside = table.within(base[..., np.newaxis] * cosh) / cosh
    return np.asarray(0.5 * greatest[..., 0] * (inside @ weight))
