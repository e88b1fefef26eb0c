"""The paraboloid: the shape of Hertz's theory."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact.checks import Array, Pair, pair
from roughcontact.grid import Grid
from roughcontact.surfaces.base import Surface, centre_point


def _radius(value: float | Sequence[float]) -> Pair:
    return pair(value, "The radius of curvature", "m", above=0.0)


@attrs.frozen
class ParaboloidSurface(Surface):
    """Paraboloid z = -(x^2 / (2 R1) + y^2 / (2 R2)), elliptic if the radii differ.

    Parameters
    ----------
    radius
        Radii of curvature along x and y, or of both, m.
    center
        Position (x, y) of the summit relative to the centre of the domain, m.
    """

    radius: Pair = attrs.field(converter=_radius)
    center: Pair = attrs.field(converter=centre_point, default=(0.0, 0.0))

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, zero at the summit."""
        x, y = grid.x - self.center[0], grid.y - self.center[1]
        return np.asarray(-(x * (x / (2 * self.radius[0])) + y * (y / (2 * self.radius[1]))), dtype=np.float64)
