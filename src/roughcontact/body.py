"""Bodies: a surface and the material under it."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array, Mask, instance_of
from roughcontact.errors import InputError
from roughcontact.grid import Grid
from roughcontact.materials import Material, Rigid
from roughcontact.surfaces import FlatSurface, Surface
from roughcontact.surfaces.base import holes_of


@attrs.frozen
class Body:
    """One of the two bodies in contact.

    Parameters
    ----------
    surface
        Its heights, positive towards the other body.
    material
        What it is made of.
    """

    surface: Surface = attrs.field(validator=instance_of(Surface, "The surface of a body", "a Surface"))
    material: Material = attrs.field(validator=instance_of(Material, "The material of a body", "a Material"))

    def heights(self, grid: Grid) -> Array:
        """Return the heights of the surface at the cell centres, shape `grid.shape`, m.

        Raises
        ------
        InputError
            If the surface does not give finite real heights of that shape.
        """
        heights = np.asarray(self.surface.heights(grid))
        name = type(self.surface).__name__
        if heights.shape != grid.shape or heights.dtype.kind != "f":
            raise InputError(
                f"The surface {name} must give real heights of shape {grid.shape}, "
                f"but gave an array of shape {heights.shape} and type {heights.dtype}."
            )
        if not np.isfinite(heights).all():
            raise InputError(f"The surface {name} gave heights that are not finite.")
        return heights

    def holes(self, grid: Grid) -> Mask | None:
        """Return which points of the surface were not measured, shape `grid.shape`; None if it knows of none."""
        holes = holes_of(self.surface, grid)
        return holes if holes is not None and holes.any() else None


RIGID_FLAT = Body(FlatSurface(), Rigid())
