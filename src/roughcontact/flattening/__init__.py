"""Permanent set: what is left of the flattening when the load is gone."""

from roughcontact.flattening.base import PermanentSet
from roughcontact.flattening.overlap import Overlap
from roughcontact.flattening.rise import UniformRise

__all__ = ["Overlap", "PermanentSet", "UniformRise"]
