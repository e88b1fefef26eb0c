"""The conditions of contact, measured on a pressure field.

With the gap g = u + h - approach the exact solution satisfies g = 0 where 0 < p < limit, g >= 0
where p = 0 and g <= 0 (plastic overlap) where p = limit.
"""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array


@attrs.frozen
class Optimality:
    """How far a pressure field is from satisfying the conditions of contact.

    Attributes
    ----------
    approach
        The level of u + h in the contact.
    complementarity
        Pressure-weighted mean of the gaps that ought to vanish, in units of the scale.
    penetration
        Deepest overlap outside the saturated cells, in units of the scale.
    scale
        The height that counts as one: the smaller of the rms relief and the range of the elastic
        displacement, so that neither a tall surface nor a light load hides an error.
    """

    approach: float
    complementarity: float
    penetration: float
    scale: float

    @property
    def error(self) -> float:
        """The greater of both violations."""
        return max(self.complementarity, self.penetration)


def optimality(pressure: Array, displacement: Array, undeformed: Array, limit: float) -> Optimality:
    """Measure the violation of the conditions of contact, in float64.

    Parameters
    ----------
    pressure
        Contact pressure, shape (nx, ny), between 0 and `limit`, not zero everywhere.
    displacement
        Displacement it causes, shape (nx, ny).
    undeformed
        Undeformed gap, from any datum, shape (nx, ny).
    limit
        Greatest pressure; `inf` where there is none.

    Notes
    -----
    The approach is the pressure-weighted mean of u + h over the cells that are neither open nor
    saturated; where there is none, any level that separates both kinds would do.
    """
    level = displacement + undeformed
    saturated = pressure >= limit
    bearing = np.where(saturated, 0.0, pressure) if saturated.any() else pressure
    load = float(np.add.reduce(bearing, axis=None))
    approach = float(np.einsum("ij,ij->", bearing, level)) / load if load > 0.0 else _between(level, pressure, limit)
    level -= approach
    allowed = np.where(saturated, np.maximum(level, 0.0), level)
    scale = _scale(displacement, undeformed)
    violation = float(np.einsum("ij,ij->", pressure, np.abs(allowed))) / float(np.add.reduce(pressure, axis=None))
    return Optimality(approach, violation / scale, max(0.0, -float(allowed.min())) / scale, scale)


def rounding_floor(displacement: Array, undeformed: Array, scale: float) -> float:
    """Return the violation that float64 cannot go below on these fields."""
    size = float(np.abs(displacement).max()) + float(np.abs(undeformed).max())
    return 16.0 * float(np.finfo(np.float64).eps) * size / scale


def _scale(displacement: Array, undeformed: Array) -> float:
    relief = float(undeformed.std())
    elastic = float(displacement.max() - displacement.min())
    return min(relief, elastic) or max(relief, elastic) or 1.0


def _between(level: Array, pressure: Array, limit: float) -> float:
    """Return a level that separates the saturated from the open cells, as well as there is one."""
    lower = float(level[pressure >= limit].max())
    open_cells = pressure <= 0.0
    return min(lower, float(level[open_cells].min())) if open_cells.any() else lower
