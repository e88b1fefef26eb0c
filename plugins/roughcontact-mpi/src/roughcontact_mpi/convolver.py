"""Convolution by FFT on slabs: rows at home, a transpose by all-to-all, columns, and back."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, cast

import attrs
import numpy as np
import roughcontact as rc
import scipy.fft
from roughcontact.typing import (
    Array,
    BoundKernel,
    ConvolutionSetup,
    IntArray,
    InverseConvolution,
    PreparedConvolution,
    RealArray,
    SupportsSpectrum,
    padded_shape,
)

from roughcontact_mpi.arrays import SlabArray
from roughcontact_mpi.functions import gather, unknown
from roughcontact_mpi.processes import Processes

# Columns that are transformed at a time: few enough for the cache.
_COLUMNS = 32
# Values of a tile of rows or columns, with what its transform takes: few enough to save memory.
_TILE_VALUES = 2**16
# The fewest tiles, on small grids.
_TILES = 4
# Values that a process sends to another at a time, from which on an exchange is divided, and the most parts.
_EXCHANGED_VALUES = 2**10
_MAX_EXCHANGES = 8


@attrs.frozen(eq=False)
class SlabFFT(rc.Convolver):
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

    boundaries = frozenset(rc.Boundary) - {rc.Boundary.WRAPPED}

    def transform_shape(self, grid: rc.Grid, boundary: rc.Boundary) -> tuple[int, int]:
        """Return the cells of the padded grid; see `roughcontact.typing.padded_shape`."""
        return padded_shape(grid, boundary)

    def prepare(self, kernel: BoundKernel, grid: rc.Grid, boundary: rc.Boundary) -> PreparedConvolution:
        """Return the convolution on slabs."""
        setup = ConvolutionSetup(self, kernel, grid, boundary)
        padded = self.transform_shape(grid, boundary)
        if boundary is rc.Boundary.PERIODIC:
            symbol = setup.spectrum_of_columns(padded, self.processes.own_columns(padded[1] // 2 + 1))
        elif boundary.mixed:
            symbol = _mixed_symbol_of_columns(setup, padded, self.processes)
        else:
            symbol = _symbol_of_columns(setup, padded, self.processes)
        return SlabConvolution(setup, symbol, padded, self.processes)


def _symbol_of_columns(setup: ConvolutionSetup, padded: tuple[int, int], processes: Processes) -> Array:
    """Return the transform of the coefficients on a padded grid, its columns of this process, for half of the rows."""
    nx, ny = setup.grid.shape
    own = processes.own_rows(nx)
    half = np.empty((own.stop - own.start, padded[1] // 2 + 1))
    for rows in list_tiles(own, 2 * padded[1]):
        given = setup.kernel.coefficients((rows.stop - rows.start, ny), setup.grid.spacing, rows.start)
        half[rows.start - own.start : rows.stop - own.start] = _transform_even(given.T, padded[1]).T
    return _transform_columns(half, processes.rows(nx), padded, processes)


def _mixed_symbol_of_columns(setup: ConvolutionSetup, padded: tuple[int, int], processes: Processes) -> Array:
    """Return `_symbol_of_columns` where one axis is periodic."""
    free = setup.boundary.free_axis
    offsets = padded[free] // 2 + 1
    waves = padded[1 - free] // 2 + 1
    own = processes.own_columns(waves)

    def find(part: slice) -> Array:
        return setup.kernel.mixed_coefficients(setup.grid, setup.boundary, offsets=offsets, part=part)

    if free == 0:
        symbol = np.empty((offsets, own.stop - own.start))
        for part in list_tiles(own, 2 * padded[0]):
            symbol[:, part.start - own.start : part.stop - own.start] = _transform_even(find(part), padded[0])
        return symbol
    # Each process has some of the waves along x, and then of those along y.
    half = np.empty((own.stop - own.start, offsets))
    for part in list_tiles(own, 2 * padded[1]):
        half[part.start - own.start : part.stop - own.start] = _transform_even(find(part).T, padded[1]).T
    transpose = Transpose(processes, processes.columns(waves), offsets)
    symbol = np.empty((waves, transpose.width))
    for block in range(transpose.blocks):
        symbol[:, transpose.own(block)] = transpose.forward(half, block)
    return symbol


def _transform_columns(half: Array, bounds: Sequence[int], padded: tuple[int, int], processes: Processes) -> Array:
    """Return the transform along x of the even extension of rows of this process: its columns."""
    transpose = Transpose(processes, bounds, padded[1] // 2 + 1)
    symbol = np.empty((padded[0] // 2 + 1, transpose.width))
    for block in range(transpose.blocks):
        own = transpose.own(block)
        columns = transpose.forward(half, block)
        for tile in list_tiles(own, 2 * padded[0]):
            given = columns[:, tile.start - own.start : tile.stop - own.start]
            symbol[:, tile] = _transform_even(given, padded[0])
    return symbol


def list_tiles(whole: slice, values: int) -> Iterator[slice]:
    """Yield parts of a range that take little memory, for a number of values of each entry."""
    step = max(1, min(_TILE_VALUES // values, (whole.stop - whole.start) // _TILES))
    for start in range(whole.start, whole.stop, step):
        yield slice(start, min(start + step, whole.stop))


def _transform_even(values: Array, length: int) -> Array:
    """Return the transform along the first axis of the even extension to a length, shape (length // 2 + 1, n)."""
    # On a padded grid of an even number of cells the last offset is its own image.
    kept = values[: length // 2 + 1]
    extended = np.zeros((length, values.shape[1]))
    extended[: kept.shape[0]] = kept
    extended[length - kept.shape[0] + 1 :] = kept[:0:-1]
    return np.asarray(scipy.fft.rfft(extended, axis=0).real)


@attrs.frozen
class Transpose:
    """Exchanges rows for columns and back, some of the columns of each process at a time.

    Parameters
    ----------
    processes
        The processes.
    bounds
        Bounds of the rows of all.
    columns
        Number of columns of the whole.
    """

    processes: Processes
    bounds: Sequence[int]
    columns: int

    @property
    def width(self) -> int:
        """Columns of this process."""
        own = self.processes.own_columns(self.columns)
        return own.stop - own.start

    @property
    def blocks(self) -> int:
        """The number of exchanges, the same on all processes: several where one would take much memory."""
        count = self.processes.count
        if count == 1:
            return 1
        values = -(-self.bounds[-1] * self.columns // count**2)
        return int(np.clip(values // _EXCHANGED_VALUES, 1, min(_MAX_EXCHANGES, max(1, self.columns // count))))

    def own(self, block: int) -> slice:
        """Return the columns of a block among those of this process."""
        return self._columns(self.processes.rank, block, first=0)

    def _columns(self, rank: int, block: int, first: int | None = None) -> slice:
        start, stop = self.processes.columns(self.columns)[rank : rank + 2]
        bounds = self.processes.share(stop - start, self.blocks)
        origin = start if first is None else first
        return slice(origin + bounds[block], origin + bounds[block + 1])

    def _sizes(self, block: int) -> tuple[list[slice], list[int], list[int]]:
        """Return the columns of all processes, the entries of this one in them, and those of its columns in all."""
        columns = [self._columns(rank, block) for rank in range(self.processes.count)]
        heights = np.diff(self.bounds).tolist()
        rank = self.processes.rank
        mine = columns[rank].stop - columns[rank].start
        return columns, [heights[rank] * (own.stop - own.start) for own in columns], [n * mine for n in heights]

    def forward(self, rows: RealArray, block: int) -> RealArray:
        """Return a block of the columns of this process, shape (nx, n), from its rows."""
        if self.processes.count == 1:
            return rows
        columns, sent, expected = self._sizes(block)
        packed = np.empty(sum(sent), dtype=rows.dtype)
        start = 0
        for own, size in zip(columns, sent, strict=True):
            packed[start : start + size].reshape(rows.shape[0], own.stop - own.start)[:] = rows[:, own]
            start += size
        mine = self.own(block)
        found = self.processes.exchange(packed, sent, expected)
        return found.reshape(self.bounds[-1], mine.stop - mine.start)

    def back(self, found: RealArray, rows: RealArray, block: int) -> None:
        """Put a block of the columns of this process into the rows of all."""
        if self.processes.count == 1:
            if found is not rows:
                rows[:] = found
            return
        columns, expected, sent = self._sizes(block)
        packed = self.processes.exchange(found.reshape(-1), sent, expected)
        start = 0
        for own, size in zip(columns, expected, strict=True):
            rows[:, own] = packed[start : start + size].reshape(rows.shape[0], own.stop - own.start)
            start += size


def _multiply(
    values: RealArray, shape: tuple[int, int], symbol: RealArray, padded: tuple[int, int], processes: Processes
) -> RealArray:
    """Return the rows of this process of a field, padded with zeros, with each wave multiplied by a real symbol.

    Parameters
    ----------
    values
        The rows of this process.
    shape
        Rows and columns of the field.
    symbol
        The columns of this process: all rows, or those of the waves from zero up, the others being the same.
    padded
        Cells of the periodic grid.
    """
    nx = shape[0]
    mx, my = padded
    half = symbol.shape[0]
    waves = _transform(values, my)
    transpose = Transpose(processes, processes.rows(nx), my // 2 + 1)
    for block in range(transpose.blocks):
        columns = transpose.forward(waves, block)
        given = symbol[:, transpose.own(block)]
        step = max(1, min(_COLUMNS, columns.shape[1] // _TILES))
        for start in range(0, columns.shape[1], step):
            tile = slice(start, start + step)
            part = scipy.fft.fft(columns[:, tile], n=mx, axis=0)
            factors = given[:, tile].astype(values.dtype, copy=False)
            part[:half] *= factors
            if half < mx:
                part[half:] *= factors[mx - half : 0 : -1]
            columns[:, tile] = scipy.fft.ifft(part, axis=0, overwrite_x=True)[:nx]
        transpose.back(columns, waves, block)
        del columns
    return transform_back(waves, my, shape[1])


def _transform(values: RealArray, length: int) -> RealArray:
    waves = np.empty((values.shape[0], length // 2 + 1), dtype=np.result_type(values.dtype, np.complex64))
    for rows in list_tiles(slice(0, values.shape[0]), length):
        waves[rows] = scipy.fft.rfft(values[rows], n=length, axis=1)
    return waves


def transform_back(waves: RealArray, length: int, count: int, norm: Any = None) -> RealArray:
    """Return the first values of each row of `length` values from its waves, which are overwritten."""
    shape = (waves.shape[0], count)
    # Whole rows take a little less than their waves, and lie in their place before those of the rows that follow.
    numbers = waves.view(waves.real.dtype).reshape(-1)
    values = numbers[: math.prod(shape)].reshape(shape) if count == length else np.empty(shape, dtype=numbers.dtype)
    for rows in list_tiles(slice(0, waves.shape[0]), length):
        values[rows] = scipy.fft.irfft(waves[rows], n=length, axis=1, norm=norm, overwrite_x=True)[:, :count]
    return values


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
            raise unknown("hypot")

    @property
    def axes(self) -> tuple[RealArray, RealArray]:
        """The stiffness of the waves along x and along y."""
        return self.ends

    def long_waves(self, rows: IntArray, columns: int) -> RealArray:
        """Return the stiffness of some waves along x and of the first ones along y, on each process."""
        own = self.processes.own_columns(self.padded[1] // 2 + 1)
        mine = self.stiffness[rows][:, : max(0, columns - own.start)]
        found = np.zeros((len(rows), columns), dtype=self.stiffness.dtype)
        found[:, own.start : own.start + mine.shape[1]] = mine
        return self.processes.total_blocks(found)

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
        field = _slab(values)
        shape = cast(tuple[int, int], field.shape)
        return _array(field.like(_multiply(field.part, shape, symbol, padded, self.processes)))


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
        field = _slab(pressure)
        shape = cast(tuple[int, int], field.shape)
        return _array(field.like(_multiply(field.part, shape, self.symbol, self.padded, self.processes)))

    def inverse(self, dtype: type[np.float32] | type[np.float64] = np.float64) -> InverseConvolution:
        """Return the approximate inverse on slabs."""
        setup = self.setup
        mx, my = setup.inverse_shape
        processes = self.processes
        own = processes.own_columns(my // 2 + 1)
        if not isinstance(setup.kernel.kernel, SupportsSpectrum):
            raise rc.InputError(f"The kernel {setup.kernel.kernel!r} has no spectrum, which a contact on slabs needs.")
        stiffness, exact = setup.stiffness_of_columns(own, dtype, processes.across)
        first = stiffness[: mx // 2 + 1, 0] if own.start == 0 < own.stop else np.zeros(mx // 2 + 1, dtype=dtype)
        top = np.zeros(my // 2 + 1, dtype=dtype)
        top[own] = stiffness[0]
        ends = processes.total_blocks(np.ascontiguousarray(first)), processes.total_blocks(top)
        return SlabInverse(stiffness, setup.inverse_shape, exact, processes=processes, ends=ends)

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
        return cast(Array, gather(_slab(values))) if gathers else values

    def sum(self, values: RealArray) -> float:
        """Return the sum over all cells."""
        return float(np.add.reduce(values, axis=None))


def _array(values: SlabArray) -> Any:
    return values


def _slab(values: Any) -> SlabArray:
    return cast(SlabArray, values)
