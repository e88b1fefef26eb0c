"""Elastic-perfectly-plastic material."""

from __future__ import annotations

import attrs

from roughcontact.checks import number
from roughcontact.materials.base import Material, poisson_ratio, young_modulus


def _hardness(value: float) -> float:
    return number(value, "The hardness", "Pa", above=0.0)


@attrs.frozen
class ElasticPerfectlyPlastic(Material):
    """Elastic until the contact pressure reaches the hardness, which it never exceeds.

    The displacement stays that of the elastic half-space under the capped pressure; where the cap
    is reached, the surfaces may overlap by the plastic flattening.

    Parameters
    ----------
    young
        Young's modulus, Pa, above zero.
    poisson
        Poisson's ratio, above -1 and at most 0.5.
    hardness
        Contact pressure at full plasticity, Pa, above zero.
    """

    young: float = attrs.field(converter=young_modulus)
    poisson: float = attrs.field(converter=poisson_ratio)
    hardness: float = attrs.field(converter=_hardness)

    @property
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E, 1/Pa."""
        return (1.0 - self.poisson**2) / self.young

    @property
    def pressure_limit(self) -> float:
        """The hardness, Pa."""
        return self.hardness
