"""What a contact does: stiffness, conductance, gradients, stress below the surface, flow, partial slip."""

from roughcontact._responses.subsurface import Stress, StressBelow, StressField, StressMaximum

__all__ = ["Stress", "StressBelow", "StressField", "StressMaximum"]
