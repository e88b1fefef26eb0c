"""Permanent set: what is left of the flattening when the load is gone."""

from roughcontact.sets.base import PermanentSet
from roughcontact.sets.overlap import Overlap
from roughcontact.sets.rise import UniformRise

__all__ = ["Overlap", "PermanentSet", "UniformRise"]
