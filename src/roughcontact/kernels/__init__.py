"""Influence kernels: the surface displacement that a pressure makes."""

from roughcontact.kernels.base import BoundKernel, InfluenceKernel, OffersCoefficients, OffersModulus, OffersSpectrum
from roughcontact.kernels.fourier import FourierHalfSpace
from roughcontact.kernels.love import Love

__all__ = [
    "BoundKernel",
    "FourierHalfSpace",
    "InfluenceKernel",
    "Love",
    "OffersCoefficients",
    "OffersModulus",
    "OffersSpectrum",
]
