"""The flat surface."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array
from roughcontact.grid import Grid
from roughcontact.surfaces.base import Surface


@attrs.frozen
class FlatSurface(Surface):
    """A plane: zero everywhere."""

    def heights(self, grid: Grid) -> Array:
        """Return zeros, shape `grid.shape`, m."""
        return np.zeros(grid.shape)
