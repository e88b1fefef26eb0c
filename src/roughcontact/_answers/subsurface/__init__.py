"""Stress below the surface: Love's cells, their transforms, the maximum, and the load of first yield."""

from roughcontact._answers.subsurface.field import StressField
from roughcontact._answers.subsurface.first_yield import FirstYield, YieldPoint
from roughcontact._answers.subsurface.maximum import StressMaximum
from roughcontact._answers.subsurface.stress import Stress, StressBelow

__all__ = ["FirstYield", "Stress", "StressBelow", "StressField", "StressMaximum", "YieldPoint"]
