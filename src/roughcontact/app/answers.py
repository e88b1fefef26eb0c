"""The answers of a run: numbers with uncertainty and unit for the page, and a table of them for a spreadsheet."""

from __future__ import annotations

import csv
import io
from typing import Any

from roughcontact._solution import ContactSolution
from roughcontact.units import Estimate, si

# Sides of the squares in which areas are stated, m, from large to small.
_SQUARES = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9}


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
    if one.unit == "m2":
        return _format_area(one)
    if not one.unit:
        return f"{_round(one.value, 4)} ± {_round(one.uncertainty, 2)}"
    number, _, name = si(one.value, one.unit, 12).partition(" ")
    scale = float(number) / one.value if one.value else 1.0
    spread = f" ± {_round(one.uncertainty * scale, 2)}" if one.uncertainty else ""
    return f"{_round(float(number), 4 if spread else 6)}{spread} {name}"


def _format_area(area: Estimate) -> str:
    name, side = next(((name, side) for name, side in _SQUARES.items() if area.value >= side**2), ("nm", 1e-9))
    relative = f" ({100 * area.uncertainty / area.value:.2g} %)" if area.value else ""
    return f"{_round(area.value / side**2, 4)} ± {_round(area.uncertainty / side**2, 2)} {name}²{relative}"


def _round(value: float, digits: int) -> str:
    """Return a number with so many digits that count, without an exponent where it is not needed."""
    return f"{float(f'{value:.{digits}g}'):g}"
