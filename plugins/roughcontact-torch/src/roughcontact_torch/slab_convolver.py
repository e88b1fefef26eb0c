"""Convolution by FFT on slabs of several devices: rows at home, a transpose, columns, and back."""

from __future__ import annotations

from typing import Any, ClassVar, cast

import attrs
import numpy as np
import roughcontact as rc
import torch
from roughcontact.slabs import SlabConvolver, multiply_on_slabs, stiffness_on_slabs
from roughcontact.solving import halve_shape
from roughcontact.typing import (
    Array,
    ConvolutionSetup,
    InverseConvolution,
    PreparedConvolution,
    RealArray,
)

from roughcontact_torch.arrays import TensorArray
from roughcontact_torch.convolver import TensorConvolution, TorchFFT, of_all_rows
from roughcontact_torch.masked_grid import STENCIL_REACH, MaskedGrid
from roughcontact_torch.processes import Processes
from roughcontact_torch.slab_arrays import SlabTensor
from roughcontact_torch.slab_grid import SlabGrid, WholeGrid

# Cells below which each process has the whole of a coarse grid.
_WHOLE_CELLS = 256**2


class SlabTorchFFT(SlabConvolver):
    """Multiplication in Fourier space on tensors, each process with its rows and columns."""

    def convolve(self, setup: ConvolutionSetup, symbol: torch.Tensor, padded: tuple[int, int]) -> PreparedConvolution:
        """Return the convolution by the columns of this process of the symbol."""
        return SlabConvolution(setup, of_all_rows(symbol, padded), padded, self.processes)


@attrs.frozen(eq=False)
class SlabConvolution(TensorConvolution):
    """Transform, multiply by the real symbol, transform back, on slabs.

    Attributes
    ----------
    symbol
        The factors of the columns of this process.
    processes
        The processes.
    """

    serves_default: ClassVar[bool] = False

    processes: Processes

    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement, an array in slabs as the pressure."""
        field = cast(SlabTensor, cast(Any, pressure))
        found = multiply_on_slabs(
            self.processes, field.tensor, field.shape[0], lambda part: self.symbol[:, part], self.padded
        )
        return self._array(found)

    def on(self, grid: rc.Grid) -> PreparedConvolution:
        """Return the convolution on a coarser grid, of a small one on each process."""
        if grid.cells >= _WHOLE_CELLS:
            return super().on(grid)
        setup = self.setup
        convolver = TorchFFT(self.processes.device.type)
        whole = cast(TensorConvolution, convolver.prepare(setup.kernel, grid, setup.boundary))
        return WholeConvolution(whole.setup, whole.symbol, whole.padded, self.processes, setup.grid.shape[0])

    def inverse(self, dtype: type[np.float32] | type[np.float64] = np.float64) -> InverseConvolution:
        """Return the columns of this process of the approximate inverse, an array of numpy."""
        return InverseConvolution(stiffness_on_slabs(self.setup, self.processes, dtype)[0], self.setup.inverse_shape)

    def grid(self) -> MaskedGrid:
        """Return what the masked descent needs of it."""
        processes = self.processes
        padded = self.setup.inverse_shape
        stiffness, _, axes = stiffness_on_slabs(self.setup, processes, np.float32)
        first = processes.own_columns(padded[1] // 2 + 1).start
        quarter = processes.total(InverseConvolution(stiffness, padded).coefficients(STENCIL_REACH, first))
        offsets = np.abs(np.arange(-STENCIL_REACH, STENCIL_REACH + 1))
        shape = self.setup.grid.shape
        half = halve_shape(shape)
        is_last = half != shape and half[0] * half[1] < _WHOLE_CELLS
        parts = processes.place(stiffness), axes, processes.place(quarter[np.ix_(offsets, offsets)])
        return self._make_grid(SlabGrid, padded, *parts, processes=processes, is_last=is_last)

    def from_numpy(self, values: Array) -> Array:
        """Return an array in slabs as it is."""
        return values

    def to_numpy(self, values: Array) -> Array:
        """Return an array in slabs of the rows of this process: nothing is gathered."""
        return self._array(cast(Any, values).tensor)

    def _array(self, tensor: torch.Tensor) -> Any:
        return SlabTensor.field(TensorArray(tensor), self.processes, self.setup.grid.shape[0])


@attrs.frozen(eq=False)
class WholeConvolution(TensorConvolution):
    """The convolution on a coarse grid of which each process has the whole.

    Attributes
    ----------
    processes
        The processes.
    finer
        Rows of the next finer grid, if that is in slabs; else None.
    """

    processes: Processes
    finer: int | None

    def on(self, grid: rc.Grid) -> PreparedConvolution:
        """Return the convolution on a coarser grid."""
        coarse = cast(TensorConvolution, super().on(grid))
        return WholeConvolution(coarse.setup, coarse.symbol, coarse.padded, self.processes, None)

    def grid(self) -> MaskedGrid:
        """Return what the masked descent needs of it."""
        grid = super().grid()
        parts = {field.name: getattr(grid, field.name) for field in attrs.fields(MaskedGrid)}
        return WholeGrid(**parts, processes=self.processes, finer=self.finer)
