"""Bodies: a surface and the material under it."""

from __future__ import annotations

from typing import Any

import attrs

from roughcontact.errors import InputError
from roughcontact.materials import Material, Rigid
from roughcontact.surfaces import FlatSurface, Surface


def _instance_of(base: type, what: str) -> Any:
    def check(_: object, __: object, value: object) -> None:
        if not isinstance(value, base):
            raise InputError.about(what, value, f"an instance of {base.__name__}")

    return check


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

    surface: Surface = attrs.field(validator=_instance_of(Surface, "The surface of a body"))
    material: Material = attrs.field(validator=_instance_of(Material, "The material of a body"))


RIGID_FLAT = Body(FlatSurface(), Rigid())
