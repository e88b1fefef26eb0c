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
from roughcontact._solve.convolvers.shear import ShearConvolution, WaveMatrix
from roughcontact._solve.convolvers.transforms import list_all_waves, padded_shape, transform_extended

__all__ = [
    "DCFFT",
    "CircularFFT",
    "ConvolutionSetup",
    "Convolver",
    "Direct",
    "InverseConvolution",
    "PreparedConvolution",
    "ShearConvolution",
    "WaveMatrix",
    "convolvers",
    "list_all_waves",
    "mixed_spectrum",
    "padded_shape",
    "periodic_spectrum",
    "transform_extended",
    "wrapped_spectrum",
]
