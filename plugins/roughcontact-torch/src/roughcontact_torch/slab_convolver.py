"""Convolution by FFT on slabs of several devices: rows at home, a transpose, columns, and back."""

from __future__ import annotations

from typing import Any, ClassVar, cast

import attrs
import numpy as np
import roughcontact as rc
import torch
from roughcontact.solving import halve_shape
from roughcontact.typing import (
    Array,
    BoundKernel,
    ConvolutionSetup,
    InverseConvolution,
    PreparedConvolution,
    RealArray,
    SupportsSpectrum,
    padded_shape,
)

from roughcontact_torch.convolver import TensorConvolution, TorchFFT, extend_evenly
from roughcontact_torch.masked_grid import STENCIL_REACH, MaskedGrid
from roughcontact_torch.processes import Processes
from roughcontact_torch.slab_arrays import SlabTensor
from roughcontact_torch.slab_grid import SlabGrid, Transpose, WholeGrid, multiply_waves_on_slabs

# Cells below which each process has the whole of a coarse grid.
_WHOLE_CELLS = 256**2


@attrs.frozen(eq=False)
class SlabTorchFFT(rc.Convolver):
    """Multiplication in Fourier space, each process with its rows and columns, on any boundary but a wrapped one.

    Parameters
    ----------
    processes
        The processes.
    """

    processes: Processes

    boundaries = frozenset(rc.Boundary) - {rc.Boundary.WRAPPED}

    def require(self, kernel: rc.InfluenceKernel, boundary: rc.Boundary) -> None:
        """Raise `InputError` if it cannot treat the boundary, or the kernel lacks a form that is needed."""
        if boundary not in self.boundaries:
            raise rc.InputError.about("The boundary on slabs", str(boundary), "'free' or 'periodic', or a pair of them")
        super().require(kernel, boundary)
        if not isinstance(kernel, SupportsSpectrum):
            raise rc.InputError(f"The kernel {kernel!r} has no spectrum, which a contact on slabs needs.")

    def transform_shape(self, grid: rc.Grid, boundary: rc.Boundary) -> tuple[int, int]:
        """Return the cells of the padded grid; see `roughcontact.typing.padded_shape`."""
        return padded_shape(grid, boundary)

    def prepare(self, kernel: BoundKernel, grid: rc.Grid, boundary: rc.Boundary) -> PreparedConvolution:
        """Return the convolution on slabs."""
        setup = ConvolutionSetup(self, kernel, grid, boundary)
        padded = self.transform_shape(grid, boundary)
        if boundary is rc.Boundary.PERIODIC:
            waves = setup.spectrum_of_columns(padded, self.processes.own_columns(padded[1] // 2 + 1))
            symbol = torch.tensor(waves, device=self.processes.device)
        elif boundary.mixed:
            symbol = _mixed_symbol_of_columns(setup, padded, self.processes)
        else:
            symbol = _free_symbol_of_columns(setup, padded, self.processes)
        return SlabConvolution(setup, symbol, padded, self.processes)


def _free_symbol_of_columns(setup: ConvolutionSetup, padded: tuple[int, int], processes: Processes) -> torch.Tensor:
    """Return the columns of this process of the transform of the coefficients, shape (mx, n)."""
    nx, ny = setup.grid.shape
    own = processes.own_rows(nx)
    coefficients = setup.kernel.coefficients((own.stop - own.start, ny), setup.grid.spacing, own.start)
    half = _transform(torch.tensor(coefficients, device=processes.device), padded[1], 1)
    transpose = Transpose(processes, processes.rows(nx), processes.columns(padded[1] // 2 + 1))
    return extend_evenly(_transform(transpose.forward(half[None])[0], padded[0], 0), padded[0], 0)


def _mixed_symbol_of_columns(setup: ConvolutionSetup, padded: tuple[int, int], processes: Processes) -> torch.Tensor:
    """Return `_free_symbol_of_columns` where one axis is periodic."""
    free = setup.boundary.free_axis
    offsets = padded[free] // 2 + 1
    waves = padded[1 - free] // 2 + 1
    own = processes.own_columns(waves)
    found = setup.kernel.mixed_coefficients(setup.grid, setup.boundary, offsets=offsets, part=own)
    values = _transform(torch.tensor(found, device=processes.device), padded[free], free)
    if free == 1:
        # Each process has some of the waves along x, and then of those along y.
        values = Transpose(processes, processes.columns(waves), processes.columns(offsets)).forward(values[None])[0]
    return extend_evenly(values, padded[0], 0)


def _transform(values: torch.Tensor, length: int, axis: int) -> torch.Tensor:
    """Return the transform along an axis of the even extension of values to a length."""
    return torch.fft.rfft(extend_evenly(values, length, axis), dim=axis).real


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
        found = multiply_waves_on_slabs(self.processes, field.rows, field.tensor[None], self.symbol, self.padded)
        return self._array(found[0])

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
        shape = self.setup.inverse_shape
        own = self.processes.own_columns(shape[1] // 2 + 1)
        return InverseConvolution(self.setup.stiffness_of_columns(own, dtype, self.processes.across)[0], shape)

    def grid(self) -> MaskedGrid:
        """Return what the masked descent needs of it."""
        inverse = self.inverse(np.float32)
        mx, my = inverse.padded
        own = self.processes.own_columns(my // 2 + 1)
        top = np.zeros(my // 2 + 1, dtype=np.float32)
        top[own] = inverse.stiffness[0]
        first = inverse.stiffness[: mx // 2 + 1, 0] if own.start == 0 else np.zeros(mx // 2 + 1, dtype=np.float32)
        axes = self.processes.total(first), self.processes.total(top)
        quarter = self.processes.total(inverse.coefficients(STENCIL_REACH, own.start))
        offsets = np.abs(np.arange(-STENCIL_REACH, STENCIL_REACH + 1))
        shape = self.setup.grid.shape
        half = halve_shape(shape)
        device = self.processes.device
        return SlabGrid(
            shape=shape,
            padded=self.padded,
            inverse_padded=inverse.padded,
            boundary=self.setup.boundary,
            symbol=self.symbol,
            symbol_float32=self.symbol_float32,
            stiffness=torch.tensor(inverse.stiffness, device=device),
            axes=axes,
            stencil=torch.tensor(quarter[np.ix_(offsets, offsets)], device=device),
            processes=self.processes,
            is_last=half != shape and half[0] * half[1] < _WHOLE_CELLS,
        )

    def from_numpy(self, values: Array) -> Array:
        """Return an array in slabs as it is."""
        return values

    def to_numpy(self, values: Array) -> Array:
        """Return an array in slabs of the rows of this process: nothing is gathered."""
        return self._array(cast(Any, values).tensor)

    def _array(self, tensor: torch.Tensor) -> Any:
        return SlabTensor(tensor, self.processes, self.setup.grid.shape[0])


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
