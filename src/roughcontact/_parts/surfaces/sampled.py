"""A surface as it is drawn: its heights on a grid."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.checks import Array
from roughcontact._base.units import outlined
from roughcontact._parts.grid import Grid


@attrs.frozen(eq=False)
class SampledSurface:
    """Heights of a surface on a grid, as a `Panel` of surfaces gets them.

    Attributes
    ----------
    heights
        Shape `grid.shape`, m, positive outward; NaN at non-measured points.
    grid
        The cells.
    periodic
        Whether the surface repeats beyond its border.
    """

    heights: Array = attrs.field(repr=outlined)
    grid: Grid
    periodic: bool

    @property
    def rms_height(self) -> float:
        """Root mean square of the measured heights about their mean, m."""
        return float(np.nanstd(self.heights))
