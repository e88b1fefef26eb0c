"""Polygons in dual cells: where the edge crosses their sides, the area inside, the length and the Euler number.

The corners of a dual cell are numbered around it from its lower left one; side k leads from corner k
to the next. Arrays over corners or sides have shape (4, n).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from roughcontact._base.checks import Array, Mask

Corners: TypeAlias = npt.NDArray[np.float64]

# Whether each corner is in contact, shape (4, 16), in the 16 kinds of dual cells: kind k has the bits of k.
_KINDS = (np.arange(16) >> np.arange(4)[:, np.newaxis] & 1).astype(bool)
# Number of corners in contact of each kind, as a floating-point number.
INSIDE = _KINDS.sum(axis=0).astype(np.float64)
_TWO = INSIDE == 2
_THREE = INSIDE == 3
_DIAGONAL = (_KINDS[0] == _KINDS[2]) & (_KINDS[1] == _KINDS[3]) & _TWO
# The corner to begin at: the one that is unlike the others, or the first of two in contact.
_ODD = np.where(_THREE, ~_KINDS, _KINDS)
_BEGIN = np.where(_ODD[0] & _ODD[3] & _TWO, 3, np.argmax(_ODD, axis=0))
_EULER = np.select([INSIDE == 1, _THREE, _DIAGONAL], [0.25, -0.25, -0.5], 0.0)


def find_kinds(contact: Mask) -> npt.NDArray[np.uint8]:
    """Return the kind of each dual cell, shape (n,), of the contact at its corners."""
    bits = contact.view(np.uint8)
    return np.asarray(bits[0] | bits[1] << 1 | bits[2] << 2 | bits[3] << 3)


def find_crossings(distance: Corners) -> Corners:
    """Return where the edge crosses each side, as a fraction of the side from its first corner."""
    away = np.abs(distance)
    return _divide(away, away[[1, 2, 3, 0]])


def measure_polygons(
    distance: Corners, contact: Mask, kind: npt.NDArray[np.uint8], size: tuple[float, float]
) -> tuple[Array, Array, Array]:
    """Return the area inside (m2), the length (m) and the Euler number of the edge in each dual cell."""
    away = np.abs(distance).ravel()
    columns = np.arange(kind.size)
    n = kind.size
    kind = kind.astype(np.intp)
    # Distances at the corner to begin at, the one before it and both behind it.
    before, here, after, last = (away.take((_BEGIN + step & 3).take(kind) * n + columns) for step in (-1, 0, 1, 2))
    rest = _divide(here, before)
    middle = _divide(here, after)
    end = _divide(after, last)
    even = _BEGIN % 2 == 0
    along, across = (np.where(even, *sides).take(kind) for sides in (size, size[::-1]))
    pair = _TWO.take(kind)
    triangle = 0.5 * rest * middle
    chord = np.hypot(np.where(pair, 1.0, middle) * along, np.where(pair, end - rest, rest) * across)
    area = np.where(pair, 0.5 * (rest + end), np.where(_THREE.take(kind), 1.0 - triangle, triangle))
    area *= size[0] * size[1]
    diagonal = np.flatnonzero(_DIAGONAL.take(kind))
    if diagonal.size:
        saddles = distance[:, diagonal]
        area[diagonal], chord[diagonal] = _measure_saddles(saddles, contact[:, diagonal], find_crossings(saddles), size)
    return area, chord, _EULER.take(kind)


def _divide(one: Array, other: Array) -> Array:
    """Return the part of a side from one corner to the edge, of the distances of both of its corners from the edge."""
    with np.errstate(invalid="ignore"):
        part = one / (one + other)
    np.copyto(part, 0.5, where=np.isnan(part))
    return np.asarray(part)


def _measure_saddles(
    distance: Corners, contact: Mask, crossing: Corners, size: tuple[float, float]
) -> tuple[Array, Array]:
    """Return area and length where opposite corners are inside: connected if the sum of distances is positive."""
    connected = distance.sum(axis=0) > 0.0
    area = np.zeros(distance.shape[1])
    chord = np.zeros(distance.shape[1])
    for corner in range(4):
        # A corner inside keeps its own triangle; where they are connected, each corner outside loses its own.
        one = 1.0 - crossing[corner - 1]
        other = crossing[corner]
        triangle = contact[corner] != connected
        area += np.where(triangle, 0.5 * one * other, 0.0)
        before, after = (size[1], size[0]) if corner % 2 == 0 else (size[0], size[1])
        chord += np.where(triangle, np.hypot(one * before, other * after), 0.0)
    area = np.where(connected, 1.0 - area, area) * (size[0] * size[1])
    return area, chord
