"""One contact of roughcontact solved by several processes, each with a slab of the domain."""

from roughcontact_mpi.arrays import SlabArray
from roughcontact_mpi.contact import SlabSolution, solve
from roughcontact_mpi.convolver import SlabFFT
from roughcontact_mpi.files import read_heights, write_field
from roughcontact_mpi.patches import SlabPatches
from roughcontact_mpi.processes import Processes
from roughcontact_mpi.surfaces import make_heights

ending_all = Processes.ending_all

__all__ = [
    "Processes",
    "SlabArray",
    "SlabFFT",
    "SlabPatches",
    "SlabSolution",
    "ending_all",
    "make_heights",
    "read_heights",
    "solve",
    "write_field",
]
