"""Paths with friction in a study: what is loaded along the surface, and the figures of what was followed."""

from __future__ import annotations

import math
from typing import Any

import attrs

from roughcontact._base.checks import integer
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import FrictionLaw
from roughcontact._solve.problem import (
    ContactProblem,
    FrictionalPath,
    SolvePlan,
    explain_with_friction,
    list_targets,
    memory_of_friction,
    resolve_friction,
)
from roughcontact._solve.solution import Status, TangentialLoad, scalars_of
from roughcontact.errors import InputError

# Loads along the surface that `explain` lists: the first ones and the last.
_MAX_LISTED_LOADS = 6


@attrs.frozen(eq=False)
class Shearing:
    """The loads along the surface that follow each normal load of a study.

    Attributes
    ----------
    loads
        The loads, one after the other.
    friction
        The law by which the surfaces slip.
    substeps
        Increments of each load; ``"auto"``: as many as it needs.
    """

    loads: tuple[TangentialLoad, ...]
    friction: FrictionLaw
    substeps: int | str

    @classmethod
    def of(cls, tangential_force: object, displacement: object, friction: object, substeps: object) -> Shearing | None:
        """Return the loads that the arguments of a study state; None without any.

        `InputError` if there are loads without friction, or friction without loads, or a value is wrong.
        """
        given = {"tangential_force": tangential_force, "displacement": displacement}
        if all(values is None for values in given.values()):
            if friction is not None or substeps != "auto":
                raise InputError(
                    "Friction is for loads along the surface: give tangential_force=[(x, y), ...] or displacement= too."
                )
            return None
        if friction is None:
            raise InputError("Loads along the surface need a law by which it slips: give friction=0.3, for example.")
        count: int | str = "auto" if substeps == "auto" else integer(substeps, "substeps=", at_least=1)
        return cls(tuple(list_targets(given)), resolve_friction(friction), count)

    @property
    def kind(self) -> str:
        """The argument of `ContactProblem.path` that states the loads."""
        return self.loads[0].kind

    def follow(self, problem: ContactProblem, load: Load) -> FrictionalPath:
        """Return the states at the loads along the surface, under a normal load."""
        along: dict[str, Any] = {self.kind: [one.values for one in self.loads]}
        return problem.path(**load.arguments, **along, friction=self.friction, substeps=self.substeps)

    def explain(self, problem: ContactProblem) -> str:
        """Return the plan of a path, in words."""
        return explain_with_friction(problem.plan, self.friction, 1 + len(self.loads))

    def memory_of(self, plan: SolvePlan) -> int:
        """Return the peak memory of a path, or of its normal contact with all cells in contact, bytes."""
        return max(plan.memory, memory_of_friction(plan, 1 + len(self.loads)))

    @property
    def parts(self) -> list[Any]:
        """What determines the states beside the problem and the normal load."""
        return [self.kind, [list(one.values) for one in self.loads], self.friction, self.substeps]

    def verify(self, problem: ContactProblem, load: Load, path: FrictionalPath) -> None:
        """Raise `InputError` unless a path has these loads, and its states are solutions of a problem."""
        origins = [state.origin for state in path]
        normal = [None if origin is None else origin.load for origin in origins]
        if [state.tangential_load for state in path] != list(self.loads) or normal != [load.arguments] * len(path):
            raise InputError("The path has other loads.")
        for state in (*([] if path.pressed is None else [path.pressed]), *path):
            problem.verify(state)

    def __str__(self) -> str:
        texts = list(map(str, self.loads))
        if len(texts) > _MAX_LISTED_LOADS:
            texts = [*texts[: _MAX_LISTED_LOADS - 1], "...", texts[-1]]
        return f"{self.kind.replace('_', ' ')} {', '.join(texts)} under each normal load; {self.friction!r}"


def figures_of(path: FrictionalPath) -> dict[str, Any]:
    """Return the figures of a path that its record states, as `read_figures` does those of a solution."""
    last = path[-1]
    counts = {"iterations": last.iterations, "convolutions": last.convolutions}
    return {**scalars_of(last), **counts, **list_figures(path)}


def list_figures(path: FrictionalPath) -> dict[str, Any]:
    """Return the figures of a path in its record, beside those of the contact at its end."""
    states = [*([] if path.pressed is None else [path.pressed]), *path]
    # From the best to the worst.
    severity = list(Status)
    stick = path.numbers[-1].stick_area
    lost = path.dissipated
    return {
        "status": max((state.status for state in states), key=severity.index).name,
        "seconds": math.fsum(state.seconds for state in states),
        "dissipated": lost.value,
        "dissipated_uncertainty": lost.uncertainty,
        "stick_area": stick.value,
        "stick_area_uncertainty": stick.uncertainty,
    }
