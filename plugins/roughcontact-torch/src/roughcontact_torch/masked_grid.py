"""One grid of the masked descent: reductions, products, sums over blocks, and the steps to other grids.

Fields have a leading axis, one entry for each contact that is solved at once; numbers of contacts keep two axes of
length one. No method reads a number of a tensor. Whatever needs cells of another place goes through the methods of
`MaskedGrid` and `Blocks`: a field of which each process holds a part needs other ones of these alone.
"""

from __future__ import annotations

import math
from typing import Any, cast

import attrs
import numpy as np
import roughcontact as rc
import torch
import torch.nn.functional as functional
from roughcontact.typing import PreparedConvolution, count_blocks, halve_shape

from roughcontact_torch.convolver import TensorConvolution

# Cut between long and short waves over the wave whose stiffness is the mean weight, and the maximum exponent in it, as
# in the preconditioner of the default solver.
_LONG_WAVE_CUT = 3.0
_MAX_EXPONENT = 30.0
# Cells of the stencil to each side of a cell that joins or leaves.
_STENCIL_REACH = 3

Axes = tuple[int, int]


def divide(one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
    """Return the ratio where the divisor is above zero, zero elsewhere."""
    return torch.where(other > 0.0, one / other, 0.0)


def multiply_waves(values: torch.Tensor, symbol: torch.Tensor, padded: Axes) -> torch.Tensor:
    """Return fields, padded with zeros, with each of their waves multiplied by a real symbol."""
    waves = torch.fft.rfft2(values, s=padded)
    waves *= symbol
    return torch.fft.irfft2(waves, s=padded)[..., : values.shape[-2], : values.shape[-1]]


@attrs.frozen(eq=False)
class Blocks:
    """A division of the cells of a padded grid into rectangles of nearly equal size.

    Attributes
    ----------
    count
        Blocks along both axes.
    size
        Cells of a block.
    rows, columns
        The number of the block of each row and of each column.
    stiffness
        The inverse kernel for the waves of the blocks.
    beyond
        The part of it beyond the stencil.
    """

    count: Axes
    size: float
    rows: torch.Tensor
    columns: torch.Tensor
    stiffness: torch.Tensor
    beyond: torch.Tensor

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

    def far_symbol(self, mean: torch.Tensor) -> torch.Tensor:
        """Return the stiffness of the far part of the kernel on the blocks, at a mean of the weights over all cells."""
        growth = torch.clamp((self.stiffness / (_LONG_WAVE_CUT * mean)) ** 2, max=_MAX_EXPONENT)
        return self.stiffness * torch.exp(growth) * self.size

    def invert_far(self, displacement: torch.Tensor) -> torch.Tensor:
        """Return what `MaskedGrid.invert` adds to `MaskedGrid.invert_near`, about: constant on each block."""
        return self.spread(self.multiply(self.sums(displacement) / self.size, self.beyond))

    def multiply(self, values: torch.Tensor, symbol: torch.Tensor) -> torch.Tensor:
        """Return values of blocks with each of their waves multiplied by a real symbol."""
        return multiply_waves(values, symbol, self.count)


@attrs.frozen(eq=False)
class MaskedGrid:
    """A grid, the convolution on it and its approximate inverse.

    Attributes
    ----------
    shape, padded, inverse_padded
        Cells of the grid, of the convolution and of its inverse.
    boundary
        Its boundary.
    symbol, symbol_float32, stiffness
        The convolution in both precisions, and its inverse in float32.
    axes
        The inverse for waves along both axes, on the host.
    stencil
        The inverse near a cell.
    """

    shape: Axes
    padded: Axes
    inverse_padded: Axes
    boundary: rc.Boundary
    symbol: torch.Tensor
    symbol_float32: torch.Tensor
    stiffness: torch.Tensor
    axes: tuple[Any, Any]
    stencil: torch.Tensor

    @classmethod
    def of(cls, convolution: TensorConvolution) -> MaskedGrid:
        """Return what the descent needs of a prepared convolution."""
        # Arrays of numpy, which the host need not read back.
        inverse = PreparedConvolution.inverse(convolution, np.float32)
        stiffness = cast(Any, convolution.from_numpy(cast(Any, inverse.stiffness))).tensor
        offsets = torch.arange(-_STENCIL_REACH, _STENCIL_REACH + 1, device=stiffness.device)
        stencil = torch.fft.irfft2(stiffness, s=inverse.padded)
        for axis, count in enumerate(inverse.padded):
            stencil = stencil.index_select(axis, offsets % count)
        setup = convolution.setup
        return cls(
            shape=setup.grid.shape,
            padded=convolution.padded,
            inverse_padded=inverse.padded,
            boundary=setup.boundary,
            symbol=convolution.symbol,
            symbol_float32=convolution.symbol_float32,
            stiffness=stiffness,
            axes=inverse.axes,
            stencil=stencil,
        )

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    @property
    def takes_stencil(self) -> bool:
        """Whether the stencil reaches no cell twice."""
        return min(self.shape) > 2 * _STENCIL_REACH

    def total(self, values: torch.Tensor) -> torch.Tensor:
        """Return the sum over the cells of each contact, in float64."""
        return values.sum((-2, -1), keepdim=True, dtype=torch.float64)

    def dot(self, one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
        """Return the product of two fields of each contact, in float64: float32 loses products of small numbers."""
        return self.total(one.to(torch.float64) * other)

    def highest(self, values: torch.Tensor) -> torch.Tensor:
        """Return the maximum over the cells of each contact."""
        return values.amax((-2, -1), keepdim=True)

    def lowest(self, values: torch.Tensor) -> torch.Tensor:
        """Return the minimum over the cells of each contact."""
        return values.amin((-2, -1), keepdim=True)

    def displace(self, pressure: torch.Tensor) -> torch.Tensor:
        """Return the displacement by pressures, in their precision."""
        symbol = self.symbol_float32 if pressure.dtype == torch.float32 else self.symbol
        return multiply_waves(pressure, symbol, self.padded)

    def invert(self, displacement: torch.Tensor) -> torch.Tensor:
        """Return approximately the pressures that cause displacements, float32."""
        return multiply_waves(displacement, self.stiffness, self.inverse_padded)

    def close(self, initial_gap: torch.Tensor, mean: torch.Tensor) -> torch.Tensor | None:
        """Return the pressures of a mean, in float64, that close every gap; None if the boundary is not periodic."""
        if self.boundary is not rc.Boundary.PERIODIC:
            return None
        return mean - multiply_waves(initial_gap, divide(torch.ones_like(self.symbol), self.symbol), self.padded)

    def invert_near(self, displacement: torch.Tensor) -> torch.Tensor:
        """Return `invert` up to three cells from each displacement."""
        reach = _STENCIL_REACH
        before, after = (0 if free else reach for free in self.boundary.free_axes)
        values = functional.pad(displacement[:, None], (after, after, before, before), mode="circular")
        # Along a free axis there are zeros beyond the border.
        beyond = [reach if free else 0 for free in self.boundary.free_axes]
        return functional.conv2d(values, self.stencil[None, None], padding=beyond)[:, 0]

    def mean_weight(self, weights: torch.Tensor) -> torch.Tensor:
        """Return the mean of weights over the cells of the padded grid."""
        return self.total(weights) / (self.inverse_padded[0] * self.inverse_padded[1])

    def blocks(self, mean: float) -> Blocks:
        """Return the blocks that resolve the long waves where weights have this mean over the padded grid."""
        bx, by = (count_blocks(axis, m, mean) for axis, m in zip(self.axes, self.inverse_padded, strict=True))
        mx, my = self.inverse_padded
        device = self.stiffness.device
        rows, columns = (
            (torch.arange(n, device=device) * b).div(m, rounding_mode="floor")
            for n, b, m in zip(self.shape, (bx, by), (mx, my), strict=True)
        )
        waves = torch.arange(bx, device=device)
        waves = torch.where(waves < (bx + 1) // 2, waves, waves - bx) % mx
        stiffness = self.stiffness.index_select(0, waves)[:, : by // 2 + 1]
        beyond = stiffness - self._stencil_waves(waves, by // 2 + 1)
        return Blocks((bx, by), mx * my / (bx * by), rows, columns, stiffness, beyond)

    def _stencil_waves(self, waves: torch.Tensor, columns: int) -> torch.Tensor:
        """Return the stencil for some waves along x and the first ones along y, float32."""
        device = waves.device
        offsets = torch.arange(-_STENCIL_REACH, _STENCIL_REACH + 1, device=device)
        numbers = (waves, torch.arange(columns, device=device))
        x, y = (
            (k[:, None] * offsets).to(torch.float64) * (2.0 * math.pi / count)
            for k, count in zip(numbers, self.inverse_padded, strict=True)
        )
        stencil = self.stencil.to(torch.float64)
        even = x.cos() @ stencil @ y.cos().mT
        return (even - x.sin() @ stencil @ y.sin().mT).to(torch.float32)

    def repeat(self, coarse: torch.Tensor) -> torch.Tensor:
        """Return values of a coarser grid on each of their cells."""
        for axis in self._halved(coarse):
            coarse = coarse.repeat_interleave(2, axis)
        return coarse

    def interpolate(self, coarse: torch.Tensor) -> torch.Tensor:
        """Interpolate by parabolas through three cell centres along the axes that were halved; the values repeat."""
        for axis in self._halved(coarse):
            before = coarse.roll(1, axis)
            after = coarse.roll(-1, axis)
            first = 0.9375 * coarse + 0.15625 * before - 0.09375 * after
            second = 0.9375 * coarse + 0.15625 * after - 0.09375 * before
            # A new last place, or one before the last axis, lies right behind the halved axis.
            coarse = torch.stack((first, second), -1 if axis == -1 else -2).flatten(axis - 1, axis)
        return coarse

    def average(self, fine: torch.Tensor) -> torch.Tensor:
        """Return the means of the cells of a finer grid on this one."""
        if fine.shape[-2] > self.shape[0]:
            fine = 0.5 * (fine[..., 0::2, :] + fine[..., 1::2, :])
        if fine.shape[-1] > self.shape[1]:
            fine = 0.5 * (fine[..., 0::2] + fine[..., 1::2])
        return fine

    def _halved(self, coarse: torch.Tensor) -> list[int]:
        """Return the axes along which another grid has fewer cells."""
        return [axis for axis in (-2, -1) if self.shape[axis] > coarse.shape[axis]]


def nested_grids(convolution: TensorConvolution) -> tuple[MaskedGrid, ...]:
    """Return the grid of a convolution and all coarser ones, from fine to coarse: even and long axes are halved."""
    grids = [MaskedGrid.of(convolution)]
    size = convolution.setup.grid.size
    while True:
        shape = grids[-1].shape
        half = halve_shape(shape)
        if half == shape:
            return tuple(grids)
        coarse = convolution.on(rc.Grid(half, size))
        grids.append(MaskedGrid.of(cast(TensorConvolution, coarse)))
