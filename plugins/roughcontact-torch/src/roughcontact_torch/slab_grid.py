"""The masked descent on slabs: each process has some rows of a grid, or the whole of a small coarse one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import cast

import attrs
import torch
from roughcontact.slabs import multiply_on_slabs

from roughcontact_torch.masked_grid import Axes, Blocks, MaskedGrid, interpolate, repeat, widen
from roughcontact_torch.processes import Processes


@attrs.frozen(eq=False)
class SlabBlocks(Blocks):
    """Blocks of which each process has those parts that lie on its rows."""

    processes: Processes

    def sums(self, field: torch.Tensor) -> torch.Tensor:
        """Return the sums of fields over each block and all processes."""
        return self.processes.reduce(super().sums(field))


@attrs.frozen(eq=False)
class SlabGrid(MaskedGrid):
    """A grid of which each process has some rows of a field, and some columns of the symbol and its inverse.

    Attributes
    ----------
    processes
        The processes.
    is_last
        Whether each process has the whole of the next coarser grid.
    """

    processes: Processes
    is_last: bool

    @property
    def part(self) -> Axes:
        """Cells that fields have on this process."""
        own = self.processes.own_rows(self.shape[0])
        return own.stop - own.start, self.shape[1]

    def total(self, values: torch.Tensor) -> torch.Tensor:
        """Return the sum over the cells of each contact, in float64."""
        return self.processes.reduce(super().total(values))

    def totals(self, values: Iterable[torch.Tensor]) -> tuple[torch.Tensor, ...]:
        """Return `total` of several fields, by one sum over processes."""
        own = torch.stack([MaskedGrid.total(self, one) for one in values])
        return torch.unbind(self.processes.reduce(own))

    def highest(self, values: torch.Tensor) -> torch.Tensor:
        """Return the maximum over the cells of each contact."""
        return self.processes.reduce(super().highest(values), "highest")

    def lowest(self, values: torch.Tensor) -> torch.Tensor:
        """Return the minimum over the cells of each contact."""
        return self.processes.reduce(super().lowest(values), "lowest")

    def read(self, *numbers: torch.Tensor) -> list[list[float]]:
        """Return numbers of each contact, those of the first process: all must do the same."""
        return super().read(*self.processes.publish(torch.stack(numbers)))

    def multiply_waves(self, values: torch.Tensor, symbol: torch.Tensor, padded: Axes) -> torch.Tensor:
        """Return fields, padded with zeros, with each of their waves multiplied by a real symbol."""
        processes = self.processes
        found = [multiply_on_slabs(processes, one, self.shape[0], lambda k: symbol[:, k], padded) for one in values]
        return torch.stack(found)

    def widen(self, values: torch.Tensor, reach: int, *, periodic: bool) -> torch.Tensor:
        """Return fields with rows before and behind: those of other processes, or zeros."""
        # Those of a coarser grid are fewer.
        count = self.shape[0] * values.shape[-2] // self.part[0]
        return torch.stack([self.processes.widen(one, count, reach, periodic=periodic) for one in values])

    def blocks(self, mean: float) -> Blocks:
        """Return the blocks that resolve the long waves where weights have this mean over the padded grid."""
        whole = super().blocks(mean)
        rows = whole.rows[self.processes.own_rows(self.shape[0])]
        return SlabBlocks(whole.count, whole.size, rows, whole.columns, whole.stiffness, whole.beyond, self.processes)

    def long_waves(self, waves: torch.Tensor, columns: int) -> torch.Tensor:
        """Return the inverse for some waves along x and the first ones along y, on each process."""
        own = self.processes.own_columns(self.inverse_padded[1] // 2 + 1)
        found = self.stiffness.new_zeros(waves.shape[0], columns)
        mine = super().long_waves(waves, max(columns - own.start, 0))
        found[:, own.start : own.start + mine.shape[1]] = mine
        return self.processes.reduce(found)

    def repeat(self, coarse: torch.Tensor) -> torch.Tensor:
        """Return values of a coarser grid on each of their cells."""
        if not self.is_last:
            return super().repeat(coarse)
        return self._own(repeat(self.processes.publish(coarse), self.shape))

    def interpolate(self, coarse: torch.Tensor) -> torch.Tensor:
        """Interpolate values of a coarser grid."""
        if not self.is_last:
            return super().interpolate(coarse)
        return self._own(interpolate(self.processes.publish(coarse), self.shape, widen))

    def _own(self, whole: torch.Tensor) -> torch.Tensor:
        return whole[..., self.processes.own_rows(self.shape[0]), :]


@attrs.frozen(eq=False)
class WholeGrid(MaskedGrid):
    """A coarse grid of which each process has the whole: it is too small to be worth what processes would send.

    Attributes
    ----------
    processes
        The processes.
    finer
        Rows of the next finer grid, if that is in slabs; else None.
    """

    processes: Processes
    finer: int | None

    def read(self, *numbers: torch.Tensor) -> list[list[float]]:
        """Return numbers of each contact, those of the first process: all must do the same."""
        return super().read(*self.processes.publish(torch.stack(numbers)))

    def average(self, fine: torch.Tensor) -> torch.Tensor:
        """Return the means of the cells of a finer grid on this one, on each process."""
        if self.finer is None:
            return super().average(fine)
        return super().average(cast(torch.Tensor, self.processes.gather_rows(fine, self.finer)))
