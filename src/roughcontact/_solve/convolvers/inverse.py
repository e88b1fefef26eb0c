"""The approximate inverse of a convolution: division by the spectrum of its kernel on a periodic grid."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._base.arrays import (
    IntArray,
    RealArray,
    matrix_product,
)
from roughcontact._base.machine import map_tiles, tiles_of
from roughcontact._base.units import outlined
from roughcontact._solve.convolvers.transforms import multiply_waves, multiply_waves_of_rows

# Minimum amplitude that is inverted, over the mean: smaller ones are rounding, or ringing of the kernel.
_MIN_AMPLITUDE = 1e-6


@attrs.frozen(eq=False)
class InverseConvolution:
    """Division by the kernel's spectrum on a periodic grid: a good preconditioner, not an exact inverse.

    A subclass for another kind of array overrides `multiply`; one for parts of arrays `long_waves`, `blocks` and
    `add_near` too.

    Attributes
    ----------
    local
        Whether its effect on a few cells is cheaper by `coefficients` than by a product.
    by_rows
        Whether `multiply` saves work where few rows are not zero.
    stiffness
        Pressure amplitude per displacement amplitude of each wave, not negative, zero for the mean,
        shape (mx, my // 2 + 1).
    padded
        Cells (mx, my) of the periodic grid.
    exact
        Whether it inverts the convolution, but for the mean.
    """

    local: ClassVar[bool] = True
    by_rows: ClassVar[bool] = True

    stiffness: RealArray = attrs.field(repr=outlined)
    padded: tuple[int, int]
    exact: bool = False

    @cached_property
    def axes(self) -> tuple[RealArray, RealArray]:
        """The stiffness of the waves along x and along y, arrays of numpy."""
        return self.stiffness[: self.padded[0] // 2 + 1, 0], self.stiffness[0]

    def long_waves(self, rows: IntArray, columns: int) -> RealArray:
        """Return the stiffness of some waves along x and of the first ones along y."""
        found: RealArray = self.stiffness[rows][:, :columns]
        return found

    def blocks(self, active: Any, partition: Any) -> Any:
        """Return active cells by blocks of a partition, which sum vectors and spread values."""
        return active.blocks(partition)

    def apply(self, displacement: RealArray) -> RealArray:
        """Return the pressure, of the shape and precision of `displacement` (float32 or float64)."""
        return self.multiply(displacement, self.stiffness, self.padded)

    def multiply(
        self, values: RealArray, symbol: RealArray, padded: tuple[int, int], rows: IntArray | None = None
    ) -> RealArray:
        """Return a field with each of its waves multiplied by a real symbol, shape of `values`.

        Parameters
        ----------
        values
            A field, which is padded with zeros, shape (nx, ny).
        symbol
            The factors, in its precision, shape (mx, my // 2 + 1).
        padded
            Cells (mx, my) of the periodic grid.
        rows
            Rows outside which the field is zero and the result is arbitrary; None for all rows.
        """
        if rows is None:
            return multiply_waves(values, symbol, padded)
        return multiply_waves_of_rows(values, rows, symbol, padded)

    def coefficients(self, reach: int, first: int = 0) -> RealArray:
        """Return the pressure at (i, j) cells from a unit displacement of one, shape (reach + 1, reach + 1).

        The part of it due to the waves along y from the first one on for which there is a stiffness.
        """
        mx, my = self.padded
        columns = np.arange(first, first + self.stiffness.shape[1])
        offsets = 2.0 * np.pi * np.arange(reach + 1)
        x = np.cos(np.outer(offsets, np.arange(mx) / mx)).astype(self.stiffness.dtype) / mx
        y = np.cos(np.outer(columns / my, offsets)).astype(self.stiffness.dtype) / my
        # Half of the waves along y are stored; each counts twice, except the first and, if even, the last.
        y[(columns > 0) & (2 * columns < my)] *= 2.0
        return matrix_product(matrix_product(x, self.stiffness), y)

    def add_near(
        self, field: RealArray, shape: tuple[int, int], cells: IntArray, amounts: RealArray, stencil: RealArray
    ) -> None:
        """Add amounts times a stencil, as of `coefficients`, around cells of a flat field, in place."""
        nx, ny = shape
        padded = self.padded
        # On a small periodic grid a cell is reached once.
        reach = tuple(min(n - 1, (m - 1) // 2) for n, m in zip(stencil.shape, padded, strict=True))
        rows, columns = np.divmod(cells, ny)
        far = (np.minimum(rows, nx - 1 - rows) >= reach[0]) & (np.minimum(columns, ny - 1 - columns) >= reach[1])
        inner = cells[far]
        inner_amounts = amounts[far]
        near = ~far
        rows = rows[near]
        columns = columns[near]
        near_amounts = amounts[near]
        for i, j in itertools.product(*(range(-n, n + 1) for n in reach)):
            value = stencil[abs(i), abs(j)]
            field[inner + (i * ny + j)] += value * inner_amounts
            if near_amounts.size:
                row = (rows + i) % padded[0]
                column = (columns + j) % padded[1]
                inside = (row < nx) & (column < ny)
                field[row[inside] * ny + column[inside]] += value * near_amounts[inside]


def invert_response(
    response: RealArray,
    dtype: npt.DTypeLike,
    size: int,
    across: Callable[[np.ufunc, float], float] = lambda _, value: value,
    *,
    has_mean: bool = True,
) -> tuple[RealArray, bool]:
    """Return the stiffness of waves from their response, zero for the mean, and whether a response was too small.

    Parameters
    ----------
    response
        The response of all waves, or of those of a part that has some of the columns.
    dtype
        Type of the stiffness.
    size
        Number of waves of all parts.
    across
        Function of a ufunc and a number of this part that returns the sum or the minimum over all parts.
    has_mean
        Whether the first wave is the mean.
    """
    tiles = tiles_of(response)

    def measure(rows: slice) -> tuple[float, float]:
        return _measure_response(response[rows], is_first=has_mean and rows.start == 0)

    sums, minima = zip(*map_tiles(measure, tiles), strict=True)
    floor = _MIN_AMPLITUDE * (across(np.add, math.fsum(sums)) / size)
    raised = not across(np.minimum, min(minima)) > floor
    stiffness = np.empty(response.shape, dtype=dtype)

    def invert(rows: slice) -> None:
        amplitude = np.abs(response[rows])
        vanishing = amplitude == 0.0
        np.divide(1.0, np.maximum(amplitude, floor, out=amplitude), out=stiffness[rows], casting="same_kind")
        stiffness[rows][vanishing] = 0.0

    map_tiles(invert, tiles)
    if has_mean:
        stiffness[0, 0] = 0.0
    return stiffness, raised


def _measure_response(rows: RealArray, *, is_first: bool) -> tuple[float, float]:
    """Return the sum of the amplitudes in rows, and the minimum, without the mean wave, which is the first of all."""
    values = rows.ravel()[1 if is_first else 0 :]
    return float(np.abs(values).sum()), float(values.min(initial=math.inf))
