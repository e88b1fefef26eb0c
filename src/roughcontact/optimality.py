"""The conditions of contact, measured on a pressure field.

With the gap g = u + h - approach the exact solution satisfies g = 0 where 0 < p < limit, g >= 0
where p = 0 and g <= 0 (plastic overlap) where p = limit.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact.checks import Array

# A gap that is known to this share of the scale only is not known.
_RESOLVED = 1e-5
# A pressure that bends the surface by no more than this share of itself is uniform up to rounding.
_UNIFORM = 1e-12
_ROUNDING = 16.0 * float(np.finfo(np.float64).eps)


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
    floor
        The error that float64 cannot go below on these fields.
    """

    approach: float
    complementarity: float
    penetration: float
    scale: float
    floor: float

    @property
    def error(self) -> float:
        """The greater of both violations."""
        return max(self.complementarity, self.penetration)

    @property
    def resolved(self) -> bool:
        """Whether the floor is low enough for the gap to mean anything."""
        return self.floor <= _RESOLVED


class Conditions:
    """The conditions of one contact, to be measured on any pressure, in float64 and in the units of a `Task`.

    Parameters
    ----------
    undeformed
        Undeformed gap, from any datum, shape (nx, ny).
    limit
        Greatest pressure, a number or an array; `inf` where there is none.
    approach
        Level of u + h in the contact where it is given; None where the load is.
    """

    def __init__(self, undeformed: Array, limit: float | Array = math.inf, approach: float | None = None) -> None:
        self._undeformed = undeformed
        self._limit = limit
        self._approach = approach
        self._capped = bool(np.isfinite(limit).any())
        self._relief = float(undeformed.std())
        self._size = float(np.abs(undeformed).max())

    def measure(self, pressure: Array, displacement: Array) -> Optimality:
        """Measure a pressure and the displacement it causes, both of shape (nx, ny).

        The pressure lies between zero and the limit. The approach is the pressure-weighted mean of
        u + h over the cells that are neither open nor saturated, if it is not given; where there is
        none, any level that separates both kinds would do.
        """
        level = displacement + self._undeformed
        saturated = pressure >= self._limit if self._capped else None
        bearing = pressure if saturated is None else np.where(saturated, 0.0, pressure)
        load = float(np.add.reduce(bearing, axis=None))
        approach = self._approach
        if approach is None:
            weighted = float(np.einsum("ij,ij->", bearing, level))
            approach = weighted / load if load > 0.0 else self._between(level, pressure)
        level -= approach
        if saturated is not None:
            # Overlap is what saturation means; only an open gap is an error there.
            np.maximum(level, 0.0, out=level, where=saturated)
        deepest = float(level.min())
        np.abs(level, out=level)
        total = load if saturated is None else float(np.add.reduce(pressure, axis=None))
        # No pressure at all is an answer to a given approach, never to a given load.
        none = math.inf if self._approach is None else 0.0
        open_gap = float(np.einsum("ij,ij->", pressure, level)) / total if total > 0.0 else none
        low, high = float(displacement.min()), float(displacement.max())
        # In cells and E* = 1 a pressure moves its own cell by about as much.
        elastic = high - low if high - low > _UNIFORM * float(pressure.max()) else 0.0
        scale = min(self._relief, elastic) or max(self._relief, elastic) or 1.0
        # On a periodic domain a pressure moves nothing as a whole, but its rounding moves single cells.
        floor = _ROUNDING * (max(high, -low, float(pressure.max())) + self._size) / scale
        return Optimality(approach, open_gap / scale, max(0.0, -deepest) / scale, scale, floor)

    def _between(self, level: Array, pressure: Array) -> float:
        """Return a level that separates the saturated from the open cells, as well as there is one."""
        lower = float(level[pressure >= self._limit].max(initial=level.min()))
        open_cells = pressure <= 0.0
        return min(lower, float(level[open_cells].min())) if open_cells.any() else lower
