"""The sphere: balls and rounded tips."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array, Pair, number
from roughcontact.errors import InputError
from roughcontact.grid import Grid
from roughcontact.surfaces.base import Surface, centre_point
from roughcontact.units import si


def _radius(value: float) -> float:
    return number(value, "The radius of the sphere", "m", above=0.0)


@attrs.frozen
class SphereSurface(Surface):
    """A true sphere, z = sqrt(R^2 - r^2) - R (`ParaboloidSurface` is Hertz's approximation of it).

    Parameters
    ----------
    radius
        Radius R of the sphere, m.
    center
        Position (x, y) of the summit relative to the centre of the domain, m.
    """

    radius: float = attrs.field(converter=_radius)
    center: Pair = attrs.field(converter=centre_point, default=(0.0, 0.0))

    @property
    def history(self) -> tuple[str, ...]:
        """What ``explain()`` tells of it."""
        return (f"a sphere of radius {si(self.radius, 'm')}",)

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, zero at the summit.

        Raises
        ------
        InputError
            If the grid reaches beyond the equator.
        """
        x, y = (grid.x - self.center[0]) / self.radius, (grid.y - self.center[1]) / self.radius
        square = x**2 + y**2
        if square.max() > 1.0:
            raise InputError(
                f"The sphere of radius {self.radius:g} m does not cover the domain of {grid.size[0]:g} m x "
                f"{grid.size[1]:g} m: choose a smaller domain, or a ParaboloidSurface."
            )
        # R - sqrt(R^2 - r^2) cancels near the summit; this form does not.
        return np.asarray(-self.radius * (square / (1.0 + np.sqrt(1.0 - square))), dtype=np.float64)
