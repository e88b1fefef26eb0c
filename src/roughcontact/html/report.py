"""The report of a solution: one self-contained page."""

from __future__ import annotations

from pathlib import Path
from typing import final

import attrs

from roughcontact._problem import ContactProblem
from roughcontact._solution import DEFAULT_AREA, ContactSolution, SolutionWriter, areas
from roughcontact._solution.origin import versions
from roughcontact._solution.summary import describe_maps, list_all_warnings, list_answers
from roughcontact.archive import replacing
from roughcontact.html.citation import list_references, write_bibtex
from roughcontact.html.elements import element, escape, items, quantity, section, table, tag
from roughcontact.html.figures import Picture, can_draw, draw_panel, draw_panels
from roughcontact.html.inputs import find_problem, list_certificate, list_inputs, list_versions
from roughcontact.html.rerun import write_script
from roughcontact.html.style import CSS
from roughcontact.load import Load

# Nothing is fetched and nothing runs, whatever a text of the page holds.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
_NO_FIGURES = "Figures need matplotlib: pip install 'roughcontact[plot]', then write the report again."
# Cells up to which a notebook shows a picture unasked.
_SMALL = 2**20


@final
@attrs.frozen
class HtmlWriter(SolutionWriter):
    """A report in HTML that opens without a network."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Html."""
        return frozenset({".html"})

    def write(self, solution: ContactSolution, path: Path) -> None:
        """Write the page."""
        with replacing(path) as partial:
            partial.write_text(self.text(solution), encoding="utf-8")

    def text(self, solution: ContactSolution) -> str:
        """Return the page."""
        problem, missing = find_problem(solution)
        title = f"Contact report: {list_answers(solution)['contact area'].partition(',')[0]}"
        head = (
            '<meta charset="utf-8">\n'
            f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f"<title>{quantity(title)}</title>\n<style>{CSS}</style>"
        )
        parts = [
            _make_answer(solution, problem),
            _make_figures(solution),
            section("Inputs", table(list_inputs(solution, problem), "What was solved"), _note(missing)),
            '<div class="columns">',
            section("Certificate", table(list_certificate(solution), "How the solve ended")),
            section("Versions", table(list_versions(solution), "The programs that made the solution")),
            "</div>",
            _make_script(solution, problem),
            _make_citation(problem),
            _make_plan(problem),
        ]
        body = element("body", element("main", "\n".join(parts)))
        return f"<!doctype html>\n{element('html', element('head', head) + body, lang='en')}\n"

    def table(self, solution: ContactSolution) -> str:
        """Return answer, verdict and warnings for a notebook, and a picture where it takes a moment only."""
        rows = {name: quantity(text) for name, text in list_answers(solution).items()}
        status = {"status": escape(solution.status)}
        rows = rows | status if solution.status.success else status | rows
        warnings = list_all_warnings(solution)
        if warnings:
            rows["warnings"] = items(warnings)
        # Notebooks set numbers on the right, which suits no words.
        left = {"style": "text-align: left; vertical-align: top"}
        shown = table(rows, f"{solution.grid}, boundary {solution.boundary}", left)
        if can_draw() and solution.grid.cells <= _SMALL and solution.contact.any():
            picture = draw_panel(solution, "pressure")
            shown += tag("img", src=picture, alt="The contact pressure", style="max-width: 24rem")
        return shown


def _make_answer(solution: ContactSolution, problem: ContactProblem | None) -> str:
    """Return the verdict, the answer and the warnings."""
    status = solution.status
    verdict, _, reason = str(status).partition(": ")
    advice = "" if status.success else " Do not use these numbers: they are those of the last iteration."
    sentence = f"{element('strong', escape(verdict.capitalize()) + ':')} {escape(reason)}.{advice}"
    answers = {name.capitalize(): quantity(text) for name, text in list_answers(solution).items()}
    maps = () if solution.origin is None else [one for one in solution.origin.maps if not one.periodic]
    if maps:
        answers["Contact area"] += f"<br>{element('span', escape(describe_maps(maps)), class_='note')}"
    parts = [
        "<h1>Contact report</h1>",
        element("p", _describe_scene(solution, problem), class_="scene"),
        element("p", sentence, class_="verdict" if status.success else "verdict failed", role="status"),
        table(answers, "The answer", class_="answer"),
        _note("Uncertainties are one standard deviation: the true value should lie within two of them."),
    ]
    warnings = list_all_warnings(solution)
    if warnings:
        parts.append(element("div", f"<h2>Warnings</h2>{items(warnings)}", class_="warnings"))
    return "\n".join(parts)


def _describe_scene(solution: ContactSolution, problem: ContactProblem | None) -> str:
    bodies = () if problem is None else (problem.body, problem.counterbody)
    names = [type(body.surface).__name__ for body in bodies]
    loads = [] if solution.origin is None else [str(Load(*load)) for load in solution.origin.load.items()]
    texts = [" on ".join(names), str(solution.grid), f"boundary {solution.boundary}", *loads]
    return escape(", ".join(filter(None, texts)))


def _make_figures(solution: ContactSolution) -> str:
    if not can_draw():
        return section("Figures", _note(_NO_FIGURES))
    answers = list_answers(solution)
    answer = f"Contact area {answers['contact area']}; max pressure {answers['max pressure']}."
    shown = "\n".join(_make_figure(picture, answer) for picture in draw_panels(solution))
    return section("Figures", element("div", shown, class_="figures"), class_="pictures")


def _make_figure(picture: Picture, answer: str) -> str:
    if picture.refusal:
        return _note(f"The panel {picture.name} is not drawn: {picture.refusal}")
    shown = tag("img", src=picture.address, alt=f"{picture.caption} {answer}")
    return element("figure", shown + element("figcaption", escape(picture.caption)))


def _make_script(solution: ContactSolution, problem: ContactProblem | None) -> str:
    if problem is None or solution.origin is None:
        return ""
    script = write_script(solution, problem, solution.origin.load)
    note = (
        "With the same versions on the same kind of processor the pressure is the same to the last bit, unless the "
        "solve started from another solution, as in a sweep; then it agrees within the tolerance."
    )
    return section("Run it again", element("pre", element("code", escape(script))), _note(note))


def _make_citation(problem: ContactProblem | None) -> str:
    made = versions()["roughcontact"]
    methods = [] if problem is None else [problem.plan.kernel, problem.plan.solver]
    references = list_references(made, [*methods, areas.resolve(DEFAULT_AREA)])
    texts = (
        element("li", f"{escape(one.text)} {element('a', escape(one.address), href=one.address)}") for one in references
    )
    bibtex = element("pre", element("code", escape(write_bibtex(made))))
    return section("Cite", element("ul", "".join(texts)), bibtex)


def _make_plan(problem: ContactProblem | None) -> str:
    return "" if problem is None else section("Plan", element("pre", escape(problem.explain())))


def _note(text: str) -> str:
    return element("p", escape(text), class_="note") if text else ""
