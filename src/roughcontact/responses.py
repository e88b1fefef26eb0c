"""Numbers of a contact, and what it does: stiffness, conductance, heat, gradients, stress below, flow, partial slip."""

from roughcontact._answers.areas import EdgeLength, FindFlags, Flags, MeanGap, PatchCount, PeakPressure, SummitApproach
from roughcontact._answers.areas.noise import FindNoise, Noise
from roughcontact._answers.areas.phases import Phases, SolvePhases
from roughcontact._answers.flow.flash_temperature import FlashTemperature, SlidingHeat
from roughcontact._answers.flow.leakage import GapFlow, Leakage, Throat
from roughcontact._answers.flow.percolation import Percolation, find_percolation
from roughcontact._answers.linear.conductance import Conductance, ContactConductance
from roughcontact._answers.linear.gradients import Gradient
from roughcontact._answers.linear.stiffness import PullOff, StabilityMargin, Stiffness
from roughcontact._answers.linear.tangential import TangentialStiffness
from roughcontact._answers.slip import CiavarellaJaeger, FrettingLoop, PartialSlip
from roughcontact._answers.subsurface import (
    FirstYield,
    Stress,
    StressBelow,
    StressField,
    StressMaximum,
    YieldPoint,
)

__all__ = [
    "CiavarellaJaeger",
    "Conductance",
    "ContactConductance",
    "EdgeLength",
    "FindFlags",
    "FindNoise",
    "FirstYield",
    "Flags",
    "FlashTemperature",
    "FrettingLoop",
    "GapFlow",
    "Gradient",
    "Leakage",
    "MeanGap",
    "Noise",
    "PartialSlip",
    "PatchCount",
    "PeakPressure",
    "Percolation",
    "Phases",
    "PullOff",
    "SlidingHeat",
    "SolvePhases",
    "StabilityMargin",
    "Stiffness",
    "Stress",
    "StressBelow",
    "StressField",
    "StressMaximum",
    "SummitApproach",
    "TangentialStiffness",
    "Throat",
    "YieldPoint",
    "find_percolation",
]
