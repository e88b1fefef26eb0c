"""The load at which a contact has a wanted area, stiffness, leakage or other answer."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Mapping
from typing import Any

import attrs

from roughcontact._base.checks import number
from roughcontact._base.units import EXAMPLES, Estimate, ShownAsPrinted, WarningText, has_unit, parse_quantity, si
from roughcontact._parts.grid import Load
from roughcontact._parts.surfaces import rms_slope
from roughcontact._solve.problem.find_load import LoadSearch, SolveFromPressure, TriedLoad
from roughcontact._solve.problem.scene import Scene
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

# The search ends where the answer is off by this fraction of its uncertainty, between these relative errors.
_PART_OF_UNCERTAINTY = 0.2
_MIN_TOLERANCE = 1e-5
_MAX_TOLERANCE = 5e-3
# Relative width of a bracket in which an answer that is still not found jumps, as an area does from cell to cell.
_JUMP_WIDTH = 1e-5
# Mean pressures between which is searched, over that of a large area: below, no cell follows the load; above, the
# heights are small beside the displacement.
_MIN_PRESSURE_RATIO = 1e-20
_MAX_PRESSURE_RATIO = 1e4
# Fraction of the area at the first load where none is wanted, and power of the load by which the second load is chosen.
_FIRST_FRACTION = 0.1
_FIRST_POWER = 0.75
# Smallest relative difference of two loads between which a slope stands out from the noise of the answers.
_MIN_SLOPE_WIDTH = 0.02
# Distances of the logarithms of further loads that are tried where an answer may hardly change.
_PROBED = tuple(0.4 * 2.0**step for step in range(5))
# Relative uncertainty of a load from which its answer hardly changes with it.
_MAX_RELATIVE_STD = 0.5
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


@guarded
def find_required_load(
    problem: Scene,
    solve: SolveFromPressure,
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
    return _WantedAnswer(problem, solve, response, name, target).find_load(on_answer)


def find_load_of_area(
    problem: Scene, solve: SolveFromPressure, fraction: object, estimator: str | AreaEstimator
) -> ContactSolution:
    """Return the solution at the load of an area; see `ContactProblem.solve_area`."""
    if problem.adhesion is not None:
        raise InputError("With adhesion one area may belong to several loads: sweep the loads instead.")
    fraction = number(fraction, "The fraction of the area", above=0.0)
    if fraction >= 1.0:
        raise InputError.about("The fraction of the area", fraction, "below 1", "Full contact is given by many loads.")
    wanted = fraction * problem.plan.grid.area
    return _WantedAnswer(problem, solve, areas.resolve(estimator), "area", wanted).find_load().solution


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


class _WantedAnswer:
    """A wanted answer, and the search for its load."""

    def __init__(
        self, problem: Scene, solve: SolveFromPressure, response: Response[Any], name: str, wanted: object
    ) -> None:
        plan = problem.plan
        self._response = response
        self._name = name
        self._given = wanted
        self._grid_area = plan.grid.area
        self._maximum = maximum_pressure(plan)
        self._wanted = math.nan
        is_area = isinstance(response, AreaEstimator)
        if is_area:
            self._wanted = self._read_area(wanted)
        elif not isinstance(wanted, str) and not has_unit(wanted):
            self._wanted = number(wanted, f"The wanted {name}", above=0.0)
        # Over the typical pressure, so that a power of two in the modulus changes no bit.
        typical = plan.modulus * rms_slope(problem.initial_gap, plan.grid)
        scale = min(1.0, self._maximum / typical)
        fraction = self._wanted / self._grid_area if is_area else _FIRST_FRACTION
        self._first = math.log(0.5 * fraction * scale)
        self._search: LoadSearch[Estimate] = LoadSearch(
            solve=solve,
            read=self._read,
            unit=Load("pressure", typical),
            ends=(typical * scale * _MIN_PRESSURE_RATIO, min(self._maximum, typical * _MAX_PRESSURE_RATIO)),
            width=_JUMP_WIDTH,
            power=_FIRST_POWER,
            rises=is_area,
        )

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
        if has_unit(self._given):
            return number(self._given, what, unit, above=0.0)
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

    def _read(self, x: float, solution: ContactSolution) -> TriedLoad[Estimate]:
        answer = read_number(solution.response(self._response), self._name)
        if math.isnan(self._wanted):
            self._wanted = self._read_text(answer.unit)
        ratio = answer.value / self._wanted
        off = math.log(ratio) if 0.0 < ratio < math.inf else math.copysign(math.inf, ratio - 1.0)
        relative = answer.uncertainty / answer.value if answer.value > 0.0 else 0.0
        tolerance = min(max(_PART_OF_UNCERTAINTY * relative, _MIN_TOLERANCE), _MAX_TOLERANCE)
        return TriedLoad(x, off, tolerance, answer)

    def find_load(self, on_answer: Callable[[int], None] | None = None) -> RequiredLoad:
        """Return the load; `InputError` if none has the wanted answer."""
        search = self._search
        search.on_answer = on_answer
        found = search.run(self._first)
        if found is None and search.bracket is not None:
            nearest = min(search.bracket, key=lambda one: abs(one.off))
            if search.is_jump and abs(nearest.answer.value - self._wanted) <= nearest.answer.uncertainty:
                found = nearest
        if found is None:
            raise InputError(f"No load gives {_a(self._name)} of {self._write(self._wanted)}: {self._explain()}")
        return self._report(found)

    def _report(self, found: TriedLoad[Estimate]) -> RequiredLoad:
        solution = self._search.solutions[found.x]
        slope = abs(self._find_slope(found)) * found.answer.value / solution.mean_pressure
        spread = math.hypot(found.answer.uncertainty, found.answer.value - self._wanted)
        uncertainty = spread / slope if slope > 0.0 else math.inf
        uncertainty = max(uncertainty, self._find_spread(found, solution))
        warnings = (*found.answer.warnings, *self._warn_of_level(slope, uncertainty / solution.mean_pressure))
        pressure = Estimate(solution.mean_pressure, uncertainty, "Pa", warnings)
        force = attrs.evolve(pressure, value=solution.force, uncertainty=uncertainty * self._grid_area, unit="N")
        cost = {"solves": len(self._search.tried), "convolutions": self._search.convolutions}
        return RequiredLoad(force, pressure, found.answer, self._wanted, self._name, solution, **cost)

    def _find_spread(self, found: TriedLoad[Estimate], solution: ContactSolution) -> float:
        """Return the largest distance of mean pressures at sharp edges over how sure they are wrong, Pa.

        On flat lands an answer hardly changes with the load, and its slope at one load tells little: others are tried
        further and further away until they are wrong.
        """
        if not self._has_sharp_edges(solution):
            return 0.0
        spread = 0.0
        for side in (-1.0, 1.0):
            for distance in _PROBED:
                one = self._search.try_load(found.x + side * distance)
                off = abs(one.answer.value - self._wanted)
                if off >= _SIGNIFICANT_STD * one.answer.uncertainty:
                    break
                apart = abs(self._search.load_at(one.x) - solution.mean_pressure)
                spread = max(spread, apart / max(off / one.answer.uncertainty, 1.0))
        return spread

    def _has_sharp_edges(self, solution: ContactSolution) -> bool:
        with contextlib.suppress(InputError):
            return bool(solution.response("flags").sharp_edge > 0.0)
        return False

    def _find_slope(self, found: TriedLoad[Estimate]) -> float:
        """Return the slope of the logarithm of the answer over that of the load, from loads that are apart."""
        search = self._search
        finite = search.find_nearest(len(search.tried))
        farthest = max((abs(one.x - found.x) for one in finite), default=0.0)
        distance = min(farthest, _MIN_SLOPE_WIDTH)
        if distance < _MIN_SLOPE_WIDTH / 4.0:
            beside = search.try_load(found.x - _MIN_SLOPE_WIDTH)
            return (found.off - beside.off) / (found.x - beside.x)
        slope = search.find_slope(found, distance)
        assert slope is not None
        return slope

    def _warn_of_level(self, slope: float, uncertainty: float) -> tuple[WarningText, ...]:
        """Return a warning if the answer does not change with the load, or hardly."""
        if slope > 0.0 and uncertainty < _MAX_RELATIVE_STD:
            return ()
        hardly = "hardly changes" if slope > 0.0 else "does not change"
        return (WarningText(f"the {self._name} {hardly} with the load here", "level"),)

    def _explain(self) -> str:
        """Return why no load gives the wanted answer."""
        tried = self._search.tried
        bracket = self._search.bracket
        if bracket is not None:
            values = [self._write(one.answer.value) for one in bracket]
            return (
                f"near {self._write_pressure(bracket[0])} it jumps from {values[0]} to {values[1]}. "
                "Refine the grid or choose another estimator."
            )
        low, high = (self._write_pressure(tried[place]) for place in (0, -1))
        nearest = min(tried, key=lambda one: abs(one.answer.value - self._wanted))
        found = f"{self._write(nearest.answer.value)} at {self._write_pressure(nearest)}"
        carried = self._search.load_at(tried[-1].x) >= (1.0 - 1e-9) * self._maximum
        limit = ", the maximum that the bodies can carry" if carried else ""
        turn = f"; it rises and falls, and was asked at {len(tried)} loads only" if self._turns() else ""
        return f"between {low} and {high}{limit}, the nearest is {found}{turn}."

    def _write(self, value: float) -> str:
        return write_number(value, self._search.tried[0].answer.unit)

    def _write_pressure(self, one: TriedLoad[Estimate]) -> str:
        return si(self._search.load_at(one.x), "Pa")

    def _turns(self) -> bool:
        """Return whether the answer rises and falls with the load."""
        signs = set()
        answers = (one.answer for one in self._search.tried if math.isfinite(one.answer.value))
        for low, high in itertools.pairwise(answers):
            if abs(high.value - low.value) > _SIGNIFICANT_STD * (low.uncertainty + high.uncertainty):
                signs.add(high.value > low.value)
        return len(signs) == 2


def _a(name: str) -> str:
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"
