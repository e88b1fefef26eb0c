"""What a study finds at each load, and how that is kept and asked: a state, from the states before."""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from roughcontact._base.units import Estimate
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import (
    ContactProblem,
    SolvePlan,
    explain_loads,
    order_loads,
    solve_next,
)
from roughcontact._solve.solution import (
    ContactSolution,
    Governed,
    read_figures,
    scalars_of,
    write,
)
from roughcontact._work.studies.record import read_solution, solution_path


class Loading(abc.ABC):
    """How a study finds what it keeps at a load, and asks it."""

    # What determines the states beside the problem and the load.
    parts: Sequence[Any] = ()
    # What the uncertainties of the answers of a state are found from.
    uncertainty: str
    # Whether each solve starts from the states at the loads before.
    goes_on = True
    # Whether a solve may take long, so that it is to go on after its process was killed.
    has_draft = False

    @abc.abstractmethod
    def require(self, problem: ContactProblem, loads: Sequence[Load]) -> None:
        """Raise `InputError` unless this can be done with a problem at loads."""

    @abc.abstractmethod
    def order(self, problem: ContactProblem, loads: Sequence[Load]) -> Sequence[int]:
        """Return the positions of loads in the order in which they are solved."""

    @abc.abstractmethod
    def solve(
        self, problem: ContactProblem, load: Load, before: Sequence[ContactSolution], draft: Path | None = None
    ) -> Any:
        """Return what is found at a load, after the last states of those before; from its draft, if it has one."""

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

    def explain(self, problem: ContactProblem, loads: Sequence[Load]) -> str:
        """Return the plan of the largest load, in words."""
        return explain_loads(problem, loads)

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

    def require(self, problem: ContactProblem, loads: Sequence[Load]) -> None:
        """Raise `InputError` unless a problem carries the loads; where it remembers, it may be unloaded."""
        for load in loads:
            if load.value != 0.0 or not problem.remembers:
                problem.require_load(**load.arguments)

    def order(self, problem: ContactProblem, loads: Sequence[Load]) -> Sequence[int]:
        """Return the positions from the largest load down; in their order where a state depends on those before."""
        return order_loads(problem, loads)

    def solve(
        self, problem: ContactProblem, load: Load, before: Sequence[ContactSolution], draft: Path | None = None
    ) -> ContactSolution:
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


def list_law_numbers(state: ContactSolution) -> dict[str, tuple[float, str]]:
    """Return the numbers of the laws of a state by name, each with its unit, and behind it its uncertainty."""
    effect = state._find_added(Governed)
    found: dict[str, tuple[float, str]] = {}
    for name, one in ({} if effect is None else effect.numbers).items():
        value, unit = (one.value, one.unit) if isinstance(one, Estimate) else one
        found[name] = (float(value), unit)
        if isinstance(one, Estimate):
            found[f"{name}_uncertainty"] = (float(one.uncertainty), unit)
    return found
