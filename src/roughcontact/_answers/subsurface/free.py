"""Stress below a load on a free domain: tables of Love's and Cerruti's cells, transformed by their parity."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import attrs
import numpy as np
import scipy.fft

from roughcontact._answers.subsurface.field import (
    COMPONENTS,
    EXCHANGED_COMPONENTS,
    LoadedPlanes,
    is_odd,
)
from roughcontact._base.arrays import Pair, RealArray, Waves
from roughcontact._base.machine import map_tiles, split, threads_for

# Values of a table that are computed at a time.
_TILE_VALUES = 2**16
# Columns that are multiplied and transformed at a time, and rows: few enough for the cache.
_COLUMNS_PER_TILE = 32
_ROWS_PER_TILE = 64
# Square of the depth over the area of a cell above which the corners of a cell cancel too much for float32.
_MAX_FLOAT32_DEPTH_SQUARE = 256.0


def cell_stress(
    z: float, poisson: float, shape: tuple[int, int], sides: Pair, dtype: type[Any], load: str = "z"
) -> RealArray:
    r"""Return the stress by a unit load on one cell, tension positive, shape (6, nx, ny), in the order `COMPONENTS`.

    With the corners :math:`X = x \pm a, Y = y \pm b` of the cell seen from the point, :math:`R^2 = X^2 + Y^2 + z^2`,
    :math:`V = -\arctan(XY / zR)` and :math:`C = \arctan(Y/X) - \arctan(zY / XR)`, a pressure gives

    .. math:: 2\pi\sigma_{xx} = \sum \pm [2\nu V - (1 - 2\nu) C - z V_{xx}], \quad
              2\pi\sigma_{zz} = \sum \pm [V + z (V_{xx} + V_{yy})], \ldots

    and a traction along x, by integration of Cerruti's point force,

    .. math:: 2\pi\sigma_{xx} &= \sum \pm \left[2\ln(R + Y) + \frac{2\nu Y}{R + z} + \frac{zY}{R(R + z)}
              - \frac{z^2 Y}{R (X^2 + z^2)}\right], \\
              2\pi\sigma_{xy} &= \sum \pm \left[\ln(R + X) - \frac{2\nu X}{R + z} - \frac{zX}{R(R + z)}\right], \quad
              2\pi\sigma_{xz} = \sum \pm \left[V + \frac{zXY}{R (X^2 + z^2)}\right], \ldots

    Parameters
    ----------
    z
        Depth, in sides of a cell along x.
    poisson
        Poisson's ratio of the body.
    shape
        Offsets (nx, ny) of the point from the centre of the cell: 0 .. nx-1 cells along x, 0 .. ny-1 along y.
    sides
        Sides of the cell.
    dtype
        Precision of the table: float32 or float64.
    load
        ``"z"``, a pressure, or ``"x"`` or ``"y"``, a traction along this axis.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009;
    Johnson, Contact Mechanics (1985), sec. 3.6, https://doi.org/10.1017/CBO9781139171731
    """
    if load == "y":
        exchanged = cell_stress(z, poisson, shape[::-1], sides[::-1], dtype, "x")
        return np.ascontiguousarray(exchanged[EXCHANGED_COMPONENTS].transpose(0, 2, 1))
    # One corner more than there are cells, from half a cell before the centre of the first cell.
    x = ((np.arange(shape[0] + 1) - 0.5) * sides[0]).astype(dtype)[:, np.newaxis]
    y = ((np.arange(shape[1] + 1) - 0.5) * sides[1]).astype(dtype)[np.newaxis, :]
    table = np.empty((len(COMPONENTS), *shape), dtype=dtype)
    sum_corners = _sum_corners if load == "z" else _sum_shear_corners

    def work(rows: slice) -> None:
        for place, corners in enumerate(sum_corners(x[rows.start : rows.stop + 1], y, dtype(z), poisson)):
            across = np.subtract(corners[1:], corners[:-1])
            np.subtract(across[:, 1:], across[:, :-1], out=table[place, rows])

    map_tiles(work, split(shape[0], max(1, _TILE_VALUES // shape[1])))
    return table


def _sum_corners(x: RealArray, y: RealArray, z: Any, poisson: float) -> tuple[RealArray, ...]:
    """Return the terms of a corner under pressure for each component, without those of x or of y alone."""
    scale = 0.5 / math.pi
    shear = 1.0 - 2.0 * poisson
    xx = x * x
    yy = y * y
    xy = x * y
    square = xx + yy
    r = np.sqrt(square + z * z)
    # At the surface the quotient is infinite and its arc tangent a right angle.
    with np.errstate(divide="ignore", over="ignore"):
        v = np.arctan(xy / (z * r))
    beyond = r + z
    # The difference of both arc tangents as one of them, R - z without cancellation.
    c = np.arctan(xy * (square / beyond) / (xx * r + z * yy))
    along_x = 1.0 / (r * (xx + z * z))
    along_y = 1.0 / (r * (yy + z * z))
    bend_x = (z * scale) * xy * along_x
    bend_y = (z * scale) * xy * along_y
    v *= scale
    c *= scale * shear
    # V_xx + V_yy and both C together follow from Laplace's equation.
    return (
        bend_x - 2.0 * poisson * v - c,
        bend_y - v + c,
        -(v + bend_x + bend_y),
        (z * z * scale) * x * along_y,
        (z * z * scale) * y * along_x,
        -scale * (shear * np.log(beyond) + z / r),
    )


def _sum_shear_corners(x: RealArray, y: RealArray, z: Any, poisson: float) -> tuple[RealArray, ...]:
    """Return the terms of a corner under traction along x for each component, without those of x or of y alone."""
    scale = 0.5 / math.pi
    xx = x * x
    yy = y * y
    depth = z * z
    r = np.sqrt(xx + yy + depth)
    with np.errstate(divide="ignore", over="ignore"):
        v = np.arctan(x * y / (z * r))
    along_x = scale * z / (r * (xx + depth))
    beyond = r + z
    bend = scale * z / (r * beyond)
    lateral = scale * 2.0 * poisson / beyond
    # ln(R + Y) without its part in X, odd in Y; ln(R + X) likewise.
    log_y = scale * np.arcsinh(y / np.sqrt(xx + depth))
    log_x = scale * np.arcsinh(x / np.sqrt(yy + depth))
    return (
        2.0 * log_y + y * (lateral + bend - z * along_x),
        2.0 * poisson * log_y - y * (lateral + bend),
        z * y * along_x,
        -scale * z / r,
        x * y * along_x - scale * v,
        log_x - x * (lateral + bend),
    )


@attrs.frozen(eq=False)
class FreePlanes(LoadedPlanes):
    """The stress below a free domain, by linear convolution on a padded grid, as the displacement by `DCFFT`.

    Attributes
    ----------
    common
        The largest steps along x and y for which `at` is called.
    """

    common: tuple[int, int] = (1, 1)

    @cached_property
    def padded(self) -> tuple[int, int]:
        """Cells of the padded grid, even multiples of the largest steps."""
        mx, my = (
            2 * step * scipy.fft.next_fast_len(-(-n // step), real=True)
            for n, step in zip(self.pressure.shape, self.common, strict=True)
        )
        return mx, my

    def add(
        self, stress: RealArray, load: str, waves: Waves, shape: tuple[int, int], sides: Pair, z: float, poisson: float
    ) -> None:
        mx, my = shape
        precision = np.float64 if z * z > _MAX_FLOAT32_DEPTH_SQUARE * sides[0] * sides[1] else np.float32
        offsets = mx // 2 + 1, my // 2 + 1
        tables = cell_stress(z, poisson, offsets, sides, precision, load).astype(np.float32)
        if self.layers is not None:
            tables += self.layers.find_table(load, offsets, sides, z).astype(np.float32)
        kept = stress.shape[1], stress.shape[2]
        for place, (component, table) in enumerate(zip(COMPONENTS, tables, strict=True)):
            odd = is_odd("x", component, load), is_odd("y", component, load)
            stress[place] += _multiply(waves, _transform(table, *odd), *odd, kept, my)


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

    map_tiles(transform_columns, split(waves.shape[1], _COLUMNS_PER_TILE))
    map_tiles(transform_rows, split(shape[0], _ROWS_PER_TILE))
    return field
