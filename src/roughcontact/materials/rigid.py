"""Rigid material."""

from __future__ import annotations

import math

import attrs

from roughcontact.materials.base import Material


@attrs.frozen
class Rigid(Material):
    """A body that does not deform."""

    @property
    def compliance(self) -> float:
        """Zero."""
        return 0.0

    @property
    def pressure_limit(self) -> float:
        """Infinite."""
        return math.inf
