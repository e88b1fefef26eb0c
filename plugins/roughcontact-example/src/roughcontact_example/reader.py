"""A surface reader."""

import attrs
import numpy as np

import roughcontact as rc
from roughcontact.typing import RawMap


@attrs.frozen
class Raw16(rc.SurfaceReader):
    """Maps of 512 x 512 points, 16 bits each in nanometres, over 1 mm x 1 mm."""

    suffixes = frozenset({".raw16"})

    def read(self, path):
        """Return the heights, shape (512, 512), m, and the sides of the domain, m."""
        heights = np.fromfile(path, dtype="<i2").reshape(512, 512) * 1e-9
        return RawMap(heights, size=(1e-3, 1e-3), metric=True)
