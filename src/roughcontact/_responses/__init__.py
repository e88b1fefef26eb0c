"""What a contact does: stiffness, conductance, gradients, stress below the surface, flow, partial slip."""

from roughcontact._responses.fretting_loop import FrettingLoop
from roughcontact._responses.gradients import Gradient
from roughcontact._responses.partial_slip import CiavarellaJaeger, PartialSlip

__all__ = [
    "CiavarellaJaeger",
    "FrettingLoop",
    "Gradient",
    "PartialSlip",
]
