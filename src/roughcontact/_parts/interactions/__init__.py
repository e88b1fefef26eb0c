"""Interactions of two surfaces: attraction as a function of the gap, friction as a function of the pressure."""

from roughcontact._parts.interactions.base import BoundInteraction, Interaction, interactions
from roughcontact._parts.interactions.friction import Coulomb, FrictionLaw, LimitedCoulomb, frictions, shear_limit
from roughcontact._parts.interactions.laws import Dugdale, Exponential, ShortRange, VanDerWaals

__all__ = [
    "BoundInteraction",
    "Coulomb",
    "Dugdale",
    "Exponential",
    "FrictionLaw",
    "Interaction",
    "LimitedCoulomb",
    "ShortRange",
    "VanDerWaals",
    "frictions",
    "interactions",
    "shear_limit",
]
