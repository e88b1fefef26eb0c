"""What a contact does: stiffness, conductance, gradients, stress below the surface, flow, partial slip."""

from roughcontact._responses.stiffness import Stiffness

__all__ = ["Stiffness"]
