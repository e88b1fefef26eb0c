"""A material."""

import attrs

import roughcontact as rc


@attrs.frozen
class Foam(rc.Material):
    """Open-cell foam: Gibson and Ashby's scaling laws for stiffness and plastic collapse.

    Parameters
    ----------
    young
        Young's modulus of the solid, Pa.
    strength
        Yield strength of the solid, Pa.
    density
        Density of the foam over that of the solid; the laws hold up to about 0.3.
    """

    young: float
    strength: float
    density: float

    @property
    def compliance(self):
        """(1 - nu^2) / E with E = E_solid density^2 and nu = 1/3, 1/Pa."""
        return (1 - 1 / 9) / (self.young * self.density**2)

    @property
    def pressure_limit(self):
        """0.3 strength density^(3/2), Pa."""
        return 0.3 * self.strength * self.density**1.5
