"""The answers of a solve as text, as JSON and as CSV."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Sequence
from typing import Any

import roughcontact as rc
from roughcontact._base.tables import Table
from roughcontact._base.units import si
from roughcontact._base.units.text import fit
from roughcontact._solve.problem import Sweep, make_table
from roughcontact._solve.solution import versions


def to_json(solutions: Sequence[rc.ContactSolution], estimator: str | None = None) -> str:
    """Return one JSON object: the description of the only solution, or a list of them under ``solutions``.

    `estimator` is the name of an area estimator whose area is given besides the default.
    """
    described = [_describe(solution, estimator) for solution in solutions]
    content = described[0] if len(described) == 1 else {"solutions": described}
    return json.dumps(_finite({**content, "versions": versions()}), indent=2, allow_nan=False, ensure_ascii=False)


def _describe(solution: rc.ContactSolution, estimator: str | None) -> dict[str, Any]:
    accuracy = solution.accuracy
    peak = solution.peak_pressure()
    return {
        "status": solution.status.name,
        "converged": solution.status.success,
        "area": _area(solution.area()),
        **({} if estimator is None else {"other_area": _area(solution.area(estimator))}),
        "peak_pressure": _estimate(peak),
        "force": _value(solution.force, "N"),
        "mean_pressure": _value(solution.mean_pressure, "Pa"),
        "approach": _value(solution.approach, "m"),
        "saturated_area": _area(solution.saturated_area()) if solution.capped else None,
        "contact_modulus": _value(solution.modulus, "Pa"),
        "warnings": list(solution.warnings),
        "accuracy": None if accuracy is None else {"met": accuracy.met, "message": str(accuracy)},
        "residuals": {name: getattr(solution.residuals, name) for name in ("complementarity", "penetration", "load")},
        "grid": {"shape": list(solution.grid.shape), "size": _value(list(solution.grid.size), "m")},
        "boundary": str(solution.boundary),
        "cost": {name: getattr(solution, name) for name in ("iterations", "convolutions", "seconds")},
    }


def _value(value: Any, unit: str) -> dict[str, Any]:
    return {"value": value, "unit": unit}


def _estimate(found: rc.Estimate) -> dict[str, Any]:
    return {
        "value": float(found.value),
        "uncertainty": float(found.uncertainty),
        "unit": found.unit,
        "warnings": list(found.warnings),
    }


def _area(area: rc.Area) -> dict[str, Any]:
    return {
        "value": float(area.value),
        "uncertainty": float(area.uncertainty),
        "unit": "m2",
        "fraction": float(area.fraction),
        "estimator": area.estimator,
        "warnings": list(area.warnings),
    }


def _finite(value: Any) -> Any:
    """Return data with None for numbers that JSON does not have."""
    if isinstance(value, dict):
        return {name: _finite(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def to_csv(solutions: Sequence[rc.ContactSolution], estimator: str | None = None) -> str:
    """Return a header and a row for each load, in SI units: the columns of `Sweep.to_pandas`, and more."""
    table = make_table(Sweep(tuple(solutions)))
    columns: dict[str, Any] = {
        **table.columns,
        "saturated_area": [float(solution.saturated_area().value) for solution in solutions],
        "status": [solution.status.name for solution in solutions],
        "warnings": [" ".join(_warnings(solution)) for solution in solutions],
        "convolutions": [solution.convolutions for solution in solutions],
        "seconds": [solution.seconds for solution in solutions],
    }
    units = {**table.units, "saturated_area": "m2", "seconds": "s"}
    if estimator is not None:
        others = [solution.area(estimator) for solution in solutions]
        columns["other_area"] = [float(area.value) for area in others]
        columns["other_area_uncertainty"] = [float(area.uncertainty) for area in others]
        units |= {"other_area": "m2", "other_area_uncertainty": "m2"}
    text = io.StringIO()
    Table(columns, units).write(text)
    return text.getvalue().replace("\r\n", "\n").rstrip("\n")


def to_text(solutions: Sequence[rc.ContactSolution], estimator: str | None = None) -> str:
    """Return the answer for people: that of one load, or a table over several, of at most 80 columns."""
    lines = [str(solutions[0])]
    if len(solutions) > 1:
        texts: dict[str, list[str]] = {}
        for solution in solutions:
            for text in _warnings(solution):
                texts.setdefault(text, []).append(si(solution.force, "N"))
        lines = [str(Sweep(tuple(solutions))), "+-: one standard deviation"]
        lines += [f"warning  {text} [at {', '.join(at)}]" for text, at in texts.items()]
    if estimator is not None:
        lines += ["", *(f"Area: {solution.area(estimator)}" for solution in solutions)]
    return fit("\n".join(lines))


def _warnings(solution: rc.ContactSolution) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*solution.warnings, *solution.area().warnings)))
