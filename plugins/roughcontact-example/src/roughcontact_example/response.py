"""A response."""

import attrs
import numpy as np

import roughcontact as rc

_VACUUM = 8.8541878128e-12  # F/m


@attrs.frozen
class Capacitance(rc.Response[rc.Estimate]):
    """Capacitance of two conductors of which one carries an insulating film, in vacuum."""

    film: float = 10e-9  # its thickness over its relative permittivity, m

    def respond(self, solution):
        """Return the capacitance, F; the area in contact brings most of its uncertainty."""
        gap = np.maximum(solution.gap, 0.0)
        value = _VACUUM * solution.grid.cell_area * float(np.sum(1.0 / (gap + self.film)))
        area = solution.area()
        return rc.Estimate(value, _VACUUM / self.film * area.uncertainty, "F", area.warnings)
