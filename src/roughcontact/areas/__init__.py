"""Area estimators: the real contact area from a solution."""

from roughcontact.areas.base import AreaEstimator
from roughcontact.areas.blend import Blend
from roughcontact.areas.cell_count import CellCount
from roughcontact.areas.hertz import Hertz
from roughcontact.areas.levelset import LevelSet, LevelSetRichardson
from roughcontact.areas.perimeter import Perimeter

__all__ = ["AreaEstimator", "Blend", "CellCount", "Hertz", "LevelSet", "LevelSetRichardson", "Perimeter"]
