"""Stress below the surface: Love's cells, their transforms, and the maximum."""

from roughcontact._responses.subsurface.field import StressField
from roughcontact._responses.subsurface.maximum import StressMaximum
from roughcontact._responses.subsurface.stress import Stress, StressBelow

__all__ = ["Stress", "StressBelow", "StressField", "StressMaximum"]
