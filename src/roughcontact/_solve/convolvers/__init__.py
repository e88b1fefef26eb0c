"""Convolvers: displacement from pressure, for each boundary of the domain."""

from roughcontact._solve.convolvers.base import ConvolutionSetup, Convolver, PreparedConvolution, convolvers
from roughcontact._solve.convolvers.circular import CircularFFT
from roughcontact._solve.convolvers.dcfft import DCFFT
from roughcontact._solve.convolvers.direct import Direct
from roughcontact._solve.convolvers.inverse import InverseConvolution, periodic_spectrum, wrapped_spectrum

__all__ = [
    "DCFFT",
    "CircularFFT",
    "ConvolutionSetup",
    "Convolver",
    "Direct",
    "InverseConvolution",
    "PreparedConvolution",
    "convolvers",
    "periodic_spectrum",
    "wrapped_spectrum",
]
