"""The load at which a body first yields below its surface."""

from __future__ import annotations

import math

import attrs

from roughcontact._answers.areas.edges import warn_if_uncertain
from roughcontact._answers.subsurface.maximum import StressMaximum
from roughcontact._answers.subsurface.stress import StressBelow, body_name, coefficient, degrees
from roughcontact._base.arrays import Array
from roughcontact._base.checks import number
from roughcontact._base.units import Quantity, ShownAsPrinted, outlined, si
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import ContactProblem, maximum_pressure, predict_pressure, problem_of
from roughcontact._solve.solution import ContactSolution, Estimate, Response, responses
from roughcontact.errors import InputError
from roughcontact.errors.warning import Answer

# Relative distance from the yield stress at which the search ends, and number of solves in it.
_STRESS_TOLERANCE = 1e-4
_MAX_SOLVES = 25
# Slope of the logarithm of the stress over the logarithm of the load: of a ball, and the smallest that is used.
_BALL_SLOPE = 1.0 / 3.0
_MIN_SLOPE = 0.05
# Largest step of the logarithm of the load.
_MAX_LOAD_STEP = math.log(300.0)
# Width of a bracket of logarithmic loads below which the stress jumps across the yield stress from cell to cell.
_MIN_BRACKET_WIDTH = 1e-4
# Distance of two logarithmic loads from which their slope is used: in the search, and for the uncertainty, which must
# not follow the steps of a maximum at the surface from cell to cell.
_MIN_LOAD_DISTANCE = 1e-2
_UNCERTAINTY_LOAD_DISTANCE = 0.1
# Smallest load that is tried of surfaces that attract each other, over their attraction.
_MIN_LOAD_FRACTION = 1e-3
# Largest load that is tried, over the load that the bodies can carry.
_MAX_LOAD_FRACTION = 0.999


@attrs.frozen(eq=False)
class YieldPoint(ShownAsPrinted, Answer):
    """The load of first yield.

    Attributes
    ----------
    force
        The normal force, N.
    maximum
        The maximum von Mises stress at that load, with its place.
    solution
        The elastic contact at that load.
    layer
        Number of the layer that yields, 1 for the topmost; 0 for a body without layers, or the one under them.
    """

    force: Estimate
    maximum: StressMaximum
    solution: ContactSolution
    layer: int = 0

    @property
    def mean_pressure(self) -> Estimate:
        """The nominal mean pressure, Pa."""
        area = self.solution.grid.area
        return attrs.evolve(
            self.force, value=self.force.value / area, uncertainty=self.force.uncertainty / area, unit="Pa"
        )

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The normal force and the mean pressure, by name."""
        return {"force": self.force, "mean_pressure": self.mean_pressure}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the load must not be trusted, in sentences; empty without a reason."""
        return self.force.warnings

    def __str__(self) -> str:
        place = f"x = {si(self.maximum.x, 'm')}, y = {si(self.maximum.y, 'm')}, depth {si(self.maximum.depth, 'm')}"
        where = f" in layer {self.layer}" if self.layer else ""
        return f"first yield{where} at {place}: {self.force}"


def _strength(value: Quantity) -> float:
    return number(value, "The yield stress", "Pa", above=0.0)


@responses.register("first-yield")
@attrs.frozen(eq=False)
class FirstYield(Response[YieldPoint]):
    r"""Load at which the maximum von Mises stress below a surface reaches the yield stress; the contact is elastic.

    On a ball :math:`F_Y = \pi^3 R^2 p_0^3 / 6 E^{*2}` with :math:`p_0 = 1.61\,Y` for :math:`\nu = 0.3`. The load is
    searched by a secant over the logarithms of load and stress. Its relative uncertainty is the uncertainty of the
    stress over their slope, a third for a ball, less for rough surfaces. Surfaces that attract each other have the
    stress of pressure and attraction together.

    Parameters
    ----------
    yield_stress
        Yield stress of the body in tension, Pa; of its layers that do not state their own too.
    body
        ``"body"`` or ``"counterbody"``.
    friction
        Coefficient of friction in full sliding, a number or shape (nx, ny); see `StressBelow`.
    direction
        Direction of the traction on the body, degrees from x towards y.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 6.1, https://doi.org/10.1017/CBO9781139171731
    """

    with_adhesion = "total pressure"
    memory_arrays = 54.0  # solves at other loads, and the stress of each
    refused_with_friction = "it is that of pressure alone; ask for the stress, which counts the traction"

    yield_stress: float = attrs.field(converter=_strength, metadata={"unit": "Pa"})
    body: str = attrs.field(default="body", converter=body_name)
    friction: Array | None = attrs.field(default=None, converter=coefficient, repr=outlined, metadata={"unit": ""})
    direction: float = attrs.field(default=0.0, converter=degrees)

    def respond(self, solution: ContactSolution) -> YieldPoint:
        """Return the load of first yield, searched from the load of the solution; see `Response.respond`."""
        problem = problem_of(solution)
        attraction = 0.0 if solution.tension is None else float(solution.tension.sum()) * solution.grid.cell_area
        if not solution.force > 0.0:
            solution = _press(problem, attraction)
        trials = [self._measure(solution)]
        # Below it the attraction alone has made the body yield.
        lightest = math.log(_MIN_LOAD_FRACTION * attraction) if attraction > 0.0 else -math.inf
        carried = maximum_pressure(problem.plan) * solution.grid.area
        heaviest = math.log(_MAX_LOAD_FRACTION * carried) if math.isfinite(carried) else math.inf
        while not trials[-1].close:
            load = _choose_load(trials, heaviest, lightest)
            if load is None:
                break
            if trials[-1].load <= lightest + _MIN_BRACKET_WIDTH and trials[-1].excess > 0.0:
                raise InputError(
                    f"The attraction alone makes the {self.body} yield: without a load the von Mises stress is "
                    f"{si(trials[-1].maximum.value, 'Pa')}."
                )
            if len(trials) == _MAX_SOLVES or (
                trials[-1].load >= heaviest - _MIN_BRACKET_WIDTH and trials[-1].excess < 0.0
            ):
                raise InputError(
                    f"No load was found at which the von Mises stress reaches {si(self.yield_stress, 'Pa')}: "
                    f"at {si(trials[-1].solution.force, 'N')} it is {si(trials[-1].maximum.value, 'Pa')}."
                )
            trials.append(self._measure(_solve(problem, trials, load)))
        last = min(trials, key=lambda one: abs(one.excess))
        slope = max(_find_slope(trials, _UNCERTAINTY_LOAD_DISTANCE), _MIN_SLOPE)
        relative = math.hypot(last.maximum.uncertainty / last.maximum.value, last.excess) / slope
        force = last.solution.force * math.exp(-last.excess / slope)
        found = warn_if_uncertain(force, relative * force, "N", last.maximum.warnings)
        return YieldPoint(found, last.maximum, last.solution, last.layer)

    def _measure(self, solution: ContactSolution) -> _Trial:
        below = StressBelow(None, self.body, friction=self.friction, direction=self.direction)
        stress = below.respond(solution)
        stated: tuple[float | None, ...] = getattr(stress._kernel, "yield_stresses", ())
        if not stated:
            return self._try(solution, stress.maximum, self.yield_stress)
        trials = []
        for place, maximum in stress.maxima.items():
            own = stated[place] if place < len(stated) else None
            layer = place + 1 if place < len(stated) else 0
            trials.append(self._try(solution, maximum, self.yield_stress if own is None else own, layer))
        return max(trials, key=lambda one: one.excess)

    def _try(self, solution: ContactSolution, maximum: StressMaximum, strength: float, layer: int = 0) -> _Trial:
        return _Trial(solution, maximum, math.log(maximum.value / strength), layer)


@attrs.frozen(eq=False)
class _Trial:
    """A load that was tried, its maximum stress, and the logarithm of this stress over the yield stress."""

    solution: ContactSolution
    maximum: StressMaximum
    excess: float
    layer: int = 0

    @property
    def load(self) -> float:
        """The logarithm of the force."""
        return math.log(self.solution.force)

    @property
    def close(self) -> bool:
        return abs(self.excess) <= _STRESS_TOLERANCE


def _press(problem: ContactProblem, attraction: float) -> ContactSolution:
    """Return the contact under a load as large as the attraction, N, for one that has no load or a tensile one."""
    if not attraction > 0.0:
        raise InputError("The contact carries no load from which that of first yield could be searched.")
    return problem.solve(force=attraction)


def _solve(problem: ContactProblem, trials: list[_Trial], load: float) -> ContactSolution:
    force = math.exp(load)
    # The two nearest loads, the nearest last.
    near = sorted(trials, key=lambda one: -abs(one.load - load))[-2:]
    start = predict_pressure([one.solution for one in near], Load("force", force))
    return problem.solve(force=force, start=start)


def _find_slope(trials: list[_Trial], distance: float = _MIN_LOAD_DISTANCE) -> float:
    """Return the slope through the last load and the nearest one at a distance; the slope of a ball without one."""
    last = trials[-1]
    apart = [one for one in trials if abs(one.load - last.load) >= distance]
    if not apart:
        return _BALL_SLOPE
    other = min(apart, key=lambda one: abs(one.load - last.load))
    return (last.excess - other.excess) / (last.load - other.load)


def _choose_load(trials: list[_Trial], heaviest: float, lightest: float = -math.inf) -> float | None:
    """Return the logarithm of the next force to try; None where the stress jumps across the yield stress."""
    last = trials[-1]
    step = -last.excess / max(_find_slope(trials), _MIN_SLOPE)
    load = min(max(last.load + min(max(step, -_MAX_LOAD_STEP), _MAX_LOAD_STEP), lightest), heaviest)
    low = max((one.load for one in trials if one.excess < 0.0), default=-math.inf)
    high = min((one.load for one in trials if one.excess > 0.0), default=math.inf)
    if 0.0 <= high - low <= _MIN_BRACKET_WIDTH:
        return None
    return load if low < load < high or high < low else 0.5 * (low + high)
