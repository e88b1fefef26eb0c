"""Solutions as text: one, and several loads beside each other."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TypeVar

from roughcontact._base.units import WIDTH, Estimate, counted, kind_of, percent, prefixed, si, warn_about, with_spread
from roughcontact._parts.grid import FIRST_LOADING, Load
from roughcontact._parts.materials import Material
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.solution.answers import ContactAnswers
from roughcontact._solve.solution.attraction import average_gap
from roughcontact._solve.solution.plausibility import exceeds_metals
from roughcontact._solve.solution.results import Area
from roughcontact._solve.solution.sampling import find_sampling_warning
from roughcontact._solve.solution.tip import judge_by_tip
from roughcontact.errors.door import guarded

S = TypeVar("S")
T = TypeVar("T")
_UNKNOWN = "not determined"
# Note below a maximum pressure that no metal bears.
MORE_THAN_METALS = "more than metals bear: unless it is meant, give a hardness"
# Characters of the labels of a printed solution.
_LABEL_WIDTH = 18
# Maximum cells for which `repr` estimates the area: 0.1 s.
_MAX_REPR_CELLS = 2**20
# Maximum loads that are named if a warning concerns all of them.
_MAX_NAMED_LOADS = 3


def list_answers(solution: ContactAnswers) -> dict[str, str]:
    """Return the texts of contact area, load, maximum pressure, approach and differences between places by name."""
    peak = _attempt(solution.peak_pressure, None)
    answers = {
        "contact area": _format_area(_attempt(solution.area, None), solution),
        "force": si(solution.force, "N", 6),
        "mean pressure": si(solution.mean_pressure, "Pa", 6),
        "maximum pressure": _UNKNOWN if peak is None else _format_estimate(peak),
        "approach": si(solution.approach, "m", 6),
    }
    if solution.capped:
        answers["saturated"] = _format_area(_attempt(solution.saturated_area, None), solution)
    for added in solution.added:
        answers |= added.list_rows(solution)
    answers |= solution.parts.list_rows(solution)
    places = describe_other_places(solution, {"contact area": _attempt(solution.area, None), "maximum pressure": peak})
    return answers | ({"other places": places} if places else {})


@guarded
def describe_other_places(solution: ContactAnswers, estimates: Mapping[str, Area | Estimate | None]) -> str:
    """Return how much other places of the same surface differ, in words; empty where it is not known.

    Parameters
    ----------
    solution
        The solution.
    estimates
        Its answers by name; those that state no sampling error are omitted.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=16e-6, seed=1)
    >>> problem = rc.ContactProblem(
    ...     rc.Body(rough, rc.Elastic(210e9, 0.3)), grid=rc.Grid((64, 64), 64e-6), boundary="periodic"
    ... )
    >>> solution = problem.solve(pressure=1e9)
    >>> rc.faces.describe_other_places(solution, {"contact area": solution.area()})
    'contact area +- ... % (standard deviation)'
    """
    differences = [f"{name} {text}" for name, one in estimates.items() if (text := format_sampling(one))]
    if not differences:
        return ""
    warning = find_sampling_warning(solution)
    return f"{', '.join(differences)} (standard deviation)" + (f"; {warning}" if warning else "")


def list_all_warnings(
    solution: ContactAnswers, known: Mapping[str, Area | Estimate] = MappingProxyType({})
) -> list[str]:
    """Return the warnings of a solution, of its answers (see `list_answers`) and of other known estimates by name.

    Known estimates are not repeated.
    """
    gathered = dict.fromkeys(_attempt(lambda: solution.warnings, ()))
    asked: dict[str, Callable[[], Area | Estimate]] = {
        "contact area": solution.area,
        "maximum pressure": solution.peak_pressure,
    }
    if solution.capped:
        asked["saturated area"] = solution.saturated_area
    estimates: dict[str, Area | Estimate | None] = {
        name: known[name] if name in known else _attempt(estimate, None) for name, estimate in asked.items()
    }
    seen: set[str] = set()
    for name, found in (estimates | dict(known)).items():
        # Other estimates repeat the warnings of the area.
        texts = () if found is None else tuple(text for text in found.warnings if text not in seen)
        seen.update(texts)
        gathered.update(dict.fromkeys(warn_about(name, text) for text in texts))
    return list(gathered)


def describe_work(solution: ContactAnswers) -> str:
    """Return the cost of a solve as text."""
    counts = counted(solution.iterations, "iteration"), counted(solution.convolutions, "convolution")
    return f"{', '.join(counts)}, {solution.seconds:.2g} s"


def describe_maps(maps: Sequence[HeightMap]) -> str:
    """Return a note on the roughness that measured maps do not include; empty without maps."""
    if not maps:
        return ""
    shortest = si(2.0 * max(max(one.grid.resolved.spacing) for one in maps), "m", 3)
    return f"roughness shorter than {shortest} is not included"


def summarize(solution: ContactAnswers, maps: Sequence[HeightMap], materials: Mapping[str, Material]) -> str:
    """Return answers, status, warnings and cost, line by line; the status of a failure first."""
    status = ("status", str(solution.status))
    rows = [*list_answers(solution).items()]
    if exceeds_metals(solution, materials.values()):
        rows.insert([label for label, _ in rows].index("maximum pressure") + 1, ("", MORE_THAN_METALS))
    if maps:
        rows.insert(1, ("", describe_maps(maps)))
    rows.insert(len(rows) if solution.status.success else 0, status)
    rows += [("warning", text) for text in list_all_warnings(solution)]
    if solution.theory is not None:
        rows.append(("Persson", str(solution.theory)))
    if solution.stickiness is not None:
        rows.append(("stickiness", str(solution.stickiness)))
    if solution.accuracy is not None:
        rows.append(("accuracy", str(solution.accuracy)))
    rigid = [name for name, material in materials.items() if material.compliance == 0.0]
    alone = f": the {rigid[0]} is rigid" if rigid else ""
    rows += [
        ("modulus E*", f"{si(solution.modulus, 'Pa', 6)}{alone}"),
        ("residuals", str(solution.certificate)),
        ("work", describe_work(solution)),
    ]
    return "\n".join(line for label, text in rows for line in _wrap(label, text))


def abbreviate(solution: ContactAnswers) -> str:
    """Return the solution in one line, with the area unless it takes long."""
    shape = " x ".join(map(str, solution.grid.shape))
    verdict, _, _ = str(solution.status).partition(":")
    texts = [verdict, si(solution.mean_pressure, "Pa")]
    area = _attempt(solution.area, None) if solution.grid.cells <= _MAX_REPR_CELLS and solution.status.success else None
    if area is not None:
        texts.append(f"contact area {with_spread(*_percentages(area, solution.grid.area))} %")
    return f"<ContactSolution {shape}, {solution.boundary}: {', '.join(texts)}>"


def _percentages(area: Area, nominal: float) -> tuple[float, float]:
    return 100.0 * area.fraction, 100.0 * area.uncertainty / nominal


def _format_estimate(one: Estimate) -> str:
    factor, unit = prefixed(abs(one.value), one.unit)
    return f"{with_spread(one.value * factor, one.uncertainty * factor)} {unit}"


def format_sampling(one: Area | Estimate | None) -> str:
    """Return how much other places differ, such as ``+- 12 %``; empty where it is not known."""
    sampling = None if one is None else one.sampling
    return f"+- {percent(sampling / abs(one.value))}" if one is not None and one.value and sampling else ""


def _format_area(area: Area | None, solution: ContactAnswers) -> str:
    # A pressure that is nan has no cell in contact.
    if area is None or not math.isfinite(solution.force):
        return _UNKNOWN
    percent = with_spread(*_percentages(area, solution.grid.area))
    return f"{percent} % of nominal, {si(area.value, 'm2')} [{area.estimator}]"


def _attempt(estimate: Callable[[], T], otherwise: S) -> T | S:
    """Return an estimate, or `otherwise` if it fails: solutions that did not converge are printed as well."""
    try:
        return estimate()
    # Estimators are plug-ins.
    except Exception:
        return otherwise


def _wrap(label: str, text: str) -> Iterator[str]:
    indent = f"{label:<{_LABEL_WIDTH - 1}} "
    for line in text.splitlines():
        yield from textwrap.wrap(line, WIDTH, initial_indent=indent, subsequent_indent=_LABEL_WIDTH * " ") or [indent]
        indent = ""


@guarded
def name_load(solution: ContactAnswers) -> str:
    """Return the load as it was given, such as ``10 N``; the mean pressure if it is not known."""
    load = find_load(solution)
    return si(solution.mean_pressure, "Pa") if load is None else str(load).removeprefix(f"{load.kind} ")


def find_load(solution: ContactAnswers) -> Load | None:
    """Return the load that was given; None if it is not known."""
    if solution.origin is None:
        return None
    ((kind, value),) = solution.origin.load.items()
    return Load(kind, value)


def remembers_flattening(solution: ContactAnswers) -> bool:
    """Return whether a state remembers how far its surfaces were flattened, as by `Flattening`."""
    return any("flattened_height" in one.list_fields() for one in solution.added)


def note_loads(solutions: Sequence[ContactAnswers]) -> list[str]:
    """Return a note that each load is a first loading; none without a hardness or for one load."""
    forgets = any(solution.capped and not remembers_flattening(solution) for solution in solutions)
    return [FIRST_LOADING] if len(solutions) > 1 and forgets else []


@guarded
def list_quantities(solution: ContactAnswers) -> tuple[dict[str, Estimate], list[str]]:
    """Return the quantities of a solution by name, in SI units, and all warnings."""
    area = solution.area()
    peak = solution.peak_pressure()
    if solution.tension is None:
        gap: Estimate = solution.response("mean-gap")
        patches: Estimate = solution.response("patches")
    else:
        gap = judge_by_tip(average_gap(solution), solution, "mean-gap")
        patches = Estimate(float(solution.patches.areas.size), 0.0, "")
    found = {
        "contact area": Estimate(area.value, area.uncertainty, "m2", relative_sampling=area._relative_sampling),
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
        Names of loads, and the warnings at each. Warnings of one rule become one, with the numbers at the last load.
    """
    if len(warnings) == 1:
        return list(warnings[0][1])
    gathered: dict[str, list[tuple[str, str]]] = {}
    for load, texts in warnings:
        for text in texts:
            gathered.setdefault(kind_of(text), []).append((load, text))
    return [_attribute(found, len(warnings)) for found in gathered.values()]


def _attribute(found: Sequence[tuple[str, str]], count: int) -> str:
    """Return a warning with the loads that it concerns before it."""
    *before, (last, text) = found
    loads = f"{', '.join(load for load, _ in before)} and {last}" if before else last
    if len(found) > _MAX_NAMED_LOADS:
        loads = f"all {count} loads" if len(found) == count else f"{len(found)} loads from {found[0][0]} to {last}"
    differ = any(other != text for _, other in before)
    return f"At {loads}{f' (here with the numbers at {last})' if differ else ''}: {text}"
