"""Interactions of two surfaces: attraction as a function of the gap, friction as a function of the pressure."""

from roughcontact._parts.interactions.base import BoundInteraction as BoundInteraction
from roughcontact._parts.interactions.base import Interaction as Interaction
from roughcontact._parts.interactions.base import interactions as interactions
from roughcontact._parts.interactions.friction import Coulomb as Coulomb
from roughcontact._parts.interactions.friction import FrictionLaw as FrictionLaw
from roughcontact._parts.interactions.friction import LimitedCoulomb as LimitedCoulomb
from roughcontact._parts.interactions.friction import frictions as frictions
from roughcontact._parts.interactions.friction import shear_limit as shear_limit
from roughcontact._parts.interactions.laws import Dugdale as Dugdale
from roughcontact._parts.interactions.laws import Exponential as Exponential
from roughcontact._parts.interactions.laws import ShortRange as ShortRange
from roughcontact._parts.interactions.laws import VanDerWaals as VanDerWaals
