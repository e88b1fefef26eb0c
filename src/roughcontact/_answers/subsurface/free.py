"""Stress below a domain beyond which nothing lies: tables of Love's cells, transformed by their parity."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np
import scipy.fft

from roughcontact._answers.subsurface.cells import COMPONENTS, ODD_IN_X, ODD_IN_Y, Depth, cell_stress
from roughcontact._answers.subsurface.planes import StressPlanes, coarsen
from roughcontact._base.checks import Pair, RealArray, Waves
from roughcontact._base.machine import map_tiles, split, threads_for

# Columns that are multiplied and transformed at a time, and rows: few enough for the cache.
_COLUMNS = 32
_ROWS = 64
# Square of the depth over the area of a cell from which the corners of a cell cancel too much for float32.
_FAR = 256.0


@attrs.frozen(eq=False)
class FreePlanes(StressPlanes):
    """Linear convolution on a padded grid, as `DCFFT` does for displacements.

    Attributes
    ----------
    pressure
        Pressure on the cells, float32, shape (nx, ny).
    sides
        Sides of a cell.
    common
        The largest steps that will be asked for.
    """

    pressure: RealArray
    sides: Pair
    common: tuple[int, int]

    @cached_property
    def padded(self) -> tuple[int, int]:
        """Cells of the padded grid, even multiples of the largest steps."""
        mx, my = (
            2 * step * scipy.fft.next_fast_len(-(-n // step), real=True)
            for n, step in zip(self.pressure.shape, self.common, strict=True)
        )
        return mx, my

    @cached_property
    def waves(self) -> Waves:
        """The waves of the padded pressure, shape (mx, my // 2 + 1)."""
        workers = threads_for(self.padded[0] * self.padded[1])
        rows = scipy.fft.rfft(self.pressure, n=self.padded[1], axis=1, workers=workers)
        return np.asarray(scipy.fft.fft(rows, n=self.padded[0], axis=0, overwrite_x=True, workers=workers))

    def at(self, z: float, poisson: float, steps: tuple[int, int]) -> RealArray:
        mx, my = (length // step for length, step in zip(self.padded, steps, strict=True))
        nx, ny = (n // step for n, step in zip(self.pressure.shape, steps, strict=True))
        sides = steps[0] * self.sides[0], steps[1] * self.sides[1]
        waves = coarsen(coarsen(self.waves, self.padded[1], steps[1], 1), self.padded[0], steps[0], 0)
        precision = np.float64 if z * z > _FAR * sides[0] * sides[1] else np.float32
        tables = cell_stress(Depth(z, poisson), (mx // 2 + 1, my // 2 + 1), sides, precision).astype(np.float32)
        stress = np.empty((len(COMPONENTS), nx, ny), dtype=np.float32)
        for place, table in enumerate(tables):
            symbol = _transform(table, ODD_IN_X[place], ODD_IN_Y[place])
            stress[place] = _multiply(waves, symbol, ODD_IN_X[place], ODD_IN_Y[place], (nx, ny), my)
        return stress


def _transform(table: RealArray, odd_in_x: bool, odd_in_y: bool) -> RealArray:
    """Return the real symbol of the table's extension by parity, shape (mx // 2 + 1, my // 2 + 1).

    An axis along which the table is odd lacks the factor -i.
    """
    for axis, odd in ((1, odd_in_y), (0, odd_in_x)):
        workers = threads_for(table.size)
        if not odd:
            table = scipy.fft.dct(table, type=1, axis=axis, overwrite_x=True, workers=workers)
            continue
        # Both ends of an odd table are zero.
        inner = (slice(None), slice(1, -1)) if axis else (slice(1, -1), slice(None))
        symbol = np.zeros_like(table)
        if table.shape[axis] > 2:
            symbol[inner] = scipy.fft.dst(table[inner], type=1, axis=axis, workers=workers)
        table = symbol
    return table


def _multiply(
    waves: Waves, symbol: RealArray, odd_in_x: bool, odd_in_y: bool, shape: tuple[int, int], length: int
) -> RealArray:
    """Return the field of the product of waves and symbol, its first cells only."""
    mx = waves.shape[0]
    half = symbol.shape[0]
    factor = np.array((1.0, -1j, -1.0)[odd_in_x + odd_in_y], dtype=waves.dtype)[()]
    mirrored = -factor if odd_in_x else factor
    kept = np.empty((shape[0], waves.shape[1]), dtype=waves.dtype)
    field = np.empty(shape, dtype=symbol.dtype)

    def transform_columns(block: slice) -> None:
        columns = np.empty((mx, block.stop - block.start), dtype=waves.dtype)
        np.multiply(waves[:half, block], symbol[:, block] * factor, out=columns[:half])
        np.multiply(waves[half:, block], symbol[mx - half : 0 : -1, block] * mirrored, out=columns[half:])
        kept[:, block] = scipy.fft.ifft(columns, axis=0, overwrite_x=True)[: shape[0]]

    def transform_rows(rows: slice) -> None:
        field[rows] = scipy.fft.irfft(kept[rows], n=length, axis=1, overwrite_x=True)[:, : shape[1]]

    map_tiles(transform_columns, split(waves.shape[1], _COLUMNS))
    map_tiles(transform_rows, split(shape[0], _ROWS))
    return field
