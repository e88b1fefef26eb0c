"""Area estimators, and estimators of other numbers of the contact, from a solution."""

from roughcontact._answers.areas.estimators import Blend as Blend
from roughcontact._answers.areas.estimators import CellCount as CellCount
from roughcontact._answers.areas.estimators import Hertz as Hertz
from roughcontact._answers.areas.estimators import LevelSet as LevelSet
from roughcontact._answers.areas.estimators import LevelSetRichardson as LevelSetRichardson
from roughcontact._answers.areas.estimators import Perimeter as Perimeter
from roughcontact._answers.areas.flags import FindFlags as FindFlags
from roughcontact._answers.areas.flags import Flags as Flags
from roughcontact._answers.areas.peak import PeakPressure as PeakPressure
from roughcontact._answers.areas.quantities import EdgeLength as EdgeLength
from roughcontact._answers.areas.quantities import MeanGap as MeanGap
from roughcontact._answers.areas.quantities import PatchCount as PatchCount
from roughcontact._answers.areas.quantities import SummitApproach as SummitApproach
from roughcontact._solve.solution import AreaEstimator as AreaEstimator
from roughcontact._solve.solution import areas as areas
