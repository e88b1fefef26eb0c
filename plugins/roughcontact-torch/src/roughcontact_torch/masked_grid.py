"""One grid of the masked descent: reductions, products, sums over blocks, and the steps to other grids.

Fields have a leading axis, one entry for each contact that is solved at once; numbers of contacts keep two axes of
length one. No method reads a number of a tensor. Whatever needs cells of another place goes through the methods of
`MaskedGrid` and `Blocks`: a field of which each process holds a part needs other ones of these alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import attrs
import roughcontact as rc
import torch
import torch.nn.functional as functional
from roughcontact.solving import LONG_WAVE_CUT, MAX_CUT_EXPONENT, count_blocks

# Cells of the stencil to each side of a cell that joins or leaves.
STENCIL_REACH = 3

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
        growth = torch.clamp((self.stiffness / (LONG_WAVE_CUT * mean)) ** 2, max=MAX_CUT_EXPONENT)
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

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    @property
    def part(self) -> Axes:
        """Cells that fields have here."""
        return self.shape

    @property
    def takes_stencil(self) -> bool:
        """Whether the stencil reaches no cell twice."""
        return min(self.shape) > 2 * STENCIL_REACH

    def total(self, values: torch.Tensor) -> torch.Tensor:
        """Return the sum over the cells of each contact, in float64."""
        return values.sum((-2, -1), keepdim=True, dtype=torch.float64)

    def totals(self, values: Iterable[torch.Tensor]) -> tuple[torch.Tensor, ...]:
        """Return `total` of several fields, by one sum over processes."""
        return tuple(self.total(one) for one in values)

    def ratio(self, one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
        """Return the total of a field over that of another one, zero where this is not above zero."""
        return divide(*self.totals((one, other)))

    def mean(self, values: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
        """Return the weighted mean over the cells of each contact, zero without weights."""
        return self.ratio(weights.to(torch.float64) * values, weights)

    def dots(self, *pairs: tuple[torch.Tensor, torch.Tensor]) -> tuple[torch.Tensor, ...]:
        """Return `dot` of several pairs, by one sum over processes."""
        return self.totals(one.to(torch.float64) * other for one, other in pairs)

    def dot(self, one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
        """Return the product of two fields of each contact, in float64: float32 loses products of small numbers."""
        return self.total(one.to(torch.float64) * other)

    def highest(self, values: torch.Tensor) -> torch.Tensor:
        """Return the maximum over the cells of each contact."""
        return values.amax((-2, -1), keepdim=True)

    def lowest(self, values: torch.Tensor) -> torch.Tensor:
        """Return the minimum over the cells of each contact."""
        return values.amin((-2, -1), keepdim=True)

    def read(self, *numbers: torch.Tensor) -> list[list[float]]:
        """Return numbers of each contact; the host waits for them."""
        found: list[list[float]] = torch.stack(numbers).flatten(1).tolist()
        return found

    def multiply_waves(self, values: torch.Tensor, symbol: torch.Tensor, padded: Axes) -> torch.Tensor:
        """Return fields, padded with zeros, with each of their waves multiplied by a real symbol."""
        return multiply_waves(values, symbol, padded)

    def widen(self, values: torch.Tensor, reach: int, *, periodic: bool) -> torch.Tensor:
        """Return fields with rows before and behind; see the function."""
        return widen(values, reach, periodic=periodic)

    def displace(self, pressure: torch.Tensor) -> torch.Tensor:
        """Return the displacement by pressures, in their precision."""
        symbol = self.symbol_float32 if pressure.dtype == torch.float32 else self.symbol
        return self.multiply_waves(pressure, symbol, self.padded)

    def invert(self, displacement: torch.Tensor) -> torch.Tensor:
        """Return approximately the pressures that cause displacements, float32."""
        return self.multiply_waves(displacement, self.stiffness, self.inverse_padded)

    def close(self, initial_gap: torch.Tensor, mean: torch.Tensor) -> torch.Tensor | None:
        """Return the pressures of a mean, in float64, that close every gap; None if the boundary is not periodic."""
        if self.boundary is not rc.Boundary.PERIODIC:
            return None
        inverse = divide(torch.ones_like(self.symbol), self.symbol)
        return mean - self.multiply_waves(initial_gap, inverse, self.padded)

    def invert_near(self, displacement: torch.Tensor) -> torch.Tensor:
        """Return `invert` up to three cells from each displacement."""
        reach = STENCIL_REACH
        # Along a free axis there are zeros beyond the border.
        x, y = (not free for free in self.boundary.free_axes)
        values = widen(self.widen(displacement, reach, periodic=x), reach, periodic=y, axis=-1)
        return functional.conv2d(values[:, None], self.stencil[None, None])[:, 0]

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
        stiffness = self.long_waves(waves, by // 2 + 1)
        beyond = stiffness - self._stencil_waves(waves, by // 2 + 1)
        return Blocks((bx, by), mx * my / (bx * by), rows, columns, stiffness, beyond)

    def long_waves(self, waves: torch.Tensor, columns: int) -> torch.Tensor:
        """Return the inverse for some waves along x and the first ones along y."""
        return self.stiffness.index_select(0, waves)[:, :columns]

    def _stencil_waves(self, waves: torch.Tensor, columns: int) -> torch.Tensor:
        """Return the stencil for some waves along x and the first ones along y, float32."""
        device = waves.device
        offsets = torch.arange(-STENCIL_REACH, STENCIL_REACH + 1, device=device)
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
        return repeat(coarse, self.part)

    def interpolate(self, coarse: torch.Tensor) -> torch.Tensor:
        """Interpolate values of a coarser grid; see the function."""
        return interpolate(coarse, self.part, self.widen)

    def average(self, fine: torch.Tensor) -> torch.Tensor:
        """Return the means of the cells of a finer grid on this one."""
        if fine.shape[-2] > self.part[0]:
            fine = 0.5 * (fine[..., 0::2, :] + fine[..., 1::2, :])
        if fine.shape[-1] > self.part[1]:
            fine = 0.5 * (fine[..., 0::2] + fine[..., 1::2])
        return fine


def repeat(coarse: torch.Tensor, cells: Axes) -> torch.Tensor:
    """Return values on each of their cells of a finer grid."""
    for axis in _halved(coarse, cells):
        coarse = coarse.repeat_interleave(2, axis)
    return coarse


def interpolate(coarse: torch.Tensor, cells: Axes, widen: Callable[..., torch.Tensor]) -> torch.Tensor:
    """Interpolate by parabolas through three cell centres along the axes that were halved; the values repeat."""
    for axis in _halved(coarse, cells):
        if axis == -1:
            before = coarse.roll(1, axis)
            after = coarse.roll(-1, axis)
        else:
            wide = widen(coarse, 1, periodic=True)
            before = wide[..., :-2, :]
            after = wide[..., 2:, :]
        first = 0.9375 * coarse + 0.15625 * before - 0.09375 * after
        second = 0.9375 * coarse + 0.15625 * after - 0.09375 * before
        # A new last place, or one before the last axis, lies right behind the halved axis.
        coarse = torch.stack((first, second), -1 if axis == -1 else -2).flatten(axis - 1, axis)
    return coarse


def widen(values: torch.Tensor, reach: int, *, periodic: bool, axis: int = -2) -> torch.Tensor:
    """Return fields with cells before and behind along an axis: those of the other end, or zeros."""
    if not periodic:
        return functional.pad(values, (0, 0) * (-1 - axis) + (reach, reach))
    before = values.narrow(axis, values.shape[axis] - reach, reach)
    return torch.cat((before, values, values.narrow(axis, 0, reach)), axis)


def _halved(coarse: torch.Tensor, cells: Axes) -> list[int]:
    """Return the axes along which a grid has fewer cells than another one."""
    return [axis for axis in (-2, -1) if cells[axis] > coarse.shape[axis]]
