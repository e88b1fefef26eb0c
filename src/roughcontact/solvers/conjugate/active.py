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

    def places(self, mask: Mask) -> Cells:
        """Return the places in a vector of the marked cells, all of them active."""

    def blocks(self, partition: Partition) -> Blocks:
        """Return the active cells, told apart by the blocks of a partition."""


class Blocks(Protocol):
    """The active cells of each block of a partition."""

    def sums(self, vector: RealArray) -> RealArray:
        """Return the sum over each block."""

    def spread(self, sums: RealArray) -> RealArray:
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
        # The cells are within the field, and of all ways to say so this one is the fastest.
        return field.take(self.cells, mode="wrap")

    def put(self, vector: RealArray) -> RealArray:
        """See `Active.put`."""
        field = np.zeros(self.mask.size, dtype=vector.dtype)
        field[self.cells] = vector
        return field

    def store(self, field: RealArray, vector: RealArray) -> None:
        """See `Active.store`."""
        field[self.cells] = vector

    def places(self, mask: Mask) -> Cells:
        """See `Active.places`."""
        return np.flatnonzero(self.take(mask))

    def blocks(self, partition: Partition) -> Blocks:
        """See `Active.blocks`."""
        i, j = np.divmod(self.cells, partition.shape[1])
        return _Listed(partition.rows[i] * partition.blocks[1] + partition.columns[j], partition)


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

    def places(self, mask: Mask) -> Cells:
        """See `Active.places`."""
        return np.flatnonzero(mask)

    def blocks(self, partition: Partition) -> Blocks:
        """See `Active.blocks`."""
        return _Masked(self, partition)


@attrs.frozen(eq=False)
class _Listed:
    """The block of each of a list of cells."""

    numbers: Cells
    partition: Partition

    def sums(self, vector: RealArray) -> RealArray:
        """See `Blocks.sums`."""
        bx, by = self.partition.blocks
        return np.bincount(self.numbers, weights=vector, minlength=bx * by).reshape(bx, by)

    def spread(self, sums: RealArray) -> RealArray:
        """See `Blocks.spread`."""
        return sums.ravel().take(self.numbers, mode="wrap")


@attrs.frozen(eq=False)
class _Masked:
    """Blocks of whole fields."""

    active: Dense
    partition: Partition

    def sums(self, vector: RealArray) -> RealArray:
        """See `Blocks.sums`."""
        parts = (self.partition.rows, self.partition.columns)
        rows, columns = (np.flatnonzero(np.diff(part, prepend=-1)) for part in parts)
        # Sums along the first axis run over whole rows at a time; the second axis is turned into it.
        strips = np.add.reduceat(vector.reshape(self.partition.shape), rows, axis=0)
        found = np.add.reduceat(np.ascontiguousarray(strips.T), columns, axis=0).T
        # A padded domain has blocks beyond the last cell, which stay empty.
        sums = np.zeros(self.partition.blocks, dtype=vector.dtype)
        sums[: rows.size, : columns.size] = found
        return sums

    def spread(self, sums: RealArray) -> RealArray:
        """See `Blocks.spread`."""
        return self.active.take(np.take(sums[self.partition.rows], self.partition.columns, axis=1).ravel())


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
