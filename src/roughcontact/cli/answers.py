"""The answers of a solve as text, as JSON and as CSV."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from typing import Any

import roughcontact as rc
from roughcontact._solution.origin import versions
from roughcontact.units import si
from roughcontact.units.text import fit


def to_json(solutions: Sequence[rc.ContactSolution], estimator: str | None = None) -> str:
    """Return one JSON object: the description of the only solution, or a list of them under ``solutions``.

    `estimator` is the name of an area estimator whose area is given besides the default.
    """
    described = [_describe(solution, estimator) for solution in solutions]
    content = described[0] if len(described) == 1 else {"solutions": described}
    return json.dumps(_finite({**content, "versions": versions()}), indent=2, allow_nan=False, ensure_ascii=False)


def _describe(solution: rc.ContactSolution, estimator: str | None) -> dict[str, Any]:
    accuracy, peak = solution.accuracy, solution.peak_pressure()
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
    """Return a header and a row for each load, in SI units."""
    rows = [_row(solution, estimator) for solution in solutions]
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().rstrip("\n")


def _row(solution: rc.ContactSolution, estimator: str | None) -> dict[str, Any]:
    area, peak = solution.area(), solution.peak_pressure()
    row = {
        "force_N": solution.force,
        "mean_pressure_Pa": solution.mean_pressure,
        "approach_m": solution.approach,
        "area_m2": float(area.value),
        "area_uncertainty_m2": float(area.uncertainty),
        "area_fraction": float(area.fraction),
        "peak_pressure_Pa": float(peak.value),
        "peak_pressure_uncertainty_Pa": float(peak.uncertainty),
        "saturated_area_m2": float(solution.saturated_area().value),
    }
    if estimator is not None:
        other = solution.area(estimator)
        row |= {"other_area_m2": float(other.value), "other_area_uncertainty_m2": float(other.uncertainty)}
    return {
        **row,
        "status": solution.status.name,
        "warnings": " ".join(dict.fromkeys((*solution.warnings, *area.warnings))),
        "convolutions": solution.convolutions,
        "seconds": solution.seconds,
    }


def to_text(solutions: Sequence[rc.ContactSolution], estimator: str | None = None) -> str:
    """Return the answer for people: that of one load, or a table over several, of at most 80 columns."""
    lines = [str(solutions[0])] if len(solutions) == 1 else _table(solutions)
    if estimator is not None:
        lines += ["", *(f"Area: {solution.area(estimator)}" for solution in solutions)]
    return fit("\n".join(lines))


def _table(solutions: Sequence[rc.ContactSolution]) -> list[str]:
    row = "{:>10} {:>13} {:>10} {:>9} {:>8} {:>13} {:>8}"
    lines = [row.format("force", "mean pressure", "approach", "area, %", "+- %", "max pressure", "+- %")]
    texts: dict[str, list[str]] = {}
    for solution in solutions:
        area, peak, force = solution.area(), solution.peak_pressure(), si(solution.force, "N")
        spreads = [f"{100 * found.uncertainty / found.value:.2g}" if found.value else "" for found in (area, peak)]
        lines.append(
            row.format(
                force,
                si(solution.mean_pressure, "Pa"),
                si(solution.approach, "m"),
                f"{100 * area.fraction:.4g}",
                spreads[0],
                si(peak.value, "Pa"),
                spreads[1],
            )
        )
        for text in dict.fromkeys((*solution.warnings, *area.warnings)):
            texts.setdefault(text, []).append(force)
    lines.append("+-: one standard deviation of the value before it; area in % of nominal")
    return [*lines, *(f"warning  {text} [at {', '.join(at)}]" for text, at in texts.items())]
