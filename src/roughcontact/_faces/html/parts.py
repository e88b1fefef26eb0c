"""Parts of a report: verdict, warnings, pictures, and the table of several loads, as its template takes them."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, TypeAlias

import attrs

from roughcontact._answers.laws import FilmLaw, InterfaceLaw
from roughcontact._base.tables import Table
from roughcontact._base.units import Estimate
from roughcontact._faces.html.words import typeset
from roughcontact._faces.panels.figures import draw_panel, forget_figure, write_png
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import Path as StatePath
from roughcontact._solve.problem import Sweep
from roughcontact._solve.solution import (
    ContactSolution,
    find_load,
    gather_warnings,
    list_estimates,
    list_quantities,
    name_load,
)
from roughcontact._work.studies import Answers, describe_answers_elsewhere, list_answer_warnings, tabulate_answers
from roughcontact.plotting import panels

# Panels that ship, in the order of the page; the panels of plug-ins come last.
_PANEL_ORDER = {
    "solution": ("heights", "pressure", "gap", "patches", "profile", "pressure-histogram", "patch-sizes"),
    "sweep": ("area-load", "load-approach", "stiffness-load"),
}
# The quantity that a load gives.
_GIVEN = {"pressure": "mean pressure", "force": "force", "approach": "approach"}


# Names, the texts of each row, and what the table shows.
WrittenTable: TypeAlias = tuple[list[str], list[list[str]], str]


@attrs.frozen
class Picture:
    """One panel, drawn.

    Attributes
    ----------
    name
        The name that the panel is registered under.
    caption
        A sentence on what it shows.
    address
        The picture as a data: address; empty if it cannot be drawn.
    refusal
        Why it cannot be drawn; empty if it is.
    """

    name: str
    caption: str
    address: str = ""
    refusal: str = ""


@attrs.frozen
class Figures:
    """Pictures under a title.

    Attributes
    ----------
    title
        The title.
    pictures
        The pictures; None if none can be drawn.
    answer
        What they show in words, for readers who do not see them.
    """

    title: str
    pictures: Sequence[Picture] | None
    answer: str = ""


def draw_panels(kind: str, subject: ContactSolution | Sweep) -> Iterator[Picture]:
    """Yield each registered panel of a kind of subject; a panel that refuses or fails says why."""
    solution = subject if isinstance(subject, ContactSolution) else subject.states[0]
    names = (name for name in panels if _draws(name, kind, solution))
    first = _PANEL_ORDER[kind]
    for name in sorted(names, key=lambda name: (first.index(name) if name in first else len(first), name)):
        caption = (inspect.getdoc(panels[name]) or name).partition("\n\n")[0].replace("\n", " ")
        try:
            yield Picture(name, caption, draw_panel(kind, subject, name))
        # Panels are plug-ins: a report is not lost because of one picture.
        except Exception as error:
            yield Picture(name, caption, refusal=" ".join(str(error).split()) or type(error).__name__)


def draw_curve(subject: StatePath) -> Picture:
    """Return the curve that a path draws."""
    return Picture("curve", f"The {subject.curve}.", _write_axes(subject.plot()))


def draw_columns(law: InterfaceLaw | FilmLaw) -> Iterator[Picture]:
    """Yield the curves of the columns that a law shows."""
    for name in law.short_table().columns:
        if name in law.columns:
            caption = f"The {name.replace('_', ' ')}, with two standard deviations by the grid as a band."
            yield Picture(name, caption, _write_axes(law.plot(name)))


def _write_axes(axes: Any) -> str:
    picture = write_png(axes.figure)
    forget_figure(axes)
    return picture


def _draws(name: str, kind: str, solution: ContactSolution) -> bool:
    try:
        return panels[name].subject == kind and panels[name].fits(solution)
    # A plug-in that cannot be imported.
    except Exception:
        return False


def loads_of(solutions: Iterable[ContactSolution]) -> list[Load]:
    """Return the given loads of the solutions that state them, from the smallest up."""
    return sorted(filter(None, map(find_load, solutions)), key=lambda load: load.value)


def describe_verdict(solutions: Sequence[ContactSolution]) -> dict[str, Any]:
    """Return how the solves ended and why, those that failed if any did."""
    failed = [solution for solution in solutions if not solution.status.success]
    found = []
    for status in dict.fromkeys(solution.status for solution in failed or solutions):
        verdict, _, reason = str(status).partition(": ")
        at = [_name_state(solution) for solution in failed if solution.status == status]
        where = f" at {', '.join(at)}" if at and len(solutions) > 1 else ""
        found.append((verdict.capitalize() + where, reason))
    return {"verdicts": found, "failed": bool(failed)}


def _name_state(state: ContactSolution) -> str:
    return name_load(state) if state.shear is None else str(state.tangential_load)


def list_sweep_warnings(sweep: Sweep) -> list[str]:
    """Return the warnings at all loads, each once."""
    return gather_warnings([(name_load(solution), list_quantities(solution)[1]) for solution in sweep.states])


def list_rows(sweep: Sweep) -> WrittenTable:
    """Return the table of a sweep: a row for each load, and each quantity in one unit."""
    given = {_GIVEN[load.kind] for load in loads_of(sweep.states)}
    found = [_choose_columns(solution, given) for solution in sweep.states]
    columns: dict[str, list[Any]] = {"load": [name_load(solution) for solution in sweep.states]}
    columns |= {name: [quantities[name] for quantities in found] for name in found[0]}
    return write_grid(Table(columns), "The answers, a row for each load")


def write_grid(table: Table, caption: str) -> WrittenTable:
    """Return the texts of a table with the signs of print, and its caption."""
    head, rows = table.to_cells()
    return head, [[typeset(cell) for cell in cells] for cells in rows], caption


def describe_responses(answers: Answers, solutions: Sequence[ContactSolution]) -> dict[str, Any]:
    """Return what responses have answered, a row for each load, and the warnings; empty without an answer."""
    columns: dict[str, list[Any]] = {"load": [name_load(solution) for solution in solutions]}
    columns |= {name.replace("_", " "): found for name, found in tabulate_answers(answers).items()}
    texts = [
        f"{name}, {load}: {result}"
        for name, found in answers.items()
        for load, result in zip(columns["load"], found, strict=True)
        if not list_estimates(result)
    ]
    if len(columns) == 1 and not texts:
        return {}
    places = describe_answers_elsewhere(answers, columns["load"])
    return {
        "rows": write_grid(Table(columns), "What the contact does, a row for each load") if len(columns) > 1 else None,
        "texts": texts,
        "places": f"Other places: {places}." if places else "",
        "warnings": list_answer_warnings(answers, solutions),
    }


def _choose_columns(solution: ContactSolution, given: set[str]) -> dict[str, Estimate]:
    """Return the quantities other than the given loads, the fraction of the area in percent."""
    found = list_quantities(solution)[0]
    fraction = found.pop("contact area fraction")
    found = {"% of nominal": Estimate(100.0 * fraction.value, 100.0 * fraction.uncertainty, ""), **found}
    order = ["contact area", "% of nominal", *(["saturated area"] if "saturated area" in found else [])]
    return {name: found[name] for name in (*order, *found) if given != {name}}
