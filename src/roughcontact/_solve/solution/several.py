"""Solutions at several loads beside each other: their loads, quantities and warnings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from roughcontact._base.units import Estimate, si
from roughcontact._base.warnings import kind_of
from roughcontact._parts.load import FIRST_LOADING, Load
from roughcontact._solve.solution.results import Area
from roughcontact._solve.solution.summary import list_all_warnings
from roughcontact.errors.door import guarded

if TYPE_CHECKING:
    from roughcontact._solve.solution.contact import ContactSolution

# Loads that are named where a warning concerns all of them.
_NAMED = 3


@guarded
def name_load(solution: ContactSolution) -> str:
    """Return the load that was asked for, such as ``10 N``, or the mean pressure where a solution does not say it."""
    if solution.origin is None:
        return si(solution.mean_pressure, "Pa")
    ((kind, value),) = solution.origin.load.items()
    return str(Load(kind, value)).removeprefix(f"{kind} ")


def note_loads(solutions: Sequence[ContactSolution]) -> list[str]:
    """Return what several loads do not have of each other, in sentences; nothing without a hardness."""
    return [FIRST_LOADING] if len(solutions) > 1 and any(solution.capped for solution in solutions) else []


@guarded
def list_quantities(solution: ContactSolution) -> tuple[dict[str, Estimate], list[str]]:
    """Return the quantities of a solution by name, in SI units, and its warnings with theirs."""
    area = solution.area()
    peak = solution.peak_pressure()
    gap: Estimate = solution.response("mean-gap")
    patches: Estimate = solution.response("patches")
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
    known: dict[str, Area | Estimate] = {
        "maximum pressure": peak,
        "mean gap": gap,
        "number of contact patches": patches,
    }
    if solution.capped:
        known["saturated area"] = saturated = solution.saturated_area()
        found["saturated area"] = Estimate(saturated.value, saturated.uncertainty, "m2")
    return found, list_all_warnings(solution, known)


@guarded
def gather_warnings(warnings: Sequence[tuple[str, Sequence[str]]]) -> list[str]:
    """Return the warnings at several loads, each once with the loads that it concerns.

    Parameters
    ----------
    warnings
        Names of loads, and the warnings at each. Those of one rule are one, with the numbers of the last.
    """
    if len(warnings) == 1:
        return list(warnings[0][1])
    gathered: dict[str, list[tuple[str, str]]] = {}
    for load, texts in warnings:
        for text in texts:
            gathered.setdefault(kind_of(text), []).append((load, text))
    return [_attribute(found, len(warnings)) for found in gathered.values()]


def _attribute(found: Sequence[tuple[str, str]], count: int) -> str:
    """Return a warning behind the loads that it concerns."""
    *before, (last, text) = found
    named = f"{', '.join(load for load, _ in before)} and {last}" if before else last
    loads = f"all {count} loads" if len(found) == count > _NAMED else named
    differ = any(other != text for _, other in before)
    return f"At {loads}{f' (here with the numbers at {last})' if differ else ''}: {text}"
