"""The report of a result: one self-contained page, and what to cite."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

import attrs

from roughcontact._answers.laws import FilmLaw, InterfaceLaw
from roughcontact._base.tables import Result
from roughcontact._base.units import counted
from roughcontact._faces.html.inputs import (
    describe_inputs,
    describe_scene,
    list_certificate,
    list_versions,
    write_script,
)
from roughcontact._faces.html.pages import make_page
from roughcontact._faces.html.parts import (
    Figures,
    describe_responses,
    describe_verdict,
    draw_columns,
    draw_curve,
    draw_panels,
    list_rows,
    list_sweep_warnings,
    loads_of,
    write_grid,
)
from roughcontact._faces.html.words import typeset
from roughcontact._faces.panels.figures import can_draw
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

_NO_ANSWERS: Answers = MappingProxyType({})
# What curves show, in words.
_ALL_NUMBERS = "The table has its numbers."


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
    return _write_result(result, None)


@write_page.register
def _write_law(law: InterfaceLaw | FilmLaw, answers: Answers = _NO_ANSWERS) -> str:
    """Return the page of a law: its rows, and its columns drawn."""
    return _write_result(law, Figures("Curves", list(draw_columns(law)) if can_draw() else None, _ALL_NUMBERS))


def _write_result(result: Result, curves: Figures | None) -> str:
    return make_page("result.html", title=repr(result).strip("<>"), shown=result._repr_html_(), curves=curves)


@write_page.register
def _write_solution(solution: ContactSolution, answers: Answers = _NO_ANSWERS) -> str:
    """Return the page, with what responses have answered."""
    return _write_contact(
        solution,
        title=list_answers(solution)["contact area"].partition(",")[0],
        states=[solution],
        loads=loads_of([solution]),
        results=_list_answers(solution),
        warnings=list_all_warnings(solution),
        responses=describe_responses(answers, [solution]),
    )


@write_page.register
def _write_sweep(sweep: Sweep, answers: Answers = _NO_ANSWERS) -> str:
    """Return the page of a sweep: all loads, with what responses have answered, then the largest in detail."""
    largest = max(sweep.states, key=lambda solution: solution.force)
    words = f"The table has the numbers of all {len(sweep)} loads."
    return _write_contact(
        largest,
        title=counted(len(sweep), "load"),
        states=sweep.states,
        loads=loads_of(sweep.states),
        rows=list_rows(sweep),
        notes=note_loads(sweep.states),
        warnings=list_sweep_warnings(sweep),
        responses=describe_responses(answers, sweep.states),
        curves=Figures("Curves", list(draw_panels("sweep", sweep)), words) if can_draw() else None,
        detailed=f"The largest load, {name_load(largest)}",
    )


@write_page.register
def _write_path(path: StatePath, answers: Answers = _NO_ANSWERS) -> str:
    """Return the page of a path: its states, with what responses have answered, then one of them in detail."""
    state = path.detailed
    problem, _ = find_problem(state)
    return _write_contact(
        state,
        title=counted(len(path), "state"),
        states=path.states,
        loads=loads_of(path.given),
        results={name.capitalize(): [typeset(text)] for name, text in path._list_results().items()},
        rows=write_grid(add_answers(path.short_table(), answers), "The states, in their order"),
        warnings=[*path.warnings, *list_answer_warnings(answers)],
        curves=Figures(path.curve.capitalize(), [draw_curve(path)] if can_draw() else None, _ALL_NUMBERS),
        detailed="The last state" if state is path[-1] else f"The largest load, {name_load(state)}",
        script="" if problem is None else write_script(path, problem),
        plan=path.explain_plan(None if problem is None else problem.plan),
    )


def _write_contact(
    solution: ContactSolution,
    *,
    title: str,
    states: Sequence[ContactSolution],
    loads: Sequence[Load],
    script: str | None = None,
    plan: str = "",
    **parts: Any,
) -> str:
    """Return the page of states, of which one is shown in detail; those of a path have a script and a plan of theirs.

    Parts that are not given are omitted.
    """
    problem, missing = find_problem(solution)
    answers = list_answers(solution)
    words = f"Contact area {answers['contact area']}; maximum pressure {answers['maximum pressure']}."
    made = versions()["roughcontact"]
    if script is None:
        script = "" if problem is None or find_load(solution) is None else write_script(solution, problem)
    omitted = dict.fromkeys(("results", "rows", "notes", "warnings", "responses", "curves", "detailed"), ())
    return make_page(
        "contact.html",
        title=typeset(title),
        scene=describe_scene(solution, problem, loads),
        date=date.today().isoformat(),
        **describe_verdict(states),
        **{**omitted, **parts},
        details=_list_answers(solution),
        panels=Figures("Figures", list(draw_panels("solution", solution)) if can_draw() else None, words),
        inputs=describe_inputs(solution, problem),
        missing=missing,
        certificate=list_certificate(solution),
        versions=list_versions(solution),
        script=script,
        references=_list_references(problem, made),
        bibtex=write_bibtex(made),
        plan=plan or ("" if problem is None else explain_state(problem.plan, solution)),
    )


def _list_answers(solution: ContactSolution) -> dict[str, list[str]]:
    """Return the answers of a solution by name, each a text and remarks on it."""
    answers = {name.capitalize(): [typeset(text)] for name, text in list_answers(solution).items()}
    maps = () if solution.origin is None else [one for one in solution.origin.maps if not one.periodic]
    if maps:
        answers["Contact area"].append(describe_maps(maps))
    materials = () if solution.origin is None else solution.origin.materials.values()
    if exceeds_metals(solution, materials):
        answers["Maximum pressure"].append(MORE_THAN_METALS)
    return answers


def _list_references(problem: ContactProblem | None, made: str) -> Sequence[Any]:
    methods = [] if problem is None else [problem.plan.kernel, problem.plan.solver]
    return list_references(made, [*methods, areas.resolve(DEFAULT_AREA)])
