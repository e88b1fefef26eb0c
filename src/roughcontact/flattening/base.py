"""The interface of permanent set."""

from __future__ import annotations

import abc

import numpy as np

from roughcontact.checks import Array
from roughcontact.solution import ContactSolution


class PermanentSet(abc.ABC):
    """What a plastic contact leaves behind. Subclass it and say by how much the surfaces are lower."""

    @abc.abstractmethod
    def lowering(self, solution: ContactSolution) -> Array:
        """Return by how much the sum of both heights is lower after unloading, shape (nx, ny), m.

        Negative where the surfaces are raised. The elastic displacement goes back whole.
        """


def overlap(solution: ContactSolution) -> Array:
    """Return the overlap of the saturated cells, shape (nx, ny), m, zero elsewhere.

    With it taken from the heights, the same pressure under the same load leaves no overlap.
    """
    return np.where(solution.saturated, np.maximum(-solution.gap, 0.0), 0.0)
