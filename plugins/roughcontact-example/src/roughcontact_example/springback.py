"""A permanent set."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class Springback(rc.PermanentSet):
    """The overlap stays, but not what is deeper than `deepest`, m: that springs back."""

    deepest: float = 10e-9

    def lowering(self, solution):
        """Return by how much both heights together are lower, shape (nx, ny), m."""
        return np.minimum(rc.Overlap().lowering(solution), self.deepest)
