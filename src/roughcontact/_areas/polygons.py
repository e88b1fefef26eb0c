"""Polygons in dual cells: where the edge crosses their sides, the area inside, the length and the Euler number.

The corners of a dual cell are numbered around it from its lower left one; side k leads from corner k
to the next. Arrays over corners or sides have shape (4, n).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from roughcontact.checks import Array, IntArray, Mask

Corners: TypeAlias = npt.NDArray[np.float64]


def find_crossings(distance: Corners) -> Corners:
    """Return where the edge crosses each side, as a fraction of the side from its first corner."""
    following = np.roll(distance, -1, axis=0)
    with np.errstate(invalid="ignore"):
        crossing = np.abs(distance) / (np.abs(distance) + np.abs(following))
    np.copyto(crossing, 0.5, where=np.isnan(crossing))
    return np.asarray(crossing)


def find_segments(crossing: Corners, contact: Mask) -> tuple[IntArray, Array]:
    """Return the straight pieces of the edge: their dual cells, shape (n,), and ends within, shape (n, 2, 2)."""
    corner = np.array(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
    points = corner[:, np.newaxis] + crossing[..., np.newaxis] * (np.roll(corner, -1, axis=0) - corner)[:, np.newaxis]
    crossed = contact != np.roll(contact, -1, axis=0)
    # Where all four sides are crossed each corner of one kind is cut off.
    cells, sides = np.nonzero(crossed.T)
    return cells[::2], points[sides, cells].reshape(-1, 2, 2)


def measure_polygons(
    distance: Corners, contact: Mask, inside: npt.NDArray[np.uint8], size: tuple[float, float]
) -> tuple[Array, Array, Array]:
    """Return the area inside (m2), the length (m) and the Euler number of the edge in each dual cell."""
    crossing = find_crossings(distance)
    diagonal = (contact[0] == contact[2]) & (contact[1] == contact[3])
    # Begin at the odd corner, or at the first of two that are inside.
    odd = np.where(inside == 3, ~contact, contact)
    first = np.where(odd[0] & odd[3] & (inside == 2), 3, np.argmax(odd, axis=0))
    columns = np.arange(first.size)
    before, here, after = (crossing[(first + step) % 4, columns] for step in (-1, 0, 1))
    along = np.where(first % 2 == 0, size[0], size[1])
    across = size[0] * size[1] / along
    triangle = 0.5 * (1.0 - before) * here
    area = np.select([inside == 1, inside == 3], [triangle, 1.0 - triangle], 0.5 * (1.0 - before + after))
    pair = inside == 2
    chord = np.hypot(
        np.where(pair, along, here * along), np.where(pair, (after + before - 1.0) * across, (1.0 - before) * across)
    )
    area *= size[0] * size[1]
    euler = np.select([inside == 1, inside == 3, diagonal], [0.25, -0.25, -0.5], 0.0)
    if diagonal.any():
        parts = (distance[:, diagonal], contact[:, diagonal], crossing[:, diagonal])
        area[diagonal], chord[diagonal] = _measure_saddles(*parts, size)
    return area, chord, euler


def _measure_saddles(
    distance: Corners, contact: Mask, crossing: Corners, size: tuple[float, float]
) -> tuple[Array, Array]:
    """Return area and length where opposite corners are inside: connected if the sum of distances is positive."""
    connected = distance.sum(axis=0) > 0.0
    area, chord = np.zeros(distance.shape[1]), np.zeros(distance.shape[1])
    for corner in range(4):
        # A corner inside keeps its own triangle; where they are connected, each corner outside loses its own.
        one, other = 1.0 - crossing[corner - 1], crossing[corner]
        triangle = contact[corner] != connected
        area += np.where(triangle, 0.5 * one * other, 0.0)
        before, after = (size[1], size[0]) if corner % 2 == 0 else (size[0], size[1])
        chord += np.where(triangle, np.hypot(one * before, other * after), 0.0)
    area = np.where(connected, 1.0 - area, area) * (size[0] * size[1])
    return area, chord
