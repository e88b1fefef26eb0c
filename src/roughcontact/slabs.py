"""One contact solved by several processes, each with a slab of the domain: what such a plug-in shares with others.

A plug-in says how its processes exchange data (`SlabProcesses`) and which solver they run (`SlabContacts`); arrays,
transforms and answers follow. ``import roughcontact`` does not load this module.

===============  ==================================================================================================
for              names
===============  ==================================================================================================
processes        `SlabProcesses`
arrays           `SlabArray`, `gather_slabs`
contacts         `SlabContacts`, `Slabs`
a convolution    `SlabConvolver`, `symbol_of_columns`, `multiply_on_slabs`, `stiffness_on_slabs`, `long_waves_on_slabs`
random surfaces  `make_random_rows`
===============  ==================================================================================================
"""

from roughcontact._solve.problem.slabs import (
    SlabArray,
    SlabContacts,
    SlabConvolver,
    SlabProcesses,
    Slabs,
    gather_slabs,
    long_waves_on_slabs,
    make_random_rows,
    multiply_on_slabs,
    stiffness_on_slabs,
    symbol_of_columns,
)
from roughcontact.errors.door import guarded

__all__ = [
    "SlabArray",
    "SlabContacts",
    "SlabConvolver",
    "SlabProcesses",
    "Slabs",
    "gather_slabs",
    "long_waves_on_slabs",
    "make_random_rows",
    "multiply_on_slabs",
    "stiffness_on_slabs",
    "symbol_of_columns",
]

for _public in (SlabArray, SlabContacts, SlabConvolver, SlabProcesses, Slabs):
    guarded(_public)
del _public
