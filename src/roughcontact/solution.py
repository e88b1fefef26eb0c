"""What a solve returns: the fields, the certificate and the answers derived from them."""

from __future__ import annotations

import math
from enum import Enum
from functools import cached_property
from typing import Protocol, runtime_checkable

import attrs
import numpy as np

from roughcontact.checks import Array, Mask
from roughcontact.clusters import Clusters, clusters_of
from roughcontact.errors import InputError
from roughcontact.grid import Boundary, Grid
from roughcontact.registry import areas
from roughcontact.units import si

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


@attrs.frozen(eq=False, kw_only=True)
class ContactSolution:
    """A solved contact.

    Attributes
    ----------
    grid, boundary
        Where the fields live, and what lies beyond.
    modulus
        Contact modulus E*, Pa.
    limit
        Greatest contact pressure, Pa, a number or an array of shape (nx, ny); `inf` where there is none.
    pressure
        Contact pressure, shape `grid.shape`, Pa.
    displacement
        Sum of the elastic displacements of both surfaces, shape `grid.shape`, m, positive into the
        bodies; its mean is zero on a periodic boundary.
    undeformed
        Gap before deformation when the summits just touch, shape `grid.shape`, m.
    approach
        Approach of the bodies since first touch, m.
    status, iterations, convolutions, seconds
        How the solve ended and what it took (wall time).
    residuals
        The certificate.
    history
        The solver's error before each iteration.
    levels
        The work on each grid, from coarse to fine, where the solver tells.
    edge_shift
        How far inside the true edge the kernel's discrete solutions put it, in cells.
    """

    grid: Grid
    boundary: Boundary
    modulus: float
    limit: float | Array
    pressure: Array
    displacement: Array
    undeformed: Array
    approach: float
    status: Status
    iterations: int
    convolutions: int
    seconds: float
    residuals: Residuals
    history: tuple[float, ...]
    levels: tuple[Level, ...] = ()
    edge_shift: float = 0.0

    @cached_property
    def clusters(self) -> Clusters:
        """The contact, told apart into cells that hang together."""
        return clusters_of(self.contact, self.pressure, self.grid, self.boundary)

    @cached_property
    def gap(self) -> Array:
        """Gap, shape `grid.shape`, m: zero in contact up to the residual, negative where saturated cells overlap."""
        gap = self.undeformed + self.displacement
        gap -= self.approach
        gap.flags.writeable = False
        return gap

    @cached_property
    def contact(self) -> Mask:
        """Cells in contact, p > 0, shape `grid.shape`."""
        return self.pressure > 0.0

    @property
    def saturated(self) -> Mask:
        """Cells whose pressure has reached the limit, shape `grid.shape`."""
        return self.pressure >= self.limit

    @property
    def force(self) -> float:
        """Normal force, N."""
        return float(np.add.reduce(self.pressure, axis=None)) * self.grid.cell_area

    @property
    def mean_pressure(self) -> float:
        """Nominal mean pressure, Pa."""
        return self.force / self.grid.area

    def area(self, estimator: str | EstimatesArea = DEFAULT_AREA) -> Area:
        """Return the real contact area.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator; the default if left out.

        Raises
        ------
        InputError
            If there is no such estimator.
        """
        chosen = areas.resolve(estimator, EstimatesArea)
        area = chosen.estimate(self)
        if not isinstance(area, Area) or not np.isfinite([area.value, area.uncertainty]).all():
            raise InputError(f"The area estimator {chosen!r} returned {area!r}, which is no Area of finite numbers.")
        return area

    def saturated_area(self, estimator: str | EstimatesArea = "level-set") -> Area:
        """Return the part of the contact area where the pressure has reached the limit; zero without a limit.

        Where the pressure is below the limit, limit - p and -gap satisfy the conditions of a contact:
        what carries there is exactly what is not saturated. So the estimators of the contact's edge
        find the edge of the saturated area as well.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator.

        Raises
        ------
        InputError
            If there is no such estimator.
        """
        if not self.saturated.any():
            return Area(0.0, 0.0, 0.0, str(estimator), perimeter=0.0)
        complement = attrs.evolve(
            self,
            pressure=self.limit - self.pressure,
            displacement=-self.displacement,
            undeformed=-self.undeformed,
            approach=-self.approach,
            # What is not saturated goes on beyond the border: that is no edge.
            boundary=Boundary.PERIODIC if self.boundary is Boundary.FREE else self.boundary,
        )
        rest = complement.area(estimator)
        # A larger one would carry more than the load.
        bearable = float(np.sum(self.pressure / self.limit)) * self.grid.cell_area
        value = min(self.grid.area - rest.value, bearable)
        return attrs.evolve(rest, value=value, fraction=value / self.grid.area, clusters=None)

    def __str__(self) -> str:
        saturated = f"\n  saturated      {self.saturated_area()}" if np.isfinite(self.limit).any() else ""
        return (
            f"{self.status}\n"
            f"  after {self.iterations} iterations, {self.convolutions} convolutions, {self.seconds:.2g} s\n"
            f"  residuals      {self.residuals}\n"
            f"  force          {si(self.force, 'N', 6)}\n"
            f"  mean pressure  {si(self.mean_pressure, 'Pa', 6)}\n"
            f"  max pressure   {si(float(self.pressure.max()), 'Pa', 6)}\n"
            f"  approach       {si(self.approach, 'm', 6)}\n"
            f"  contact area   {self.area()}{saturated}"
        )
