"""What a contact does: stiffness, conductance, gradients, stress below the surface, flow, partial slip."""

from roughcontact._responses.subsurface import (
    FirstYield,
    Stress,
    StressBelow,
    StressField,
    StressMaximum,
    YieldPoint,
)

__all__ = ["FirstYield", "Stress", "StressBelow", "StressField", "StressMaximum", "YieldPoint"]
