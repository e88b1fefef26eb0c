"""Contact patches: connected cells in contact."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np

from roughcontact.checks import Array, IntArray, Mask, read_only
from roughcontact.errors import InputError
from roughcontact.grid import Boundary, Grid

# Cells below which a patch has no point that is surrounded by contact, so that its area is hardly known.
_SMALL_PATCH = 4


@attrs.frozen(eq=False)
class ContactPatches:
    """Patches of the contact: cells that share a side or a corner, also across a periodic or wrapped border.

    Attributes
    ----------
    grid, boundary
        The grid, and what lies beyond its border.
    pressure
        Contact pressure, shape `grid.shape`, Pa.
    labels
        Number of each cell's patch, from 1, and zero for open cells, shape `grid.shape`.
    count
        Number of patches.
    """

    grid: Grid
    boundary: Boundary
    pressure: Array = attrs.field(converter=read_only)
    labels: IntArray = attrs.field(converter=read_only)
    count: int

    @cached_property
    def cells(self) -> IntArray:
        """Number of cells of each patch, shape (count,)."""
        return read_only(np.bincount(self.labels.ravel()[self._members], minlength=self.count + 1)[1:])

    @cached_property
    def _members(self) -> IntArray:
        """Flat indices of the cells in contact."""
        return np.flatnonzero(self.labels)

    @property
    def areas(self) -> Array:
        """Counted area of each patch, shape (count,), m2: mostly too large, see `CellCount`."""
        return np.asarray(self.cells * self.grid.cell_area, dtype=np.float64)

    @cached_property
    def forces(self) -> Array:
        """Normal force on each patch, shape (count,), N."""
        return read_only(self.sum(self.pressure) * self.grid.cell_area)

    def sum(self, field: Array) -> Array:
        """Return the sum of a field of shape `grid.shape` over each patch, shape (count,)."""
        if np.shape(field) != self.labels.shape or not np.isfinite(field).all():
            raise InputError.about("The field", field, f"an array of finite numbers of shape {self.labels.shape}")
        label, values = self.labels.ravel()[self._members], field.ravel()[self._members]
        return np.bincount(label, weights=values, minlength=self.count + 1)[1:].astype(np.float64)

    @cached_property
    def perimeters(self) -> Array:
        """Length of the cell sides between each patch and open cells, shape (count,), m."""
        lengths = np.zeros(self.count + 1)
        for axis, side in ((0, self.grid.spacing[1]), (1, self.grid.spacing[0])):
            for step in (-1, 1):
                beyond = np.roll(self.labels, step, axis=axis)
                open_ = (self.labels > 0) & (beyond == 0)
                if self.boundary is Boundary.FREE:
                    np.moveaxis(open_, axis, 0)[0 if step == 1 else -1] = False
                lengths += side * np.bincount(self.labels[open_], minlength=self.count + 1)
        return read_only(lengths[1:])

    @property
    def mean_pressures(self) -> Array:
        """Force over counted area of each patch, shape (count,), Pa."""
        return np.asarray(self.forces / self.areas)

    @property
    def small_fraction(self) -> float:
        """Fraction of the counted area in patches of fewer than four cells."""
        total = int(self.cells.sum())
        return float(self.cells[self.cells < _SMALL_PATCH].sum() / total) if total else 0.0

    def __str__(self) -> str:
        if self.count == 0:
            return "no patches"
        return (
            f"{self.count} patches of {self.cells.mean():.3g} cells on average, {int(self.cells.max())} at most; "
            f"the largest carries {100 * self.forces.max() / self.forces.sum():.3g} % of the load; "
            f"{100 * self.small_fraction:.3g} % of the counted area is in patches of fewer than {_SMALL_PATCH} cells"
        )


def find_patches(contact: Mask, pressure: Array, grid: Grid, boundary: Boundary) -> ContactPatches:
    """Return the patches of the cells in contact."""
    from scipy import ndimage

    numbers, count = ndimage.label(contact, structure=np.ones((3, 3)))
    labels = numbers.astype(np.intp, copy=False)
    if boundary is not Boundary.FREE and count > 1:
        labels, count = _join_across_border(labels, count)
    return ContactPatches(grid, boundary, pressure, labels, count)


def _join_across_border(labels: IntArray, count: int) -> tuple[IntArray, int]:
    """Return the labels with one number for patches that touch across the border, and the number of patches."""
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
    return np.concatenate(([0], numbers + 1)).astype(labels.dtype)[labels], int(joined)
