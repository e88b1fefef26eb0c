"""What the uncertainty of an answer is found from: a model of the errors, coarser grids, more noise, and the maps."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import attrs

from roughcontact._base.units import Estimate
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.solution.results import Area
from roughcontact._solve.solution.tip import widen_area_by_tip
from roughcontact.errors import InputError

E = TypeVar("E", bound=Estimate)

# Names of what the uncertainty of an answer is found from, and what they say.
UNCERTAINTIES = {
    "auto": "a model of the errors, or two grids at sharp edges and rough heights",
    "model": "a model of the errors",
    "two grids": "two grids",
    "noise": "a model of the errors, and by more noise in the heights",
}

# Standard deviation of the position of edges on the facets of an interpolated map, cells: set on maps of 4 and 8 cells
# a wave interpolated two and four times, bilinearly, in benchmarks/area_classes.py.
_FACET_EDGE_STD = 0.04


def judge(
    solution: Any,
    found: E,
    kind: str,
    ask: Callable[[Any], Estimate],
    flagged_factors: tuple[float, float] = (1.0, 1.0),
) -> E:
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
    flagged_factors
        Those of the response (`Response.flagged_factors`).
    """
    if kind == "model" or (kind == "auto" and flagged_factors[0] == 0.0):
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
        judged: E = phases.judge(found, ask, flagged_factors)
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
        return widen_area_by_tip(area)
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


def judge_maps(area: Area, maps: Iterable[HeightMap], cell_area: float) -> Area:
    """Return an area with the warnings of the maps, and the uncertainty by the facets of interpolated maps."""
    warnings = dict.fromkeys(text for one in maps for text in one.warnings)
    facets = 0.0
    if area.perimeter > 0.0 and any(one.period > 0.0 for one in maps):
        facets = _FACET_EDGE_STD * area.perimeter * math.sqrt(cell_area)
    if not warnings and facets == 0.0:
        return area
    uncertainty = math.hypot(area.uncertainty, facets)
    return attrs.evolve(area, uncertainty=uncertainty, warnings=(*area.warnings, *warnings))
