"""What a study finds at each load: a state, or a path under it, with loads along the surface, time or sliding."""

from __future__ import annotations

import abc
import copy
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from roughcontact._base.checks import integer
from roughcontact._base.units import Estimate, si
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
    explain_with_friction,
    list_places,
    list_targets,
    memory_of_friction,
    order_loads,
    read_frictional_path,
    read_load_path,
    remember_changes,
    require_frictional,
    require_used,
    resolve_friction,
    save_load_path,
    save_path,
    solve_next,
)
from roughcontact._solve.solution import (
    ContactSolution,
    Governed,
    Response,
    Status,
    TangentialLoad,
    read_figures,
    require_to_hold,
    scalars_of,
    write,
)
from roughcontact._work.studies.record import read_solution, solution_path
from roughcontact.errors import InputError

# Loads or places of a path that `explain` lists: the first ones and the last.
_MAX_LISTED_LOADS = 6
# Arrays of a state on a path: pressure, displacement, gap, its change, and what laws remember before and after.
_ARRAYS_OF_STATE = 10


class Loading(abc.ABC):
    """How a study finds what it keeps at a load, and asks it."""

    # What determines the states beside the problem and the load.
    parts: Sequence[Any] = ()
    # What the uncertainties of the answers of a state are found from.
    uncertainty: str
    # Whether each solve starts from the states at the loads before.
    goes_on = True

    @abc.abstractmethod
    def require(self, problem: ContactProblem) -> None:
        """Raise `InputError` unless this can be done with a problem."""

    @abc.abstractmethod
    def order(self, problem: ContactProblem, loads: Sequence[Load]) -> Sequence[int]:
        """Return the positions of loads in the order in which they are solved."""

    @abc.abstractmethod
    def solve(self, problem: ContactProblem, load: Load, before: Sequence[ContactSolution]) -> Any:
        """Return what is found at a load, after the last states of those before."""

    def follows(self, problem: ContactProblem) -> bool:
        """Return whether what is found at a load depends on the loads before it."""
        return False

    @abc.abstractmethod
    def write(self, file: Path, found: Any, key: str, earlier: Sequence[Mapping[str, float]]) -> None:
        """Write what was found; the list of records is flushed once for the chain, and with it the names of files.

        `earlier` are the loads on which it depends.
        """

    @abc.abstractmethod
    def read(self, folder: Path, key: str) -> Any:
        """Return what was written under a key; `InputError` where it is missing or damaged."""

    def read_figures(self, folder: Path, key: str) -> dict[str, Any]:
        """Return the figures of what was written, by which a record is known to be of it."""
        return {**scalars_of(self.end_of(found := self.read(folder, key))), **self.list_figures(found)}

    @abc.abstractmethod
    def verify(self, problem: ContactProblem, load: Load, found: Any) -> None:
        """Raise `InputError` unless what was read is of a problem and a load."""

    @abc.abstractmethod
    def end_of(self, found: Any) -> ContactSolution:
        """Return the state that a record describes."""

    def list_figures(self, found: Any) -> dict[str, Any]:
        """Return the figures of a record beside those of this state."""
        return {}

    def list_warnings(self, found: Any) -> tuple[str, ...]:
        """Return what is warned of beside this state."""
        return ()

    def explain(self, problem: ContactProblem) -> str:
        """Return the plan of a load, in words."""
        return problem.explain()

    def memory_of(self, plan: SolvePlan) -> int:
        """Return the peak memory of a load, bytes."""
        return plan.memory

    def list_rows(self) -> list[tuple[str, str]]:
        """Return what it does at each load, and what the time of a study does not count, in rows of its plan."""
        return []

    def describe(self) -> dict[str, Any]:
        """Return it as plain data by name, beside the loads."""
        return {}


def judge_by(uncertainty: str, state: ContactSolution) -> ContactSolution:
    """Return a state whose answers have uncertainties found from this."""
    return state if state.uncertainty == uncertainty else attrs.evolve(state, uncertainty=uncertainty)


@attrs.frozen
class SingleLoads(Loading):
    """A state at each load, from the states before.

    Attributes
    ----------
    uncertainty
        What the uncertainties of its answers are found from.
    """

    uncertainty: str = "auto"

    def require(self, problem: ContactProblem) -> None:
        """Take any problem."""

    def order(self, problem: ContactProblem, loads: Sequence[Load]) -> Sequence[int]:
        """Return the positions from the largest load down; in their order where a state depends on those before."""
        return order_loads(problem, loads)

    def solve(self, problem: ContactProblem, load: Load, before: Sequence[ContactSolution]) -> ContactSolution:
        """Return the state at a load."""
        return judge_by(self.uncertainty, solve_next(problem, before, load))

    def follows(self, problem: ContactProblem) -> bool:
        """Return whether a state depends on those before."""
        return problem.remembers

    def write(self, file: Path, found: Any, key: str, earlier: Sequence[Mapping[str, float]]) -> None:
        """Write a state, whose key follows from its problem and the loads."""
        write(file, found, flush=False, earlier=earlier)

    def read(self, folder: Path, key: str) -> ContactSolution:
        """Return the state with a key."""
        return judge_by(self.uncertainty, read_solution(folder, key))

    def read_figures(self, folder: Path, key: str) -> dict[str, Any]:
        """Return the figures of a state, whose fields are not read."""
        return read_figures(solution_path(folder, key), key)

    def verify(self, problem: ContactProblem, load: Load, found: Any) -> None:
        """Raise `InputError` unless a state is a solution of a problem: its key says at which load."""
        problem.verify(found)

    def end_of(self, found: Any) -> ContactSolution:
        """Return the state."""
        state: ContactSolution = found
        return state


SINGLE_LOADS = SingleLoads()


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

    def require(self, problem: ContactProblem) -> None:
        """Raise `InputError` unless a problem has a response to loads along its surface."""
        # Of a copy: the responses to shear of all problems would take the memory of many grids.
        require_frictional(copy.copy(problem))

    def order(self, problem: ContactProblem, loads: Sequence[Load]) -> Sequence[int]:
        """Return the positions in their order."""
        return range(len(loads))

    def solve(self, problem: ContactProblem, load: Load, before: Sequence[ContactSolution]) -> FrictionalPath:
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

    def explain(self, problem: ContactProblem) -> str:
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
    accuracy
        Admissible error of an increment.
    uncertainty
        What the uncertainties of the answers at the end of a path are found from.
    """

    time: tuple[float, ...]
    sliding: tuple[float, ...]
    accuracy: float
    uncertainty: str = "auto"
    goes_on = False

    @property
    def passed(self) -> dict[str, tuple[float, ...] | None]:
        """The arguments of `ContactProblem.path` that state what passes."""
        return {"time": self.time or None, "sliding": self.sliding or None}

    @property
    def parts(self) -> Sequence[Any]:  # type: ignore[override]
        """Times, distances and accuracy."""
        return ["time", list(self.time), "sliding", list(self.sliding), self.accuracy]

    def require(self, problem: ContactProblem) -> None:
        """Raise `InputError` unless a law of a problem depends on what passes."""
        require_used(remember_changes(problem), self.passed)

    def order(self, problem: ContactProblem, loads: Sequence[Load]) -> Sequence[int]:
        """Return the positions in their order."""
        return range(len(loads))

    def solve(self, problem: ContactProblem, load: Load, before: Sequence[ContactSolution]) -> LoadPath:
        """Return the states under a normal load."""
        given: dict[str, Any] = {**load.arguments, **self.passed}
        path: LoadPath = problem.path(**given, accuracy=self.accuracy)
        return path

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
        expected = [(load.arguments, place.time, place.sliding) for place in list_places([load], **self.passed)]
        if places != expected:
            raise InputError("The path has other places.")
        scene = remember_changes(problem)
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

    def explain(self, problem: ContactProblem) -> str:
        """Return the plan of a state with the laws that remember, in words."""
        return remember_changes(problem).explain()

    def memory_of(self, plan: SolvePlan) -> int:
        """Return the peak memory of a path with all its states, bytes."""
        return plan.memory + 8 * plan.grid.cells * _ARRAYS_OF_STATE * (2 + max(len(self.time), len(self.sliding)))

    def list_rows(self) -> list[tuple[str, str]]:
        """Return what passes, and what the time is of."""
        return [("path", str(self)), ("", "for single solves: each place of a path takes several")]

    def describe(self) -> dict[str, Any]:
        """Return times, distances and accuracy."""
        values = {name: describe_value(list(one), unit) for name, one, unit in self._list_passed()}
        return {**values, "accuracy": self.accuracy}

    def _list_passed(self) -> list[tuple[str, tuple[float, ...], str]]:
        pairs = (("time", self.time, "s"), ("sliding", self.sliding, "m"))
        return [(name, values, unit) for name, values, unit in pairs if values]

    def __str__(self) -> str:
        texts = [
            f"{name} {_shorten_list([si(value, unit, 3) for value in values])}"
            for name, values, unit in self._list_passed()
        ]
        return f"{'; '.join(texts)}, under each normal load"


def list_law_numbers(state: ContactSolution) -> dict[str, tuple[float, str]]:
    """Return the numbers of the laws of a state by name, each with its unit."""
    effect = state._find_added(Governed)
    numbers = {} if effect is None else effect.numbers
    pairs = {name: (one.value, one.unit) if isinstance(one, Estimate) else one for name, one in numbers.items()}
    return {name: (float(value), unit) for name, (value, unit) in pairs.items()}


def read_loading(
    along: Mapping[str, Any], passed: Mapping[str, Any], uncertainty: str, responses: Sequence[Response[Any]]
) -> Loading:
    """Return what the arguments of a study ask for at each load.

    Parameters
    ----------
    along
        ``tangential_force``, ``displacement``, ``friction`` and ``substeps``.
    passed
        ``time``, ``sliding`` and ``accuracy``.
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
    if strict != PATH_ACCURACY and not passes:
        raise InputError("The accuracy is that of increments of time or sliding: give time=[...] or sliding= too.")
    if all(values is None for values in given.values()):
        if friction is not None or substeps != "auto":
            raise InputError(
                "Friction is for loads along the surface: give tangential_force=[(x, y), ...] or displacement= too."
            )
        if not passes:
            return SingleLoads(uncertainty)
        places = list_places([Load("force", 1.0)], **lists)
        times, distances = (
            tuple(getattr(place, name) for place in places) if values is not None else ()
            for name, values in lists.items()
        )
        return PassingUnder(times, distances, strict, uncertainty)
    if passes:
        raise InputError("Time and sliding distance pass without friction: omit them, or the loads along the surface.")
    for response in responses:
        require_to_hold(response, {"shear"})
    if friction is None:
        raise InputError("Loads along the surface need a law by which it slips: give friction=0.3, for example.")
    count: int | str = "auto" if substeps == "auto" else integer(substeps, "substeps=", at_least=1)
    return LoadsAlong(tuple(list_targets(given)), resolve_friction(friction), count, uncertainty)
