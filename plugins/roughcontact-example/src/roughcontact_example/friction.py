"""A law of friction."""

import attrs

import roughcontact as rc


@attrs.frozen
class Junctions(rc.FrictionLaw):
    """Junctions that grow with the pressure until they are one: friction at low pressure, a shear strength at high one.

    Parameters
    ----------
    coefficient
        Coefficient of friction at low pressure.
    strength
        Shear strength of the material, Pa.
    """

    coefficient: float
    strength: float

    def limit(self, pressure):
        """Return s = mu p k / (mu p + k), Pa."""
        sheared = self.coefficient * pressure
        return sheared * self.strength / (sheared + self.strength)
