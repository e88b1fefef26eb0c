"""The report of a result: one self-contained page, and what to cite."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Sequence
from datetime import date
from pathlib import Path
from types import MappingProxyType
from typing import final

import attrs

from roughcontact._base.tables import Result
from roughcontact._base.units import counted
from roughcontact._faces.html.elements import CSS, element, escape, grid, items, quantity, section, table, tag
from roughcontact._faces.html.inputs import (
    describe_scene,
    list_certificate,
    list_inputs,
    list_versions,
    write_script,
)
from roughcontact._faces.html.parts import (
    draw_curve,
    draw_panels,
    list_sweep_warnings,
    loads_of,
    make_curves,
    make_figures,
    make_responses,
    make_rows,
    make_verdict,
    make_warnings,
    note,
)
from roughcontact._faces.panels.figures import can_draw, draw_panel
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import (
    ContactProblem,
    Sweep,
    explain_state,
    find_problem,
)
from roughcontact._solve.problem import Path as StatePath
from roughcontact._solve.solution import (
    DEFAULT_AREA,
    MORE_THAN_METALS,
    ContactSolution,
    SolutionWriter,
    areas,
    describe_maps,
    exceeds_metals,
    find_load,
    list_all_warnings,
    list_answers,
    name_load,
    note_loads,
    versions,
)
from roughcontact._work.reports import list_references, write_bibtex
from roughcontact._work.studies import Answers, add_answers, list_answer_warnings

# Nothing is fetched and nothing runs, whatever a text of the page holds.
_SECURITY_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
_NO_FIGURES = "Figures need matplotlib: pip install 'roughcontact[plot]', then write the report again."
_NOTE = note("Uncertainties are one standard deviation: the true value should lie within two of them.")
# Notebooks set numbers on the right, which suits no words.
_LEFT = {"style": "text-align: left; vertical-align: top"}
# Cells up to which a notebook shows a picture unasked.
_MAX_PICTURE_CELLS = 2**20
_NO_ANSWERS: Answers = MappingProxyType({})


@final
@attrs.frozen
class HtmlWriter(SolutionWriter):
    """A report in HTML that opens without a network."""

    @property
    def suffixes(self) -> frozenset[str]:
        """The ending of an HTML file."""
        return frozenset({".html"})

    def write(self, solution: ContactSolution, path: Path) -> None:
        """Write the page."""
        solution.to_html(path)


@functools.singledispatch
def write_page(result: Result, answers: Answers = _NO_ANSWERS) -> str:
    """Return the page of a result, with what responses have answered of its states.

    That of a law, a study or a report of errors has what a notebook shows.
    """
    name = repr(result).strip("<>")
    return _make_page(name, ["<h1>Report</h1>", result._repr_html_()])


@write_page.register
def _write_solution(solution: ContactSolution, answers: Answers = _NO_ANSWERS) -> str:
    """Return the page, with what responses have answered."""
    problem, missing = find_problem(solution)
    return _make_page(
        list_answers(solution)["contact area"].partition(",")[0],
        [
            _make_head(solution, problem, loads_of([solution])),
            make_verdict([solution]),
            _make_answer(solution),
            _NOTE,
            make_warnings(list_all_warnings(solution)),
            make_responses(answers, [solution]),
            _make_figures(solution),
            *_make_details(solution, problem, missing),
        ],
    )


@write_page.register
def _write_sweep(sweep: Sweep, answers: Answers = _NO_ANSWERS) -> str:
    """Return the page of a sweep: all loads, with what responses have answered, then the largest in detail."""
    largest = max(sweep.states, key=lambda solution: solution.force)
    problem, missing = find_problem(largest)
    return _make_page(
        counted(len(sweep), "load"),
        [
            _make_head(largest, problem, loads_of(sweep.states)),
            make_verdict(sweep.states),
            make_rows(sweep),
            _NOTE,
            *map(note, note_loads(sweep.states)),
            make_warnings(list_sweep_warnings(sweep)),
            make_responses(answers, sweep.states),
            make_curves(sweep) if can_draw() else "",
            section(f"The largest load, {name_load(largest)}", _make_answer(largest)),
            _make_figures(largest),
            *_make_details(largest, problem, missing),
        ],
    )


@write_page.register
def _write_path(path: StatePath, answers: Answers = _NO_ANSWERS) -> str:
    """Return the page of a path: its states, with what responses have answered, then one of them in detail."""
    detailed = path.detailed
    problem, missing = find_problem(detailed)
    script = "" if problem is None else write_script(path, problem)
    return _make_page(
        counted(len(path), "state"),
        [
            _make_head(detailed, problem, loads_of(path.given)),
            make_verdict(path.states),
            *_make_states(path, answers),
            section(_name_detailed(path), _make_answer(detailed)),
            _make_figures(detailed),
            *_make_details(
                detailed, problem, missing, script, path.explain_plan(None if problem is None else problem.plan)
            ),
        ],
    )


def _name_detailed(path: StatePath) -> str:
    is_last = path.detailed is path[-1]
    return "The last state" if is_last else f"The largest load, {name_load(path.detailed)}"


@functools.singledispatch
def show_in_notebook(result: Result) -> str:
    """Return a result as a notebook shows it."""
    return element("pre", escape(result))


@show_in_notebook.register
def _show_solution(solution: ContactSolution) -> str:
    """Return answer, verdict and warnings for a notebook, and a picture unless the grid is large."""
    rows = {name: quantity(text) for name, text in list_answers(solution).items()}
    status = {"status": escape(solution.status)}
    rows = rows | status if solution.status.success else status | rows
    warnings = list_all_warnings(solution)
    if warnings:
        rows["warnings"] = items(warnings)
    shown = table(rows, f"{solution.grid}, boundary {solution.boundary}", _LEFT)
    if can_draw() and solution.grid.cells <= _MAX_PICTURE_CELLS and solution.contact.any():
        picture = draw_panel("solution", solution, "pressure")
        shown += tag("img", src=picture, alt="The contact pressure", style="max-width: 24rem")
    return shown


def _make_page(title: str, parts: Iterable[str]) -> str:
    head = (
        '<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_SECURITY_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{quantity(f'Contact report: {title}')}</title>\n<style>{CSS}</style>"
    )
    body = element("body", element("main", "\n".join(filter(None, parts))))
    return f"<!doctype html>\n{element('html', element('head', head) + body, lang='en')}\n"


def _make_head(solution: ContactSolution, problem: ContactProblem | None, loads: Sequence[Load]) -> str:
    scene = f"{describe_scene(solution, problem, loads)}; written on {date.today().isoformat()}"
    return f"<h1>Contact report</h1>\n{element('p', escape(scene), class_='scene')}"


def _make_answer(solution: ContactSolution) -> str:
    answers = {name.capitalize(): quantity(text) for name, text in list_answers(solution).items()}
    maps = () if solution.origin is None else [one for one in solution.origin.maps if not one.periodic]
    if maps:
        answers["Contact area"] += f"<br>{element('span', escape(describe_maps(maps)), class_='note')}"
    materials = () if solution.origin is None else solution.origin.materials.values()
    if exceeds_metals(solution, materials):
        answers["Maximum pressure"] += f"<br>{element('span', escape(MORE_THAN_METALS), class_='note')}"
    return table(answers, "The answer", class_="answer")


def _make_figures(solution: ContactSolution) -> str:
    if not can_draw():
        return section("Figures", note(_NO_FIGURES))
    answers = list_answers(solution)
    answer = f"Contact area {answers['contact area']}; maximum pressure {answers['maximum pressure']}."
    return make_figures("Figures", draw_panels("solution", solution), answer)


def _make_states(path: StatePath, answers: Answers) -> Iterator[str]:
    """Yield answers, table, warnings and curve of a path."""
    found = {name.capitalize(): quantity(text) for name, text in path._list_results().items()}
    title = path.curve.capitalize()
    words = "The table has its numbers."
    yield table(found, "The answer", class_="answer")
    yield grid(*add_answers(path.short_table(), answers).to_cells(), "The states, in their order")
    yield _NOTE
    yield make_warnings((*path.warnings, *list_answer_warnings(answers)))
    yield make_figures(title, [draw_curve(path)], words) if can_draw() else section(title, note(_NO_FIGURES))


def _make_details(
    solution: ContactSolution, problem: ContactProblem | None, missing: str, script: str | None = None, plan: str = ""
) -> list[str]:
    """Return inputs, certificate, versions, script, citation and plan; with friction script and plan are others."""
    return [
        section("Inputs", table(list_inputs(solution, problem), "What was solved"), note(missing)),
        '<div class="columns">',
        section("Certificate", table(list_certificate(solution), "How the solve ended")),
        section("Versions", table(list_versions(solution), "The programs that made the solution")),
        "</div>",
        _make_script(solution, problem) if script is None else _show_script(script),
        _make_citation(problem),
        _make_plan(solution, problem, plan),
    ]


def _make_script(solution: ContactSolution, problem: ContactProblem | None) -> str:
    load = find_load(solution)
    return "" if problem is None or load is None else _show_script(write_script(solution, problem))


def _show_script(script: str) -> str:
    if not script:
        return ""
    remark = (
        "With the same versions on the same kind of processor the pressure is the same to the last bit, unless the "
        "solve started from another solution, as in a sweep; then it agrees within the tolerance."
    )
    return section("Run it again", element("pre", element("code", escape(script))), note(remark))


def _make_citation(problem: ContactProblem | None) -> str:
    made = versions()["roughcontact"]
    methods = [] if problem is None else [problem.plan.kernel, problem.plan.solver]
    references = list_references(made, [*methods, areas.resolve(DEFAULT_AREA)])
    texts = (
        element("li", f"{escape(one.text)} {element('a', escape(one.address), href=one.address)}") for one in references
    )
    bibtex = element("pre", element("code", escape(write_bibtex(made))))
    return section("Cite", element("ul", "".join(texts)), bibtex)


def _make_plan(solution: ContactSolution, problem: ContactProblem | None, plan: str) -> str:
    text = plan or ("" if problem is None else explain_state(problem.plan, solution))
    return section("Plan", element("pre", escape(text))) if text else ""
