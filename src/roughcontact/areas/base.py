"""The area estimator interface and the boundary of a cell mask."""

from __future__ import annotations

import abc
import math

import numpy as np

from roughcontact.checks import Mask
from roughcontact.grid import Boundary
from roughcontact.solution import Area, ContactSolution

# Mean overshoot of a counted cell boundary, in cells, over all positions and directions of an edge.
OVERSHOOT = (math.pi - 1.0 + math.log(2.0)) / 24.0


class AreaEstimator(abc.ABC):
    """A rule for the real contact area. Subclass it and say `estimate`."""

    @abc.abstractmethod
    def estimate(self, solution: ContactSolution) -> Area:
        """Return the real contact area with its error bar."""


def boundary_sides(contact: Mask, boundary: Boundary) -> int:
    """Count the cell sides between contact and open cells, shape of `contact` (nx, ny).

    On a free boundary the border of the domain itself is not counted; on the others the domain
    closes on itself.
    """
    inner = np.count_nonzero(contact[1:] != contact[:-1]) + np.count_nonzero(contact[:, 1:] != contact[:, :-1])
    if boundary is Boundary.FREE:
        return int(inner)
    # Along an axis of one cell both neighbours are the cell itself and nothing is added.
    seam = np.count_nonzero(contact[0] != contact[-1]) + np.count_nonzero(contact[:, 0] != contact[:, -1])
    return int(inner + seam)
