"""Area estimators: the real contact area from a solution."""

from roughcontact.areas.base import AreaEstimator
from roughcontact.areas.cell_count import CellCount
from roughcontact.areas.perimeter import Perimeter

__all__ = ["AreaEstimator", "CellCount", "Perimeter"]
