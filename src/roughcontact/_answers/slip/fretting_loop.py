"""The loop of tangential force and displacement."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.checks import Array, read_only
from roughcontact._base.units import outlined, si


@attrs.frozen(eq=False)
class FrettingLoop:
    """Tangential force and displacement at first loading, and in the cycles that follow.

    Attributes
    ----------
    force
        Tangential force at first loading, shape (points + 1,), N, from zero.
    displacement
        Tangential displacement, shape (points + 1,), m.
    uncertainty
        Standard deviation of the displacement, shape (points + 1,), m.
    """

    force: Array = attrs.field(converter=read_only, repr=outlined)
    displacement: Array = attrs.field(converter=read_only, repr=outlined)
    uncertainty: Array = attrs.field(converter=read_only, repr=outlined)

    @property
    def cycle(self) -> tuple[Array, Array]:
        """Force, N, and displacement, m, of a cycle from the maximum force and back, shape (2 points + 1,).

        After a reversal the change is twice that of the first loading at half the change of force (Masing).
        """
        force = self.force[-1] - 2.0 * self.force
        moved = self.displacement[-1] - 2.0 * self.displacement
        return np.concatenate((force, -force[1:])), np.concatenate((moved, -moved[1:]))

    @property
    def energy(self) -> float:
        """Area within the cycle by the trapezoidal rule, J."""
        force, moved = self.cycle
        return float(abs(np.trapezoid(force, moved)))

    def __str__(self) -> str:
        lines = [f"{'force':>12} {'displacement':>14}"]
        lines += [f"{si(q, 'N'):>12} {si(u, 'm'):>14}" for q, u in zip(self.force, self.displacement, strict=True)]
        return "\n".join(lines)
