"""A kernel."""

import attrs
import numpy as np

import roughcontact as rc


@attrs.frozen
class Springs(rc.InfluenceKernel):
    """Winkler's foundation: independent springs under the cells, each of length `thickness`, m."""

    thickness: float = 1e-6

    def coefficients(self, shape, spacing, compliance):
        """Return the displacement of cell (i, j) by unit pressure on cell (0, 0), shape (nx, ny), m/Pa."""
        values = np.zeros(shape)
        values[0, 0] = self.thickness * compliance
        return values

    def spectrum(self, qx, qy, spacing, compliance):
        """Return the displacement by pressure waves of unit amplitude, shape (m, n), m/Pa."""
        return np.full((qx.shape[0], qy.shape[1]), self.thickness * compliance)
