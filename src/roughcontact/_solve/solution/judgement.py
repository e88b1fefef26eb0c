"""What the uncertainty of an answer is found from: a model of the errors, coarser grids, or more noise."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

from roughcontact._base.units import Estimate
from roughcontact._solve.solution.results import Area
from roughcontact.errors import InputError

E = TypeVar("E", bound=Estimate)

# Names of what the uncertainty of an answer is found from, and what they say.
UNCERTAINTIES = {
    "auto": "a model of the errors, or two grids at sharp edges and rough heights",
    "model": "a model of the errors",
    "two grids": "two grids",
    "noise": "a model of the errors, and by more noise in the heights",
}


def judge(solution: Any, found: E, kind: str, ask: Callable[[Any], Estimate], flagged_factor: float | None = None) -> E:
    """Return an answer of the model with the uncertainty of a kind.

    Parameters
    ----------
    solution
        The contact.
    found
        Its answer.
    kind
        A name of `UNCERTAINTIES`.
    ask
        Returns the answer of another solution.
    flagged_factor
        That of the response (`Response.flagged_factor`).
    """
    if kind == "model":
        return found
    if kind == "noise":
        noisy: E = solution.response("noise").judge(solution, found, ask)
        return noisy
    # Nothing widens an unbounded value.
    is_bounded = found.uncertainty < abs(found.value) < math.inf
    phases = _find_phases(solution, kind) if is_bounded or kind != "auto" else None
    if phases is None or not is_bounded:
        return found
    try:
        judged: E = phases.judge(found, ask, flagged_factor)
    except InputError:
        if kind == "auto":
            return found
        raise
    return judged


def judge_area(solution: Any, found: Area, kind: str) -> Area:
    """Return the default area with the uncertainty of a kind, extrapolated over two grids where they are flagged."""
    phases = None if kind in ("model", "noise") else _find_phases(solution, kind)
    if phases is not None and phases.flagged:
        area: Area = phases.extrapolate_area(solution, found)
        return area
    return judge(solution, found, kind, lambda one: one.area(uncertainty="model"))


def _find_phases(solution: Any, kind: str) -> Any:
    """Return the phases of the grid; None if the contact is better judged by the model."""
    if kind == "two grids":
        return solution.phases()
    # A part of a contact knows neither all heights nor a coarser grid.
    return solution.response("judgement").phases if solution.parts.is_whole else None


def explain_uncertainties(solution: Any) -> str:
    """Return what the uncertainties of the answers are found from, and why."""
    if solution.uncertainty == "auto":
        if not solution.parts.is_whole:
            return f"uncertainties by {UNCERTAINTIES['model']}: the contact is divided among processes"
        return str(solution.response("judgement"))
    return f"uncertainties by {UNCERTAINTIES[solution.uncertainty]}, as asked"
