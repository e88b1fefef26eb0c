"""Convolvers: displacement from pressure, for each boundary of the domain."""

from roughcontact._solve.convolvers.base import (
    ConvolutionSetup,
    Convolver,
    InverseConvolution,
    PreparedConvolution,
    convolvers,
    list_all_waves,
    mixed_spectrum,
    padded_shape,
    periodic_spectrum,
    transform_extended,
    wrapped_spectrum,
)
from roughcontact._solve.convolvers.direct import Direct
from roughcontact._solve.convolvers.fft import DCFFT, CircularFFT
from roughcontact._solve.convolvers.shear import ShearConvolution, WaveMatrix

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
