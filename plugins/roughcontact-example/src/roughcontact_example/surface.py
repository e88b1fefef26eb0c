"""A surface."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class Dimples(rc.Surface):
    """A surface with a laser texture: paraboloidal dimples of a depth and a radius, `pitch` apart along x and y, m."""

    surface: rc.Surface
    depth: float = 1e-6
    radius: float = 10e-6
    pitch: float = 40e-6

    def heights(self, grid):
        """Return the heights at the cell centres, shape (nx, ny), m, positive outward."""
        x, y = (np.remainder(centres + 0.5 * self.pitch, self.pitch) - 0.5 * self.pitch for centres in (grid.x, grid.y))
        return self.surface.heights(grid) - self.depth * np.maximum(1.0 - (x**2 + y**2) / self.radius**2, 0.0)
