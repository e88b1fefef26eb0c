"""The count of cells less what the perimeter tells of its excess."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.areas.base import OVERSHOOT, AreaEstimator, boundary_sides
from roughcontact.solution import Area, ContactSolution

# The correction is right to about a third for smooth edges; the rest is the wander of the discrete
# solution itself, a few hundredths of a cell times the root of the number of boundary sides.
_SHARE = 0.35
_WANDER = 0.06


@attrs.frozen
class Perimeter(AreaEstimator):
    r"""Counted area less a perimeter correction.

    .. math:: A = N \Delta x \Delta y - \frac{\pi - 1 + \ln 2}{24}\, S\, \Delta x \Delta y

    with N cells in contact and S cell sides between contact and open cells. Exact on average for a
    straight edge that crosses the cells at random; it takes too much off smooth Hertzian edges and
    must not be used for sharp ones (punches), whose count is exact.

    References
    ----------
    Yastrebov, Anciaux, Molinari, Tribol. Int. 114 (2017) 161-171,
    https://doi.org/10.1016/j.triboint.2017.04.023
    """

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the corrected area; see `AreaEstimator.estimate`."""
        contact, cell = solution.contact, solution.grid.cell_area
        count, sides = int(np.count_nonzero(contact)), boundary_sides(contact, solution.boundary)
        value = (count - OVERSHOOT * sides) * cell
        uncertainty = (_SHARE * OVERSHOOT * sides + _WANDER * np.sqrt(sides)) * cell
        return Area(value, value / solution.grid.area, float(uncertainty), "perimeter")
