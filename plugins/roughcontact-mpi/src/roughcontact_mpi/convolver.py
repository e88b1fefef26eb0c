"""Convolution by FFT on slabs, for the default solver."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any, cast

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.slabs import (
    SlabArray,
    SlabConvolver,
    gather_slabs,
    long_waves_on_slabs,
    multiply_on_slabs,
    stiffness_on_slabs,
)
from roughcontact.typing import (
    Array,
    ConvolutionSetup,
    IntArray,
    InverseConvolution,
    PreparedConvolution,
    RealArray,
)

from roughcontact_mpi.processes import Processes


@attrs.frozen(eq=False)
class SlabFFT(SlabConvolver):
    """Multiplication in Fourier space, each process with its rows and columns, on any boundary but a wrapped one.

    Parameters
    ----------
    processes
        The processes; by default all that `mpiexec` has started.
    gathers
        Whether the solver's result becomes a whole array of numpy on each process, or stays in slabs.
    """

    processes: Processes = attrs.field(factory=Processes)
    gathers: bool = attrs.field(default=True, kw_only=True)

    def convolve(self, setup: ConvolutionSetup, symbol: Array, padded: tuple[int, int]) -> PreparedConvolution:
        """Return the convolution by the columns of this process of the symbol."""
        return SlabConvolution(setup, symbol, padded, self.processes)


def _multiply(field: SlabArray, symbol: RealArray, padded: tuple[int, int]) -> Any:
    """Return a field in slabs with each of its waves multiplied by the columns of each process of a symbol."""

    def factors(columns: slice) -> RealArray:
        return symbol[:, columns].astype(field.dtype, copy=False)

    return field.like(multiply_on_slabs(field.processes, field.part, field.shape[0], factors, padded))


@attrs.frozen(eq=False)
class SlabInverse(InverseConvolution):
    """The approximate inverse on slabs: each process has the stiffness of its columns, as an array of numpy."""

    by_rows = False

    processes: Processes = attrs.field(kw_only=True)
    ends: tuple[RealArray, RealArray] = attrs.field(kw_only=True)

    def __attrs_post_init__(self) -> None:
        # A stiffness of all waves comes from a step that does not know of slabs.
        own = self.processes.own_columns(self.padded[1] // 2 + 1)
        if self.stiffness.shape[1] != own.stop - own.start:
            raise rc.InputError(
                "Fields on slabs have no stiffness of all waves, which contacts of thin stiff layers need: solve the "
                "contact in one process, by rc.ContactProblem."
            )

    @property
    def axes(self) -> tuple[RealArray, RealArray]:
        """The stiffness of the waves along x and along y."""
        return self.ends

    def long_waves(self, rows: IntArray, columns: int) -> RealArray:
        """Return the stiffness of some waves along x and of the first ones along y, on each process."""
        return long_waves_on_slabs(self.processes, self.padded, self.stiffness[rows], columns)

    def coefficients(self, reach: int, first: int = 0) -> RealArray:
        """Return the pressure at (i, j) cells from a unit displacement of one; see `InverseConvolution`."""
        own = self.processes.own_columns(self.padded[1] // 2 + 1)
        return self.processes.total_blocks(super().coefficients(reach, own.start))

    def add_near(
        self, field: RealArray, shape: tuple[int, int], cells: IntArray, amounts: RealArray, stencil: RealArray
    ) -> None:
        """Add amounts times a stencil around cells of a flat field; rows of other processes go there."""
        processes = self.processes
        mx, my = self.padded
        ny = shape[1]
        reach = min(stencil.shape[0] - 1, (mx - 1) // 2)
        bounds = processes.rows(shape[0])
        own = processes.own_rows(shape[0])
        count = own.stop - own.start
        wide = np.zeros((count + 2 * reach, ny), dtype=_slab(field).dtype)
        if count:
            alone = InverseConvolution(self.stiffness, (count + 2 * reach, my))
            places = _slab(cells).part + reach * ny
            alone.add_near(wide.reshape(-1), wide.shape, places, _slab(amounts).part, stencil[: reach + 1])
        target = _slab(field).part.reshape(count, ny)
        target += wide[reach : reach + count]

        def beyond(rank: int) -> list[tuple[int, int]]:
            """Return the rows beyond those of a process, as positions and as rows of the field."""
            start, stop = bounds[rank : rank + 2]
            if start == stop:
                return []
            before = [(k, (start - reach + k) % mx) for k in range(reach)]
            after = [(stop - start + reach + k, (stop + k) % mx) for k in range(reach)]
            return before + after

        mine = beyond(processes.rank)
        ranks = range(processes.count)
        sent = [[place for place, row in mine if bounds[other] <= row < bounds[other + 1]] for other in ranks]
        incoming = [[row for _, row in beyond(other) if own.start <= row < own.stop] for other in ranks]
        found = processes.exchange_rows(wide, sent, [len(rows) for rows in incoming])
        for row, values in zip(itertools.chain.from_iterable(incoming), found, strict=True):
            target[row - own.start] += values

    def blocks(self, active: Any, partition: Any) -> Any:
        """Return active cells by blocks, whose sums are those over all processes."""
        own = self.processes.own_rows(partition.shape[0])
        rows = partition.rows[own]
        first = int(rows[0]) if rows.size else 0
        count = int(rows[-1]) - first + 1 if rows.size else 0
        blocks = (count, partition.blocks[1])
        here = attrs.evolve(partition, shape=(rows.size, partition.shape[1]), blocks=blocks, rows=rows - first)
        given = {field.name: getattr(active, field.name) for field in attrs.fields(type(active))}
        parts = {name: value.part if isinstance(value, SlabArray) else value for name, value in given.items()}
        local = type(active)(**parts).blocks(here) if rows.size else None
        return _SlabBlocks(local, slice(first, first + count), partition.blocks, self.processes)

    def multiply(
        self, values: RealArray, symbol: RealArray, padded: tuple[int, int], rows: IntArray | None = None
    ) -> RealArray:
        """Return a field with each of its waves multiplied by a symbol; see `InverseConvolution.multiply`."""
        if isinstance(values, np.ndarray):
            return super().multiply(values, symbol, padded, rows)
        return _array(_multiply(_slab(values), symbol, padded))


@attrs.frozen(eq=False)
class _SlabBlocks:
    """Active cells by blocks: those of this process by the blocks of its rows; none if it has no rows."""

    local: Any
    rows: slice
    blocks: tuple[int, int]
    processes: Processes

    def sums(self, vector: SlabArray) -> RealArray:
        """Return the sum over each block and all processes, shape (bx, by), an array of numpy."""
        found = np.zeros(self.blocks)
        if self.local is not None:
            found[self.rows] = self.local.sums(vector.part)
        return self.processes.total_blocks(found)

    def spread(self, values: RealArray) -> SlabArray:
        """Return the vector with the value of its block on each cell."""
        part = np.zeros(0, dtype=values.dtype) if self.local is None else self.local.spread(values[self.rows])
        return SlabArray.list(part, self.processes)

    def tiles(self, values: RealArray) -> Callable[[slice], SlabArray]:
        """Return the flat field with the value of its block on each cell, as a function of the only tile."""
        part = np.zeros(0, dtype=values.dtype)
        if self.local is not None:
            shape = self.local.partition.shape
            part = self.local.tiles(values[self.rows])(slice(0, shape[0] * shape[1]))
        return lambda tile: SlabArray.list(part, self.processes)


@attrs.frozen(eq=False)
class SlabConvolution(PreparedConvolution):
    """Transform, multiply by the real symbol, transform back, on slabs.

    Attributes
    ----------
    symbol
        The factors of the columns of this process, an array of numpy.
    padded
        Cells of the transforms.
    """

    setup: ConvolutionSetup
    symbol: Array
    padded: tuple[int, int]
    processes: Processes

    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement, an array of the kind of the pressure."""
        if isinstance(pressure, np.ndarray):
            return self.to_numpy(self.apply(self.from_numpy(pressure)))
        return _array(_multiply(_slab(pressure), self.symbol, self.padded))

    def inverse(self, dtype: type[np.float32] | type[np.float64] = np.float64) -> InverseConvolution:
        """Return the approximate inverse on slabs."""
        stiffness, exact, ends = stiffness_on_slabs(self.setup, self.processes, dtype)
        return SlabInverse(stiffness, self.setup.inverse_shape, exact, processes=self.processes, ends=ends)

    def from_numpy(self, values: Array) -> Array:
        """Return the rows of this process of a field, or a single value, as an array in slabs."""
        if isinstance(values, SlabArray):
            return _array(values)
        if values.ndim < 2 or values.shape != self.setup.grid.shape:
            return _array(SlabArray(values, self.processes, None))
        own = self.processes.own_rows(values.shape[0])
        return _array(SlabArray.field(values[own].copy(), self.processes, values.shape[0]))

    def to_numpy(self, values: Array) -> Array:
        """Return the whole field, on each process; or as it is, if the convolver does not gather."""
        gathers = cast(SlabFFT, self.setup.convolver).gathers
        return cast(Array, gather_slabs(_slab(values))) if gathers else values

    def sum(self, values: RealArray) -> float:
        """Return the sum over all cells."""
        return float(np.add.reduce(values, axis=None))


def _array(values: SlabArray) -> Any:
    return values


def _slab(values: Any) -> SlabArray:
    return cast(SlabArray, values)
