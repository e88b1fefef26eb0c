"""Sums of surfaces: form and waviness and roughness."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array, Mask
from roughcontact.grid import Grid
from roughcontact.surfaces.base import Surface, history_of, holes_of, own_grid


@attrs.frozen
class SurfaceSum(Surface):
    """The sum of the heights of several surfaces; ``one + other`` makes it.

    Parameters
    ----------
    parts
        The surfaces to be added.
    """

    parts: tuple[Surface, ...]

    @property
    def grid(self) -> Grid | None:
        """The grid of the first part that carries one."""
        return next((grid for grid in map(own_grid, self.parts) if grid is not None), None)

    @property
    def history(self) -> tuple[str, ...]:
        """What was done to the parts."""
        return tuple(text for part in self.parts for text in history_of(part) or (_named(part),))

    def holes_on(self, grid: Grid) -> Mask | None:
        """Return which cells are holes of a part, shape `grid.shape`."""
        masks = [mask for mask in (holes_of(part, grid) for part in self.parts) if mask is not None]
        return np.logical_or.reduce(masks) if masks else None

    def heights(self, grid: Grid) -> Array:
        """Return the summed heights, shape `grid.shape`, m."""
        total = np.zeros(grid.shape)
        for part in self.parts:
            total += part.heights(grid)
        return total


def _named(part: Surface) -> str:
    return "a height map" if own_grid(part) is not None else f"plus {part!r}"
