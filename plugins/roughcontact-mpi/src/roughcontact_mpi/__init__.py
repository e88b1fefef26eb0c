"""One contact of roughcontact solved by several processes, each with a slab of the domain."""

from roughcontact_mpi.convolver import SlabFFT
from roughcontact_mpi.processes import Processes

__all__ = ["Processes", "SlabFFT"]
