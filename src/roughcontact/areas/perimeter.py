"""The count of cells less what the perimeter tells of its excess."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact.areas.base import OVERSHOOT, AreaEstimator, boundary_sides, sides_length, straight_rows
from roughcontact.areas.curvature import roughness
from roughcontact.areas.trust import doubts
from roughcontact.solution import Area, ContactSolution

# Two bars hold everything from no correction at all (sharp edges) to twice the correction.
_SHARE = 0.5
# The edge lies anywhere in its cell: rms of a uniform distribution.
_SPREAD = 1.0 / math.sqrt(12.0)


@attrs.frozen
class Perimeter(AreaEstimator):
    r"""Counted area less a perimeter correction.

    .. math:: A = N \Delta x \Delta y - \frac{\pi - 1 + \ln 2}{24}\, S\, \Delta x \Delta y

    with N cells in contact and S cell sides between contact and open cells. Exact on average for a
    straight edge that crosses the cells at random; it takes too much off smooth Hertzian edges.
    Where the pressure has reached its limit the edge is sharp and the count is right, so that sides
    of saturated cells are not corrected, and the area is never less than the load needs at the limit.

    The uncertainty allows for half of the correction and for edges that lie anywhere in their
    cells: sides in one straight row err together.

    References
    ----------
    Yastrebov, Anciaux, Molinari, Tribol. Int. 114 (2017) 161-171,
    https://doi.org/10.1016/j.triboint.2017.04.023
    """

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the corrected area; see `AreaEstimator.estimate`."""
        contact, cell = solution.contact, solution.grid.cell_area
        rows = straight_rows(contact, solution.boundary)
        elastic = int(rows.sum()) - boundary_sides(contact, solution.boundary, solution.saturated)
        count = int(np.count_nonzero(contact))
        needed = float(np.add.reduce(solution.pressure / solution.limit, axis=None))
        value = max(count - OVERSHOOT * elastic, needed) * cell
        wander = _SPREAD * math.sqrt(float(np.sum(rows.astype(np.float64) ** 2)))
        uncertainty = (_SHARE * OVERSHOOT * elastic + wander) * cell
        return Area(
            value,
            value / solution.grid.area,
            uncertainty,
            "perimeter",
            perimeter=sides_length(solution),
            doubts=doubts(solution, roughness(solution)),
        )
