"""Solutions seen in a mirror, moved, in other units, and copied."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from roughcontact.checks import Array
from roughcontact.grid import Grid
from roughcontact.solution import ContactSolution


def _fields(solution: ContactSolution, change: Callable[[Array], Array]) -> ContactSolution:
    limit = solution.limit if isinstance(solution.limit, float) else change(np.asarray(solution.limit))
    return attrs.evolve(
        solution,
        pressure=change(solution.pressure),
        displacement=change(solution.displacement),
        undeformed=change(solution.undeformed),
        limit=limit,
    )


def mirrored(solution: ContactSolution, axes: tuple[int, ...]) -> ContactSolution:
    """Return the solution turned over along the axes."""
    return _fields(solution, lambda field: np.ascontiguousarray(np.flip(field, axes)))


def shifted(solution: ContactSolution, cells: tuple[int, int]) -> ContactSolution:
    """Return a periodic solution moved by so many cells."""
    return _fields(solution, lambda field: np.roll(field, cells, axis=(0, 1)))


def copied(solution: ContactSolution) -> ContactSolution:
    """Return a solution whose fields can be written to."""
    return _fields(solution, np.array)


def scaled(solution: ContactSolution, length: float, stiffness: float) -> ContactSolution:
    """Return the solution with lengths and moduli times a factor."""
    grid = solution.grid
    return attrs.evolve(
        solution,
        grid=Grid(grid.shape, (length * grid.size[0], length * grid.size[1])),
        modulus=stiffness * solution.modulus,
        limit=stiffness * solution.limit,
        pressure=stiffness * solution.pressure,
        displacement=length * solution.displacement,
        undeformed=length * solution.undeformed,
        approach=length * solution.approach,
        residuals=attrs.evolve(solution.residuals, scale=length * solution.residuals.scale),
    )
