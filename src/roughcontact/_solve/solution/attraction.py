"""The conditions of an adhesive contact, measured on a pressure and a tension.

With the displacement u by the pressure p, the initial gap h, the gap g = u + h - approach and the tension t, the
contact pressure is c = p + t. The exact solution satisfies g = 0 where c > 0 and p is below its limit, g >= 0 and
t = s(g), the law of the interaction, where c = 0, and g <= 0 where p is at its limit.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.checks import Array, Mask
from roughcontact._parts.interactions import BoundInteraction

# Rounding of the gap over its largest term, as in `conditions`.
_ROUNDING = 16.0 * float(np.finfo(np.float64).eps)


@attrs.frozen
class AdhesiveViolation:
    """The amount by which a pressure and a tension violate the conditions of contact, and the approach they imply.

    Attributes
    ----------
    approach
        The approach, given or implied by the contact pressure.
    complementarity
        Mean of the gaps that should vanish, weighted by the contact pressure, over `scale`.
    penetration
        Maximum overlap outside the saturated cells, over `scale`.
    tension
        Maximum difference between the tension and the law at the gap, over the strength of the law.
    gap
        The same difference over the maximum slope of the law and `scale`: how far the gap is off.
    bounds
        Maximum amount by which the pressure leaves its bounds, minus the strength and the limit, over the strength.
    scale
        The smaller of the standard deviation of the initial gap and the range of the displacement.
    floor
        The error that rounding in float64 may cause on these fields, over `scale`.
    """

    approach: float
    complementarity: float
    penetration: float
    tension: float
    gap: float
    bounds: float
    scale: float
    floor: float

    @property
    def error(self) -> float:
        """The maximum of the errors of the gap: complementarity, penetration, `gap` and `floor`."""
        return max(self.complementarity, self.penetration, self.gap, self.floor)


@attrs.frozen(eq=False, kw_only=True)
class AdhesiveConditions:
    """The conditions of one adhesive contact, in float64 and in the units of a `Task`.

    Parameters
    ----------
    initial_gap
        Gap before deformation, shape (nx, ny).
    interaction
        The law.
    pressure_limit
        Maximum pressure, which broadcasts to (nx, ny); `inf` where there is none.
    approach
        The approach if it is given; None if the load is.
    rms
        The standard deviation of the initial gap, if it is not that of all cells.
    """

    initial_gap: Array
    interaction: BoundInteraction
    pressure_limit: Array = attrs.field(factory=lambda: np.array(math.inf))
    approach: float | None = None
    rms: float | None = None

    def measure(self, pressure: Array, tension: Array, displacement: Array) -> AdhesiveViolation:
        """Return the violation by a pressure and a tension, and the displacement by the pressure, shape (nx, ny).

        Unless it is given, the approach is the mean of u + h weighted by the contact pressure of the cells that are
        not saturated; without such cells, the value at which the highest cell touches.
        """
        contact = np.maximum(pressure + tension, 0.0)
        saturated = pressure >= self.pressure_limit
        elastic = np.where(saturated, 0.0, contact)
        approach = self._find_approach(elastic, saturated, displacement)
        gap = displacement + self.initial_gap
        gap -= approach
        closing = np.where(saturated, np.maximum(gap, 0.0), gap)
        carried = float(contact.sum())
        opened = float(np.einsum("ij,ij->", contact, np.abs(closing))) / carried if carried > 0.0 else 0.0
        overlap = max(0.0, -float(closing.min()))
        scale = self._find_scale(displacement, pressure)
        off = self._tension_error(gap, tension, contact)
        strength = float(np.max(self.interaction.strength))
        below = float((-np.asarray(self.interaction.strength) - pressure).max())
        above = float((pressure - self.pressure_limit).max())
        largest = max(float(np.abs(displacement).max()), float(np.abs(pressure).max()), abs(approach))
        return AdhesiveViolation(
            approach=approach,
            complementarity=opened / scale,
            penetration=overlap / scale,
            tension=off / strength,
            gap=off / (self.interaction.steepest * scale),
            bounds=max(0.0, below, above) / strength,
            scale=scale,
            floor=_ROUNDING * largest / scale,
        )

    def _find_approach(self, elastic: Array, saturated: Mask, displacement: Array) -> float:
        if self.approach is not None:
            return self.approach
        load = float(elastic.sum())
        if load > 0.0:
            return float(np.einsum("ij,ij->", elastic, displacement + self.initial_gap)) / load
        moved = displacement + self.initial_gap
        return float(moved[saturated].max()) if saturated.any() else float(moved.min())

    def _find_scale(self, displacement: Array, pressure: Array) -> float:
        rms = float(self.initial_gap.std()) if self.rms is None else self.rms
        moved = float(displacement.max() - displacement.min())
        elastic = moved if moved > _ROUNDING * float(np.abs(pressure).max()) else 0.0
        return min(rms, elastic) or max(rms, elastic) or 1.0

    def _tension_error(self, gap: Array, tension: Array, contact: Array) -> float:
        """Return the maximum difference of the tension from the law: at the gap of open cells, at zero in contact."""
        law = self.interaction.tension(np.where(contact > 0.0, 0.0, np.maximum(gap, 0.0)))
        return float(np.abs(law - tension).max())
