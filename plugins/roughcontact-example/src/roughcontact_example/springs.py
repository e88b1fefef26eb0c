"""A kernel."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class Springs(rc.InfluenceKernel):
    """Winkler's foundation: springs under the cells, as deep as `thickness`, m."""

    thickness: float = 1e-6

    def coefficients(self, shape, spacing, compliance):
        """Return the displacement of the cells (i, j) by a pressure on the cell (0, 0), m/Pa."""
        values = np.zeros(shape)
        values[0, 0] = self.thickness * compliance
        return values

    def spectrum(self, qx, qy, spacing, compliance):
        """Return the displacement by waves of pressure, m/Pa."""
        return np.full((qx.shape[0], qy.shape[1]), self.thickness * compliance)
