"""Convolvers: displacement from pressure, for each boundary of the domain."""

from roughcontact._solve.convolvers.base import (
    ConvolutionSetup,
    Convolver,
    InverseConvolution,
    PreparedConvolution,
    convolvers,
    mixed_spectrum,
    periodic_spectrum,
    wrapped_spectrum,
)
from roughcontact._solve.convolvers.direct import Direct
from roughcontact._solve.convolvers.fft import DCFFT, CircularFFT
from roughcontact._solve.convolvers.matrix import WaveMatrix
from roughcontact._solve.convolvers.shear import ShearConvolution
from roughcontact._solve.convolvers.stress import StressConvolution
from roughcontact._solve.convolvers.transforms import list_all_waves, padded_shape

__all__ = [
    "DCFFT",
    "CircularFFT",
    "ConvolutionSetup",
    "Convolver",
    "Direct",
    "InverseConvolution",
    "PreparedConvolution",
    "ShearConvolution",
    "StressConvolution",
    "WaveMatrix",
    "convolvers",
    "list_all_waves",
    "mixed_spectrum",
    "padded_shape",
    "periodic_spectrum",
    "wrapped_spectrum",
]
