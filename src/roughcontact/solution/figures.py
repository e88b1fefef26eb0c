"""How a solve ended, its residuals and its areas."""

from __future__ import annotations

import math
from enum import Enum
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import attrs

from roughcontact.checks import Array

if TYPE_CHECKING:
    from roughcontact.solution.contact import ContactSolution

DEFAULT_AREA = "blend"


class Status(Enum):
    """How a solve ended, in a sentence."""

    CONVERGED = "converged: the conditions of contact hold within the tolerance"
    CONVERGED_TO_ROUNDING = "converged to rounding: the conditions of contact hold as well as float64 can tell"
    RESCUED = (
        "converged: the conditions of contact hold within the tolerance, by a second method, for the first stalled"
    )
    UNRESOLVED = "not converged: displacement or pressure dwarf the relief so much that float64 cannot resolve the gap"
    MAXIMUM_ITERATIONS = "not converged: the maximum number of iterations was reached"
    STALLED = "not converged: no step lowers the error any more"
    NOT_FINITE = "not converged: a value that is not finite appeared"
    UNCONFIRMED = "not converged: the residuals recomputed from the pressure do not confirm the solver"

    @property
    def success(self) -> bool:
        """Whether the solution is certified."""
        return self in (Status.CONVERGED, Status.CONVERGED_TO_ROUNDING, Status.RESCUED)

    def __str__(self) -> str:
        return self.value


@attrs.frozen
class Residuals:
    """The violations of the conditions of contact, recomputed in float64 from the pressure alone.

    Attributes
    ----------
    complementarity
        Pressure-weighted mean of the gap where it ought to vanish, divided by `scale`.
    penetration
        Deepest overlap outside the saturated cells, divided by `scale`.
    load
        Relative error of the load.
    scale
        Height that counts as one, m: the smaller of the rms relief and the range of the displacement.
    """

    complementarity: float
    penetration: float
    load: float
    scale: float

    @property
    def error(self) -> float:
        """The greater of complementarity and penetration."""
        return max(self.complementarity, self.penetration)

    def __str__(self) -> str:
        return f"complementarity {self.complementarity:.1e}, penetration {self.penetration:.1e}, load {self.load:.1e}"


@attrs.frozen
class Level:
    """The work on one of the grids that a solver went through.

    Attributes
    ----------
    shape
        Cells of the grid.
    iterations
        Iterations on it.
    double, single
        Convolutions in float64 and in float32.
    inverse
        Applications of the approximate inverse, each the cost of a convolution.
    """

    shape: tuple[int, int]
    iterations: int
    double: int
    single: int = 0
    inverse: int = 0


@attrs.frozen
class Area:
    """Real contact area with its error bar.

    Attributes
    ----------
    value
        Area, m2.
    fraction
        Area over nominal area.
    uncertainty
        Standard deviation, as the estimator knows it, m2: the true area should lie within two of them.
    estimator
        The estimator that made it.
    perimeter
        Length of the edge of the contact, m; nan where the estimator does not tell.
    doubts
        Why the value must not be trusted, in sentences; empty if nothing speaks against it.
    clusters
        Area of each of the solution's clusters, shape (count,), m2; None where the estimator does not tell.
    """

    value: float
    fraction: float
    uncertainty: float
    estimator: str
    perimeter: float = attrs.field(default=math.nan, kw_only=True)
    doubts: tuple[str, ...] = attrs.field(default=(), kw_only=True)
    clusters: Array | None = attrs.field(default=None, kw_only=True, eq=False, repr=False)

    def __str__(self) -> str:
        relative = self.uncertainty / self.value if self.value > 0.0 else 0.0
        bar = f"{100 * relative:.2g} %" if self.value > 0.0 else f"{self.uncertainty:.2g} m2"
        doubtful = "".join(f"; doubtful: {doubt}" for doubt in self.doubts)
        return f"{self.value:.5g} m2 ({100 * self.fraction:.4g} % of nominal) +- {bar} [{self.estimator}]{doubtful}"


@runtime_checkable
class EstimatesArea(Protocol):
    """Anything that estimates the real contact area from a solution."""

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the area."""
