"""Convolution by FFT on slabs: rows at home, a transpose, columns, and back."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import RealArray
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import BoundKernel, InfluenceKernel, SupportsSpectrum
from roughcontact._parts.surfaces import SelfAffineSurface
from roughcontact._solve.convolvers import ConvolutionSetup, Convolver, PreparedConvolution, padded_shape
from roughcontact._solve.problem.slabs.processes import SlabProcesses, in_tiles
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Values of a tile of rows, with what its transform takes: few enough to save memory.
_TILE_VALUES = 2**16
# Values that a process sends to another at a time, from which on an exchange is divided.
_EXCHANGED_VALUES = 2**10


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

    processes: SlabProcesses
    bounds: Sequence[int]
    columns: int

    @property
    def width(self) -> int:
        """Columns of this process."""
        own = self.processes.own_columns(self.columns)
        return int(own.stop - own.start)

    @property
    def blocks(self) -> int:
        """The number of exchanges, the same on all processes: several where one would take much memory."""
        count = self.processes.count
        if count == 1:
            return 1
        values = -(-self.bounds[-1] * self.columns // count**2)
        most = min(self.processes.max_exchanges, max(1, self.columns // count))
        return int(np.clip(values // _EXCHANGED_VALUES, 1, most))

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

    def forward(self, rows: Any, block: int) -> Any:
        """Return a block of the columns of this process, shape (nx, n), from its rows."""
        if self.processes.count == 1:
            return rows
        columns, sent, expected = self._sizes(block)
        packed = self.processes.empty(sum(sent), rows)
        start = 0
        for own, size in zip(columns, sent, strict=True):
            packed[start : start + size].reshape(rows.shape[0], own.stop - own.start)[:] = rows[:, own]
            start += size
        mine = self.own(block)
        found = self.processes.exchange(packed, sent, expected)
        return found.reshape(self.bounds[-1], mine.stop - mine.start)

    def back(self, found: Any, rows: Any, block: int) -> None:
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


@guarded
def multiply_on_slabs(
    processes: SlabProcesses, values: Any, nx: int, factors: Callable[[slice], Any], padded: tuple[int, int]
) -> Any:
    """Return the rows of this process of a field, padded with zeros, with each wave multiplied by a real symbol.

    Parameters
    ----------
    processes
        The processes.
    values
        The rows of this process, shape (n, ny).
    nx
        Rows of the field.
    factors
        Returns the symbol on some of the columns of this process: all its rows, or those of the waves from zero up, the
        others being the same.
    padded
        Cells (mx, my) of the periodic grid.
    """
    mx, my = padded
    fourier = processes.transforms

    def multiply(columns: Any, symbol: Any) -> Any:
        waves = fourier.fft(columns, mx, 0)
        half = symbol.shape[0]
        waves[:half] *= symbol
        if half < mx:
            waves[half:] *= symbol[mx - half : 0 : -1]
        return fourier.ifft(waves, None, 0)[:nx]

    waves = _transform(processes, values, my)
    transpose = Transpose(processes, processes.rows(nx), my // 2 + 1)
    for block in range(transpose.blocks):
        columns = transpose.forward(waves, block)
        own = transpose.own(block)
        tiles = [*processes.tiles_of_columns(own, padded=mx > nx)]
        if len(tiles) == 1:
            columns = multiply(columns, factors(own))
        else:
            for tile in tiles:
                here = slice(tile.start - own.start, tile.stop - own.start)
                columns[:, here] = multiply(columns[:, here], factors(tile))
        transpose.back(columns, waves, block)
        del columns
    return transform_back(processes, waves, my, values.shape[1])


def _tiles_of_rows(processes: SlabProcesses, count: int, length: int) -> list[slice]:
    return [*processes.tiles(slice(0, count), _TILE_VALUES // length)]


def _transform(processes: SlabProcesses, values: Any, length: int) -> Any:
    """Return the waves of each row, padded with zeros to a length."""
    tiles = _tiles_of_rows(processes, values.shape[0], length)
    transform = processes.transforms.rfft
    if len(tiles) == 1:
        return transform(values, length, -1)
    waves = np.empty((values.shape[0], length // 2 + 1), dtype=np.result_type(values.dtype, np.complex64))
    for rows in tiles:
        waves[rows] = transform(values[rows], length, -1)
    return waves


def transform_back(processes: SlabProcesses, waves: Any, length: int, count: int, norm: str | None = None) -> Any:
    """Return the first values of each row of `length` values from its waves, which are overwritten."""
    tiles = _tiles_of_rows(processes, waves.shape[0], length)
    transform = processes.transforms.irfft
    if len(tiles) == 1:
        return transform(waves, length, -1, norm)[:, :count]
    shape = (waves.shape[0], count)
    # Whole rows take a little less than their waves, and lie in their place before those of the rows that follow.
    numbers = waves.view(waves.real.dtype).reshape(-1)
    values = numbers[: math.prod(shape)].reshape(shape) if count == length else np.empty(shape, dtype=numbers.dtype)
    for rows in tiles:
        values[rows] = transform(waves[rows], length, -1, norm)[:, :count]
    return values


def _transform_even(processes: SlabProcesses, values: Any, length: int) -> Any:
    """Return the transform along the first axis of the even extension to a length, shape (length // 2 + 1, n)."""
    library = processes.library
    # On a padded grid of an even number of cells the last offset is its own image.
    kept = values[: length // 2 + 1]
    images = kept[1 : length - kept.shape[0] + 1]
    beyond = library.zeros_like(values[: length - kept.shape[0] - images.shape[0]])
    extended = library.concatenate((kept, beyond, library.flip(images, (0,))))
    return processes.transforms.rfft(extended, None, 0).real


@guarded
def symbol_of_columns(setup: ConvolutionSetup, padded: tuple[int, int], processes: SlabProcesses) -> Any:
    """Return the transform of the kernel on a padded grid: the columns of this process.

    It has all rows on a periodic boundary, and those of the waves from zero up elsewhere.
    """
    own = processes.own_columns(padded[1] // 2 + 1)
    if setup.boundary is Boundary.PERIODIC:
        return processes.place(setup.spectrum_of_columns(padded, own))
    if not setup.boundary.mixed:
        nx, ny = setup.grid.shape

        def find(rows: slice) -> RealArray:
            return setup.kernel.coefficients((rows.stop - rows.start, ny), setup.grid.spacing, rows.start)

        half = _rows_of_waves(find, processes, processes.own_rows(nx), padded[1])
        return _exchange(half, processes, processes.rows(nx), padded[1] // 2 + 1, padded[0])
    free = setup.boundary.free_axis
    waves = padded[1 - free] // 2 + 1

    def find_mixed(part: slice) -> RealArray:
        return setup.kernel.mixed_coefficients(setup.grid, setup.boundary, offsets=padded[free] // 2 + 1, part=part)

    if free == 0:
        symbol = processes.empty((padded[0] // 2 + 1, own.stop - own.start))
        for part in processes.tiles(own, _TILE_VALUES // (2 * padded[0])):
            here = slice(part.start - own.start, part.stop - own.start)
            symbol[:, here] = _transform_even(processes, processes.place(find_mixed(part)), padded[0])
        return symbol
    # Each process has some of the waves along x, and then of those along y.
    half = _rows_of_waves(find_mixed, processes, processes.own_columns(waves), padded[1])
    return _exchange(half, processes, processes.columns(waves), padded[1] // 2 + 1)


def _rows_of_waves(find: Callable[[slice], RealArray], processes: SlabProcesses, own: slice, length: int) -> Any:
    """Return the transforms along y of the even extensions of rows that are found a tile at a time."""
    half = processes.empty((own.stop - own.start, length // 2 + 1))
    for rows in processes.tiles(own, _TILE_VALUES // (2 * length)):
        found = _transform_even(processes, processes.place(find(rows)).T, length)
        half[rows.start - own.start : rows.stop - own.start] = found.T
    return half


def _exchange(
    half: Any, processes: SlabProcesses, bounds: Sequence[int], columns: int, length: int | None = None
) -> Any:
    """Return the columns of this process from rows; with a length, the transform of their even extension to it."""
    transpose = Transpose(processes, bounds, columns)
    symbol = processes.empty((bounds[-1] if length is None else length // 2 + 1, transpose.width))
    for block in range(transpose.blocks):
        own = transpose.own(block)
        found = transpose.forward(half, block)
        if length is None:
            symbol[:, own] = found
            continue
        for tile in processes.tiles(own, _TILE_VALUES // (2 * length)):
            given = found[:, tile.start - own.start : tile.stop - own.start]
            symbol[:, tile] = _transform_even(processes, given, length)
    return symbol


@guarded
def make_random_rows(surface: SelfAffineSurface, grid: Grid, processes: SlabProcesses) -> Any:
    """Return the rows of this process of a random surface, m; each draws all random numbers, and keeps its waves."""
    nx, ny = grid.shape
    columns = processes.own_columns(ny // 2 + 1)
    half = processes.place(surface.half_spectrum(grid, columns, processes.across))
    tiles = [*processes.tiles(slice(0, half.shape[1]), _TILE_VALUES // (2 * nx))]
    half = in_tiles(lambda part: processes.transforms.ifft(part, None, 0, "forward"), half, tiles)
    own = processes.own_rows(nx)
    waves = processes.empty((own.stop - own.start, ny // 2 + 1), half)
    transpose = Transpose(processes, processes.rows(nx), ny // 2 + 1)
    for block in range(transpose.blocks):
        transpose.back(half[:, transpose.own(block)], waves, block)
    del half
    return transform_back(processes, waves, ny, ny, "forward")


@guarded
def stiffness_on_slabs(
    setup: ConvolutionSetup, processes: SlabProcesses, dtype: Any
) -> tuple[RealArray, bool, tuple[RealArray, RealArray]]:
    """Return the columns of this process of the approximate inverse, whether it is exact, and its axes, of numpy."""
    mx, my = setup.inverse_shape
    own = processes.own_columns(my // 2 + 1)
    stiffness, exact = setup.stiffness_of_columns(own, dtype, processes.across)
    first = np.zeros(mx // 2 + 1, dtype=dtype)
    top = np.zeros(my // 2 + 1, dtype=dtype)
    top[own] = stiffness[0]
    if own.start == 0 < own.stop:
        first[:] = stiffness[: mx // 2 + 1, 0]
    return stiffness, exact, (processes.total_blocks(first), processes.total_blocks(top))


@guarded
def long_waves_on_slabs(
    processes: SlabProcesses, padded: tuple[int, int], stiffness: RealArray, columns: int
) -> RealArray:
    """Return the first columns of rows of the inverse, on each process, from the columns of each."""
    own = processes.own_columns(padded[1] // 2 + 1)
    mine = stiffness[:, : max(0, columns - own.start)]
    found = np.zeros((stiffness.shape[0], columns), dtype=stiffness.dtype)
    found[:, own.start : own.start + mine.shape[1]] = mine
    return processes.total_blocks(found)


@attrs.frozen(eq=False)
class SlabConvolver(Convolver, abc.ABC):
    """Multiplication in Fourier space, each process with its rows and columns, on any boundary but a wrapped one.

    Parameters
    ----------
    processes
        The processes.
    """

    processes: Any

    boundaries = frozenset(Boundary) - {Boundary.WRAPPED}

    def require(self, kernel: InfluenceKernel, boundary: Boundary) -> None:
        """Raise `InputError` if it cannot treat the boundary, or the kernel lacks a form that is needed."""
        if boundary not in self.boundaries:
            raise InputError.about("The boundary on slabs", str(boundary), "'free' or 'periodic', or a pair of them")
        super().require(kernel, boundary)
        if not isinstance(kernel, SupportsSpectrum):
            raise InputError(f"The kernel {kernel!r} has no spectrum, which a contact on slabs needs.")

    def transform_shape(self, grid: Grid, boundary: Boundary) -> tuple[int, int]:
        """Return the cells of the padded grid; see `roughcontact.typing.padded_shape`."""
        return padded_shape(grid, boundary)

    def prepare(self, kernel: BoundKernel, grid: Grid, boundary: Boundary) -> PreparedConvolution:
        """Return the convolution on slabs."""
        setup = ConvolutionSetup(self, kernel, grid, boundary)
        padded = self.transform_shape(grid, boundary)
        return self.convolve(setup, symbol_of_columns(setup, padded, self.processes), padded)

    @abc.abstractmethod
    def convolve(self, setup: ConvolutionSetup, symbol: Any, padded: tuple[int, int]) -> PreparedConvolution:
        """Return the convolution by the columns of this process of the symbol; see `symbol_of_columns`."""
