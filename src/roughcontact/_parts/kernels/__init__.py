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
from roughcontact._parts.kernels.layers import SupportsConduction, SupportsTangential, has_layers
from roughcontact._parts.kernels.stress import BoundStress, HalfSpaceStress, SupportsStress
from roughcontact._parts.kernels.stress_cells import STRESS_COMPONENTS

__all__ = [
    "STRESS_COMPONENTS",
    "BoundKernel",
    "BoundStress",
    "FourierHalfSpace",
    "HalfSpaceStress",
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
    "odd_axes",
    "require_form",
]
