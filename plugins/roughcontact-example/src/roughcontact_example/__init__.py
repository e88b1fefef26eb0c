"""One small plug-in of each kind, to copy from."""

from roughcontact_example.area import Between
from roughcontact_example.convolver import SignalConvolver
from roughcontact_example.flattening import Springback
from roughcontact_example.friction import Junctions
from roughcontact_example.interaction import Capillary
from roughcontact_example.kernel import Springs
from roughcontact_example.material import Foam
from roughcontact_example.oxidation import Oxidation
from roughcontact_example.panel import PatchForces
from roughcontact_example.reader import Raw16
from roughcontact_example.response import Capacitance
from roughcontact_example.shear_solver import ProjectedGradient
from roughcontact_example.solver import AcceleratedGradient
from roughcontact_example.surface import Dimples

__all__ = [
    "AcceleratedGradient",
    "Between",
    "Capacitance",
    "Capillary",
    "Dimples",
    "Foam",
    "Junctions",
    "Oxidation",
    "PatchForces",
    "ProjectedGradient",
    "Raw16",
    "SignalConvolver",
    "Springback",
    "Springs",
]
