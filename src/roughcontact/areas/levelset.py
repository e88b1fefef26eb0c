"""Areas inside the edge that is drawn between the cells."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.areas.base import AreaEstimator
from roughcontact.areas.edges import drawn, edge_error, few_cells
from roughcontact.areas.total import summed
from roughcontact.solution import Area, ContactSolution


@attrs.frozen
class LevelSet(AreaEstimator):
    r"""Area inside the edge that pressure and gap tell of, drawn between the cells.

    .. math:: A = A_\mathrm{polygon} + s\,h\,L + (\tfrac12 + 0.16)\,h^2\,\chi

    with the length L and the Euler number chi of the edge and the kernel's own shift s inward (see
    `roughcontact.areas.contour` for the edge). It needs no more than the solution, and clusters of a
    few cells: where they are fewer see `Blend`.
    """

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the area inside the drawn edge; see `AreaEstimator.estimate`."""
        found = drawn(solution)
        common = edge_error(found, 2.0 * found.excess)
        return summed(solution, found.area, few_cells(solution, found), common, found, "level-set")


@attrs.frozen
class LevelSetRichardson(AreaEstimator):
    r"""The level-set area, extrapolated from edges drawn between all cells and between every second.

    .. math:: A = (4 A_1 - A_2) / 3

    One solution gives both, so that the errors that the drawing makes in the square of the cell go.
    """

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the extrapolated area; see `AreaEstimator.estimate`."""
        found = drawn(solution)
        common = edge_error(found, 2.0 * found.excess_refined)
        values = np.maximum(found.refined, 0.0)
        return summed(solution, values, few_cells(solution, found), common, found, "level-set-richardson")
