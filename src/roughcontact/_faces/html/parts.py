"""Parts of a report that one load and several have: verdict, warnings, figures; and the table of several."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from roughcontact._base.tables import Table
from roughcontact._base.units import Estimate
from roughcontact._faces.html.elements import element, escape, grid, items, section, tag
from roughcontact._faces.html.figures import Picture, draw_panels
from roughcontact._parts.load import Load
from roughcontact._solve.problem import Sweep
from roughcontact._solve.solution import ContactSolution, gather_warnings, list_quantities, name_load

# The quantity that a load gives.
_GIVEN = {"pressure": "mean pressure", "force": "force", "approach": "approach"}


def note(text: str) -> str:
    """Return a remark in small letters; nothing of an empty text."""
    return element("p", escape(text), class_="note") if text else ""


def loads_of(solutions: Iterable[ContactSolution]) -> list[Load]:
    """Return the loads that were asked for, from the smallest up; those that solutions do not say are missing."""
    origins = [solution.origin for solution in solutions]
    found = [Load(kind, value) for origin in origins if origin is not None for kind, value in origin.load.items()]
    return sorted(found, key=lambda load: load.value)


def make_verdict(solutions: Sequence[ContactSolution]) -> str:
    """Return how the solves ended, those that failed first."""
    failed = [solution for solution in solutions if not solution.status.success]
    texts = []
    for status in dict.fromkeys(solution.status for solution in failed or solutions):
        verdict, _, reason = str(status).partition(": ")
        at = [name_load(solution) for solution in failed if solution.status == status]
        where = f" at {', '.join(at)}" if at and len(solutions) > 1 else ""
        texts.append(f"{element('strong', escape(verdict.capitalize() + where) + ':')} {escape(reason)}.")
    advice = " Do not use these numbers: they are those of the last iteration." if failed else ""
    return element("p", " ".join(texts) + advice, class_="verdict failed" if failed else "verdict", role="status")


def make_warnings(texts: Sequence[str]) -> str:
    """Return the warnings, if there are any."""
    return element("div", f"<h2>Warnings</h2>{items(texts)}", class_="warnings") if texts else ""


def list_sweep_warnings(sweep: Sweep) -> list[str]:
    """Return the warnings at all loads, each once."""
    return gather_warnings([(name_load(solution), list_quantities(solution)[1]) for solution in sweep.solutions])


def make_rows(sweep: Sweep) -> str:
    """Return the table of a sweep: a row for each load, and each quantity in one unit."""
    given = {_GIVEN[load.kind] for load in loads_of(sweep.solutions)}
    found = [_choose_columns(solution, given) for solution in sweep.solutions]
    columns: dict[str, list[Any]] = {"load": [name_load(solution) for solution in sweep.solutions]}
    columns |= {name: [quantities[name] for quantities in found] for name in found[0]}
    return grid(*Table(columns).to_cells(), "The answers, a row for each load")


def _choose_columns(solution: ContactSolution, given: set[str]) -> dict[str, Estimate]:
    """Return the quantities beside the load, the fraction of the area in percent."""
    found = list_quantities(solution)[0]
    fraction = found.pop("contact area fraction")
    found = {"% of nominal": Estimate(100.0 * fraction.value, 100.0 * fraction.uncertainty, ""), **found}
    order = ["contact area", "% of nominal", *(["saturated area"] if "saturated area" in found else [])]
    return {name: found[name] for name in (*order, *found) if given != {name}}


def make_curves(sweep: Sweep) -> str:
    """Return the panels of a sweep."""
    return make_figures("Curves", draw_panels("sweep", sweep), f"The table has the numbers of all {len(sweep)} loads.")


def make_figures(title: str, pictures: Iterable[Picture], answer: str) -> str:
    """Return pictures side by side; `answer` is what they show in words, for those who do not see them."""
    shown = "\n".join(_make_figure(picture, answer) for picture in pictures)
    return section(title, element("div", shown, class_="figures"), class_="pictures")


def _make_figure(picture: Picture, answer: str) -> str:
    if picture.refusal:
        return note(f"The panel {picture.name} is not drawn: {picture.refusal}")
    shown = tag("img", src=picture.address, alt=f"{picture.caption} {answer}")
    return element("figure", shown + element("figcaption", escape(picture.caption)))
