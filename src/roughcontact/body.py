"""Bodies: a surface and the material under it."""

from __future__ import annotations

import attrs

from roughcontact.checks import instance_of
from roughcontact.materials import Material, Rigid
from roughcontact.surfaces import FlatSurface, Surface


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


RIGID_FLAT = Body(FlatSurface(), Rigid())
