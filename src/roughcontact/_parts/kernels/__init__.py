"""Influence kernels: the displacement of the surface by a pressure."""

from roughcontact._parts.kernels.base import (
    BoundKernel,
    InfluenceKernel,
    SupportsCoefficients,
    SupportsSpectrum,
    kernels,
    require_form,
)
from roughcontact._parts.kernels.half_space import FourierHalfSpace, Love

__all__ = [
    "BoundKernel",
    "FourierHalfSpace",
    "InfluenceKernel",
    "Love",
    "SupportsCoefficients",
    "SupportsSpectrum",
    "kernels",
    "require_form",
]
