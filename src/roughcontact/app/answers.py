"""The answers of a run: numbers with uncertainty and unit for the page, and a table of them for a spreadsheet."""

from __future__ import annotations

import csv
import io
from typing import Any

from roughcontact._solution import ContactSolution
from roughcontact.units import Estimate, prefixed, with_spread


def describe_solution(solution: ContactSolution) -> dict[str, Any]:
    """Return the answer at one load: how the solve ended, quantities by name in SI units, and all warnings."""
    area, peak = solution.area(), solution.peak_pressure()
    gap, patches = solution.estimate("mean-gap"), solution.estimate("patches")
    found = {
        "contact area": Estimate(area.value, area.uncertainty, "m2"),
        "contact area fraction": Estimate(area.fraction, area.uncertainty / solution.grid.area, ""),
        "maximum pressure": peak,
        "force": Estimate(solution.force, 0.0, "N"),
        "mean pressure": Estimate(solution.mean_pressure, 0.0, "Pa"),
        "approach": Estimate(solution.approach, 0.0, "m"),
        "mean gap": gap,
        "contact patches": patches,
    }
    if solution.capped:
        saturated = solution.saturated_area()
        found["saturated area"] = Estimate(saturated.value, saturated.uncertainty, "m2")
    texts = [*solution.warnings, *area.warnings, *(text for one in (peak, gap, patches) for text in one.warnings)]
    return {
        "status": str(solution.status),
        "certified": solution.status.success,
        "seconds": solution.seconds,
        "quantities": [
            {"name": name, "value": one.value, "uncertainty": one.uncertainty, "unit": one.unit, "text": _format(one)}
            for name, one in found.items()
        ],
        "warnings": [f"{text[0].upper()}{text[1:].rstrip('.')}." for text in dict.fromkeys(texts)],
    }


def make_table(answers: list[dict[str, Any]]) -> str:
    """Return the answers as CSV: a row for each load, a column for each quantity and for its uncertainty."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\r\n")
    names = list(dict.fromkeys((one["name"], one["unit"]) for answer in answers for one in answer["quantities"]))
    head = [f"{name}{', ' if unit else ''}{unit}" for name, unit in names]
    writer.writerow([text for title in head for text in (title, f"uncertainty of {title}")] + ["status", "warnings"])
    for answer in answers:
        known = {one["name"]: one for one in answer["quantities"]}
        cells = [known.get(name, {"value": "", "uncertainty": ""}) for name, _ in names]
        numbers = [value for cell in cells for value in (cell["value"], cell["uncertainty"])]
        writer.writerow([*numbers, answer["status"], " ".join(answer["warnings"])])
    return file.getvalue()


def _format(one: Estimate) -> str:
    """Return a number with its uncertainty and unit, as people write them."""
    base, power = ("m", 2) if one.unit == "m2" else (one.unit, 1)
    factor, unit = prefixed(abs(one.value), base, power) if base else (1.0, "")
    if not one.uncertainty:
        return f"{one.value * factor:.6g} {unit}".strip()
    relative = f" ({100 * one.uncertainty / one.value:.2g} %)" if one.unit == "m2" and one.value else ""
    number = with_spread(one.value * factor, one.uncertainty * factor).strip("()").replace("+-", "±")
    return f"{number} {unit}{relative}".strip()
