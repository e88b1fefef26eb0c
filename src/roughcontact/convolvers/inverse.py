"""The pressure that would cause a displacement, as waves of the unbounded surface tell it."""

from __future__ import annotations

import math

import attrs
import numpy as np
import numpy.typing as npt
import scipy.fft

from roughcontact.checks import RealArray
from roughcontact.convolvers.base import Scene
from roughcontact.convolvers.spectra import periodic_spectrum, wrapped_spectrum
from roughcontact.grid import Boundary
from roughcontact.kernels import OffersSpectrum

# Room beyond a free border, as a share of the domain: less couples opposite borders, more gains nothing.
_MARGIN = 1.25
# A narrow domain needs more than a share of itself, in cells.
_AT_LEAST = 16
# Wave amplitudes below this share of the mean are rounding or ringing of the kernel.
_SMALLEST = 1e-6


@attrs.frozen(eq=False)
class InverseConvolution:
    """Division by the kernel's spectrum on a periodic grid: a good preconditioner, not an exact inverse.

    Attributes
    ----------
    stiffness
        Pressure amplitude per displacement amplitude of each wave, positive and zero for the mean,
        shape (mx, my // 2 + 1).
    padded
        Cells (mx, my) of the periodic grid.
    """

    stiffness: RealArray
    padded: tuple[int, int]

    def apply(self, displacement: RealArray) -> RealArray:
        """Return the pressure, shape and precision of `displacement` (float32 or float64)."""
        (mx, my), (nx, ny) = self.padded, displacement.shape
        waves = scipy.fft.rfft(displacement, n=my, axis=1)
        waves = scipy.fft.fft(waves, n=mx, axis=0, overwrite_x=True)
        waves *= self.stiffness
        waves = scipy.fft.ifft(waves, axis=0, overwrite_x=True)[:nx]
        pressure = scipy.fft.irfft(waves, n=my, axis=1, overwrite_x=True)
        return np.asarray(pressure[:, :ny])


def inverse_of(scene: Scene, dtype: npt.DTypeLike = np.float64) -> InverseConvolution:
    """Return the approximate inverse of what was planned, its stiffness stored in the precision that is asked for."""
    if scene.boundary is Boundary.FREE:
        mx, my = (
            scipy.fft.next_fast_len(max(math.ceil(_MARGIN * n), n + _AT_LEAST), real=True) for n in scene.grid.shape
        )
    else:
        mx, my = scene.grid.shape
    known = isinstance(scene.kernel.kernel, OffersSpectrum)
    spectrum = periodic_spectrum if known else wrapped_spectrum
    response = np.abs(spectrum(scene.kernel, (mx, my), scene.grid.spacing))
    response[0, 0] = 0.0
    floor = _SMALLEST * float(response.mean())
    stiffness = np.zeros_like(response)
    np.divide(1.0, np.maximum(response, floor), out=stiffness, where=response > 0.0)
    stiffness[0, 0] = 0.0
    return InverseConvolution(stiffness.astype(dtype, copy=False), (mx, my))
