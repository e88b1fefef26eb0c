"""Interactions: the attraction of two surfaces as a function of the gap."""

from roughcontact._parts.interactions.base import BoundInteraction, Interaction, interactions
from roughcontact._parts.interactions.laws import Dugdale, Exponential, ShortRange, VanDerWaals

__all__ = [
    "BoundInteraction",
    "Dugdale",
    "Exponential",
    "Interaction",
    "ShortRange",
    "VanDerWaals",
    "interactions",
]
