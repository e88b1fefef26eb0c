"""What a contact does: stiffness, conductance, gradients, stress below the surface, flow, partial slip."""

from roughcontact._responses.conductance import Conductance, ContactConductance
from roughcontact._responses.stiffness import Stiffness
from roughcontact._responses.tangential import TangentialStiffness

__all__ = ["Conductance", "ContactConductance", "Stiffness", "TangentialStiffness"]
