"""Layered, anisotropic and graded half-spaces: materials and influence kernels for roughcontact."""

from roughcontact_layered.anisotropic import AnisotropicKernel
from roughcontact_layered.crystal import Anisotropic, TransverselyIsotropic
from roughcontact_layered.graded import GradedKernel
from roughcontact_layered.kernel import LayeredKernel
from roughcontact_layered.pair import PairKernel
from roughcontact_layered.stack import Layer

__all__ = [
    "Anisotropic",
    "AnisotropicKernel",
    "GradedKernel",
    "Layer",
    "LayeredKernel",
    "PairKernel",
    "TransverselyIsotropic",
]
