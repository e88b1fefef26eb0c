"""The amplitudes of a kernel's waves on a circular grid."""

from __future__ import annotations

import numpy as np
import scipy.fft

from roughcontact.checks import Array, Pair
from roughcontact.kernels import BoundKernel


def periodic_spectrum(kernel: BoundKernel, shape: tuple[int, int], spacing: Pair) -> Array:
    """Return the kernel's own spectrum at the waves of the grid, shape (nx, ny // 2 + 1)."""
    qx = 2 * np.pi / spacing[0] * scipy.fft.fftfreq(shape[0])[:, np.newaxis]
    qy = 2 * np.pi / spacing[1] * scipy.fft.rfftfreq(shape[1])[np.newaxis, :]
    return kernel.spectrum(qx, qy, spacing)


def wrapped_spectrum(kernel: BoundKernel, shape: tuple[int, int], spacing: Pair) -> Array:
    """Return the transform of the coefficients of the nearest images, shape (nx, ny // 2 + 1)."""
    nearest = kernel.coefficients((shape[0] // 2 + 1, shape[1] // 2 + 1), spacing)
    i, j = (np.minimum(np.arange(n), n - np.arange(n)) for n in shape)
    return np.ascontiguousarray(scipy.fft.rfft2(nearest[np.ix_(i, j)]).real)
