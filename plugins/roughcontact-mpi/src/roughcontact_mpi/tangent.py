"""The linear answer of a contact on slabs: one more solve, on its cells of contact."""

from __future__ import annotations

from typing import Any, cast

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.solving import LinearSolution, solve_on_cells
from roughcontact.typing import Array, Mask

from roughcontact_mpi.arrays import SlabArray


@attrs.frozen(eq=False)
class SlabTangent:
    """The kernel of a contact on slabs, restricted to its cells below the pressure limit.

    Attributes
    ----------
    solution
        The contact, on the window of this process.
    """

    solution: Any

    @property
    def cells(self) -> Mask:
        """The cells of the window that it is restricted to."""
        return np.asarray(self.solution.contact & ~self.solution.saturated)

    @property
    def is_rigid(self) -> bool:
        """Whether all cells of a periodic domain are in contact, so that uniform pressure displaces nothing."""
        part = self.solution.parts
        touching = part.total(int(np.count_nonzero(self.cells[part.inside])))
        return self.solution.boundary is rc.Boundary.PERIODIC and touching == self.solution.grid.cells

    def solve(self, right: Array, tolerance: float) -> LinearSolution:
        """Return the solution for a right side on the window, m; its values are on the window too."""
        part = self.solution.parts
        cells, own = (
            SlabArray.field(field[part.inside].copy(), part.processes, part.shape[0]) for field in (self.cells, right)
        )
        convolution = self.solution.convolution
        answer = solve_on_cells(
            convolution,
            convolution.inverse(np.float32),
            cast(Any, cells),
            cast(Any, own),
            tolerance,
            unit=self.solution.grid.spacing[0] / self.solution.modulus,
            rigid=False,
        )
        answer.require(tolerance, self.solution)
        return attrs.evolve(answer, values=part.read(cast(Any, answer.values)))
