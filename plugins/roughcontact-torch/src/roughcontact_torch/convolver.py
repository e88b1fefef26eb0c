"""Convolution by FFT on tensors."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any, ClassVar, cast

import attrs
import numpy as np
import roughcontact as rc
import torch
from roughcontact.slabs import make_random_rows, multiply_on_slabs, symbol_of_columns
from roughcontact.solving import halve_shape
from roughcontact.typing import (
    Array,
    BoundKernel,
    ConvolutionSetup,
    IntArray,
    InverseConvolution,
    PreparedConvolution,
    RealArray,
    ShearConvolution,
    padded_shape,
)

from roughcontact_torch.arrays import TensorArray
from roughcontact_torch.kinds import Tensors, torch_dtype
from roughcontact_torch.masked_grid import STENCIL_REACH, MaskedGrid

_DEVICES = ("auto", "cpu", "cuda")


def _device_name(value: object) -> str:
    if value not in _DEVICES:
        raise rc.InputError.about("The device of the tensors", value, " or ".join(f"'{name}'" for name in _DEVICES))
    return str(value)


@attrs.frozen
class TorchFFT(rc.Convolver):
    """Multiplication in Fourier space by torch, on any boundary, on a processor or a GPU.

    The default solver then works on tensors of the device throughout; the solution has numpy's arrays, and its
    residuals are measured in float64 as always.

    Parameters
    ----------
    device
        ``"cpu"``, ``"cuda"``, or ``"auto"``: CUDA where torch finds it.
    """

    device: str = attrs.field(default="auto", converter=_device_name)

    boundaries = frozenset(rc.Boundary)

    def __str__(self) -> str:
        return f"{self!r}: tensors of torch {torch.__version__} on {self.place}"

    @property
    def place(self) -> torch.device:
        """The device of the tensors.

        Raises
        ------
        InputError
            If it is not there.
        """
        found = torch.cuda.is_available()
        if self.device == "cuda" and not found:
            raise rc.InputError("torch finds no CUDA device here: choose device='auto' or device='cpu'.")
        return torch.device("cuda" if found and self.device != "cpu" else "cpu")

    def require(self, kernel: rc.InfluenceKernel, boundary: rc.Boundary) -> None:
        """Raise `InputError` if the kernel lacks the form that is needed, or the device is not there."""
        super().require(kernel, boundary)
        _ = self.place

    def transform_shape(self, grid: rc.Grid, boundary: rc.Boundary) -> tuple[int, int]:
        """Return the cells of the padded grid; see `roughcontact.typing.padded_shape`."""
        return padded_shape(grid, boundary)

    def heights(self, surface: rc.Surface, grid: rc.Grid) -> Array:
        """Return the heights of a surface, m; those of `SelfAffineSurface` are transformed on the device."""
        if type(surface) is not rc.SelfAffineSurface:
            return surface.heights(grid)
        return cast(Array, make_random_rows(surface, grid, Tensors(self.place)).numpy(force=True))

    def prepare(self, kernel: BoundKernel, grid: rc.Grid, boundary: rc.Boundary) -> PreparedConvolution:
        """Return the convolution on tensors."""
        setup = ConvolutionSetup(self, kernel, grid, boundary)
        padded = self.transform_shape(grid, boundary)
        symbol = symbol_of_columns(setup, padded, Tensors(self.place))
        return TensorConvolution(setup, of_all_rows(symbol, padded), padded)


def of_all_rows(symbol: torch.Tensor, padded: tuple[int, int]) -> torch.Tensor:
    """Return a symbol of a padded grid with all its rows, from those of the waves from zero up, or all."""
    half = symbol.shape[0]
    return torch.cat((symbol, symbol[1 : padded[0] - half + 1].flip(0)))


def _multiply(values: torch.Tensor, symbol: torch.Tensor, padded: tuple[int, int]) -> torch.Tensor:
    """Return a field, padded with zeros, with each of its waves multiplied by a real symbol."""
    if values.shape == padded:
        waves = torch.fft.rfft2(values)
        waves *= symbol
        return torch.fft.irfft2(waves, s=padded)
    processes = Tensors(values.device)
    return multiply_on_slabs(processes, values, values.shape[0], lambda part: symbol[:, part], padded).contiguous()


@attrs.frozen(eq=False)
class TensorInverse(InverseConvolution):
    """The approximate inverse, on tensors."""

    # Kernels on a GPU are few and large, or their start takes the time.
    local = False
    by_rows = False

    @cached_property
    def axes(self) -> tuple[RealArray, RealArray]:
        """The stiffness along both axes on the host: single values of it are read often."""
        x = self._stiffness[: self.padded[0] // 2 + 1, 0]
        y = self._stiffness[0]
        return x.numpy(force=True), y.numpy(force=True)

    @property
    def _stiffness(self) -> torch.Tensor:
        return _tensor(self.stiffness)

    def multiply(
        self, values: RealArray, symbol: RealArray, padded: tuple[int, int], rows: IntArray | None = None
    ) -> RealArray:
        """Return a field with each of its waves multiplied by a symbol; see `InverseConvolution.multiply`."""
        return _array(_multiply(_tensor(values), _tensor(symbol), padded))


@attrs.frozen(eq=False)
class TensorConvolution(PreparedConvolution):
    """Transform, multiply by the real symbol, transform back, on tensors; numpy's arrays go there and come back."""

    # Whether the default solver can continue on its arrays.
    serves_default: ClassVar[bool] = True

    setup: ConvolutionSetup
    symbol: torch.Tensor
    padded: tuple[int, int]

    @cached_property
    def symbol_float32(self) -> torch.Tensor:
        """The symbol in float32."""
        return self.symbol.to(torch.float32)

    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement, an array of the kind of the pressure."""
        if isinstance(pressure, np.ndarray):
            return self.to_numpy(self.apply(self.from_numpy(pressure)))
        symbol = self.symbol_float32 if pressure.dtype == np.float32 else self.symbol
        return _array(_multiply(_tensor(pressure), symbol, self.padded))

    def inverse(self, dtype: type[np.float32] | type[np.float64] = np.float64) -> InverseConvolution:
        """Return the approximate inverse on tensors."""
        found = super().inverse(dtype)
        return TensorInverse(self.from_numpy(found.stiffness), found.padded, found.exact)

    def grid(self) -> MaskedGrid:
        """Return what the masked descent needs of it."""
        # Arrays of numpy, which the host need not read back.
        inverse = super().inverse(np.float32)
        stiffness = _tensor(self.from_numpy(inverse.stiffness))
        offsets = torch.arange(-STENCIL_REACH, STENCIL_REACH + 1, device=stiffness.device)
        stencil = torch.fft.irfft2(stiffness, s=inverse.padded)
        for axis, count in enumerate(inverse.padded):
            stencil = stencil.index_select(axis, offsets % count)
        return self._make_grid(MaskedGrid, inverse.padded, stiffness, inverse.axes, stencil)

    def _make_grid(
        self,
        kind: type[MaskedGrid],
        inverse_padded: tuple[int, int],
        stiffness: torch.Tensor,
        axes: tuple[RealArray, RealArray],
        stencil: torch.Tensor,
        **more: Any,
    ) -> MaskedGrid:
        return kind(
            shape=self.setup.grid.shape,
            padded=self.padded,
            inverse_padded=inverse_padded,
            boundary=self.setup.boundary,
            symbol=self.symbol,
            symbol_float32=self.symbol_float32,
            stiffness=stiffness,
            axes=axes,
            stencil=stencil,
            **more,
        )

    def nested_grids(self) -> tuple[MaskedGrid, ...]:
        """Return its grid and all coarser ones, from fine to coarse: even and long axes are halved."""
        grid = self.setup.grid
        half = halve_shape(grid.shape)
        if half == grid.shape:
            return (self.grid(),)
        coarse = cast(TensorConvolution, self.on(rc.Grid(half, grid.size)))
        return (self.grid(), *coarse.nested_grids())

    def on_host(self, grid: rc.Grid) -> PreparedConvolution:
        """Return the same convolution on a grid, on numpy's arrays."""
        setup = self.setup
        host = rc.DCFFT() if setup.boundary.has_free_axis else rc.CircularFFT()
        return host.prepare(setup.kernel, grid, setup.boundary)

    def shear(self) -> ShearConvolution:
        """Return the convolution of shear on the host: the solver of shear works on numpy's arrays."""
        return self.on_host(self.setup.grid).shear()

    @contextmanager
    def use_threads(self, count: int) -> Iterator[None]:
        """Let torch take so many threads of the processor, in this process, until the end."""
        before = torch.get_num_threads()
        torch.set_num_threads(count)
        try:
            yield
        finally:
            torch.set_num_threads(before)

    def from_numpy(self, values: Array) -> Array:
        """Return a copy on the device; tensors as they are."""
        if isinstance(values, TensorArray):
            return _array(values.tensor)
        return _array(torch.tensor(values, dtype=torch_dtype(values.dtype), device=self.symbol.device))

    def to_numpy(self, values: Array) -> Array:
        """Return the values on the host."""
        return cast(Array, _tensor(values).numpy(force=True))


def _array(tensor: torch.Tensor) -> Any:
    return TensorArray(tensor)


def _tensor(values: Any) -> torch.Tensor:
    return cast(torch.Tensor, values.tensor)
