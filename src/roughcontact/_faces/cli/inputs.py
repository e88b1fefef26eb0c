"""The inputs of an answer as data that JSON can hold: parts as expressions of a script, loads with their units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import roughcontact as rc
from roughcontact._faces.html.inputs import describe_part, find_problem
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import AS_GIVEN, RequiredLoad
from roughcontact._solve.solution import TangentialLoad, find_load
from roughcontact._work.studies import Study, name_of

_METHOD = ("kernel", "convolver", "solver")


def describe_value(value: Any, unit: str) -> dict[str, Any]:
    """Return a number, or a list of numbers, with its unit."""
    return {"value": value, "unit": unit}


def describe_grid(grid: rc.Grid) -> dict[str, Any]:
    """Return the cells and the size of a grid."""
    return {"shape": list(grid.shape), "size": describe_value(list(grid.size), "m")}


def describe_problem(problem: rc.ContactProblem) -> dict[str, Any]:
    """Return method, bodies, adhesion, grid and boundary of a problem."""
    plan = problem.plan
    parts: dict[str, Any] = {name: describe_part(getattr(plan, name)) for name in _METHOD}
    if problem.adhesion is not None:
        parts["adhesion"] = describe_part(problem.adhesion)
    for name in ("body", "counterbody"):
        body = getattr(problem, name)
        parts[name] = {"surface": describe_part(body.surface), "material": describe_part(body.material)}
        if body.surface.provenance:
            parts[name]["provenance"] = list(body.surface.provenance)
    return {**parts, "grid": describe_grid(plan.grid), "boundary": str(problem.boundary)}


def describe_loads(loads: Sequence[Load] | Sequence[TangentialLoad]) -> dict[str, Any]:
    """Return loads of one kind: a value, of several a list of values."""
    values = [one.value if isinstance(one, Load) else list(one.values) for one in loads]
    return {"kind": loads[0].kind, **describe_value(values[0] if len(values) == 1 else values, loads[0].unit)}


def describe_responses(asked: Mapping[str, rc.Response[Any]]) -> dict[str, Any]:
    """Return what is asked of a contact, with its fields, by name; empty if nothing is."""
    return {"responses": {name: describe_part(one) for name, one in asked.items()}} if asked else {}


def describe_wanted(answer: rc.Response[Any], required: RequiredLoad) -> dict[str, Any]:
    """Return the answer for which a load was asked, and what was wanted of it."""
    return {"solve_for": {"answer": describe_part(answer), **describe_value(required.wanted, required.answer.unit)}}


def describe_inputs(problem: rc.ContactProblem, loads: Sequence[Load]) -> dict[str, Any]:
    """Return the parts of a problem and its loads."""
    return {**describe_problem(problem), "load": describe_loads(loads)}


def find_inputs(solutions: Sequence[rc.ContactSolution]) -> dict[str, Any] | None:
    """Return the problem of solutions, and their loads; None if they are not known."""
    problem, _ = find_problem(solutions[0])
    loads = [load for load in map(find_load, solutions) if load is not None]
    return None if problem is None or len(loads) < len(solutions) else describe_inputs(problem, loads)


def find_state_inputs(state: rc.FrictionalSolution) -> dict[str, Any] | None:
    """Return the problem of a state with friction, its loads and the law; None if they are not known."""
    return _find_frictional_inputs([state.contact], [state])


def find_path_inputs(path: rc.FrictionalPath) -> dict[str, Any] | None:
    """Return the problem of a path, its loads and the law, and increments that were given; None if not known."""
    # Under one normal load the bodies are pressed first, and then moved.
    contacts = [state.contact for state in (path if path.pressed is None else path[:1])]
    found = _find_frictional_inputs(contacts, path)
    if found is not None and AS_GIVEN in path.reasons:
        found["substeps"] = path.increments[path.reasons.index(AS_GIVEN)]
    return found


def _find_frictional_inputs(
    contacts: Sequence[rc.ContactSolution], states: Sequence[rc.FrictionalSolution]
) -> dict[str, Any] | None:
    found = find_inputs(contacts)
    law = {"friction": describe_part(states[0].friction)}
    return None if found is None else {**found, "along": describe_loads([one.given for one in states]), **law}


def describe_study(study: Study) -> dict[str, Any]:
    """Return the problems of a study by name, and what each is solved at and asked for."""
    content: dict[str, Any] = {
        "problems": {name: describe_problem(problem) for name, problem in study.problems.items()},
        "load": describe_loads(study.loads),
        "seeds": list(study.seeds),
        "areas": list(study.areas),
        **describe_responses({name_of(one): one for one in study.responses}),
    }
    if study.shearing is not None:
        content["along"] = describe_loads(study.shearing.loads)
        content["friction"] = describe_part(study.shearing.friction)
    return content
