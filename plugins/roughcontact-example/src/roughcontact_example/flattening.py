"""A flattening model."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class Springback(rc.FlatteningModel):
    """The overlap of saturated cells remains up to a depth of `maximum`, m; what is deeper springs back."""

    maximum: float = 10e-9

    def height_loss(self, solution):
        """Return by how much the sum of both heights is lower after unloading, shape (nx, ny), m."""
        return np.minimum(rc.Overlap().height_loss(solution), self.maximum)
