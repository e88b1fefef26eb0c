"""A law of adhesion."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class Capillary(rc.Interaction):
    """Water between two hydrophilic surfaces: Laplace's tension as far as the meniscus reaches, then none.

    Parameters
    ----------
    surface_energy
        Surface energy of the liquid, J/m2.
    kelvin_radius
        Radius of the meniscus, m.
    smoothing
        Length over which the tension falls at the end of the meniscus, m.
    """

    surface_energy: float
    kelvin_radius: float
    smoothing: float

    def tension(self, gap):
        """Return gamma / r inside the meniscus, up to a gap of 2 r, Pa; a logistic function ends it."""
        place = (np.asarray(gap) - 2 * self.kelvin_radius) / self.smoothing
        return self.surface_energy / self.kelvin_radius / (1 + np.exp(place))

    def slope(self, gap):
        """Return the derivative of the tension, Pa/m."""
        place = (np.asarray(gap) - 2 * self.kelvin_radius) / self.smoothing
        return -self.surface_energy / self.kelvin_radius / self.smoothing / (2 * np.cosh(place / 2)) ** 2

    def energy(self, gap):
        """Return the integral of the tension from far away, J/m2."""
        place = (np.asarray(gap) - 2 * self.kelvin_radius) / self.smoothing
        return -self.surface_energy / self.kelvin_radius * self.smoothing * np.logaddexp(0, -place)
