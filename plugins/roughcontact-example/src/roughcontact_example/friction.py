"""A law of friction."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class Saturating(rc.FrictionLaw):
    """Coulomb's law at light pressure, with a smooth passage to the shear strength of the softer body, Pa."""

    coefficient: float = attrs.field(converter=float, metadata={"unit": ""})
    strength: float = attrs.field(converter=float, metadata={"unit": "Pa"})

    def limit(self, pressure):
        """Return the shear strength at a pressure of at least zero, Pa."""
        return self.strength * np.tanh(self.coefficient * pressure / self.strength)
