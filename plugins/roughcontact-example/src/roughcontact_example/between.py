"""An area estimator."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class Between(rc.AreaEstimator):
    """Halfway between the cells in contact and those whose four neighbours are in contact too."""

    def estimate(self, solution):
        """Return the area; half the difference is its bar."""
        outer = solution.contact
        beyond = "edge" if solution.boundary is rc.Boundary.FREE else "wrap"
        framed = np.pad(outer, 1, mode=beyond)
        inner = outer & framed[2:, 1:-1] & framed[:-2, 1:-1] & framed[1:-1, 2:] & framed[1:-1, :-2]
        fraction = 0.5 * (outer.mean() + inner.mean())
        bar = 0.5 * (outer.mean() - inner.mean())
        whole = solution.grid.area
        return rc.Area(fraction * whole, fraction, bar * whole, "between")
