"""One contact solved by several processes, each with a slab of the domain."""

from roughcontact._solve.problem.slabs.arrays import SlabArray as SlabArray
from roughcontact._solve.problem.slabs.contact import SlabContacts as SlabContacts
from roughcontact._solve.problem.slabs.contact import Slabs as Slabs
from roughcontact._solve.problem.slabs.functions import gather_slabs as gather_slabs
from roughcontact._solve.problem.slabs.processes import SlabProcesses as SlabProcesses
from roughcontact._solve.problem.slabs.transforms import SlabConvolver as SlabConvolver
from roughcontact._solve.problem.slabs.transforms import long_waves_on_slabs as long_waves_on_slabs
from roughcontact._solve.problem.slabs.transforms import make_random_rows as make_random_rows
from roughcontact._solve.problem.slabs.transforms import multiply_on_slabs as multiply_on_slabs
from roughcontact._solve.problem.slabs.transforms import stiffness_on_slabs as stiffness_on_slabs
from roughcontact._solve.problem.slabs.transforms import symbol_of_columns as symbol_of_columns
