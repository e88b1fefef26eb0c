"""Influence kernels: the displacement of the surface by a pressure, and by shear."""

from roughcontact._parts.kernels.base import (
    BoundKernel,
    InfluenceKernel,
    SupportsCoefficients,
    SupportsRows,
    SupportsShear,
    SupportsSpectrum,
    kernels,
    knows_own_rows,
    odd_axes,
    require_form,
)
from roughcontact._parts.kernels.half_space import FourierHalfSpace, Love
from roughcontact._parts.kernels.layers import SupportsConduction, SupportsStress, SupportsTangential, has_layers
from roughcontact._parts.kernels.mixed import list_octaves, sum_along_x

__all__ = [
    "BoundKernel",
    "FourierHalfSpace",
    "InfluenceKernel",
    "Love",
    "SupportsCoefficients",
    "SupportsConduction",
    "SupportsRows",
    "SupportsShear",
    "SupportsSpectrum",
    "SupportsStress",
    "SupportsTangential",
    "has_layers",
    "kernels",
    "knows_own_rows",
    "list_octaves",
    "odd_axes",
    "require_form",
    "sum_along_x",
]
