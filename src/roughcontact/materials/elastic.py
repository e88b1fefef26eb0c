"""Linear elastic material."""

from __future__ import annotations

import math

import attrs

from roughcontact.materials.base import Material, plane_strain_compliance, poisson_ratio, young_modulus


@attrs.frozen
class Elastic(Material):
    """Homogeneous, isotropic, linear elastic half-space.

    Parameters
    ----------
    young
        Young's modulus, Pa, above zero.
    poisson
        Poisson's ratio, above -1 and at most 0.5.
    """

    young: float = attrs.field(converter=young_modulus)
    poisson: float = attrs.field(converter=poisson_ratio)

    @property
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E, 1/Pa."""
        return plane_strain_compliance(self.young, self.poisson)

    @property
    def pressure_limit(self) -> float:
        """Infinite: an elastic body bears any pressure."""
        return math.inf
