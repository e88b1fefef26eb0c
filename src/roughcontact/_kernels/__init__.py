"""Influence kernels: the displacement of the surface by a pressure."""

from roughcontact._kernels.base import BoundKernel, InfluenceKernel, SupportsCoefficients, SupportsSpectrum, kernels
from roughcontact._kernels.fourier import FourierHalfSpace
from roughcontact._kernels.love import Love

__all__ = [
    "BoundKernel",
    "FourierHalfSpace",
    "InfluenceKernel",
    "Love",
    "SupportsCoefficients",
    "SupportsSpectrum",
    "kernels",
]
