"""The count of cells in contact."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.areas.base import OVERSHOOT, AreaEstimator, boundary_sides, sides_length
from roughcontact.areas.curvature import roughness
from roughcontact.areas.trust import doubts
from roughcontact.solution import Area, ContactSolution


@attrs.frozen
class CellCount(AreaEstimator):
    """All cells with p > 0, as most codes count: nearly always too much, for a touched cell counts whole.

    The uncertainty is that excess as the perimeter tells it (see `Perimeter`).
    """

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the counted area; see `AreaEstimator.estimate`."""
        contact = solution.contact
        count = int(np.count_nonzero(contact))
        excess = OVERSHOOT * boundary_sides(contact, solution.boundary) * solution.grid.cell_area
        return Area(
            count * solution.grid.cell_area,
            count / contact.size,
            excess,
            "cell-count",
            perimeter=sides_length(solution),
            doubts=doubts(solution, roughness(solution)),
        )
