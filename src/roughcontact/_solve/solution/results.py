"""Status and residuals of a solve, responses, areas and their estimators."""

from __future__ import annotations

import abc
import math
from collections.abc import Collection, Mapping
from enum import Enum
from types import MappingProxyType
from typing import Any, ClassVar, Generic, Literal, TypeAlias, TypeVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, as_shape, read_only
from roughcontact._base.checks import Part, number
from roughcontact._base.machine import require_memory
from roughcontact._base.registry import Registry
from roughcontact._base.units import Estimate as Estimate
from roughcontact._base.units import ShownAsPrinted, WarningText, prefixed, si, with_spread
from roughcontact._solve.solution.additions import Condition
from roughcontact.errors import InputError, argument

T_co = TypeVar("T_co", covariant=True)
DEFAULT_AREA = "blend"
# The load of a patch does not tell its area where surfaces attract each other; its edge does.
DEFAULT_ADHESIVE_AREA = "level-set"
# Maximum error by rounding, over the scale, at which float64 resolves the gap: see docs/use/conventions.md.
_MAX_RESOLVED_ERROR = 1e-5
# Distance of a pressure at the limit, over the limit, and gap that counts as zero, over the scale.
_LIMIT_TOLERANCE = 1e-4
# Fraction of the pressure limit above which a cell, whose pressure is a mean, may contain saturated points.
_NEAR_LIMIT_FRACTION = 0.95
# Maximum undecided fraction of the saturated area without a warning.
_MAX_UNDECIDED_FRACTION = 0.05
# Additional standard deviation of the position of the edge of saturated cells, cells: the elastic ring around them is
# narrow. Measured on 60 balls whose maximum pressure by Hertz is 1.15 to 2.5 times the limit.
_SATURATED_EDGE_STD = 0.055
_NO_LIMITS: Mapping[str, str] = MappingProxyType({})
_RUN_IN_WARNING = WarningText(
    "cells at the pressure limit hardly overlap, as on run-in surfaces: their saturated part is not determined",
    "run in",
)


class Response(Part, abc.ABC, Generic[T_co]):
    """The response of a contact to a small change, a current or a flow. Subclass it and define `respond`.

    Its further arguments, such as a conductivity or depths, are fields of the subclass.

    Attributes
    ----------
    depends_on_place
        Whether its value changes if a periodic contact is shifted, as for a flow between two sides.
    holds_with
        What may act beside the pressure: ``"tension"`` of surfaces that attract each other; ``"shear"``, and what other
        laws add, with which it is that of the normal contact or, if it has a field ``traction``, of pressure and
        traction; ``"relaxation"`` of viscoelastic bodies, where it reads the fields alone. It is refused where one acts
        that is not named.
    refusal
        Why it does not hold with shear, in words.
    fails_with
        What laws may do below a surface that it does not know, `Law.explain_limits`: ``"inner stress"``, ``"inner
        flow"``, ``"inner moduli"``. It is refused where a law does it.
    reads
        What its `pressure` is where there is tension: ``"total pressure"``, the normal contact as it is, or ``"contact
        pressure"``, the part that presses; or ``"state"``: all of the solution, with what laws have added to it.
    flagged_factors
        Its standard deviation where sharp edges or rough heights are flagged: over its change over two grids, zero for
        that of the model unless two grids are asked; and at least over that of the model.
    memory_arrays
        Peak memory beyond the solution, in float64 arrays of the grid: what does not fit is refused.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class OpenVolume(rc.Response):
    ...     def respond(self, solution):
    ...         volume = float(solution.gap.sum()) * solution.grid.cell_area
    ...         return rc.Estimate(volume, 0.01 * volume, "m3")
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> body = rc.Body(wave, rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> print(problem.solve(pressure=100e6).response(OpenVolume()))
    18140 µm3 +- 1 %
    """

    depends_on_place: ClassVar[bool] = False
    holds_with: ClassVar[frozenset[str]] = frozenset({"shear"})
    refusal: ClassVar[str] = "it knows no traction"
    fails_with: ClassVar[frozenset[str]] = frozenset()
    reads: ClassVar[str] = "total pressure"
    flagged_factors: ClassVar[tuple[float, float]] = (1.0, 1.0)
    memory_arrays: ClassVar[float] = 12.0

    @abc.abstractmethod
    def respond(self, solution: Any) -> T_co:
        """Return the response: an `Estimate`, or an object with its uncertainty and warnings.

        Raises
        ------
        InputError
            If it is not defined for this contact; the message says why.
        """


# Registered names of the responses without arguments that answer a number.
NameOfNumber: TypeAlias = Literal[
    "approach", "mean-gap", "patches", "peak-pressure", "perimeter", "pull-off", "stability", "stiffness",
    "tangential-stiffness",
]  # fmt: skip
responses: Registry[Response[Any]] = Registry(Response, "response", "roughcontact.responses")


def list_fields(response: Response[Any]) -> tuple[str, ...]:
    """Return the names of the fields of a response."""
    kind: Any = type(response)
    return tuple(attrs.fields_dict(kind)) if attrs.has(kind) else ()


def require_to_hold(response: Response[Any], laws: Collection[str], limits: Mapping[str, str] = _NO_LIMITS) -> None:
    """Raise `InputError` if a response does not hold with what laws add to the pressure, `ContactFields._laws`.

    `limits` are the reasons of `Addition.limits`.
    """
    kind = type(response)
    for unknown in sorted(response.fails_with & limits.keys()):
        name = responses.name_of(kind) or kind.__name__
        raise InputError(f"The response {name!r} is not known for this contact: {limits[unknown]}.")
    if "tension" in laws and "tension" not in response.holds_with:
        raise InputError(f"{kind.__name__} does not hold for surfaces that attract each other: it knows no tension.")
    if "relaxation" in laws and "relaxation" not in response.holds_with:
        name = responses.name_of(kind) or kind.__name__
        raise InputError(f"The response {name!r} is not known for bodies that relax: it takes one modulus.")
    if set(laws) - {"tension"} and "shear" not in response.holds_with:
        name = responses.name_of(kind) or kind.__name__
        what = "friction" if laws != {"laws"} else "laws"
        raise InputError(f"The response {name!r} is not for a contact with {what}: {response.refusal}.")


def ask(solution: Any, response: Response[Any]) -> Any:
    """Return what a response answers, with a value and an uncertainty if it is a number; see `ContactSolution`."""
    require_memory_of_answer(solution, response)
    found = response.respond(solution._view(response))
    if isinstance(found, Estimate) and not (found.uncertainty >= 0.0 and abs(found.value) >= 0.0):
        raise InputError(f"The response {response!r} returned {found!r}, which has no value or no uncertainty.")
    return found


def require_memory_of_answer(solution: Any, response: Response[Any]) -> None:
    """Refuse a response that takes more memory than there is, or than its problem allows."""
    source: Any = None if solution.origin is None else solution.origin.source
    require_memory(
        8.0 * solution.grid.cells * response.memory_arrays,
        f"{type(response).__name__} of a contact on {' x '.join(map(str, solution.grid.shape))} cells",
        "ask a coarser grid for it",
        None if source is None else source.memory_limit,
    )


def list_estimates(found: object) -> dict[str, Estimate]:
    """Return the numbers of what a response has returned, by name; empty without any.

    A single number has an empty name; other results have `estimates`.
    """
    if isinstance(found, Estimate):
        return {"": found}
    value, spread = (getattr(found, part, None) for part in ("value", "uncertainty"))
    if isinstance(value, (int, float)) and isinstance(spread, (int, float)):
        warnings = tuple(getattr(found, "warnings", ()))
        return {"": Estimate(float(value), float(spread), getattr(found, "unit", None) or "", warnings)}
    return dict(getattr(found, "estimates", {}))


def read_number(found: object, name: str) -> Estimate:
    """Return what a response has returned as one number; `InputError` if it is something else."""
    number = list_estimates(found).get("")
    if number is None or math.isnan(number.value):
        raise InputError(f"The response {name!r} is not a number with an uncertainty.")
    return number


class Status(Enum):
    """How a solve ended, in a sentence.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> problem.solve(force=1.0).status is rc.Status.CONVERGED
    True
    """

    CONVERGED = "converged: the conditions of contact hold within the tolerance"
    CONVERGED_TO_ROUNDING = "converged to rounding: the conditions of contact hold as well as double precision can tell"
    RESCUED = (
        "converged: the conditions of contact hold within the tolerance, by a second method after the first stalled"
    )
    UNRESOLVED = "not converged: the displacement or the pressure is too large for double precision to resolve the gap"
    MAXIMUM_ITERATIONS = "not converged: the maximum number of iterations was reached"
    STALLED = "not converged: no step reduces the error further"
    SEPARATED = "separated: no contact carries this load, the surfaces come apart"
    NOT_FINITE = "not converged: a value that is not finite appeared"
    UNCONFIRMED = "not converged: the residuals recomputed from the pressure do not confirm the solver"

    @property
    def success(self) -> bool:
        """Whether the solution is certified."""
        return self in (Status.CONVERGED, Status.CONVERGED_TO_ROUNDING, Status.RESCUED)

    def within(self, floor: float, tolerance: float) -> Status:
        """Return this status, or the one to which rounding in float64 restricts a success.

        Parameters
        ----------
        floor
            The error by rounding (see `Violation`).
        tolerance
            The error of a pressure that counts as converged.
        """
        if not self.success or floor <= min(tolerance, _MAX_RESOLVED_ERROR):
            return self
        return Status.CONVERGED_TO_ROUNDING if floor <= _MAX_RESOLVED_ERROR else Status.UNRESOLVED

    def __str__(self) -> str:
        return self.value


@attrs.frozen
class Residuals(ShownAsPrinted):
    """The violations of the conditions of contact, recomputed in float64 from the pressure alone.

    Attributes
    ----------
    complementarity
        Pressure-weighted mean of the gap in the contact, divided by `scale`.
    penetration
        Deepest overlap outside the saturated cells, divided by `scale`. Both are at least the error by rounding in
        float64.
    load
        Relative error of the load.
    scale
        Height, m: the smaller of the standard deviation of the initial gap and the range of the displacement.
    tension
        Maximum difference between the tension and its law, over the maximum slope of the law and `scale`; zero without
        adhesion.
    """

    complementarity: float = attrs.field(converter=float)
    penetration: float = attrs.field(converter=float)
    load: float = attrs.field(converter=float)
    scale: float = attrs.field(converter=float)
    tension: float = attrs.field(converter=float, default=0.0)

    @property
    def error(self) -> float:
        """The maximum of complementarity, penetration and tension."""
        return max(self.complementarity, self.penetration, self.tension)

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """Them as conditions of a certificate."""
        over = f", over {si(self.scale, 'm')}"
        attracting = "difference between the tension and its law, over the steepest slope of the law"
        return (
            Condition(
                "complementarity",
                self.complementarity,
                f"mean of the gap where there is pressure, weighted by it{over}",
            ),
            Condition("penetration", self.penetration, f"deepest overlap outside the saturated cells{over}"),
            Condition("load", self.load, "relative error of the load", judges=False),
            *([Condition("tension", self.tension, f"{attracting}{over}")] if self.tension else []),
        )

    def __str__(self) -> str:
        return ", ".join(map(str, self.conditions))


@attrs.frozen
class GridLevel:
    """The work on one grid of a nested iteration.

    Attributes
    ----------
    shape
        Cells of the grid.
    iterations
        Iterations on it.
    double, single
        Convolutions in float64 and in float32.
    inverse
        Applications of the approximate inverse, each at the cost of a convolution.
    """

    shape: tuple[int, int] = attrs.field(converter=as_shape)
    iterations: int = attrs.field(converter=int)
    double: int = attrs.field(converter=int)
    single: int = attrs.field(default=0, converter=int)
    inverse: int = attrs.field(default=0, converter=int)


@attrs.frozen
class Area(Estimate):
    """Real contact area with its uncertainty.

    Attributes
    ----------
    value
        Area, m2.
    fraction
        Area over nominal area.
    uncertainty
        One standard deviation, m2: the true area should lie within two of them.
    sampling
        Standard deviation between places of the same rough surface, m2; None where there is no such surface.
    estimator
        Name of the estimator.
    unit
        ``"m2"``.
    perimeter
        Length of the edge of the contact, m; nan where the estimator does not give it.
    warnings
        Why the value must not be trusted, in sentences; empty without a reason.
    patches
        Area of each of the solution's patches, shape (count,), m2, without summits in contact between the cells; None
        where the estimator does not give them.
    certain_fraction
        Fraction of the contact on points that the tip of a stylus has surely touched; None unless a map was `restored`
        below its tip.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> area = problem.solve(force=1.0).area()
    >>> print(f"{100 * area.fraction:.2f} % of nominal, estimated by {area.estimator}")
    6.89 % of nominal, estimated by blend
    """

    value: float
    fraction: float
    uncertainty: float
    estimator: str
    unit: str = attrs.field(default="m2", init=False)
    perimeter: float = attrs.field(default=math.nan, kw_only=True)
    warnings: tuple[str, ...] = attrs.field(default=(), kw_only=True)
    patches: Array | None = attrs.field(
        default=None, converter=attrs.converters.optional(read_only), kw_only=True, eq=False, repr=False
    )
    certain_fraction: float | None = attrs.field(default=None, kw_only=True)

    def __str__(self) -> str:
        factor, unit = prefixed(max(self.value, self.uncertainty), "m", 2)
        plain_unit = unit.replace("²", "2")
        texts = [f"{with_spread(factor * self.value, factor * self.uncertainty)} {plain_unit}"]
        if self.value > 0.0:
            percent = 100.0 * self.fraction
            # In points of percent, as the fraction: a relative uncertainty would be misread as points.
            texts.append(f"{with_spread(percent, percent * self.uncertainty / self.value)} % of nominal")
        return f"{', '.join(texts)} [{self.estimator}]{self._reasons}"


class AreaEstimator(Response[Area]):
    """A rule for the real contact area. Subclass it and define `estimate`.

    Attributes
    ----------
    expects
        What it expects of a contact, nothing by default: ``"summits"``, whose curvature tells the area, and
        ``"roots"``, that the pressure ends as the root of the distance from the edge. Its area is warned of on surfaces
        that loads have changed otherwise.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class Counted(rc.AreaEstimator):
    ...     def estimate(self, solution):
    ...         area = float(solution.contact.sum()) * solution.grid.cell_area
    ...         return rc.Area(area, area / solution.grid.area, 0.1 * area, "counted")
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> print(problem.solve(force=1.0).area(Counted()))
    (742 +- 74) µm2, (7.42 +- 0.74) % of nominal [counted]
    """

    expects: ClassVar[frozenset[str]] = frozenset()
    holds_with = frozenset({"tension", "shear", "relaxation"})
    reads = "contact pressure"

    @abc.abstractmethod
    def estimate(self, solution: Any) -> Area:
        """Return the real contact area and its uncertainty."""

    def respond(self, solution: Any) -> Area:
        """Return the real contact area, as `ContactSolution.area` does."""
        ask = getattr(solution, "area", None)
        if not callable(ask):
            raise InputError.about("The solution", solution, "a ContactSolution")
        area: Area = ask(self)
        return area


areas = Registry(AreaEstimator, "area estimator", "roughcontact.areas")


def warn_of_changes(area: Area, estimator: AreaEstimator, holding: str) -> Area:
    """Return an area with a warning if its estimator expects more than the one that holds for the surfaces, by name."""
    if estimator.expects <= areas[holding].expects:
        return area
    name = areas.name_of(type(estimator)) or type(estimator).__name__
    text = (
        f"loads before have changed the surfaces: an area by {name!r} may err by more than it states, one by "
        f"{holding!r} holds"
    )
    return attrs.evolve(area, warnings=(*area.warnings, WarningText(text, "changed surfaces")))


def estimate_saturated_area(solution: Any, estimator: str | AreaEstimator) -> Area:
    """Return the saturated area; see `ContactSolution.saturated_area`."""
    name = str(estimator) if isinstance(estimator, str) else type(estimator).__name__
    areas.resolve(estimator)
    if not solution.saturated.any():
        # A cell whose mean pressure is near the limit may hold a point that has reached it.
        near = (
            int(np.count_nonzero(solution.pressure > _NEAR_LIMIT_FRACTION * solution.pressure_limit))
            * solution.grid.cell_area
        )
        return Area(0.0, 0.0, near, name, perimeter=0.0)
    complement = attrs.evolve(
        solution,
        pressure=solution.pressure_limit - solution.pressure,
        displacement=-solution.displacement,
        initial_gap=-solution.initial_gap,
        approach=-solution.approach,
    )
    rest: Area = complement.area(estimator, uncertainty="model")
    # A larger saturated area would carry more than the load.
    admissible = float(np.sum(solution.pressure / solution.pressure_limit)) * solution.grid.cell_area
    value = min(solution.grid.area - rest.value, admissible)
    undecided = _undecided(solution)
    warnings = rest.warnings
    if undecided > _MAX_UNDECIDED_FRACTION * value:
        warnings += (_RUN_IN_WARNING,)
    edge = (
        _SATURATED_EDGE_STD * rest.perimeter * float(np.sqrt(solution.grid.cell_area))
        if np.isfinite(rest.perimeter)
        else 0.0
    )
    uncertainty = float(np.hypot(np.hypot(rest.uncertainty, undecided), edge))
    fraction = value / solution.grid.area
    return attrs.evolve(
        rest,
        value=value,
        fraction=fraction,
        uncertainty=uncertainty,
        warnings=warnings,
        patches=None,
        relative_sampling=None,
    )


def _undecided(solution: Any) -> float:
    """Return the area of the cells at the limit with zero gap, within the residual, m2: saturated or not."""
    at_limit = solution.pressure > (1.0 - _LIMIT_TOLERANCE) * solution.pressure_limit
    closed = np.abs(solution.gap) <= _LIMIT_TOLERANCE * solution.residuals.scale
    return int(np.count_nonzero(at_limit & closed)) * float(solution.grid.cell_area)


def estimate_attractive_area(solution: Any, fraction: float) -> Area:
    """Return the area of strong tension; see `ContactSolution.attractive_area`."""
    fraction = number(fraction, "The fraction of the maximum tension", above=0.0)
    if fraction >= 1.0:
        raise InputError.about("The fraction of the maximum tension", fraction, "below 1")
    if solution.tension is None:
        raise InputError(f"The surfaces do not attract each other: give the problem {argument('adhesion')}.")
    strong = (solution.tension > fraction * float(solution.tension.max())) & ~solution.contact
    # A cell at the edge of the zone is inside or outside as a whole: half a cell either way, not alike for all.
    steps = sum(int(np.count_nonzero(np.diff(strong, axis=axis))) for axis in (0, 1))
    value = int(np.count_nonzero(strong)) * solution.grid.cell_area
    uncertainty = 0.5 * math.sqrt(steps) * solution.grid.cell_area
    return Area(value, value / solution.grid.area, uncertainty, "cell-count")
