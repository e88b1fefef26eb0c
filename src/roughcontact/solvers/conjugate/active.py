"""The cells whose pressure may change, and vectors on them."""

from __future__ import annotations

from functools import cached_property
from typing import Protocol, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact.checks import Mask, RealArray

Cells: TypeAlias = npt.NDArray[np.intp]

# From this share of active cells on, whole fields with zeros are faster than lists of cells.
_DENSE = 0.4


class Active(Protocol):
    """A set of active cells; its vectors hold a value for each of them, and perhaps zeros for others."""

    @property
    def mask(self) -> Mask:
        """All cells, flat."""

    @property
    def count(self) -> int:
        """Number of active cells."""

    @property
    def ones(self) -> RealArray:
        """The vector of ones, float32."""

    def take(self, field: RealArray) -> RealArray:
        """Return the vector of a flat field."""

    def put(self, vector: RealArray) -> RealArray:
        """Return the flat field that is `vector` on the active cells and zero elsewhere."""

    def store(self, field: RealArray, vector: RealArray) -> None:
        """Set the active cells of a flat field."""

    def blocks(self, vector: RealArray, partition: Partition) -> RealArray:
        """Return the sums over the blocks of a partition."""

    def unblocked(self, sums: RealArray, partition: Partition) -> RealArray:
        """Return the vector that is constant on blocks."""


@attrs.frozen(eq=False)
class Partition:
    """A division of the grid into rectangular blocks of nearly equal size.

    Attributes
    ----------
    shape, blocks
        Cells (nx, ny) and blocks (bx, by).
    rows, columns
        Block of each row and of each column of cells.
    """

    shape: tuple[int, int]
    blocks: tuple[int, int]
    rows: npt.NDArray[np.int32]
    columns: npt.NDArray[np.int32]


@attrs.frozen(eq=False)
class Sparse:
    """Few active cells: vectors list them."""

    mask: Mask
    cells: Cells

    @property
    def count(self) -> int:
        """Number of active cells."""
        return self.cells.size

    @cached_property
    def ones(self) -> RealArray:
        """The vector of ones."""
        return np.ones(self.cells.size, dtype=np.float32)

    def take(self, field: RealArray) -> RealArray:
        """See `Active.take`."""
        return field[self.cells]

    def put(self, vector: RealArray) -> RealArray:
        """See `Active.put`."""
        field = np.zeros(self.mask.size, dtype=vector.dtype)
        field[self.cells] = vector
        return field

    def store(self, field: RealArray, vector: RealArray) -> None:
        """See `Active.store`."""
        field[self.cells] = vector

    def blocks(self, vector: RealArray, partition: Partition) -> RealArray:
        """See `Active.blocks`."""
        bx, by = partition.blocks
        return np.bincount(self._numbers(partition), weights=vector, minlength=bx * by).reshape(bx, by)

    def unblocked(self, sums: RealArray, partition: Partition) -> RealArray:
        """See `Active.unblocked`."""
        return sums.ravel()[self._numbers(partition)]

    def _numbers(self, partition: Partition) -> Cells:
        i, j = np.divmod(self.cells, partition.shape[1])
        return np.asarray(partition.rows[i] * partition.blocks[1] + partition.columns[j])


@attrs.frozen(eq=False)
class Dense:
    """Many active cells: vectors are whole fields, zero on all others."""

    mask: Mask
    count: int

    @cached_property
    def ones(self) -> RealArray:
        """The vector of ones: the mask itself."""
        return self.mask.astype(np.float32)

    def take(self, field: RealArray) -> RealArray:
        """See `Active.take`."""
        factor = self.ones if field.dtype == np.float32 else self.mask
        return np.multiply(field, factor, dtype=field.dtype)

    def put(self, vector: RealArray) -> RealArray:
        """See `Active.put`."""
        return vector

    def store(self, field: RealArray, vector: RealArray) -> None:
        """See `Active.store`."""
        np.copyto(field, vector, where=self.mask)

    def blocks(self, vector: RealArray, partition: Partition) -> RealArray:
        """See `Active.blocks`."""
        sums = np.zeros(partition.blocks, dtype=vector.dtype)
        rows, columns = (np.flatnonzero(np.diff(part, prepend=-1)) for part in (partition.rows, partition.columns))
        # Sums along the first axis run over whole rows at a time; the second axis is turned into it.
        strips = np.add.reduceat(vector.reshape(partition.shape), rows, axis=0)
        found = np.add.reduceat(np.ascontiguousarray(strips.T), columns, axis=0).T
        # A padded domain has blocks beyond the last cell, which stay empty.
        sums[: rows.size, : columns.size] = found
        return sums

    def unblocked(self, sums: RealArray, partition: Partition) -> RealArray:
        """See `Active.unblocked`."""
        return self.take(np.take(sums[partition.rows], partition.columns, axis=1).ravel())


def total(vector: RealArray) -> float:
    """Return the sum of a vector, in float64."""
    return float(np.add.reduce(vector, dtype=np.float64))


def dot(one: RealArray, other: RealArray) -> float:
    """Return the product of two vectors, without the threads of a BLAS."""
    return float(np.einsum("i,i->", one, other))


def active_set(mask: Mask) -> Active:
    """Return the set of the marked cells, flat, in the form that is faster."""
    count = int(np.count_nonzero(mask))
    return Dense(mask, count) if count > _DENSE * mask.size else Sparse(mask, np.flatnonzero(mask))
