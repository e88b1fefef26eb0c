"""Area estimators, and estimators of other numbers of the contact, from a solution."""

from roughcontact._areas.estimators import Blend, CellCount, Hertz, LevelSet, LevelSetRichardson, Perimeter
from roughcontact._areas.peak import PeakPressure
from roughcontact._areas.quantities import EdgeLength, MeanGap, PatchCount, SummitApproach
from roughcontact._solution import AreaEstimator, areas

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
