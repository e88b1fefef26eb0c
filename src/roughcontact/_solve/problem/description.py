"""Solutions and their inputs as data that JSON can hold: parts as expressions of a script, numbers with their units."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path as File
from typing import Any, TypeVar, final

import attrs
import numpy as np

from roughcontact._base.archive import replacing
from roughcontact._parts.grid import Grid, Load
from roughcontact._parts.kernels import InfluenceKernel, has_layers
from roughcontact._solve.problem.body import Body
from roughcontact._solve.problem.expressions import describe_part
from roughcontact._solve.problem.path import Path
from roughcontact._solve.problem.problem import ContactProblem
from roughcontact._solve.problem.saved import problem_of
from roughcontact._solve.solution import (
    Area,
    ContactSolution,
    Estimate,
    SolutionWriter,
    TangentialLoad,
    describe_other_places,
    find_load,
    versions,
)
from roughcontact.errors import RoughContactError

E = TypeVar("E", bound=Estimate | Area)
_METHOD = ("kernel", "convolver", "solver")
_RESIDUALS = ("complementarity", "penetration", "load", "tension")
_COST = ("iterations", "convolutions", "seconds")
# Arguments of a path that its loads do not show.
_OF_PATHS = ("substeps", "cycles", "time", "sliding", "direction", "shift", "accuracy")


@final
@attrs.frozen
class JsonWriter(SolutionWriter):
    """Inputs, answers and certificate for other programs, without fields: what ``roughcontact solve --json`` prints."""

    @property
    def suffixes(self) -> frozenset[str]:
        """The ending of a JSON file."""
        return frozenset({".json"})

    def write(self, solution: ContactSolution, path: File) -> None:
        """Write the file."""
        with replacing(path) as partial:
            partial.write_text(f"{format_json(self.describe(solution))}\n", encoding="utf-8")

    def describe(self, solution: ContactSolution) -> dict[str, Any]:
        """Return the content of the file."""
        plain: dict[str, Any] = to_plain({**describe_solution(solution), "versions": find_versions(solution)})
        return plain


def describe_solution(solution: ContactSolution, estimator: str | None = None) -> dict[str, Any]:
    """Return answers, certificate and inputs of a solution, with the area of one more estimator if it is named."""
    accuracy = solution.accuracy
    area = _ask(solution, solution.area)
    peak = _ask(solution, solution.peak_pressure)
    places = describe_other_places(solution, {"contact area": area, "maximum pressure": peak})
    return {
        "status": solution.status.name,
        "converged": solution.status.success,
        "area": _describe_area(area),
        **({} if estimator is None else {"other_area": _describe_area(solution.area(estimator))}),
        "peak_pressure": None if peak is None else describe_estimate(peak),
        "force": describe_value(solution.force, "N"),
        "mean_pressure": describe_value(solution.mean_pressure, "Pa"),
        "approach": describe_value(solution.approach, "m"),
        **_describe_attractive_area(solution),
        "saturated_area": _describe_area(_ask(solution, solution.saturated_area))
        if solution.capped and solution.parts.is_whole
        else None,
        "contact_modulus": describe_value(solution.modulus, "Pa"),
        "other_places": places or None,
        "warnings": list(solution.warnings),
        "accuracy": None if accuracy is None else {"met": accuracy.met, "message": str(accuracy)},
        **_describe_added(solution),
        "residuals": {name: getattr(solution.residuals, name) for name in _RESIDUALS},
        "certificate": {one.name: one.residual for one in solution.certificate.conditions},
        "inputs": find_inputs([solution]),
        "grid": describe_grid(solution.grid),
        "boundary": str(solution.boundary),
        "cost": {name: getattr(solution, name) for name in _COST},
    }


def _describe_added(solution: ContactSolution) -> dict[str, Any]:
    """Return the numbers that physics have added to a solution, with their units."""
    return {
        name: describe_estimate(one) if isinstance(one, Estimate) else describe_value(*one)
        for numbers in (*(one.list_numbers(solution) for one in solution.added), solution.parts.list_numbers(solution))
        for name, one in numbers.items()
    }


def _ask(solution: ContactSolution, ask: Callable[[], E]) -> E | None:
    """Return an answer; None if a solution that did not converge has none."""
    try:
        return ask()
    # Estimators are plug-ins.
    except Exception:
        if solution.status.success:
            raise
        return None


def describe_estimate(found: Estimate | Area) -> dict[str, Any]:
    """Return an estimate with its uncertainty, unit and warnings."""
    sampling = found.sampling
    return {
        "value": float(found.value),
        "uncertainty": float(found.uncertainty),
        **({} if sampling is None else {"sampling": float(sampling)}),
        "unit": found.unit,
        "warnings": list(found.warnings),
    }


def _describe_area(area: Area | None) -> dict[str, Any] | None:
    if area is None:
        return None
    return {**describe_estimate(area), "fraction": float(area.fraction), "estimator": area.estimator}


def _describe_attractive_area(solution: ContactSolution) -> dict[str, Any]:
    if solution.tension is None:
        return {}
    return {"attractive_area": _describe_area(_ask(solution, solution.attractive_area))}


def describe_value(value: Any, unit: str) -> dict[str, Any]:
    """Return a number, or a list of numbers, with its unit."""
    return {"value": value, "unit": unit}


def describe_grid(grid: Grid) -> dict[str, Any]:
    """Return the cells and the size of a grid."""
    return {"shape": list(grid.shape), "size": describe_value(list(grid.size), "m")}


def describe_problem(problem: ContactProblem) -> dict[str, Any]:
    """Return method, bodies, adhesion, grid and boundary of a problem."""
    plan = problem.plan
    parts: dict[str, Any] = {name: describe_part(getattr(plan, name)) for name in _METHOD}
    parts["tolerance"] = plan.solver.tolerance
    if problem.adhesion is not None:
        parts["adhesion"] = describe_part(problem.adhesion)
    if problem.laws:
        parts["laws"] = [describe_part(law) for law in problem.laws]
    for name in ("body", "counterbody"):
        body = getattr(problem, name)
        parts[name] = {"surface": describe_part(body.surface), "material": describe_part(body.material)}
        if body.surface.provenance:
            parts[name]["provenance"] = list(body.surface.provenance)
        layers = _list_layers(plan.kernel, name, body)
        if layers:
            parts[name]["layers"] = [_describe_fields(one) for one in layers]
    return {**parts, "grid": describe_grid(plan.grid), "boundary": str(problem.boundary)}


def _list_layers(kernel: InfluenceKernel, name: str, body: Body) -> Sequence[Any]:
    """Return the layers that a kernel of layers has on a body, from the surface downwards; empty without any."""
    part: Any = kernel.part_of(name) or kernel
    layers = getattr(part, "layers", ())
    return layers if layers and has_layers(kernel, name, body.material) else ()


def _describe_fields(part: Any) -> dict[str, Any]:
    """Return the numbers of a part by name, with their units."""
    found = {}
    for field in attrs.fields(type(part)):
        unit = field.metadata.get("unit", field.metadata.get("plain_unit", ""))
        found[field.name] = describe_value(getattr(part, field.name), unit)
    return found


def describe_loads(loads: Sequence[Load] | Sequence[TangentialLoad]) -> dict[str, Any]:
    """Return loads of one kind: a value, of several a list of values."""
    values = [one.value if isinstance(one, Load) else list(one.values) for one in loads]
    return {"kind": loads[0].kind, **describe_value(values[0] if len(values) == 1 else values, loads[0].unit)}


def describe_inputs(problem: ContactProblem, loads: Sequence[Load]) -> dict[str, Any]:
    """Return the parts of a problem and its loads."""
    return {**describe_problem(problem), "load": describe_loads(loads)}


def find_problem(solution: ContactSolution) -> tuple[ContactProblem | None, str]:
    """Return the problem that a solution solves, or None and the reason in a sentence."""
    try:
        return problem_of(solution), ""
    except RoughContactError as error:
        return None, str(error)


def find_inputs(solutions: Sequence[ContactSolution]) -> dict[str, Any] | None:
    """Return the problem of solutions, their loads and with friction its law; None if they are not known."""
    problem, _ = find_problem(solutions[0])
    loads = [load for load in map(find_load, solutions) if load is not None]
    if problem is None or len(loads) < len(solutions):
        return None
    return describe_inputs(problem, loads) | _describe_along(solutions)


def _describe_along(states: Sequence[ContactSolution]) -> dict[str, Any]:
    """Return the loads along the surface of states with friction, and the law; nothing without."""
    if states[0].shear is None:
        return {}
    return {
        "along": describe_loads([state.tangential_load for state in states]),
        "friction": describe_part(states[0].friction),
    }


def find_path_inputs(path: Path) -> dict[str, Any] | None:
    """Return the problem of a path, its loads, what passes, the law, and given increments; None if not known."""
    found = find_inputs(path.given)
    if found is None:
        return None
    found |= _describe_along(path)
    return found | {name: value for name, value in path.list_arguments().items() if name in _OF_PATHS}


def find_versions(solution: ContactSolution) -> Mapping[str, str]:
    """Return the versions of the packages that solved a contact; those of today if they are not known."""
    return versions() if solution.origin is None else solution.origin.versions


def to_plain(value: Any) -> Any:
    """Return data in the types of JSON, with None for numbers that JSON does not have."""
    if isinstance(value, Mapping):
        return {str(name): to_plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    # Warnings are texts with a severity.
    return str(value) if isinstance(value, str) else value


def format_json(content: Mapping[str, Any]) -> str:
    """Return data as one JSON object; null for numbers that JSON does not have."""
    return json.dumps(to_plain(content), indent=2, allow_nan=False, ensure_ascii=False)
