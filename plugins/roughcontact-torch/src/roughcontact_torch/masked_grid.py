"""The operators of the masked descent on one grid: products, sums, blocks, and the step between grids.

All tensors have a leading axis, one entry for each contact that is solved at once; numbers of contacts keep two axes of
length one. No function here reads a number of a tensor.
"""

from __future__ import annotations

from functools import cached_property
from typing import cast

import attrs
import numpy as np
import torch
import torch.nn.functional as functional

from roughcontact_torch.convolver import TensorConvolution, TensorInverse

# Cut between long and short waves over the wave whose stiffness is the mean weight, the resolution of blocks over it,
# the maximum exponent in the cut, and the limits of blocks, as in the preconditioner of the default solver.
_LONG_WAVE_CUT = 3.0
_BLOCK_RESOLUTION = 1.5
_MAX_EXPONENT = 30.0
_MAX_BLOCK_CELLS = 64
_MIN_BLOCKS = 8
# Cells of the stencil to each side of a cell that joins or leaves.
_STENCIL_REACH = 3

Axes = tuple[int, int]
_FLOAT32 = np.float32


def total(values: torch.Tensor) -> torch.Tensor:
    """Return the sum over the cells of each contact, in float64."""
    return values.sum((-2, -1), keepdim=True, dtype=torch.float64)


def dot(one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
    """Return the product of two fields of each contact, in float64."""
    return total(one * other)


def highest(values: torch.Tensor) -> torch.Tensor:
    """Return the maximum over the cells of each contact."""
    return values.amax((-2, -1), keepdim=True)


def lowest(values: torch.Tensor) -> torch.Tensor:
    """Return the minimum over the cells of each contact."""
    return values.amin((-2, -1), keepdim=True)


def divide(one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
    """Return the ratio where the divisor is above zero, zero elsewhere."""
    positive = other > 0.0
    return torch.where(positive, one / torch.where(positive, other, 1.0), 0.0)


def multiply_waves(values: torch.Tensor, symbol: torch.Tensor, padded: Axes) -> torch.Tensor:
    """Return fields, padded with zeros, with each of their waves multiplied by a real symbol."""
    waves = torch.fft.rfft2(values, s=padded)
    waves = waves * symbol
    return torch.fft.irfft2(waves, s=padded)[..., : values.shape[-2], : values.shape[-1]]


@attrs.frozen(eq=False)
class Blocks:
    """A division of the cells of a padded grid into rectangles of nearly equal size."""

    count: Axes
    padded: Axes
    rows: torch.Tensor
    columns: torch.Tensor
    far: torch.Tensor
    mean: float

    @classmethod
    def of(cls, grid: MaskedGrid, mean: float) -> Blocks:
        """Return the blocks that resolve the long waves where weights have this mean over the padded grid."""
        inverse = grid.inverse
        mx, my = inverse.padded
        bx, by = (_count_blocks(axis, m, mean) for axis, m in zip(inverse.axes, inverse.padded, strict=True))
        device = grid.stiffness.device
        rows, columns = (
            (torch.arange(n, device=device) * b).div(m, rounding_mode="floor")
            for n, b, m in zip(grid.shape, (bx, by), (mx, my), strict=True)
        )
        half = torch.fft.fftfreq(bx, 1.0 / bx, device=device).to(torch.int64) % mx
        stiffness = grid.stiffness[half][:, : by // 2 + 1]
        growth = torch.clamp((stiffness / (_LONG_WAVE_CUT * mean)) ** 2, max=_MAX_EXPONENT)
        size = mx * my / (bx * by)
        return cls((bx, by), (mx, my), rows, columns, stiffness * torch.exp(growth) * size, size * mean)

    def sums(self, field: torch.Tensor) -> torch.Tensor:
        """Return the sums of fields over each block."""
        summed = field
        for axis, numbers, count in ((-2, self.rows, self.count[0]), (-1, self.columns, self.count[1])):
            shape = list(summed.shape)
            shape[axis] = count
            summed = torch.zeros(shape, dtype=field.dtype, device=field.device).index_add(axis, numbers, summed)
        return summed

    def spread(self, values: torch.Tensor) -> torch.Tensor:
        """Return fields with the value of its block on each cell."""
        return values.index_select(-2, self.rows).index_select(-1, self.columns)

    def approximate(self, values: torch.Tensor) -> torch.Tensor:
        """Apply the inverse of the far part and the mean weight to values of blocks."""
        return multiply_waves(values, 1.0 / (self.far + self.mean), self.count)


def _count_blocks(stiffness: object, count: int, mean: float) -> int:
    """Return the number of blocks along an axis: few, but enough for all long waves."""
    axis = cast("list[float]", stiffness)
    size = 1
    while 2 * size <= _MAX_BLOCK_CELLS and count // (2 * size) >= _MIN_BLOCKS:
        if float(axis[max(count // (4 * size), 1)]) < _BLOCK_RESOLUTION * _LONG_WAVE_CUT * mean:
            break
        size *= 2
    return max(count // size, 1)


@attrs.frozen(eq=False)
class MaskedGrid:
    """A grid, the convolution on it and its approximate inverse."""

    shape: Axes
    padded: Axes
    free: tuple[bool, bool]
    symbol: torch.Tensor
    symbol_float32: torch.Tensor
    stiffness: torch.Tensor
    inverse: TensorInverse
    stencil: torch.Tensor

    @classmethod
    def of(cls, convolution: TensorConvolution) -> MaskedGrid:
        """Return what the descent needs of a prepared convolution."""
        inverse = cast(TensorInverse, convolution.inverse(dtype=_FLOAT32))
        stiffness = inverse.stiffness.tensor
        offsets = torch.arange(-_STENCIL_REACH, _STENCIL_REACH + 1, device=stiffness.device)
        response = torch.fft.irfft2(stiffness, s=inverse.padded)
        for axis, count in enumerate(inverse.padded):
            response = response.index_select(axis, offsets % count)
        setup = convolution.setup
        return cls(
            shape=setup.grid.shape,
            padded=convolution.padded,
            free=setup.boundary.free_axes,
            symbol=convolution.symbol,
            symbol_float32=convolution.symbol_float32,
            stiffness=stiffness,
            inverse=inverse,
            stencil=response,
        )

    def displace(self, pressure: torch.Tensor) -> torch.Tensor:
        """Return the displacement by pressures, in their precision."""
        symbol = self.symbol_float32 if pressure.dtype == torch.float32 else self.symbol
        return multiply_waves(pressure, symbol, self.padded)

    def invert(self, displacement: torch.Tensor) -> torch.Tensor:
        """Return approximately the pressures that cause displacements, float32."""
        return multiply_waves(displacement, self.stiffness, self.inverse.padded)

    def invert_near(self, displacement: torch.Tensor) -> torch.Tensor:
        """Return `invert` up to three cells from each displacement."""
        reach = _STENCIL_REACH
        values = displacement[:, None]
        before, after = (0 if free else reach for free in self.free)
        # Along a free axis there are zeros beyond the border.
        values = functional.pad(values, (after, after, before, before), mode="circular")
        beyond = [reach if free else 0 for free in self.free]
        return functional.conv2d(values, self.stencil[None, None], padding=beyond)[:, 0]

    @cached_property
    def takes_stencil(self) -> bool:
        """Whether the stencil reaches no cell twice."""
        return min(self.shape) > 2 * _STENCIL_REACH
