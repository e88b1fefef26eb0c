"""The area estimator interface and the boundary of a cell mask."""

from __future__ import annotations

import abc
import math
from typing import Any

import numpy as np
import numpy.typing as npt

from roughcontact.checks import IntArray, Mask
from roughcontact.grid import Boundary
from roughcontact.solution import Area, ContactSolution

# Mean overshoot of a counted cell boundary, in cells, over all positions and directions of an edge.
OVERSHOOT = (math.pi - 1.0 + math.log(2.0)) / 24.0


class AreaEstimator(abc.ABC):
    """A rule for the real contact area. Subclass it and say `estimate`."""

    @abc.abstractmethod
    def estimate(self, solution: ContactSolution) -> Area:
        """Return the real contact area with its error bar."""


def framed(field: npt.NDArray[Any], width: int, boundary: Boundary) -> npt.NDArray[Any]:
    """Return a field with a frame: on a closed domain the field goes on there, else its outermost cells do."""
    return np.pad(field, width, mode="edge" if boundary is Boundary.FREE else "wrap")


def boundary_sides(contact: Mask, boundary: Boundary, of: Mask | None = None) -> int:
    """Count the cell sides between contact and open cells.

    On a free boundary the border of the domain itself is not counted; on the others the domain
    closes on itself.

    Parameters
    ----------
    contact
        Cells in contact, shape (nx, ny).
    boundary
        What lies beyond the border.
    of
        Count only the sides of these of the cells in contact, shape (nx, ny); all if left out.
    """
    return sum(int(np.count_nonzero(sides)) for sides in _sides(contact, boundary, of))


def sides_length(solution: ContactSolution) -> float:
    """Return the length of the cell sides between contact and open cells, m; the edge itself is shorter."""
    across, along = _sides(solution.contact, solution.boundary, None)
    dx, dy = solution.grid.spacing
    return float(np.count_nonzero(across) * dy + np.count_nonzero(along) * dx)


def straight_rows(contact: Mask, boundary: Boundary) -> IntArray:
    """Return the lengths, in sides, of the straight rows that make up the edge of the contact."""
    lengths = []
    for axis, sides in enumerate(_sides(contact, boundary, None)):
        along = sides if axis == 0 else np.ascontiguousarray(sides.T)
        if boundary is not Boundary.FREE:
            # A row that goes on across the border is one: its line is turned to begin at a gap.
            seam = np.flatnonzero(along[:, 0] & along[:, -1] & ~along.all(axis=1))
            first = np.argmin(along[seam], axis=1)[:, np.newaxis]
            turned = (np.arange(along.shape[1]) + first) % along.shape[1]
            along[seam] = np.take_along_axis(along[seam], turned, axis=1)
        framed = np.zeros((along.shape[0], along.shape[1] + 2), dtype=np.int8)
        framed[:, 1:-1] = along
        changes = np.diff(framed, axis=1)
        lengths.append(np.nonzero(changes == -1)[1] - np.nonzero(changes == 1)[1])
    return np.concatenate(lengths)


def _sides(contact: Mask, boundary: Boundary, of: Mask | None) -> tuple[Mask, Mask]:
    """Mark the sides between each cell and the next along x, then along y."""
    found = []
    for axis in (0, 1):
        following = np.roll(contact, -1, axis=axis)
        sides = contact != following
        if of is not None:
            sides &= of | np.roll(of, -1, axis=axis)
        if boundary is Boundary.FREE:
            sides[(-1,) if axis == 0 else (slice(None), -1)] = False
        found.append(sides)
    return found[0], found[1]
