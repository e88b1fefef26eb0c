"""The state of a contact with friction at one point of a path, its tangential load and its residuals."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.archive import digest_of
from roughcontact._base.arrays import Array, Pair, read_only
from roughcontact._base.units import ShownAsPrinted, si
from roughcontact._solve.solution.results import Residuals


@attrs.frozen(eq=False, kw_only=True)
class FrictionalState:
    """What the next step of a path knows of the one before: no slip is stored, it follows.

    Attributes
    ----------
    pressure
        Contact pressure, shape (nx, ny), Pa.
    shear
        Traction on the body, shape (2, nx, ny), Pa.
    displacement
        Tangential displacement of the counterbody (x, y), m.
    approach
        Approach since first touch, m.
    """

    pressure: Array = attrs.field(converter=read_only)
    shear: Array = attrs.field(converter=read_only)
    displacement: Pair
    approach: float

    @classmethod
    def unloaded(cls, shape: tuple[int, int]) -> FrictionalState:
        """Return the state of bodies that just touch."""
        return cls(pressure=np.zeros(shape), shear=np.zeros((2, *shape)), displacement=(0.0, 0.0), approach=0.0)

    @cached_property
    def digest(self) -> str:
        """Hexadecimal digits that identify the state by its values."""
        numbers = np.array([*self.displacement, self.approach])
        names = [digest_of(one) for one in (self.pressure, self.shear, numbers)]
        return digest_of(np.array(names))


@attrs.frozen
class TangentialLoad:
    """What is given along the surface in one step.

    Attributes
    ----------
    kind
        ``"tangential_force"``, N; ``"displacement"``, m; or ``"direction"`` of steady sliding, a unit vector.
    values
        Components along x and y.
    """

    kind: str
    values: Pair

    @property
    def unit(self) -> str:
        """SI unit of the values."""
        return {"tangential_force": "N", "displacement": "m"}.get(self.kind, "")

    def __str__(self) -> str:
        return f"({', '.join(si(value, self.unit) for value in self.values)})"


@attrs.frozen
class FrictionalResiduals(ShownAsPrinted):
    """The violations of the conditions of contact with friction, recomputed in float64 from two states in a row.

    Attributes
    ----------
    normal
        Those of the normal contact, whose initial gap is changed by the displacement due to the traction.
    shear_load
        Error of the tangential force over the sum of the shear strengths, or of a given displacement over the range of
        the initial gap.
    cone
        Maximum excess of the traction over the shear strength, over the maximum of the strength.
    slip
        Maximum over all cells of :math:`|q - P_s(q + w/k)|`, over the maximum of the strength s: zero if and only if
        cells below their strength do not slip, and the others slip along their traction. The slip is w, k the
        displacement of a cell by its own traction, and P the nearest traction within the strength.
    dissipation
        Energy gained by slip, which must lose energy, over k times the maximum times the sum of the strengths.
    energy
        Error of the balance of elastic energy and work in the last increment, over the largest of its terms.
    """

    normal: Residuals
    shear_load: float = attrs.field(converter=float)
    cone: float = attrs.field(converter=float)
    slip: float = attrs.field(converter=float)
    dissipation: float = attrs.field(converter=float)
    energy: float = attrs.field(converter=float)

    @property
    def error(self) -> float:
        """The maximum of the errors of the normal contact, of cone and slip."""
        return max(self.normal.error, self.cone, self.slip)

    def __str__(self) -> str:
        return (
            f"{self.normal}, tangential load {self.shear_load:.1e}, cone {self.cone:.1e}, slip {self.slip:.1e}, "
            f"energy {self.energy:.1e}"
        )
