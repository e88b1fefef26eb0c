"""Plastic flattening: what remains of it after unloading."""

from roughcontact._flattening.models import FlatteningModel, Overlap, UniformRise, flattening_models

__all__ = ["FlatteningModel", "Overlap", "UniformRise", "flattening_models"]
