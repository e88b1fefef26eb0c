"""Dual cells, whose corners are the centres of four cells, and the patches that they belong to."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._answers.areas.cells import split
from roughcontact._answers.areas.polygons import INSIDE
from roughcontact._base.checks import Array, IntArray, Mask
from roughcontact._parts.grid import Boundary
from roughcontact._solve.solution import ContactSolution


@attrs.frozen(eq=False)
class DualCells:
    """Dual cells, numbered by their lower left corners.

    Attributes
    ----------
    stride
        Distance of the corners, in cells.
    before
        Number of dual cells before the first cell along each axis.
    weights
        Fraction of each dual cell that lies in the domain, along x and along y.
    rows, columns
        Row and column of the cells at the lower and the upper corner, shape (2, number along the axis).
    """

    stride: int
    before: int
    weights: tuple[Array, Array]
    rows: IntArray
    columns: IntArray

    def count_inside(self, contact: Mask) -> npt.NDArray[np.uint8]:
        """Return the number of corners in contact of each dual cell."""
        s = self.stride
        extended = np.pad(contact.view(np.uint8), (self.before, s), mode="edge" if self.before else "wrap")
        rows = extended[:-s] + extended[s:]
        return np.asarray(rows[:, :-s] + rows[:, s:])

    def find_edge(self, contact: Mask) -> tuple[IntArray, IntArray]:
        """Return the row and the column of the dual cells with corners in contact and others."""
        return split(np.flatnonzero((self.count_inside(contact) - np.uint8(1)) < 3), self.columns.shape[1])

    def corners(self, i: IntArray, j: IntArray) -> IntArray:
        """Return the flat indices of the cells at the corners of dual cells, in order around them, shape (4, n)."""
        m, n = (self.rows.shape[1], self.columns.shape[1])
        s = self.stride
        ny = n - self.before
        steps = np.array((0, s * ny, s * ny + s, s))[:, np.newaxis]
        found = (i - self.before) * ny + (j - self.before) + steps
        border = np.flatnonzero((i < self.before) | (j < self.before) | (i >= m - s) | (j >= n - s))
        low, high = self.rows[:, i[border]] * ny
        left, right = self.columns[:, j[border]]
        found[:, border] = low + left, high + left, high + right, low + right
        return np.asarray(found)

    def cover(self, solution: ContactSolution) -> Array:
        """Return the number of dual cells whose corners are in each patch, by quarters, shape (count + 1,)."""
        patches = solution.patches
        if self.before == 0:
            return np.concatenate(([0.0], patches.cells))
        i, j = np.divmod(patches.members, self.columns.shape[1] - self.before)
        along, across = (
            0.5 * np.bincount(corners.ravel(), weights=np.tile(weights, 2))
            for corners, weights in zip((self.rows, self.columns), self.weights, strict=True)
        )
        weights = along[i] * across[j]
        return np.bincount(patches.member_labels, weights=weights, minlength=patches.count + 1).astype(np.float64)


@attrs.frozen(eq=False)
class Owners:
    """The patches that dual cells belong to; one whose corners lie in several is divided by its corners in contact.

    Attributes
    ----------
    cell, patch, fraction
        Dual cells (all, if none is divided), patches and how much of the one belongs to the other, shape (m,).
    count
        Number of patches.
    """

    cell: IntArray | slice
    patch: IntArray
    fraction: Array
    count: int

    @classmethod
    def find(cls, label: IntArray, kind: npt.NDArray[np.uint8], count: int) -> Owners:
        """Return the owners of dual cells from the labels at their corners, shape (4, n)."""
        highest = label.max(axis=0)
        divided = ((label != highest) & (label > 0)).any(axis=0)
        if not divided.any():
            return cls(slice(None), highest, np.ones(1), count)
        alone = np.flatnonzero(~divided)
        several = np.flatnonzero(divided)
        which, corner = np.nonzero(label[:, several].T)
        cell = several[which]
        patch = label[corner, several[which]]
        return cls(
            np.concatenate((alone, cell)),
            np.concatenate((highest[alone], patch)),
            np.concatenate((np.ones(alone.size), 1.0 / INSIDE[kind[cell]])),
            count,
        )

    def sum(self, values: Array) -> Array:
        """Return the sum of values of the dual cells over each patch, shape (count + 1,)."""
        weights = values[self.cell] * self.fraction
        return np.bincount(self.patch, weights=weights, minlength=self.count + 1).astype(np.float64)


def find_dual_cells(solution: ContactSolution, stride: int) -> DualCells:
    """Return the dual cells whose corners are `stride` cells apart."""
    before = stride if solution.boundary is Boundary.FREE else 0
    weights = []
    corners = []
    for n in solution.grid.shape:
        first = np.arange(-before, n)
        both = np.stack((first, first + stride))
        if before == 0:
            weights.append(np.ones(n))
            corners.append(both % n)
            continue
        # The domain ends half a cell beyond the outermost centres.
        inside = np.minimum(both[1], n - 0.5) - np.maximum(both[0], -0.5)
        weights.append(np.clip(inside, 0.0, stride) / stride)
        corners.append(np.clip(both, 0, n - 1))
    return DualCells(stride, before, (weights[0], weights[1]), corners[0], corners[1])
