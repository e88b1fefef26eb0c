"""Circular convolution by FFT: periodic and wrapped boundaries."""

from __future__ import annotations

import attrs
import numpy as np
import scipy.fft

from roughcontact.checks import Array
from roughcontact.convolvers.base import Convolver, PlannedConvolution, require_boundary, worker_count
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
        (nx, ny), (dx, dy) = grid.shape, grid.spacing
        if boundary is Boundary.PERIODIC:
            qx = 2 * np.pi / dx * scipy.fft.fftfreq(nx)[:, np.newaxis]
            qy = 2 * np.pi / dy * scipy.fft.rfftfreq(ny)[np.newaxis, :]
            symbol = kernel.spectrum(qx, qy, grid.spacing)
        else:
            nearest = kernel.coefficients((nx // 2 + 1, ny // 2 + 1), grid.spacing)
            i, j = (np.minimum(np.arange(n), n - np.arange(n)) for n in (nx, ny))
            symbol = scipy.fft.rfft2(nearest[np.ix_(i, j)], workers=self.workers).real
        return _CircularPlan(np.ascontiguousarray(symbol), ny, self.workers)


@attrs.frozen(eq=False)
class _CircularPlan(PlannedConvolution):
    """Transform, multiply by the real symbol, transform back."""

    symbol: Array
    width: int
    workers: int

    def apply(self, pressure: Array) -> Array:
        """Return the displacement; see `PlannedConvolution.apply`."""
        # Two one-dimensional transforms are twice as fast as scipy's two-dimensional inverse.
        waves = scipy.fft.rfft(pressure, axis=1, workers=self.workers)
        waves = scipy.fft.fft(waves, axis=0, overwrite_x=True, workers=self.workers)
        waves *= self.symbol
        waves = scipy.fft.ifft(waves, axis=0, overwrite_x=True, workers=self.workers)
        displacement: Array = scipy.fft.irfft(waves, n=self.width, axis=1, overwrite_x=True, workers=self.workers)
        return displacement
