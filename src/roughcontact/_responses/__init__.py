"""What a contact does: stiffness, conductance, gradients, stress below the surface, flow, partial slip."""

from roughcontact._responses.conductance import Conductance, ContactConductance
from roughcontact._responses.fretting_loop import FrettingLoop
from roughcontact._responses.gradients import Gradient
from roughcontact._responses.leakage import GapFlow, Leakage
from roughcontact._responses.partial_slip import CiavarellaJaeger, PartialSlip
from roughcontact._responses.percolation import Percolation, find_percolation
from roughcontact._responses.stiffness import Stiffness
from roughcontact._responses.subsurface import (
    FirstYield,
    Stress,
    StressBelow,
    StressField,
    StressMaximum,
    YieldPoint,
)
from roughcontact._responses.tangential_stiffness import TangentialStiffness
from roughcontact._responses.throats import Throat

__all__ = [
    "CiavarellaJaeger",
    "Conductance",
    "ContactConductance",
    "FirstYield",
    "FrettingLoop",
    "GapFlow",
    "Gradient",
    "Leakage",
    "PartialSlip",
    "Percolation",
    "Stiffness",
    "Stress",
    "StressBelow",
    "StressField",
    "StressMaximum",
    "TangentialStiffness",
    "Throat",
    "YieldPoint",
    "find_percolation",
]
