"""The memory of solves and of contacts with friction, in arrays of the grid: refused before it is taken."""

from __future__ import annotations

import math

import numpy as np

from roughcontact._base.machine import require_memory
from roughcontact._parts.grid import Boundary, Grid
from roughcontact.errors.door import guarded

# Fractions of the cells in contact below the pressure limit, without and with a free boundary, and the peak memory of a
# solve there, in float64 arrays of the grid; more contact takes no more. Vectors hold only the cells in contact; on a
# free boundary kernel and spectra are larger. It is a sixth to a quarter more than a solve holds
# (docs/studies/memory.py), because an allocator keeps some of what was released.
_CONTACT_FRACTIONS = {False: (0.0, 0.4), True: (0.0, 0.1, 0.4)}
_ARRAYS_AT_FRACTIONS = {False: (8.0, 11.1), True: (11.5, 11.9, 13.2)}
# Minimum arrays if vectors hold all cells, as for other solvers and the direct sum; measured by
# tests/problems/test_memory.py.
UNRESTRICTED_ARRAYS = 14.5
# Divisor of the sides of the largest proposed grid, so that they can be halved to coarser grids.
_SIDE_MULTIPLE = 32


def memory_of_solve(grid: Grid, boundary: Boundary, contact_fraction: float) -> int:
    """Return the peak memory of a solve, beyond the problem itself, bytes; see `SolvePlan.memory_at`."""
    free = boundary.has_free_axis
    return int(8 * grid.cells * np.interp(contact_fraction, _CONTACT_FRACTIONS[free], _ARRAYS_AT_FRACTIONS[free]))


@guarded
def require_memory_of_solve(grid: Grid, boundary: Boundary, limit: int | None = None) -> None:
    """Refuse a grid on which a solve does not fit into memory, even at light contact; heights are not needed.

    `limit` is the memory that it may take, bytes; None: the memory of the machine.
    """
    require_arrays(memory_of_solve(grid, boundary, 0.0), "A solve", grid, boundary, limit)


def require_arrays(needed: int, what: str, grid: Grid, boundary: Boundary, limit: int | None) -> None:
    """Refuse fields on a grid that need more memory than there is, with the largest grid that fits."""
    shape = " x ".join(map(str, grid.shape))

    def advise(available: int) -> str:
        sides = (_round_down(math.sqrt(available / needed) * n) for n in grid.shape)
        padded = ", or a periodic boundary, which needs less" if boundary.has_free_axis else ""
        return f"choose at most {' x '.join(map(str, sides))} cells{padded}"

    require_memory(needed, f"{what} on {shape} cells, boundary {boundary},", advise, limit)


def _round_down(side: float) -> int:
    """Return a number of cells from one to `side` that can be halved a few times."""
    return int(side) // _SIDE_MULTIPLE * _SIDE_MULTIPLE or max(1, int(side))
