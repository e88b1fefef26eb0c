"""Paths under each normal load of a study: of loads along the surface, or of time and sliding distance."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from roughcontact._base.checks import integer, list_of, number
from roughcontact._base.units import si
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import FrictionLaw
from roughcontact._solve.problem import (
    PATH_ACCURACY,
    ContactProblem,
    FrictionalPath,
    LoadPath,
    SolvePlan,
    check_accuracy,
    describe_loads,
    describe_part,
    describe_value,
    explain_loads,
    explain_with_friction,
    list_places,
    list_targets,
    memory_of_friction,
    prepare_path,
    read_frictional_path,
    read_load_path,
    remember_changes,
    require_frictional,
    resolve_friction,
    run_load_path,
    save_load_path,
    save_path,
)
from roughcontact._solve.solution import (
    ContactSolution,
    Response,
    Status,
    TangentialLoad,
    require_to_hold,
)
from roughcontact._work.studies.loading import SINGLE_LOADS, Loading, SingleLoads, judge_by, list_law_numbers
from roughcontact._work.studies.record import solution_path
from roughcontact.errors import InputError

# Loads or places of a path that `explain` lists: the first ones and the last.
_MAX_LISTED_LOADS = 6
# Arrays of a state on a path: pressure, displacement, gap, its change, and what laws remember before and after.
_ARRAYS_OF_STATE = 10


@attrs.frozen(eq=False)
class LoadsAlong(Loading):
    """The loads along the surface that follow each normal load of a study.

    Attributes
    ----------
    loads
        The loads, one after the other.
    friction
        The law by which the surfaces slip.
    substeps
        Increments of each load; ``"auto"``: as many as it needs.
    uncertainty
        What the uncertainties of the answers at the end of a path are found from.
    """

    loads: tuple[TangentialLoad, ...]
    friction: FrictionLaw
    substeps: int | str
    uncertainty: str = "auto"
    goes_on = False

    @property
    def kind(self) -> str:
        """The argument of `ContactProblem.path` that states the loads."""
        return self.loads[0].kind

    @property
    def parts(self) -> Sequence[Any]:  # type: ignore[override]
        """Loads, law and increments."""
        return [self.kind, [list(one.values) for one in self.loads], self.friction, self.substeps]

    def require(self, problem: ContactProblem, loads: Sequence[Load]) -> None:
        """Raise `InputError` unless a problem carries the loads, and has a response to those along its surface."""
        # Of a copy: the responses to shear of all problems would take the memory of many grids.
        require_frictional(copy.copy(problem))
        SINGLE_LOADS.require(problem, loads)

    def order(self, problem: ContactProblem, loads: Sequence[Load]) -> Sequence[int]:
        """Return the positions in their order."""
        return range(len(loads))

    def solve(
        self, problem: ContactProblem, load: Load, before: Sequence[ContactSolution], draft: Path | None = None
    ) -> FrictionalPath:
        """Return the states at the loads along the surface, under a normal load."""
        along: dict[str, Any] = {self.kind: [one.values for one in self.loads]}
        return problem.path(**load.arguments, **along, friction=self.friction, substeps=self.substeps)

    def write(self, file: Path, found: Any, key: str, earlier: Sequence[Mapping[str, float]]) -> None:
        """Write a path."""
        save_path(file, found, key)

    def read(self, folder: Path, key: str) -> FrictionalPath:
        """Return the path with a key."""
        return read_frictional_path(solution_path(folder, key), verify=False, key=key, law=self.friction)

    def verify(self, problem: ContactProblem, load: Load, found: Any) -> None:
        """Raise `InputError` unless a path has these loads, and its states are solutions of a problem."""
        normal = [None if state.origin is None else state.origin.load for state in found]
        if [one.tangential_load for one in found] != list(self.loads) or normal != [load.arguments] * len(found):
            raise InputError("The path has other loads.")
        for state in found._saved_states:
            problem.verify(state)

    def end_of(self, found: Any) -> ContactSolution:
        """Return the state at the end of a path."""
        return judge_by(self.uncertainty, found[-1])

    def list_figures(self, found: Any) -> dict[str, Any]:
        """Return the figures of a path in its record, beside those of the contact at its end."""
        states = found._saved_states
        # From the best to the worst.
        severity = list(Status)
        stick = found.numbers[-1].stick_area
        lost = found.dissipated
        return {
            "status": max((state.status for state in states), key=severity.index).name,
            "iterations": found[-1].iterations,
            "convolutions": found[-1].convolutions,
            "seconds": math.fsum(state.seconds for state in states),
            "dissipated": lost.value,
            "dissipated_uncertainty": lost.uncertainty,
            "stick_area": stick.value,
            "stick_area_uncertainty": stick.uncertainty,
        }

    def list_warnings(self, found: Any) -> tuple[str, ...]:
        """Return what is warned of the path as a whole."""
        warnings: tuple[str, ...] = found.warnings
        return warnings

    def explain(self, problem: ContactProblem, loads: Sequence[Load]) -> str:
        """Return the plan of a path, in words."""
        return explain_with_friction(problem.plan, self.friction, 1 + len(self.loads))

    def memory_of(self, plan: SolvePlan) -> int:
        """Return the peak memory of a path, or of its normal contact with all cells in contact, bytes."""
        return max(plan.memory, memory_of_friction(plan, 1 + len(self.loads)))

    def list_rows(self) -> list[tuple[str, str]]:
        """Return the loads along the surface, and what the time is of."""
        return [
            ("path", str(self)),
            ("", "for the normal contacts alone: each step of a path takes several solves more"),
        ]

    def describe(self) -> dict[str, Any]:
        """Return the loads along the surface and the law."""
        return {"along": describe_loads(self.loads), "friction": describe_part(self.friction)}

    def __str__(self) -> str:
        texts = _shorten_list(list(map(str, self.loads)))
        return f"{self.kind.replace('_', ' ')} {texts} under each normal load; {self.friction!r}"


def _shorten_list(texts: Sequence[str]) -> str:
    if len(texts) > _MAX_LISTED_LOADS:
        texts = [*texts[: _MAX_LISTED_LOADS - 1], "...", texts[-1]]
    return ", ".join(texts)


@attrs.frozen(eq=False)
class PassingUnder(Loading):
    """The times and sliding distances that pass under each normal load of a study, on fresh surfaces.

    Attributes
    ----------
    time, sliding
        Times, s, and distances, m, at the places of a path; empty: none pass.
    factors
        The loads there, over the normal load; empty: it holds.
    accuracy
        Admissible error of an increment.
    uncertainty
        What the uncertainties of the answers at the end of a path are found from.
    """

    time: tuple[float, ...]
    sliding: tuple[float, ...]
    factors: tuple[float, ...]
    accuracy: float
    uncertainty: str = "auto"
    goes_on = False
    has_draft = True

    @property
    def passed(self) -> dict[str, Any]:
        """The arguments of `ContactProblem.path` that state what passes."""
        return {"time": self.time or None, "sliding": self.sliding or None}

    @property
    def parts(self) -> Sequence[Any]:  # type: ignore[override]
        """Times, distances, accuracy, and factors if there are some."""
        factors = ["factors", list(self.factors)] if self.factors else []
        return ["time", list(self.time), "sliding", list(self.sliding), self.accuracy, *factors]

    def require(self, problem: ContactProblem, loads: Sequence[Load]) -> None:
        """Raise `InputError` unless a problem carries the loads, and a law of it depends on what passes."""
        for load in loads:
            prepare_path(problem, self._find_normal(load), **self.passed)

    def _find_normal(self, load: Load) -> dict[str, Any]:
        """Return the argument of `ContactProblem.path` that states the loads."""
        return {load.kind: [factor * load.value for factor in self.factors] if self.factors else load.value}

    def order(self, problem: ContactProblem, loads: Sequence[Load]) -> Sequence[int]:
        """Return the positions in their order."""
        return range(len(loads))

    def solve(
        self, problem: ContactProblem, load: Load, before: Sequence[ContactSolution], draft: Path | None = None
    ) -> LoadPath:
        """Return the states under a normal load."""
        normal = self._find_normal(load)
        strict = self.accuracy
        return run_load_path(problem, normal, {}, self.passed, strict, None, _show_nothing, draft, is_draft=True)

    def write(self, file: Path, found: Any, key: str, earlier: Sequence[Mapping[str, float]]) -> None:
        """Write a path."""
        save_load_path(file, found, key)

    def read(self, folder: Path, key: str) -> LoadPath:
        """Return the path with a key."""
        return read_load_path(solution_path(folder, key), key)

    def verify(self, problem: ContactProblem, load: Load, found: Any) -> None:
        """Raise `InputError` unless a path leads to these places under a load, and its states are of a problem."""
        places = [
            (state.origin and state.origin.load, time, sliding)
            for state, time, sliding in zip(found, found.time, found.sliding, strict=True)
        ]
        scene, expected = prepare_path(problem, self._find_normal(load), **self.passed)
        if places != [(place.load.arguments, place.time, place.sliding) for place in expected]:
            raise InputError("The path has other places.")
        for state in found:
            scene.verify(state)

    def end_of(self, found: Any) -> ContactSolution:
        """Return the state at the end of a path."""
        return judge_by(self.uncertainty, found[-1])

    def list_figures(self, found: Any) -> dict[str, Any]:
        """Return where a path ends, and the cost of its states."""
        return {
            "status": found[-1].status.name,
            "iterations": found[-1].iterations,
            "convolutions": found[-1].convolutions,
            "seconds": math.fsum(state.seconds for state in found),
            **{name: values[-1] for name, values, _ in self._list_passed()},
            "numbers": list_law_numbers(found[-1]),
        }

    def explain(self, problem: ContactProblem, loads: Sequence[Load]) -> str:
        """Return the plan of a state with the laws that remember, in words."""
        return explain_loads(remember_changes(problem), loads)

    def memory_of(self, plan: SolvePlan) -> int:
        """Return the peak memory of a path with all its states, bytes."""
        states = 2 + max(len(self.time), len(self.sliding))
        return plan.memory + 8 * plan.grid.cells * _ARRAYS_OF_STATE * states

    def list_rows(self) -> list[tuple[str, str]]:
        """Return what passes, and what the time is of."""
        return [("path", str(self)), ("", "for single solves: each place of a path takes several")]

    def describe(self) -> dict[str, Any]:
        """Return times, distances, factors and accuracy."""
        values = {name: describe_value(list(one), unit) for name, one, unit in self._list_passed()}
        return {**values, **({"factors": list(self.factors)} if self.factors else {}), "accuracy": self.accuracy}

    def _list_passed(self) -> list[tuple[str, tuple[float, ...], str]]:
        pairs = (("time", self.time, "s"), ("sliding", self.sliding, "m"))
        return [(name, values, unit) for name, values, unit in pairs if values]

    def __str__(self) -> str:
        texts = [
            f"{name} {_shorten_list([si(value, unit, 3) for value in values])}"
            for name, values, unit in self._list_passed()
        ]
        times = f"{_shorten_list([f'{factor:.3g}' for factor in self.factors])} times " if self.factors else ""
        return f"{'; '.join(texts)}, under {times}each normal load"


def _show_nothing(text: str, done: float | None = None) -> None:
    """Tell nobody how far a path of a study has come."""


def read_loading(
    along: Mapping[str, Any], passed: Mapping[str, Any], uncertainty: str, responses: Sequence[Response[Any]]
) -> Loading:
    """Return what the arguments of a study ask for at each load.

    Parameters
    ----------
    along
        ``tangential_force``, ``displacement``, ``friction`` and ``substeps``.
    passed
        ``time``, ``sliding``, ``factors`` and ``accuracy``.
    uncertainty
        What the uncertainties of answers are found from.
    responses
        What is asked of each contact.

    Raises
    ------
    InputError
        If there are loads along the surface without friction, or friction without them, if something passes with them,
        a value is wrong, or a response means nothing for a state with a tangential traction.
    """
    given = {name: along[name] for name in ("tangential_force", "displacement")}
    friction = along["friction"]
    substeps = along["substeps"]
    strict = check_accuracy(passed["accuracy"])
    lists = {name: passed[name] for name in ("time", "sliding")}
    passes = any(values is not None for values in lists.values())
    if passed["factors"] is not None and not passes:
        raise InputError("The factors are those of a load over time or sliding: give time=[...] or sliding= too.")
    if strict != PATH_ACCURACY and not passes:
        raise InputError("The accuracy is that of increments of time or sliding: give time=[...] or sliding= too.")
    if all(values is None for values in given.values()):
        if friction is not None or substeps != "auto":
            raise InputError(
                "Friction is for loads along the surface: give tangential_force=[(x, y), ...] or displacement= too."
            )
        if not passes:
            return SingleLoads(uncertainty)
        factors = _list_factors(passed["factors"])
        places = list_places([Load("force", factor) for factor in factors or (1.0,)], **lists)
        times, distances = (
            tuple(getattr(place, name) for place in places) if values is not None else ()
            for name, values in lists.items()
        )
        return PassingUnder(times, distances, factors, strict, uncertainty)
    if passes:
        raise InputError("Time and sliding distance pass without friction: omit them, or the loads along the surface.")
    for response in responses:
        require_to_hold(response, {"shear"})
    if friction is None:
        raise InputError("Loads along the surface need a law by which it slips: give friction=0.3, for example.")
    count: int | str = "auto" if substeps == "auto" else integer(substeps, "substeps=", at_least=1)
    return LoadsAlong(tuple(list_targets(given)), resolve_friction(friction), count, uncertainty)


def _list_factors(values: object) -> tuple[float, ...]:
    """Return the factors of a load at the places of a path; empty without any."""
    if values is None:
        return ()
    allowed = "a list of numbers, factors=[...]"
    found = tuple(number(value, "A factor of the loads") for value in list_of(values, "The factors", allowed))
    if not found:
        raise InputError.about("The factors", values, allowed)
    return found
