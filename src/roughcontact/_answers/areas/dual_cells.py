"""Dual cells, between the centres of four cells: their corners, kinds, weights, and the patches that own them."""

from __future__ import annotations

from functools import lru_cache

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._answers.areas.cells import split
from roughcontact._base.arrays import Array, IntArray, Mask
from roughcontact._parts.grid import pad_axes
from roughcontact._solve.solution import ContactSolution

# Whether each corner is in contact, shape (4, 16), in the 16 kinds of dual cells: kind k has the bits of k.
CORNERS_INSIDE = (np.arange(16) >> np.arange(4)[:, np.newaxis] & 1).astype(bool)
# Number of corners in contact of each kind, as a floating-point number.
CORNER_COUNTS = CORNERS_INSIDE.sum(axis=0).astype(np.float64)


def find_kinds(contact: Mask) -> npt.NDArray[np.uint8]:
    """Return the kind of each dual cell, shape (n,), of the contact at its corners."""
    bits = contact.view(np.uint8)
    return np.asarray(bits[0] | bits[1] << 1 | bits[2] << 2 | bits[3] << 3)


@attrs.frozen(eq=False)
class DualCells:
    """Dual cells, numbered by their lower left corners.

    Attributes
    ----------
    stride
        Distance of the corners, in cells.
    before
        Number of dual cells before the first cell along x and along y: none along a periodic axis.
    weights
        Fraction of each dual cell that lies in the domain, along x and along y.
    rows, columns
        Row and column of the cells at the lower and the upper corner, shape (2, number along the axis).
    """

    stride: int
    before: tuple[int, int]
    weights: tuple[Array, Array]
    rows: IntArray
    columns: IntArray

    def count_inside(self, contact: Mask) -> npt.NDArray[np.uint8]:
        """Return the number of corners in contact of each dual cell."""
        s = self.stride
        before_x, before_y = self.before
        free = before_x > 0, before_y > 0
        extended = pad_axes(contact.view(np.uint8), ((before_x, s), (before_y, s)), free)
        rows = extended[:-s] + extended[s:]
        return np.asarray(rows[:, :-s] + rows[:, s:])

    def find_edge(self, contact: Mask) -> tuple[IntArray, IntArray]:
        """Return rows and columns of the dual cells that have corners in contact and open corners."""
        return split(np.flatnonzero((self.count_inside(contact) - np.uint8(1)) < 3), self.columns.shape[1])

    def corners(self, i: IntArray, j: IntArray) -> IntArray:
        """Return the flat indices of the cells at the corners of dual cells, in order around them, shape (4, n)."""
        m, n = (self.rows.shape[1], self.columns.shape[1])
        s = self.stride
        before_x, before_y = self.before
        ny = n - before_y
        steps = np.array((0, s * ny, s * ny + s, s))[:, np.newaxis]
        found = (i - before_x) * ny + (j - before_y) + steps
        border = np.flatnonzero((i < before_x) | (j < before_y) | (i >= m - s) | (j >= n - s))
        low, high = self.rows[:, i[border]] * ny
        left, right = self.columns[:, j[border]]
        found[:, border] = low + left, high + left, high + right, low + right
        return np.asarray(found)

    def weigh(self, i: IntArray, j: IntArray) -> Array:
        """Return the weights of dual cells: each of stride^2 choices of cells covers all of the contact."""
        if self.before == (0, 0):
            return np.full(i.size, 1.0 / self.stride**2)
        return np.asarray(self.weights[0][i] * self.weights[1][j] / self.stride**2)

    def cover(self, solution: ContactSolution) -> Array:
        """Return the number of dual cells in each patch, a quarter for each corner, shape (count + 1,)."""
        patches = solution.patches
        if self.before == (0, 0):
            return np.concatenate(([0.0], patches.cells))
        i, j = np.divmod(patches.members, self.columns.shape[1] - self.before[1])
        along, across = (
            0.5 * np.bincount(corners.ravel(), weights=np.tile(weights, 2))
            for corners, weights in zip((self.rows, self.columns), self.weights, strict=True)
        )
        weights = along[i] * across[j]
        cover = np.bincount(patches.member_labels, weights=weights, minlength=patches.count + 1)
        return solution.parts.total(cover.astype(np.float64))


@attrs.frozen(eq=False)
class CellOwners:
    """The patches to which dual cells belong; a dual cell with corners in several patches is divided among them.

    Attributes
    ----------
    cell, patch, fraction
        Dual cells (all, if none is divided), their patches, and the fraction of the dual cell that belongs to the
        patch, shape (m,).
    count
        Number of patches.
    """

    cell: IntArray | slice
    patch: IntArray
    fraction: Array
    count: int

    @classmethod
    def find(cls, label: IntArray, kind: npt.NDArray[np.uint8], count: int) -> CellOwners:
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
            np.concatenate((np.ones(alone.size), 1.0 / CORNER_COUNTS[kind[cell]])),
            count,
        )

    def sum(self, values: Array) -> Array:
        """Return the sum of values of the dual cells over each patch, shape (count + 1,)."""
        weights = values[self.cell] * self.fraction
        return np.bincount(self.patch, weights=weights, minlength=self.count + 1).astype(np.float64)


def find_dual_cells(solution: ContactSolution, stride: int) -> DualCells:
    """Return the dual cells whose corners are `stride` cells apart."""
    return _make_dual_cells(solution.contact.shape, solution.boundary.free_axes, stride)


@lru_cache(maxsize=8)
def _make_dual_cells(shape: tuple[int, int], free: tuple[bool, bool], stride: int) -> DualCells:
    before = tuple(stride if ends else 0 for ends in free)
    weights = []
    corners = []
    for n, more in zip(shape, before, strict=True):
        first = np.arange(-more, n)
        both = np.stack((first, first + stride))
        if more == 0:
            weights.append(np.ones(n))
            corners.append(both % n)
            continue
        # The domain ends half a cell beyond the outermost centres.
        inside = np.minimum(both[1], n - 0.5) - np.maximum(both[0], -0.5)
        weights.append(np.clip(inside, 0.0, stride) / stride)
        corners.append(np.clip(both, 0, n - 1))
    return DualCells(stride, (before[0], before[1]), (weights[0], weights[1]), corners[0], corners[1])
