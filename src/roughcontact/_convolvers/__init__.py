"""Convolvers: displacement from pressure, for each boundary of the domain."""

from roughcontact._convolvers.base import ConvolutionSetup, Convolver, PreparedConvolution, convolvers
from roughcontact._convolvers.circular import CircularFFT
from roughcontact._convolvers.dcfft import DCFFT
from roughcontact._convolvers.direct import Direct
from roughcontact._convolvers.inverse import InverseConvolution

__all__ = [
    "DCFFT",
    "CircularFFT",
    "ConvolutionSetup",
    "Convolver",
    "Direct",
    "InverseConvolution",
    "PreparedConvolution",
    "convolvers",
]
