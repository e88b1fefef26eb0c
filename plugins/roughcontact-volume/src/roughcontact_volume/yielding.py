"""What a material that yields is made of: elastic constants, yield stress and hardening."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array, Quantity, si

from roughcontact_volume.hardening import Hardening, LinearHardening, check_number, check_stress
from roughcontact_volume.residual_stress import ResidualStress


def _young(value: Quantity) -> float:
    return rc.Elastic(value, 0.0).young


def _poisson(value: Quantity) -> float:
    return rc.Elastic(1.0, value).poisson


def _yield_stress(value: Quantity) -> float:
    return check_stress(value, "The yield stress")


def _accuracy(value: float) -> float:
    return check_number(value, "The accuracy of the substeps", "", most=1.0)


def _hardening(value: Any) -> Hardening:
    if value is None:
        return LinearHardening(0.0)
    if isinstance(value, Hardening):
        return value
    if isinstance(value, (int, float, str)) and not isinstance(value, bool):
        return LinearHardening(value)
    raise rc.InputError.about(
        "The hardening of a material",
        value,
        "None for perfect plasticity, a modulus such as '4GPa', or a Hardening such as SwiftHardening(0.005, 0.2)",
    )


def _residual(value: Any) -> ResidualStress | None:
    if value is None or isinstance(value, ResidualStress):
        return value
    raise rc.InputError.about("The residual stress of a material", value, "None or a ResidualStress(depth, stress)")


@attrs.frozen
class Yielding(rc.Material):
    """An elastic material with a yield stress that hardens; see `Plastic`, which flows in a contact."""

    young: float = attrs.field(converter=_young, metadata={"unit": "Pa"})
    poisson: float = attrs.field(converter=_poisson, metadata={"unit": ""})
    yield_stress: float = attrs.field(converter=_yield_stress, metadata={"unit": "Pa"})
    hardening: Hardening = attrs.field(default=None, converter=_hardening)
    accuracy: float = attrs.field(default=0.02, converter=_accuracy, kw_only=True, metadata={"unit": ""})
    residual: ResidualStress | None = attrs.field(default=None, converter=_residual, kw_only=True)

    def __attrs_post_init__(self) -> None:
        self.hardening.require_fitting(self.yield_stress)
        largest = 0.0 if self.residual is None else self.residual.find_largest()
        if largest >= self.yield_stress:
            raise rc.InputError(
                f"The residual stress alone makes the material yield: its von Mises stress is {si(largest, 'Pa')}, the "
                f"yield stress {si(self.yield_stress, 'Pa')}."
            )

    @property
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E, 1/Pa."""
        return (1.0 - self.poisson**2) / self.young

    @property
    def pressure_limit(self) -> float:
        """Infinite: what limits the pressure is the flow below it."""
        return math.inf

    @property
    def shear_modulus(self) -> float:
        """Shear modulus E / (2 (1 + nu)), Pa."""
        return 0.5 * self.young / (1.0 + self.poisson)

    def find_yield_stress(self, strain: Array) -> Array:
        """Return the yield stress, Pa, after an accumulated plastic strain."""
        return self.hardening.find_yield_stress(self.yield_stress, strain)

    def find_slope(self, strain: Array) -> Array:
        """Return its derivative by the strain, Pa."""
        return self.hardening.find_slope(self.yield_stress, strain)

    def find_residual(self, thicknesses: Array) -> Array:
        """Return the residual stress that it has without any flow, mean over layers, shape (6, nz), Pa."""
        if self.residual is None:
            return np.zeros((6, len(thicknesses)))
        return self.residual.find_mean_stress(thicknesses)

    def find_work(self, strain: Array) -> Array:
        """Return the plastic work per volume until an accumulated plastic strain, J/m3."""
        return self.hardening.find_work(self.yield_stress, strain)
