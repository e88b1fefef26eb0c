"""An area estimator."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class Between(rc.AreaEstimator):
    """Halfway between the cells in contact and those whose four neighbours are in contact too."""

    def estimate(self, solution):
        """Return the real contact area; half the difference is its uncertainty."""
        outer = solution.contact
        beyond = "edge" if solution.boundary is rc.Boundary.FREE else "wrap"
        padded = np.pad(outer, 1, mode=beyond)
        inner = outer & padded[2:, 1:-1] & padded[:-2, 1:-1] & padded[1:-1, 2:] & padded[1:-1, :-2]
        fraction = 0.5 * (outer.mean() + inner.mean())
        uncertainty = 0.5 * (outer.mean() - inner.mean())
        nominal = solution.grid.area
        return rc.Area(fraction * nominal, fraction, uncertainty * nominal, "between")
