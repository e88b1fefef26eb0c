"""Bonded elastic layers on a half-space: an influence kernel for roughcontact."""

from roughcontact_layered.kernel import LayeredKernel
from roughcontact_layered.stack import Layer

__all__ = ["Layer", "LayeredKernel"]
