"""Elastic-perfectly-plastic material."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array, frozen_array, number
from roughcontact.errors import InputError
from roughcontact.materials.base import Material, plane_strain_compliance, poisson_ratio, young_modulus


def _hardness(value: float | Array) -> float | Array:
    if not isinstance(value, (list, tuple)) and np.ndim(value) == 0:
        return number(value, "The hardness", "Pa", above=0.0)
    try:
        array = frozen_array(np.array(value, dtype=np.float64))
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.ndim != 2 or not (np.isfinite(array).all() and array.min() > 0.0):
        raise InputError.about("The hardness", value, "a number or an array (nx, ny), finite and above 0 (Pa)")
    return array


@attrs.frozen(eq=False)
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
        Contact pressure at full plasticity, Pa, above zero: a number, or an array of the grid's shape.
    """

    young: float = attrs.field(converter=young_modulus)
    poisson: float = attrs.field(converter=poisson_ratio)
    hardness: float | Array = attrs.field(converter=_hardness)

    @property
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E, 1/Pa."""
        return plane_strain_compliance(self.young, self.poisson)

    @property
    def pressure_limit(self) -> float | Array:
        """The hardness, Pa."""
        return self.hardness
