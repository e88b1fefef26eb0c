"""The response of a kernel at each offset, by plain sums: what convolvers are judged by."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import Array
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels.base import BoundKernel


def responses(kernel: BoundKernel, grid: Grid, boundary: Boundary) -> Array:
    """Return displacement over pressure at each offset within the grid, shape (nx, ny), without a transform."""
    if boundary is not Boundary.PERIODIC:
        return kernel.coefficients(grid.shape, grid.spacing)
    waves = [2.0 * np.pi * np.asarray(np.fft.fftfreq(n), dtype=np.float64) for n in grid.shape]
    qx, qy = (wave / step for wave, step in zip(waves, grid.spacing, strict=True))
    amplitudes = kernel.spectrum(qx[:, np.newaxis], qy[np.newaxis, :], grid.spacing)
    # A kernel is even, so that cosines are all of its waves.
    x, y = (np.cos(np.outer(np.arange(wave.size), wave)) for wave in waves)
    return np.asarray(x @ amplitudes @ y.T) / grid.cells
