"""Clusters: cells in contact that hang together."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np

from roughcontact.checks import Array, IntArray, Mask
from roughcontact.grid import Boundary, Grid

# Clusters of fewer cells say little about their own area.
FEW_CELLS = 4


@attrs.frozen(eq=False)
class Clusters:
    """The contact, told apart into cells that share a side or a corner.

    On a periodic or wrapped boundary clusters go on across the border.

    Attributes
    ----------
    grid, boundary
        Where the contact lives, and what lies beyond.
    pressure
        Contact pressure, shape `grid.shape`, Pa.
    labels
        Number of each cell's cluster from 1 on, zero for open cells, shape `grid.shape`.
    count
        Number of clusters.
    """

    grid: Grid
    boundary: Boundary
    pressure: Array
    labels: IntArray
    count: int

    @cached_property
    def cells(self) -> IntArray:
        """Cells of each cluster, shape (count,)."""
        return np.bincount(self.labels.ravel()[self._members], minlength=self.count + 1)[1:]

    @cached_property
    def _members(self) -> IntArray:
        """Flat indices of the cells in contact."""
        return np.flatnonzero(self.labels)

    @property
    def areas(self) -> Array:
        """Counted area of each cluster, shape (count,), m2: too much, as every count."""
        return np.asarray(self.cells * self.grid.cell_area, dtype=np.float64)

    @cached_property
    def forces(self) -> Array:
        """Normal force on each cluster, shape (count,), N."""
        return self.sums(self.pressure) * self.grid.cell_area

    def sums(self, field: Array) -> Array:
        """Return the sum of a field of shape `grid.shape` over each cluster, shape (count,)."""
        cells = self._members
        label, values = self.labels.ravel()[cells], field.ravel()[cells]
        return np.bincount(label, weights=values, minlength=self.count + 1)[1:].astype(np.float64)

    @cached_property
    def perimeters(self) -> Array:
        """Length of the cell sides between each cluster and open cells, shape (count,), m."""
        lengths = np.zeros(self.count + 1)
        for axis, side in ((0, self.grid.spacing[1]), (1, self.grid.spacing[0])):
            for step in (-1, 1):
                beyond = np.roll(self.labels, step, axis=axis)
                open_ = (self.labels > 0) & (beyond == 0)
                if self.boundary is Boundary.FREE:
                    np.moveaxis(open_, axis, 0)[0 if step == 1 else -1] = False
                lengths += side * np.bincount(self.labels[open_], minlength=self.count + 1)
        return np.asarray(lengths[1:])

    @property
    def mean_pressures(self) -> Array:
        """Force over counted area of each cluster, shape (count,), Pa."""
        return np.asarray(self.forces / self.areas)

    @property
    def small_share(self) -> float:
        """Share of the counted area in clusters of fewer than four cells."""
        total = int(self.cells.sum())
        return float(self.cells[self.cells < FEW_CELLS].sum() / total) if total else 0.0

    def __str__(self) -> str:
        if self.count == 0:
            return "no clusters"
        return (
            f"{self.count} clusters of {self.cells.mean():.3g} cells on average, {int(self.cells.max())} at most; "
            f"the largest bears {100 * self.forces.max() / self.forces.sum():.3g} % of the load; "
            f"{100 * self.small_share:.3g} % of the counted area lies in clusters below {FEW_CELLS} cells"
        )


def clusters_of(contact: Mask, pressure: Array, grid: Grid, boundary: Boundary) -> Clusters:
    """Return the clusters of the cells in contact, shape `grid.shape`."""
    from scipy import ndimage

    numbers, count = ndimage.label(contact, structure=np.ones((3, 3)))
    labels = numbers.astype(np.intp, copy=False)
    if boundary is not Boundary.FREE and count > 1:
        labels, count = _joined(labels, count)
    return Clusters(grid, boundary, pressure, labels, count)


def _joined(labels: IntArray, count: int) -> tuple[IntArray, int]:
    """Give clusters that touch across the border one number."""
    from scipy import sparse

    pairs = []
    for edge in (labels, labels.T):
        for step in (-1, 0, 1):
            last, first = edge[-1], np.roll(edge[0], step)
            both = (last > 0) & (first > 0)
            pairs.append(np.stack((last[both], first[both])))
    one, other = np.concatenate(pairs, axis=1) - 1
    links = sparse.coo_matrix((np.ones(one.size), (one, other)), shape=(count, count))
    joined, numbers = sparse.csgraph.connected_components(links, directed=False)
    table = np.concatenate(([0], numbers + 1)).astype(labels.dtype)
    return table[labels], int(joined)
