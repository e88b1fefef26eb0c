"""Real transforms of fields: by rows and blocks of columns, in the cache and on threads; products with symbols."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from roughcontact._base.arrays import Array, IntArray, Pair, RealArray, Waves
from roughcontact._base.machine import map_tiles, split, threads_for
from roughcontact._parts.grid import Boundary, Grid
from roughcontact.errors.door import guarded

# Bytes along a row of the columns that are transformed at a time: few enough for the cache, enough for vector units. On
# 512 x 512 and 1024 x 1024 cells 16 and 32 columns of float64 are fastest; 8 take 6 % longer, 128 take 13 %.
_COLUMN_BLOCK_BYTES = 32 * 16
# Values of the rows that are cut at a time, to save the memory of padded rows.
_ROW_BLOCK_VALUES = 2**17
# Minimum waves that are multiplied by columns: in float32 that takes 5 % less than three passes on
# 2048 x 2048 cells, 10 % less on 4096 x 4096 and 4 % more on 1024 x 1024 (docs/studies/scale.py products).
_MIN_COLUMNWISE_WAVES = 2**21


def transform_rows(values: RealArray, length: int) -> Waves:
    """Return the waves of each row, padded with zeros to `length`, shape (nx, length // 2 + 1)."""
    waves: Waves = scipy.fft.rfft(values, n=length, axis=1, workers=threads_for(values.size))
    return waves


def transform_columns(waves: Waves, length: int) -> Waves:
    """Return the waves of each column of some fields, padded with zeros to `length`; the waves may be overwritten."""
    threads = threads_for(2 * (waves.size // waves.shape[-2]) * length)
    found: Waves
    if threads == 1:
        # The same transform, wrapped in a third of the time.
        found = scipy.fftpack.fft(waves, n=length, axis=-2, overwrite_x=True)  # type: ignore[arg-type]
    else:
        found = scipy.fft.fft(waves, n=length, axis=-2, overwrite_x=True, workers=threads)
    return found


def transform_columns_back(waves: Waves) -> Waves:
    """Return each column from its waves, which may be overwritten."""
    threads = threads_for(2 * waves.size)
    found: Waves
    if threads == 1:
        found = scipy.fftpack.ifft(waves, axis=-2, overwrite_x=True)
    else:
        found = scipy.fft.ifft(waves, axis=-2, overwrite_x=True, workers=threads)
    return found


def multiply_columns(
    waves: Waves, length: int | None, multiply: Callable[[Waves, slice], Waves], out: Waves | None = None
) -> None:
    """Transform each column, padded with zeros to `length`, multiply it, transform it back and cut it.

    Parameters
    ----------
    waves
        The waves of all rows, shape (nx, ny), or of several fields, (k, nx, ny).
    length
        Number of waves of a column; None of columns that are transformed already.
    multiply
        Function of the waves of some columns, shape (length, n) or (k, length, n), and of their slice. It returns the
        product; of several fields, any number. It may overwrite waves that are transformed here.
    out
        Where the products go, `waves` by default.
    """
    target = waves if out is None else out

    def work(block: slice) -> None:
        columns: Waves = waves[..., block]
        if length is not None:
            columns = scipy.fft.fft(columns, n=length, axis=-2)
        products = multiply(columns, block)
        target[..., block] = scipy.fft.ifft(products, axis=-2, overwrite_x=True)[..., : target.shape[-2], :]

    map_tiles(work, split(waves.shape[-1], _COLUMN_BLOCK_BYTES // waves.itemsize))


def transform_rows_back(waves: Waves, length: int, count: int, out: RealArray | None = None) -> RealArray:
    """Return the first `count` values of each row of `length`, in `out` if given; the waves may be overwritten."""
    if count == length and out is None:
        whole = scipy.fft.irfft(waves, n=length, axis=1, overwrite_x=True, workers=threads_for(2 * waves.size))
        return np.asarray(whole)
    values = np.empty((waves.shape[0], count), dtype=waves.real.dtype) if out is None else out

    def work(rows: slice) -> None:
        values[rows] = scipy.fft.irfft(waves[rows], n=length, axis=1, overwrite_x=True)[:, :count]

    map_tiles(work, split(waves.shape[0], max(1, _ROW_BLOCK_VALUES // length)))
    return values


def multiply_waves(values: RealArray, symbol: RealArray, padded: tuple[int, int]) -> RealArray:
    """Return a field, padded with zeros, with each of its waves multiplied by a real symbol, shape of `values`."""
    waves = _multiply_columns(transform_rows(values, padded[1]), symbol, padded[0])
    return transform_rows_back(waves, padded[1], values.shape[1])


def multiply_waves_of_rows(values: RealArray, rows: IntArray, symbol: RealArray, padded: tuple[int, int]) -> RealArray:
    """Return `multiply_waves` of a field that is zero outside some rows, on these rows; zero elsewhere."""
    found = transform_rows(values[rows], padded[1])
    waves: Waves = np.zeros((values.shape[0], found.shape[1]), dtype=found.dtype)
    waves[rows] = found
    del found
    waves = _multiply_columns(waves, symbol, padded[0])
    product = np.zeros_like(values)
    product[rows] = transform_rows_back(waves[rows], padded[1], values.shape[1])
    return product


def _multiply_columns(waves: Waves, symbol: RealArray, length: int) -> Waves:
    """Return waves along y times the symbol of all waves; columns are padded to a length."""
    if symbol.size >= _MIN_COLUMNWISE_WAVES:
        multiply_columns(waves, length, lambda columns, block: np.multiply(columns, symbol[:, block], out=columns))
        return waves
    # Two one-dimensional transforms are twice as fast as scipy's two-dimensional inverse.
    rows = waves.shape[0]
    waves = transform_columns(waves, length)
    waves *= symbol
    return transform_columns_back(waves)[:rows]


def transform_extended(values: RealArray, length: int, odd: bool, axis: int = 0) -> RealArray:
    """Return the transform along an axis of the even or odd extension to `length`: its only part."""
    n = values.shape[axis]
    shape = list(values.shape)
    if length % 2 == 0 and n <= length // 2 + (not odd):
        # The cosine transform needs half of the extension, the sine transform half without its ends, which are zero.
        shape[axis] = length // 2 + 1
        half = values
        if n < shape[axis]:
            half = np.zeros(shape, dtype=values.dtype)
            np.moveaxis(half, axis, 0)[:n] = np.moveaxis(values, axis, 0)
        workers = threads_for(half.size)
        if not odd:
            return np.asarray(scipy.fft.dct(half, type=1, axis=axis, overwrite_x=half is not values, workers=workers))
        inner = (slice(None),) * axis + (slice(1, -1),)
        if length > 2:
            half[inner] = -scipy.fft.dst(half[inner], type=1, axis=axis, workers=workers)
        np.moveaxis(half, axis, 0)[0] = 0.0
        return half
    shape[axis] = length
    extended = np.zeros(shape, dtype=values.dtype)
    ahead = np.moveaxis(extended, axis, 0)
    given = np.moveaxis(values, axis, 0)
    ahead[:n] = given
    ahead[length - n + 1 :] = -given[:0:-1] if odd else given[:0:-1]
    waves = scipy.fft.rfft(extended, axis=axis, workers=threads_for(extended.size))
    return np.ascontiguousarray(waves.imag if odd else waves.real)


def transform_offsets(
    coefficients: RealArray, padded: tuple[int, int], odd: tuple[bool, bool] = (False, False)
) -> RealArray:
    """Return the transform of coefficients that are even or odd in x and in y, on a padded grid.

    Shape (mx // 2 + 1, my // 2 + 1). Odd in one axis it is imaginary, and its imaginary part is returned.
    """
    values = transform_extended(transform_extended(coefficients, padded[1], odd[1], axis=1), padded[0], odd[0])
    return -values if all(odd) else values


def half_waves(shape: tuple[int, int], spacing: Pair) -> tuple[Array, Array]:
    """Return the wave numbers from zero up along both axes of a grid, shapes (nx // 2 + 1, 1) and (1, ny // 2 + 1)."""
    qx, qy = (2 * np.pi / step * np.asarray(scipy.fft.rfftfreq(n)) for n, step in zip(shape, spacing, strict=True))
    return qx[:, np.newaxis], qy[np.newaxis, :]


def list_all_waves(half: RealArray, length: int, odd: bool = False) -> RealArray:
    """Return the factors of all `length` waves along x, of which those from zero up are given."""
    rows = np.arange(length)
    mirrored = rows > length // 2
    values: RealArray = half[np.where(mirrored, length - rows, rows)]
    if odd:
        values[mirrored] *= -1.0
    return values


@guarded
def padded_shape(grid: Grid, boundary: Boundary) -> tuple[int, int]:
    """Return the cells of the grid, along free axes at least 2n - 1 of them, as many as are fast for real transforms.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rc.typing.padded_shape(rc.Grid((32, 24), 1e-3), rc.Boundary.FREE_PERIODIC)
    (64, 24)
    """
    sizes = zip(grid.shape, boundary.free_axes, strict=True)
    mx, my = (scipy.fft.next_fast_len(2 * n - 1, real=True) if free else n for n, free in sizes)
    return mx, my
