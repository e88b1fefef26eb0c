"""The passes: what a solver does to fields and vectors beside its products.

Active cells, whose pressure may change, gather vectors of fields, scatter and store them, sum them over blocks and
spread blocks. Bounds find active cells, release others, add to a gap and find its minimum. Two passes reduce vectors,
`dot` and `total`. Between grids `interpolate` and `coarsen` (`grids`), and `project_to_weighted_load` (`projection`),
are the others. Numbers leave a pass, never an array that only the next one reads, so that one compiled, or on the slabs
of several processes, or on a device, may take its place.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._base.arrays import Array, IntArray, Mask, RealArray, sum_of_products
from roughcontact._base.machine import map_tiles, tiles_of

# Fraction of active cells above which fields with zeros are faster than lists of cells; 0.2 and 0.8 change the
# CPU time by less than 3 % (docs/studies/solver_constants.py).
_DENSE_FRACTION = 0.4
# Product of float32 vectors below which terms below 1e-38, the minimum of float32, may be lost.
_UNDERFLOW_PRODUCT = 1e-30
# Maximum fraction of rows with active cells for transforms of these alone; above, it costs memory and saves little.
_SPARSE_ROW_FRACTION = 0.5


@attrs.frozen(eq=False)
class Partition:
    """A division of cells (nx, ny) into rectangular blocks (bx, by) of nearly equal size, by rows and columns."""

    shape: tuple[int, int]
    blocks: tuple[int, int]
    rows: npt.NDArray[np.int32]
    columns: npt.NDArray[np.int32]


@lru_cache(maxsize=4)
def divide(shape: tuple[int, int], padded: tuple[int, int], blocks: tuple[int, int]) -> Partition:
    """Return the partition of the cells; a solve repeats a few of them."""
    rows, columns = (((np.arange(n) * b) // m).astype(np.int32) for n, m, b in zip(shape, padded, blocks, strict=True))
    return Partition(shape, blocks, rows, columns)


@attrs.frozen(eq=False)
class ListedCells:
    """Few active cells, as a flat mask and as indices: a vector has one entry for each."""

    mask: Mask
    cells: IntArray

    @property
    def count(self) -> int:
        """Number of active cells."""
        return self.cells.size

    @cached_property
    def ones(self) -> RealArray:
        """The vector of ones, float32."""
        return np.ones_like(self.cells, dtype=np.float32)

    def gather(self, field: RealArray) -> RealArray:
        """Return the vector of a flat field."""
        vector = np.empty_like(self.cells, dtype=field.dtype)

        def take(part: slice) -> None:
            # All cells lie within the field; this mode of numpy is the fastest.
            field.take(self.cells[part], mode="wrap", out=vector[part])

        map_tiles(take, tiles_of(self.cells))
        return vector

    def share(self, field: RealArray) -> RealArray:
        """Return the vector of a field that is zero on all other cells; masked cells return the field itself."""
        return self.gather(field)

    def scatter(self, vector: RealArray) -> RealArray:
        """Return the flat field that is the vector on the active cells and zero elsewhere."""
        field = np.zeros_like(self.mask, dtype=vector.dtype)
        self.store(field, vector)
        return field

    def store(self, field: RealArray, vector: RealArray) -> None:
        """Set a flat field on the active cells."""

        def put(part: slice) -> None:
            field[self.cells[part]] = vector[part]

        map_tiles(put, tiles_of(self.cells))

    def limits(self, limit: Array) -> Array:
        """Return the pressure limits, one entry or a flat field, in a form that broadcasts to vectors."""
        return limit if limit.size == 1 else self.gather(limit)

    def mark(self, mask: Mask) -> Mask:
        """Return a mask of vectors."""
        return mask

    def few_rows(self, length: int) -> IntArray | None:
        """Return the rows of the given length with an active cell; None if most rows have one."""
        counts = self._count_in_rows(length)
        rows = np.flatnonzero(counts)
        return rows if rows.size < _SPARSE_ROW_FRACTION * counts.size else None

    def _count_in_rows(self, length: int) -> IntArray:
        # Cells are ordered by rows: this takes half the time of a division.
        return np.diff(np.searchsorted(self.cells, np.arange(0, self.mask.size + 1, length)))

    def blocks(self, partition: Partition) -> _ListedBlocks:
        """Return the active cells by blocks of a partition."""
        nx, ny = partition.shape
        counts = self._count_in_rows(ny)
        firsts = np.arange(0, nx * ny, ny, like=self.cells)
        rows, columns = (np.asarray(part, like=self.cells) for part in (partition.rows, partition.columns))
        columns = columns.take(self.cells - np.repeat(firsts, counts), mode="wrap")
        return _ListedBlocks(partition, np.repeat(rows * partition.blocks[1], counts) + columns)


@attrs.frozen(eq=False)
class MaskedCells:
    """Many active cells: vectors are flat fields, zero on all others; see `ListedCells`."""

    mask: Mask
    count: int

    @cached_property
    def ones(self) -> RealArray:
        """The vector of ones, which is the mask, float32."""
        return self.mask.astype(np.float32)

    def gather(self, field: RealArray) -> RealArray:
        """Return the field, zero on cells that are not active."""
        factor = self.ones if field.dtype == np.float32 else self.mask
        return np.multiply(field, factor, dtype=field.dtype)

    def share(self, field: RealArray) -> RealArray:
        """Return the field itself; see `ListedCells.share`."""
        return field

    def scatter(self, vector: RealArray) -> RealArray:
        """Return the vector itself."""
        return vector

    def store(self, field: RealArray, vector: RealArray) -> None:
        """Set a flat field on the active cells."""
        np.copyto(field, vector, where=self.mask)

    def limits(self, limit: Array) -> Array:
        """Return the limit itself: the vector is zero on cells that are not active."""
        return limit

    def mark(self, mask: Mask) -> Mask:
        """Return the mask, false on cells that are not active."""
        return mask & self.mask

    def few_rows(self, length: int) -> None:
        """Return None: most rows have active cells."""

    def blocks(self, partition: Partition) -> _MaskedBlocks:
        """Return the active cells by blocks of a partition."""
        return _MaskedBlocks(partition)


ActiveCells: TypeAlias = ListedCells | MaskedCells
Levels: TypeAlias = Callable[[slice], RealArray] | None


@attrs.frozen(eq=False)
class _Blocks:
    """Active cells by blocks of a partition."""

    partition: Partition

    def tiles(self, values: RealArray) -> Callable[[slice], RealArray]:
        """Return the flat field with the value of its block on each cell, as a function of the tile."""
        partition = self.partition
        strips = np.take(values, partition.columns, axis=1)
        length = partition.shape[1]

        def spread(tile: slice) -> RealArray:
            first = tile.start // length
            found: RealArray = strips[partition.rows[first : -(-tile.stop // length)]].ravel()
            return found[tile.start - first * length : tile.stop - first * length]

        return spread


@attrs.frozen(eq=False)
class _ListedBlocks(_Blocks):
    """Listed cells with the number of the block of each."""

    numbers: IntArray

    def sums(self, vector: RealArray) -> RealArray:
        """Return the sum over each block, shape (bx, by)."""
        bx, by = self.partition.blocks
        return np.bincount(self.numbers, weights=vector, minlength=bx * by).reshape(bx, by)

    def spread(self, values: RealArray) -> RealArray:
        """Return the vector with the value of its block, shape (bx, by), on each cell."""
        return values.ravel().take(self.numbers, mode="wrap")


@attrs.frozen(eq=False)
class _MaskedBlocks(_Blocks):
    """Masked cells by blocks; see `_ListedBlocks`."""

    def sums(self, vector: RealArray) -> RealArray:
        """Return the sum over each block, shape (bx, by)."""
        numbers = (self.partition.rows, self.partition.columns)
        rows, columns = (np.flatnonzero(np.diff(axis, prepend=-1)) for axis in numbers)
        field = vector.reshape(self.partition.shape)
        ends = [*rows[1:], len(field)]
        # Sums of whole rows are fast: the second axis has few values left.
        strips = np.stack([np.add.reduce(field[i:j], axis=0) for i, j in zip(rows, ends, strict=True)])
        found = np.add.reduceat(strips, columns, axis=1)
        # A padded domain has blocks beyond the last cell, which stay empty.
        sums = np.zeros(self.partition.blocks, dtype=vector.dtype, like=vector)
        sums[: rows.size, : columns.size] = found
        return sums

    def spread(self, values: RealArray) -> RealArray:
        """Return the values of the blocks on each cell, also where a vector, by which it is multiplied, is zero."""
        return np.take(values[self.partition.rows], self.partition.columns, axis=1).ravel()


def active_cells(field: RealArray, mark: Callable[[slice], Mask]) -> ActiveCells:
    """Return the active cells of a flat field in the faster form; `mark` returns the mask of a tile."""
    mask = np.empty_like(field, dtype=bool)

    def find(tile: slice) -> IntArray:
        mask[tile] = mark(tile)
        cells: IntArray = np.flatnonzero(mask[tile])
        cells += tile.start
        return cells

    found = map_tiles(find, tiles_of(field))
    count = sum(cells.size for cells in found)
    return MaskedCells(mask, count) if count > _DENSE_FRACTION * mask.size else ListedCells(mask, np.concatenate(found))


def limits_at(limit: Array, index: Mask | IntArray | slice) -> Array:
    """Return the pressure limits of the indexed cells; a limit of one entry holds for all."""
    return limit if limit.size == 1 else limit[index]


@attrs.frozen(eq=False)
class Bounds:
    """The bounds of a pressure: zero, and a limit, flat, of one entry or one for each cell, or `inf`."""

    limit: Array

    @cached_property
    def capped(self) -> bool:
        """Whether the pressure of any cell is limited."""
        return bool(np.isfinite(self.limit).any())

    def inside(self, pressure: Array, limit: Array) -> Mask:
        """Return the mask of the pressures strictly inside the bounds, from the limits of their cells."""
        inside = pressure > 0.0
        if self.capped:
            inside &= pressure < limit
        return inside

    def find_inside(self, pressure: Array) -> ActiveCells:
        """Return the cells strictly inside the bounds."""
        return active_cells(pressure, lambda tile: self.inside(pressure[tile], limits_at(self.limit, tile)))

    def release(
        self, gap: RealArray, pressure: Array, bearing: Mask | None, level: np.float32, levels: Levels
    ) -> ActiveCells:
        """Return the cells inside the bounds, and those released from a bound by the sign of their gap.

        Parameters
        ----------
        gap, pressure
            Both, flat.
        bearing
            The cells inside the bounds, which without a limit are all in contact; None: found from the pressure.
        level
            The gap below which open cells, and above which saturated ones, are released.
        levels
            The same for open cells, by tiles; None: it is the same everywhere.
        """

        def mark(tile: slice) -> Mask:
            low = gap[tile] < (level if levels is None else levels(tile))
            if bearing is not None:
                low |= bearing[tile]
                return low
            high = gap[tile] > level
            high |= pressure[tile] < limits_at(self.limit, tile)
            return np.where(pressure[tile] > 0.0, high, low)

        return active_cells(gap, mark)

    def minimum(self, gap: RealArray, pressure: Array) -> float:
        """Return the minimum gap of the cells that are not saturated: they must not overlap."""
        return min(map_tiles(lambda tile: self._minimum(gap, pressure, tile), tiles_of(gap)))

    def add(self, gap: RealArray, change: RealArray, part: np.float32, pressure: Array) -> float:
        """Add a part of a change, flat, to the gap, and return its minimum; the change is scaled to that part."""

        def add(tile: slice) -> float:
            change[tile] *= part
            gap[tile] += change[tile]
            return self._minimum(gap, pressure, tile)

        return min(map_tiles(add, tiles_of(gap)))

    def _minimum(self, gap: RealArray, pressure: Array, tile: slice) -> float:
        outside = pressure[tile] < limits_at(self.limit, tile) if self.capped else True
        return float(np.minimum.reduce(gap[tile], where=outside, initial=np.inf))


def total(vector: RealArray) -> float:
    """Return the sum of a vector, in float64."""
    return float(np.add.reduce(vector, dtype=np.float64))


def dot(one: RealArray, other: RealArray) -> float:
    """Return the product of two vectors; see `sum_of_products`."""
    product = sum_of_products(one, other)
    if abs(product) < _UNDERFLOW_PRODUCT:
        product = float(np.einsum("i,i->", one, other, dtype=np.float64, casting="same_kind"))
    return product
