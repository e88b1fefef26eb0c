"""The load at which a contact has a wanted area, stiffness, leakage or other answer."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Mapping
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import number
from roughcontact._base.units import EXAMPLES, Estimate, ShownAsPrinted, WarningText, parse_quantity, si
from roughcontact._parts.grid import Load
from roughcontact._parts.surfaces import rms_slope
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.sweep import predict_pressure
from roughcontact._solve.problem.task import maximum_pressure
from roughcontact._solve.solution import (
    DEFAULT_AREA,
    AreaEstimator,
    ContactSolution,
    Response,
    areas,
    read_number,
    responses,
)
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.errors.warning import Answer

Solve = Callable[[Load, Array | None], ContactSolution]

# The search ends where the answer is off by this fraction of its uncertainty, between these relative errors.
_PART_OF_UNCERTAINTY = 0.2
_MIN_TOLERANCE = 1e-5
_MAX_TOLERANCE = 5e-3
# Maximum tries: halvings, the worst case, narrow any bracket below the criterion for jumps.
_MAX_TRIES = 40
# Relative width of a bracket in which an answer that is still not found jumps, as an area does from cell to cell.
_JUMP_WIDTH = 1e-5
# Errors that were not halved in two steps, after which all brackets are halved.
_MAX_STALLS = 1
# Mean pressures between which is searched, over that of a large area: below, no cell follows the load; above, the
# heights are small beside the displacement.
_MIN_PRESSURE_RATIO = 1e-20
_MAX_PRESSURE_RATIO = 1e4
# Fraction of the area at the first load where none is wanted, and power of the load by which the second load is chosen.
_FIRST_FRACTION = 0.1
_FIRST_POWER = 0.75
# Factor by which the load changes at most in a step without a bracket; each further one is its square. The first step
# is shorter where the answer may fall with the load.
_FIRST_FACTOR = 8.0
_PROBING_FACTOR = 2.0
# Smallest relative difference of two loads between which a slope stands out from the noise of the answers.
_MIN_SLOPE_WIDTH = 0.02
# Steps from one load to the next, over that between the two before, up to which the pressure is extrapolated.
_MAX_EXTRAPOLATION = 3.0
# Factor by which the digits of the answer grow from try to try, about, by the secant rule; error from which on they do.
_ORDER = 1.6
_MAX_FORECAST_ERROR = 0.5
# Standard deviations by which an answer must fall and rise again to be called so.
_SIGNIFICANT_STD = 2.0


@attrs.frozen(eq=False)
class RequiredLoad(ShownAsPrinted, Answer):
    """The load that a wanted answer requires.

    Attributes
    ----------
    force, pressure
        The normal force, N, and the nominal mean pressure, Pa. Their uncertainty is that of the answer over its slope.
    answer
        The answer at that load, with its uncertainty.
    wanted
        The wanted answer, in the unit of `answer`.
    name
        What was wanted, such as ``"stiffness"``.
    solution
        The contact at that load.
    solves, convolutions
        Loads that were solved, and their convolutions.
    """

    force: Estimate
    pressure: Estimate
    answer: Estimate
    wanted: float
    name: str
    solution: ContactSolution
    solves: int
    convolutions: int

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The normal force and the mean pressure, by name."""
        return {"force": self.force, "mean_pressure": self.pressure}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the load must not be trusted, in sentences; empty without a reason."""
        return self.force.warnings

    def __str__(self) -> str:
        reasons = "".join(f"; uncertain: {text}" for text in self.warnings)
        force, pressure = (attrs.evolve(one, warnings=()) for one in (self.force, self.pressure))
        return f"{self.name} of {write_number(self.wanted, self.answer.unit)} at {force}, {pressure}{reasons}"


def write_number(value: float, unit: str) -> str:
    """Return a number with its unit, to six digits."""
    return si(value, unit, 6) if unit else f"{value:.6g}"


@attrs.frozen
class _Point:
    """An answer at a load.

    `x` and `off` are the logarithms of the mean pressure over the typical one and of the answer over the wanted one.
    """

    x: float
    off: float
    answer: Estimate


@guarded
def find_required_load(
    problem: Scene,
    solve: Solve,
    answer: object,
    value: object,
    asked: Mapping[str, object],
    on_answer: Callable[[int], None] | None = None,
) -> RequiredLoad:
    """Return the load that an answer requires; see `ContactProblem.solve_for`.

    `on_answer` is called with the number of solves that are still to come, about, after each of them.
    """
    if problem.adhesion is not None:
        raise InputError("With adhesion one answer may belong to several loads: sweep the loads instead.")
    response, name, target = _resolve(answer, value, asked)
    return _Search(problem, solve, response, name, target).run(on_answer)


def find_load_of_area(
    problem: Scene, solve: Solve, fraction: object, estimator: str | AreaEstimator
) -> ContactSolution:
    """Return the solution at the load of an area; see `ContactProblem.solve_area`."""
    if problem.adhesion is not None:
        raise InputError("With adhesion one area may belong to several loads: sweep the loads instead.")
    fraction = number(fraction, "The fraction of the area", above=0.0)
    if fraction >= 1.0:
        raise InputError.about("The fraction of the area", fraction, "below 1", "Full contact is given by many loads.")
    wanted = fraction * problem.plan.grid.area
    return _Search(problem, solve, areas.resolve(estimator), "area", wanted).run().solution


def _resolve(answer: object, value: object, asked: Mapping[str, object]) -> tuple[Response[Any], str, object]:
    """Return the response, its name in sentences, and what is wanted of it."""
    if answer is not None:
        if asked:
            raise InputError(f"Give the fields of the response when it is made: omit {next(iter(asked))}=.")
        if isinstance(answer, str):
            raise InputError.about("The answer", answer, "a response object", f"By name: solve_for({answer}=...).")
        if not isinstance(answer, Response):
            raise InputError.about("The answer", answer, "a response or an area estimator")
        registry: Any = areas if isinstance(answer, AreaEstimator) else responses
        named = "area" if registry is areas else registry.name_of(type(answer)) or type(answer).__name__
        if value is None:
            raise InputError(f"Say which {named} is wanted: give value=.")
        return answer, named, value
    if value is not None:
        raise InputError(
            "value= is for a response object: solve_for(response, value=...); by name solve_for(area=...)."
        )
    known = {"area", *responses}
    wanted = [word for word in asked if word in known or word.replace("_", "-") in known]
    if asked and not wanted:
        raise InputError.unknown("answer", next(iter(asked)), [word.replace("-", "_") for word in known])
    if len(wanted) != 1:
        got = " and ".join(f"{word}=" for word in wanted) or "nothing"
        raise InputError(
            "Give exactly one wanted answer, area= or a registered response such as stiffness=, leakage= or "
            f"peak_pressure=, but got {got}."
        )
    (word,) = wanted
    fields = {field: one for field, one in asked.items() if field != word}
    if word == "area":
        if set(fields) - {"estimator"}:
            raise InputError(f"Beside area= only estimator= may be given, but got {next(iter(fields))}=.")
        return areas.resolve(fields.get("estimator", DEFAULT_AREA)), "area", asked[word]
    name = word if word in responses else word.replace("_", "-")
    return responses.create(name, **fields), name, asked[word]


class _Search:
    """The search for one load.

    The logarithm of most answers is nearly a straight line over that of the load: the line through the last two points
    tells the next load, the parabola through three points once they are on both sides.
    """

    def __init__(self, problem: Scene, solve: Solve, response: Response[Any], name: str, wanted: object) -> None:
        plan = problem.plan
        self._solve = solve
        self._response = response
        self._name = name
        self._given = wanted
        self._grid_area = plan.grid.area
        self._maximum = maximum_pressure(plan)
        self._typical = plan.modulus * rms_slope(problem.initial_gap, plan.grid)
        self._points: list[_Point] = []
        self._solutions: dict[float, ContactSolution] = {}
        self._wanted = math.nan
        self._errors: list[float] = []
        self._stalls = 0
        self._convolutions = 0
        # Over the typical pressure, so that a power of two in the modulus changes no bit.
        self._limit = self._maximum / self._typical
        smallest = _MIN_PRESSURE_RATIO * min(1.0, self._limit)
        self._ends = math.log(smallest), math.log(min(self._limit, _MAX_PRESSURE_RATIO))
        if isinstance(response, AreaEstimator):
            self._wanted = self._read_area(wanted)
        elif not isinstance(wanted, str):
            self._wanted = number(wanted, f"The wanted {name}", above=0.0)

    def _read_area(self, given: object) -> float:
        """Return a wanted area, m2, from a number, ``"0.1mm2"`` or ``"10%"`` of the nominal area."""
        value = given
        if isinstance(given, str):
            with contextlib.suppress(ValueError):
                value = self._grid_area * parse_quantity(given, "") if "%" in given else parse_quantity(given, "m2")
        area = number(value, "The wanted area", "m2", above=0.0)
        if area >= self._grid_area:
            nominal = si(self._grid_area, "m2")
            hint = "Full contact is given by many loads."
            raise InputError.about("The wanted area", given, f"below the nominal area of {nominal}", hint)
        return area

    def _read_text(self, unit: str) -> float:
        """Return a wanted answer that is given as a text, in the unit of the answers."""
        what = f"The wanted {self._name}"
        text = str(self._given)
        # A conductance has the units of a thermal one, but may be an electrical one.
        unit_of_text = "W/K or S" if unit == "W/K" else unit
        try:
            value = parse_quantity(text, unit_of_text if unit_of_text in EXAMPLES else "")
        except ValueError as error:
            if unit_of_text in EXAMPLES:
                raise InputError(f"{what}: {error}.") from error
            raise InputError.about(what, text, f"a plain number, {unit}") from error
        return number(value, what, unit, above=0.0)

    def run(self, on_answer: Callable[[int], None] | None = None) -> RequiredLoad:
        """Return the load; `InputError` if none has the wanted answer."""
        fraction = _FIRST_FRACTION
        if isinstance(self._response, AreaEstimator):
            fraction = self._wanted / self._grid_area
        x = math.log(0.5 * fraction * min(1.0, self._limit))
        for _ in range(_MAX_TRIES):
            point = self._try(x)
            if abs(point.off) <= self._tolerance(point.answer):
                return self._report(point)
            if on_answer is not None:
                on_answer(self._forecast())
            bracket = self._find_bracket()
            if bracket is not None and bracket[1].x - bracket[0].x <= _JUMP_WIDTH:
                nearest = min(bracket, key=lambda one: abs(one.off))
                if abs(nearest.answer.value - self._wanted) <= nearest.answer.uncertainty:
                    return self._report(nearest)
                break
            x = self._extrapolate() if bracket is None else self._interpolate(*bracket)
        raise InputError(self._say_jump())

    def _try(self, x: float) -> _Point:
        """Return the answer at a load, after solving from the nearest loads."""
        load = Load("pressure", self._pressure_at(x))
        near = sorted(self._solutions, key=lambda one: -abs(one - x))[-2:]
        if len(near) == 2 and abs(x - near[1]) > _MAX_EXTRAPOLATION * abs(near[1] - near[0]):
            near = near[1:]
        solution = self._solve(load, predict_pressure([self._solutions[one] for one in near], load))
        self._convolutions += solution.convolutions
        answer = read_number(solution.response(self._response), self._name)
        if math.isnan(self._wanted):
            self._wanted = self._read_text(answer.unit)
        ratio = answer.value / self._wanted
        point = _Point(x, math.log(ratio) if 0.0 < ratio < math.inf else math.copysign(math.inf, ratio - 1.0), answer)
        self._points = sorted([*self._points, point], key=lambda one: one.x)
        # Fields take memory: those of the loads next to the last one are enough.
        self._solutions[x] = solution
        kept = sorted(self._solutions, key=lambda one: abs(one - x))[:3]
        bracket = self._find_bracket() or ()
        self._solutions = {
            one: found for one, found in self._solutions.items() if one in (*kept, *(end.x for end in bracket))
        }
        return point

    def _forecast(self) -> int:
        """Return how many tries are still to come, about."""
        nearest = min(self._points, key=lambda one: abs(one.off))
        digits = -math.log(min(abs(nearest.off), _MAX_FORECAST_ERROR)) / -math.log(self._tolerance(nearest.answer))
        return max(1, math.ceil(-math.log(digits) / math.log(_ORDER)))

    def _pressure_at(self, x: float) -> float:
        return min(self._typical * math.exp(x), self._maximum)

    def _tolerance(self, answer: Estimate) -> float:
        relative = answer.uncertainty / answer.value if answer.value > 0.0 else 0.0
        return min(max(_PART_OF_UNCERTAINTY * relative, _MIN_TOLERANCE), _MAX_TOLERANCE)

    def _find_bracket(self) -> tuple[_Point, _Point] | None:
        """Return the closest neighbouring loads whose answers are on both sides of the wanted one."""
        found = [pair for pair in itertools.pairwise(self._points) if (pair[0].off < 0.0) != (pair[1].off < 0.0)]
        return min(found, key=lambda pair: pair[1].x - pair[0].x, default=None)

    def _interpolate(self, low: _Point, high: _Point) -> float:
        """Return a load inside a bracket."""
        middle = 0.5 * (low.x + high.x)
        if not (math.isfinite(low.off) and math.isfinite(high.off)):
            return middle
        self._errors.append(min(abs(low.off), abs(high.off)))
        if len(self._errors) > 2 and self._errors[-1] > 0.5 * self._errors[-3]:
            # The answer jumps or bends.
            self._stalls += 1
            return middle
        if self._stalls > _MAX_STALLS:
            return middle
        others = [one for one in self._nearest(3) if one not in (low, high)]
        for points in ([low, high, *others[:1]], [low, high]):
            x = _at_zero(points)
            if low.x < x < high.x:
                return x
        return middle

    def _nearest(self, count: int) -> list[_Point]:
        """Return the points whose finite answers are nearest to the wanted one."""
        finite = [one for one in self._points if math.isfinite(one.off)]
        return sorted(finite, key=lambda one: abs(one.off))[:count]

    def _extrapolate(self) -> float:
        """Return a load farther out, as long as all answers are on one side of the wanted one."""
        first = self._points[0]
        last = self._points[-1]
        change = last.off - first.off
        # Where all answers are zero, as an area without a cell in contact, or without end: up, then down.
        rising = bool(len(self._points) % 2) if math.isnan(change) else change >= 0.0
        upwards = (first.off < 0.0) == rising
        edge = last if upwards else first
        if len(self._points) == 1:
            known = isinstance(self._response, AreaEstimator)
            reach = math.log(_FIRST_FACTOR if known else _PROBING_FACTOR)
            step = abs(edge.off) / _FIRST_POWER
        else:
            reach = math.log(_FIRST_FACTOR) * 2.0 ** (len(self._points) - 2)
            step = math.inf
            near = self._nearest(3)
            for count in (2, 3):
                ahead = (_at_zero(near[:count]) if len(near) >= count else math.nan) - edge.x
                if math.isfinite(edge.off) and 0.0 < (ahead if upwards else -ahead) <= min(2.0 * step, reach):
                    step = abs(ahead)
        step = min(step, reach)
        x = edge.x + (step if upwards else -step)
        x = min(max(x, self._ends[0]), self._ends[1])
        if first.x <= x <= last.x:
            raise InputError(self._say_range())
        return x

    def _report(self, point: _Point) -> RequiredLoad:
        solution = self._solutions[point.x]
        slope = abs(self._slope(point)) * point.answer.value / solution.mean_pressure
        spread = math.hypot(point.answer.uncertainty, point.answer.value - self._wanted)
        uncertainty = spread / slope if slope > 0.0 else math.inf
        warnings = (*point.answer.warnings, *self._warn_of_level(slope))
        pressure = Estimate(solution.mean_pressure, uncertainty, "Pa", warnings)
        force = attrs.evolve(pressure, value=solution.force, uncertainty=uncertainty * self._grid_area, unit="N")
        cost = {"solves": len(self._points), "convolutions": self._convolutions}
        return RequiredLoad(force, pressure, point.answer, self._wanted, self._name, solution, **cost)

    def _slope(self, point: _Point) -> float:
        """Return the slope of the logarithm of the answer over that of the load."""
        others = [one for one in self._points if math.isfinite(one.off) and one is not point]
        apart = [one for one in others if abs(one.x - point.x) >= _MIN_SLOPE_WIDTH]
        near = sorted(apart, key=lambda one: abs(one.x - point.x))[:2]
        if not near:
            farthest = max(others, key=lambda one: abs(one.x - point.x), default=None)
            if farthest is None or abs(farthest.x - point.x) < _MIN_SLOPE_WIDTH / 4.0:
                beside = self._try(point.x - _MIN_SLOPE_WIDTH)
                return (point.off - beside.off) / (point.x - beside.x)
            near = [farthest]
        slopes = [(point.off - one.off) / (point.x - one.x) for one in near]
        if len(near) == 1:
            return slopes[0]
        # The derivative of the parabola at the point.
        one, other = (near[index].x - point.x for index in (0, 1))
        slope = (slopes[0] * other - slopes[1] * one) / (other - one)
        return slope if slope * slopes[0] > 0.0 else slopes[0]

    def _warn_of_level(self, slope: float) -> tuple[WarningText, ...]:
        """Return a warning if the answer does not change with the load."""
        if slope > 0.0:
            return ()
        return (WarningText(f"the {self._name} does not change with the load here", "level"),)

    def _say_range(self) -> str:
        unit = self._points[0].answer.unit
        wanted = write_number(self._wanted, unit)
        low, high = (si(self._pressure_at(self._points[index].x), "Pa") for index in (0, -1))
        nearest = min(self._points, key=lambda one: abs(one.answer.value - self._wanted))
        found = f"{write_number(nearest.answer.value, unit)} at {si(self._pressure_at(nearest.x), 'Pa')}"
        carried = self._pressure_at(self._points[-1].x) >= (1.0 - 1e-9) * self._maximum
        limit = ", the maximum that the bodies can carry" if carried else ""
        tried = f"between {low} and {high}{limit}, the nearest is {found}"
        turn = f"; it rises and falls, and was asked at {len(self._points)} loads only" if self._turns() else ""
        return f"No load gives {_a(self._name)} of {wanted}: {tried}{turn}."

    def _turns(self) -> bool:
        """Return whether the answer rises and falls with the load."""
        signs = set()
        for low, high in itertools.pairwise(one.answer for one in self._points if math.isfinite(one.answer.value)):
            if abs(high.value - low.value) > _SIGNIFICANT_STD * (low.uncertainty + high.uncertainty):
                signs.add(high.value > low.value)
        return len(signs) == 2

    def _say_jump(self) -> str:
        bracket = self._find_bracket()
        wanted = write_number(self._wanted, self._points[0].answer.unit)
        if bracket is None:
            return self._say_range()
        values = [write_number(one.answer.value, one.answer.unit) for one in bracket]
        near = si(self._pressure_at(bracket[0].x), "Pa")
        return (
            f"No load gives {_a(self._name)} of {wanted}: near {near} it jumps from {values[0]} to {values[1]}. "
            "Refine the grid or choose another estimator."
        )


def _a(name: str) -> str:
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


def _at_zero(points: list[_Point]) -> float:
    """Return the load at which the polynomial through two or three points, load over answer, has the wanted answer."""
    offs = [one.off for one in points]
    if len(set(offs)) < len(offs):
        return math.nan
    total = 0.0
    for one in points:
        others = [off for off in offs if off != one.off]
        total += one.x * float(np.prod([off / (off - one.off) for off in others]))
    return total
