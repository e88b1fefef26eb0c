"""What a contact does: stiffness, conductance, gradients, stress below the surface, flow, partial slip."""

from roughcontact._responses.leakage import GapFlow, Leakage
from roughcontact._responses.percolation import Percolation, find_percolation
from roughcontact._responses.throats import Throat

__all__ = ["GapFlow", "Leakage", "Percolation", "Throat", "find_percolation"]
