"""Convolvers: displacement from pressure, for the boundary that the problem has."""

from roughcontact.convolvers.base import Convolver, PlannedConvolution, Scene
from roughcontact.convolvers.circular import CircularFFT
from roughcontact.convolvers.dcfft import DCFFT
from roughcontact.convolvers.direct import Direct

__all__ = ["DCFFT", "CircularFFT", "Convolver", "Direct", "PlannedConvolution", "Scene"]
