"""A solve in your own hands: what a solver on other arrays shares with those that ship.

`bind_kernel` makes a kernel dimensionless and a convolver prepares it, `make_task` makes the `Task` of a load, a solver
answers with an `Outcome` (`roughcontact.typing`), and `confirm` recomputes the conditions of contact from the fields
alone, which gives a `ConfirmedFields`, of which `make_solution` makes a `ContactSolution`, on whatever arrays.

==================  ===============================================================================================
for                 names
==================  ===============================================================================================
pressures           `starting_pressure`, `nearest_pressure`, `project_to_load`, `rescale_to_load`,
                    `ContactConditions`
fields              `NumpyPasses`, what a descent on whole fields does beside its products
nested grids        `halve_shape`, `solve_in_window`, `GridSolution`, `GridLevel`, `estimate_approach`
a preconditioner    `WaveMatrix`, `count_blocks`, `LONG_WAVE_CUT`, `MAX_CUT_EXPONENT`
memory              `available_memory`, `require_memory`, `require_memory_of_solve`
threads             `map_tiles`, which splits the work on tiles of arrays
answers on slabs    `Whole`, `find_patches`, `solve_on_cells`, `LinearSolution`
==================  ===============================================================================================
"""

from roughcontact._answers.linear.tangent import LinearSolution, solve_on_cells
from roughcontact._base import machine
from roughcontact._base.machine import available_memory, require_memory
from roughcontact._solve.convolvers import WaveMatrix
from roughcontact._solve.problem import (
    ConfirmedFields,
    bind_kernel,
    confirm,
    make_solution,
    make_task,
    require_certified,
    require_memory_of_solve,
)
from roughcontact._solve.solution import ContactConditions, GridLevel, Whole, find_patches
from roughcontact._solve.solvers import (
    LONG_WAVE_CUT,
    MAX_CUT_EXPONENT,
    GridSolution,
    NumpyPasses,
    count_blocks,
    estimate_approach,
    halve_shape,
    nearest_pressure,
    project_to_load,
    rescale_to_load,
    solve_in_window,
    starting_pressure,
)
from roughcontact.errors.door import guarded

# The package itself sees the errors of its own work as they are.
map_tiles = guarded(machine.map_tiles)

__all__ = [
    "LONG_WAVE_CUT",
    "MAX_CUT_EXPONENT",
    "ConfirmedFields",
    "ContactConditions",
    "GridLevel",
    "GridSolution",
    "LinearSolution",
    "NumpyPasses",
    "WaveMatrix",
    "Whole",
    "available_memory",
    "bind_kernel",
    "confirm",
    "count_blocks",
    "estimate_approach",
    "find_patches",
    "halve_shape",
    "make_solution",
    "make_task",
    "map_tiles",
    "nearest_pressure",
    "project_to_load",
    "require_certified",
    "require_memory",
    "require_memory_of_solve",
    "rescale_to_load",
    "solve_in_window",
    "solve_on_cells",
    "starting_pressure",
]
