"""Convolution by FFT inside compiled code."""

from __future__ import annotations

from functools import cached_property

import attrs
import numba
import numpy as np
import roughcontact as rc
import scipy.fft
from numba import njit
from roughcontact.typing import (
    BoundKernel,
    ConvolutionSetup,
    FieldPasses,
    IntArray,
    InverseConvolution,
    PreparedConvolution,
    RealArray,
    ShearConvolution,
    padded_shape,
)

from roughcontact_numba.passes import CompiledPasses


# rocket-fft gives compiled code the transforms of scipy.fft, by the same library.
@njit(cache=True, nogil=True)
def _multiply(values, symbol, mx, my):  # type: ignore[no-untyped-def]
    """Return a field, padded with zeros to (mx, my), with each of its waves multiplied by a real symbol.

    The symbol has all rows of waves, or those from zero up.
    """
    nx, ny = values.shape
    waves = scipy.fft.rfft(values, my, 1)
    waves = scipy.fft.fft(waves, mx, 0, None, True)
    for i in range(mx):
        row = i if i < symbol.shape[0] else mx - i
        for j in range(waves.shape[1]):
            waves[i, j] *= symbol[row, j]
    waves = scipy.fft.ifft(waves, mx, 0, None, True)
    product = scipy.fft.irfft(waves[:nx], my, 1, None, True)
    return product if ny == my else product[:, :ny].copy()


@njit(cache=True, nogil=True)
def _add_near(field, cells, amounts, stencil, mx, my):  # type: ignore[no-untyped-def]
    nx, ny = field.shape
    # On a small periodic grid a cell is reached once.
    rows = min(stencil.shape[0] - 1, (mx - 1) // 2)
    columns = min(stencil.shape[1] - 1, (my - 1) // 2)
    for k in range(cells.size):
        row, column = divmod(cells[k], ny)
        for i in range(-rows, rows + 1):
            x = (row + i) % mx
            if x < nx:
                for j in range(-columns, columns + 1):
                    y = (column + j) % my
                    if y < ny:
                        field[x, y] += stencil[abs(i), abs(j)] * amounts[k]


@attrs.frozen
class CompiledFFT(rc.Convolver):
    """Multiplication in Fourier space, and the passes of a descent on small grids, compiled by numba.

    On free, periodic and mixed boundaries; ``"auto"`` chooses it on grids on which it is faster.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), convolver="compiled")
    >>> print(problem.solve(force=1.2).area())
    (778.331 +- 0.023) µm2, (7.78331 +- 0.00023) % of nominal [blend]
    """

    boundaries = frozenset(rc.Boundary) - {rc.Boundary.WRAPPED}

    def __str__(self) -> str:
        return f"{self!r}: products and passes compiled by numba {numba.__version__}"

    def transform_shape(self, grid: rc.Grid, boundary: rc.Boundary) -> tuple[int, int]:
        """Return the cells of the padded grid; see `roughcontact.typing.padded_shape`."""
        return padded_shape(grid, boundary)

    def prepare(self, kernel: BoundKernel, grid: rc.Grid, boundary: rc.Boundary) -> PreparedConvolution:
        """Return the convolution of a kernel on a grid; see `Convolver.prepare`."""
        setup = ConvolutionSetup(self, kernel, grid, boundary)
        inner = rc.CircularFFT() if boundary is rc.Boundary.PERIODIC else rc.DCFFT()
        return CompiledConvolution(setup, inner.prepare(kernel, grid, boundary))


@attrs.frozen(eq=False)
class CompiledInverse(InverseConvolution):
    """The approximate inverse, compiled."""

    def multiply(
        self, values: RealArray, symbol: RealArray, padded: tuple[int, int], rows: IntArray | None = None
    ) -> RealArray:
        """Return a field with each of its waves multiplied by a symbol; see `InverseConvolution.multiply`."""
        return _multiply(values, symbol, *padded)

    def add_near(
        self, field: RealArray, shape: tuple[int, int], cells: IntArray, amounts: RealArray, stencil: RealArray
    ) -> None:
        """Add amounts times a stencil around cells; see `InverseConvolution.add_near`."""
        _add_near(field.reshape(shape), cells, amounts, stencil, *self.padded)


@attrs.frozen(eq=False)
class CompiledConvolution(PreparedConvolution):
    """Transform, multiply and transform back in one compiled call."""

    setup: ConvolutionSetup
    inner: PreparedConvolution

    @property
    def passes(self) -> type[FieldPasses]:
        """The compiled passes."""
        return CompiledPasses

    @cached_property
    def padded(self) -> tuple[int, int]:
        """The cells of the padded grid."""
        return padded_shape(self.setup.grid, self.setup.boundary)

    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement by a pressure; see `PreparedConvolution.apply`."""
        symbol = self.inner.symbol_like(pressure)  # type: ignore[attr-defined]
        return _multiply(np.ascontiguousarray(pressure), symbol, *self.padded)

    def inverse(self, dtype: type[np.float32] | type[np.float64] = np.float64) -> InverseConvolution:
        """Return the approximate inverse, compiled."""
        found = self.inner.inverse(dtype)
        return CompiledInverse(found.stiffness, found.padded, found.exact)

    def shear(self) -> ShearConvolution:
        """Return the map from shear, that of numpy."""
        return self.inner.shear()
