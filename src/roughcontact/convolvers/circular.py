"""Circular convolution by FFT: periodic and wrapped boundaries."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np
import scipy.fft

from roughcontact.checks import Array, RealArray
from roughcontact.convolvers.base import Convolver, PlannedConvolution, Scene, require_boundary, worker_count
from roughcontact.convolvers.spectra import periodic_spectrum, wrapped_spectrum
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import BoundKernel


@attrs.frozen
class CircularFFT(Convolver):
    """Multiplication in Fourier space, without padding.

    ``periodic``: the domain repeats for ever and every image counts; the kernel's spectrum is used,
    and the mean displacement, which is arbitrary, is zero. ``wrapped``: only the nearest image of
    each cell counts, as in many codes that forget the padding; the kernel's coefficients are used.

    Parameters
    ----------
    workers
        Threads of each transform.
    """

    workers: int = attrs.field(converter=worker_count, default=1)

    @property
    def boundaries(self) -> frozenset[Boundary]:
        """Periodic and wrapped."""
        return frozenset({Boundary.PERIODIC, Boundary.WRAPPED})

    def transform_shape(self, grid: Grid, boundary: Boundary) -> tuple[int, int]:
        """Return the grid's own shape."""
        return grid.shape

    def plan(self, kernel: BoundKernel, grid: Grid, boundary: Boundary) -> PlannedConvolution:
        """Return the planned convolution; see `Convolver.plan`."""
        require_boundary(self, boundary)
        spectrum = periodic_spectrum if boundary is Boundary.PERIODIC else wrapped_spectrum
        symbol = spectrum(kernel, grid.shape, grid.spacing)
        return _CircularPlan(Scene(self, kernel, grid, boundary), np.ascontiguousarray(symbol), self.workers)


@attrs.frozen(eq=False)
class _CircularPlan(PlannedConvolution):
    """Transform, multiply by the real symbol, transform back."""

    scene: Scene
    symbol: Array
    workers: int

    @cached_property
    def short_symbol(self) -> RealArray:
        """The symbol in float32."""
        return self.symbol.astype(np.float32)

    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement; see `PlannedConvolution.apply`."""
        # Two one-dimensional transforms are twice as fast as scipy's two-dimensional inverse.
        waves = scipy.fft.rfft(pressure, axis=1, workers=self.workers)
        waves = scipy.fft.fft(waves, axis=0, overwrite_x=True, workers=self.workers)
        waves *= self.short_symbol if pressure.dtype == np.float32 else self.symbol
        waves = scipy.fft.ifft(waves, axis=0, overwrite_x=True, workers=self.workers)
        width = pressure.shape[1]
        return np.asarray(scipy.fft.irfft(waves, n=width, axis=1, overwrite_x=True, workers=self.workers))
