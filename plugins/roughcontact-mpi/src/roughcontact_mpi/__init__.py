"""One contact of roughcontact solved by several processes, each with a slab of the domain."""

from roughcontact.slabs import SlabArray

from roughcontact_mpi.contact import Contacts
from roughcontact_mpi.convolver import SlabFFT
from roughcontact_mpi.files import read_heights, write_field
from roughcontact_mpi.patches import SlabPatches
from roughcontact_mpi.processes import Processes

ending_all = Processes.ending_all
make_heights = Contacts.make_heights
solve = Contacts.solve

__all__ = [
    "Processes",
    "SlabArray",
    "SlabFFT",
    "SlabPatches",
    "ending_all",
    "make_heights",
    "read_heights",
    "solve",
    "write_field",
]
