"""The approximate inverse of a convolution, and the spectra and products of waves that it shares with others."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import attrs
import numpy as np
import numpy.typing as npt
import scipy.fft

from roughcontact._base.checks import Array, IntArray, Pair, RealArray, Waves
from roughcontact._base.machine import threads_for
from roughcontact._base.units import outlined
from roughcontact._parts.grid import Boundary
from roughcontact._parts.kernels import BoundKernel, SupportsSpectrum
from roughcontact._solve.convolvers.waves import multiply_columns, transform_rows, transform_rows_back

if TYPE_CHECKING:
    from roughcontact._solve.convolvers.base import ConvolutionSetup

# Sides of the padded grid of the inverse on a free boundary: at least this multiple of the domain's, and this
# many cells more, so that opposite borders hardly interact. 1.125 and 1.5, 8 and 32 cells change the products of
# the default solver by less than 1 % (docs/studies/solver_constants.py).
_PADDED = 1.25
_PADDING = 16
# Amplitudes below this fraction of the mean are rounding, or ringing of the kernel: their inverse is bounded.
_SMALLEST = 1e-6
# Waves from which on they are multiplied by columns: in float32 that takes 5 % less than three passes on
# 2048 x 2048 cells, 10 % less on 4096 x 4096 and 4 % more on 1024 x 1024 (docs/studies/scale.py products).
_LARGE = 2**21


@attrs.frozen(eq=False)
class InverseConvolution:
    """Division by the kernel's spectrum on a periodic grid: a good preconditioner, not an exact inverse.

    A subclass multiplies waves of another kind of array: it overrides `multiply`.

    Attributes
    ----------
    local
        Whether its effect on a few cells costs less by `coefficients` than by a product.
    stiffness
        Pressure amplitude per displacement amplitude of each wave, not negative, zero for the mean,
        shape (mx, my // 2 + 1).
    padded
        Cells (mx, my) of the periodic grid.
    exact
        Whether it inverts the convolution, but for the mean.
    """

    local: ClassVar[bool] = True

    stiffness: RealArray = attrs.field(repr=outlined)
    padded: tuple[int, int]
    exact: bool = False

    @cached_property
    def axes(self) -> tuple[RealArray, RealArray]:
        """The stiffness of the waves along x and of those along y, arrays of numpy."""
        return self.stiffness[: self.padded[0] // 2 + 1, 0], self.stiffness[0]

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
            Rows outside which the field is zero, and the result may be anything; None if it has no such rows.
        """
        if rows is None:
            return multiply_waves(values, symbol, padded)
        return _multiply_waves_of_rows(values, rows, symbol, padded)

    def coefficients(self, reach: int) -> RealArray:
        """Return the pressure at (i, j) cells from a unit displacement of one, shape (reach + 1, reach + 1)."""
        mx, my = self.padded
        columns = self.stiffness.shape[1]
        offsets = 2.0 * np.pi * np.arange(reach + 1)
        x = np.cos(np.outer(offsets, np.arange(mx) / mx)).astype(self.stiffness.dtype) / mx
        y = np.cos(np.outer(np.arange(columns) / my, offsets)).astype(self.stiffness.dtype) / my
        # Half of the waves along y are stored; the others equal them, but for the first and, if even, the last.
        y[1 : (my + 1) // 2] *= 2.0
        return x @ self.stiffness @ y


def multiply_waves(values: RealArray, symbol: RealArray, padded: tuple[int, int]) -> RealArray:
    """Return a field, padded with zeros, with each of its waves multiplied by a real symbol, shape of `values`."""
    waves = _multiply_columns(transform_rows(values, padded[1]), symbol, padded[0])
    return transform_rows_back(waves, padded[1], values.shape[1])


def _multiply_waves_of_rows(values: RealArray, rows: IntArray, symbol: RealArray, padded: tuple[int, int]) -> RealArray:
    """Return the same as `multiply_waves` for a field that is zero outside some rows, on these rows; zero elsewhere."""
    found = transform_rows(values[rows], padded[1])
    waves: Waves = np.zeros((values.shape[0], found.shape[1]), dtype=found.dtype)
    waves[rows] = found
    del found
    waves = _multiply_columns(waves, symbol, padded[0])
    product = np.zeros_like(values)
    product[rows] = transform_rows_back(waves[rows], padded[1], values.shape[1])
    return product


def _multiply_columns(waves: Waves, symbol: RealArray, length: int) -> Waves:
    """Return waves along y times the symbol of all waves; columns are padded to a length for it."""
    if symbol.size >= _LARGE:
        multiply_columns(waves, length, lambda columns, block: np.multiply(columns, symbol[:, block], out=columns))
        return waves
    # Two one-dimensional transforms are twice as fast as scipy's two-dimensional inverse.
    rows = waves.shape[0]
    threads = threads_for(2 * symbol.size)
    waves = scipy.fft.fft(waves, n=length, axis=0, overwrite_x=True, workers=threads)
    waves *= symbol
    back: Waves = scipy.fft.ifft(waves, axis=0, overwrite_x=True, workers=threads)
    return back[:rows]


def approximate_inverse(setup: ConvolutionSetup, dtype: npt.DTypeLike = np.float64) -> InverseConvolution:
    """Return the approximate inverse of a convolution, its stiffness in the given precision."""
    shape = setup.grid.shape
    if setup.boundary is Boundary.FREE:
        mx, my = (scipy.fft.next_fast_len(max(math.ceil(_PADDED * n), n + _PADDING), real=True) for n in shape)
        shape = mx, my
    if setup.boundary is Boundary.PERIODIC:
        response = np.array(setup.spectrum)
    else:
        known = isinstance(setup.kernel.kernel, SupportsSpectrum)
        spectrum = periodic_spectrum if known else wrapped_spectrum
        response = spectrum(setup.kernel, shape, setup.grid.spacing)
    response[0, 0] = 0.0
    floor = _SMALLEST * float(np.abs(response).mean())
    exact = setup.boundary is Boundary.PERIODIC and bool((response.ravel()[1:] > floor).all())
    response = np.abs(response)
    stiffness = np.zeros_like(response)
    np.divide(1.0, np.maximum(response, floor), out=stiffness, where=response > 0.0)
    stiffness[0, 0] = 0.0
    return InverseConvolution(stiffness.astype(dtype, copy=False), shape, exact)


def periodic_spectrum(kernel: BoundKernel, shape: tuple[int, int], spacing: Pair) -> Array:
    """Return the kernel's spectrum at the waves of a periodic grid, shape (nx, ny // 2 + 1)."""
    qx = 2 * np.pi / spacing[0] * scipy.fft.fftfreq(shape[0])[:, np.newaxis]
    qy = 2 * np.pi / spacing[1] * scipy.fft.rfftfreq(shape[1])[np.newaxis, :]
    return kernel.spectrum(qx, qy, spacing)


def wrapped_spectrum(kernel: BoundKernel, shape: tuple[int, int], spacing: Pair) -> Array:
    """Return the transform of the coefficients of the nearest images, shape (nx, ny // 2 + 1)."""
    nearest = kernel.coefficients((shape[0] // 2 + 1, shape[1] // 2 + 1), spacing)
    i, j = (np.minimum(np.arange(n), n - np.arange(n)) for n in shape)
    return np.ascontiguousarray(scipy.fft.rfft2(nearest[np.ix_(i, j)]).real)
