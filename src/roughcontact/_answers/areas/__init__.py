"""Area estimators, and estimators of other numbers of the contact, from a solution."""

from roughcontact._answers.areas.estimators import Blend, CellCount, Hertz, LevelSet, LevelSetRichardson, Perimeter
from roughcontact._answers.areas.peak import PeakPressure
from roughcontact._answers.areas.quantities import EdgeLength, MeanGap, PatchCount, SummitApproach
from roughcontact._solve.solution import AreaEstimator, areas

__all__ = [
    "AreaEstimator",
    "Blend",
    "CellCount",
    "EdgeLength",
    "Hertz",
    "LevelSet",
    "LevelSetRichardson",
    "MeanGap",
    "PatchCount",
    "PeakPressure",
    "Perimeter",
    "SummitApproach",
    "areas",
]
