"""Stress below the surface: Love's cells, their transforms, the maximum, and the load of first yield."""

from roughcontact._answers.subsurface.field import StressField as StressField
from roughcontact._answers.subsurface.first_yield import FirstYield as FirstYield
from roughcontact._answers.subsurface.first_yield import YieldPoint as YieldPoint
from roughcontact._answers.subsurface.maximum import StressMaximum as StressMaximum
from roughcontact._answers.subsurface.stress import Stress as Stress
from roughcontact._answers.subsurface.stress import StressBelow as StressBelow
