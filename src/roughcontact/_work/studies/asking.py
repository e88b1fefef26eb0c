"""Responses in tables of names and numbers, for the command line and the page: their fields, and their answers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias, get_type_hints

import attrs

from roughcontact._base.arrays import Array
from roughcontact._base.registry import PartField, Registry, find_view, list_fields, summarize
from roughcontact._base.tables import Table, page_or_file
from roughcontact._base.units import Estimate, kind_of
from roughcontact._solve.problem import Path as StatePath
from roughcontact._solve.problem import Sweep
from roughcontact._solve.solution import (
    ContactSolution,
    Response,
    format_sampling,
    list_estimates,
    responses,
)
from roughcontact._work.studies.coatings import find_layer_class
from roughcontact._work.studies.form import Form
from roughcontact.errors import InputError, RoughContactError, Sentence
from roughcontact.errors.door import guarded

# What each response that was asked for says of each solution, by the name of the response.
Answers: TypeAlias = Mapping[str, Sequence[Any]]
_NO_ANSWERS: Answers = MappingProxyType({})


@attrs.frozen
class ResponseForm:
    """What a form asks for a registered response.

    Attributes
    ----------
    summary
        What the response says, in a line.
    fields
        Its fields.
    is_array
        Whether it answers a number for each cell, which is for scripts.
    """

    summary: str
    fields: tuple[PartField, ...]
    is_array: bool


@guarded
def describe_response(name: str) -> ResponseForm:
    """Return what a form asks for the response with a registered name; `InputError` if it cannot be loaded.

    Examples
    --------
    >>> from roughcontact.faces import describe_response
    >>> [(field.name, field.unit) for field in describe_response("leakage").fields if field.is_needed]
    [('viscosity', 'Pa s'), ('pressure_drop', 'Pa')]
    """
    cls = responses[name]
    # The fields of a class that is not of attrs are for scripts.
    fields = tuple(list_fields(cls).values()) if attrs.has(cls) else ()
    line = summarize(cls)
    return ResponseForm(line[:1].lower() + line[1:], fields, get_type_hints(cls.respond).get("return") == Array)


@guarded
def build_part(registry: Registry[Any], name: str, fields: Mapping[str, Any], what: str) -> Any:
    """Return a part with a registered name.

    Parameters
    ----------
    registry
        The registry, such as ``rc.surfaces``.
    name
        The name.
    fields
        Its fields by name, numbers in SI units or texts as in a study file.
    what
        What a sentence calls the part.

    Raises
    ------
    InputError
        If a field is wrong or missing.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rc.faces.build_part(rc.surfaces, "sphere", {"radius": "5 mm"}, "the ball")
    SphereSurface(radius=0.005, center=(0.0, 0.0))
    """
    return _build(registry.base, {**fields, "type": name}, what)


@guarded
def build_layer(fields: Mapping[str, Any], what: str) -> Any:
    """Return a layer of a body, by the plug-in roughcontact-layered.

    Parameters
    ----------
    fields
        Its fields by name, numbers in SI units or texts as in a study file.
    what
        What a sentence calls the layer.

    Raises
    ------
    InputError
        If a field is wrong or missing.
    MissingPackage
        Without the plug-in.
    """
    return _build(find_layer_class(), fields, what)


def _build(kind: type, fields: Mapping[str, Any], what: str) -> Any:
    form = Form()
    made = form.read(kind, fields, "")
    for place, error in form.faults:
        raise InputError(f"{what}{place and f' {place}'}: {error.marked}") from error
    return made


@guarded
def build_response(name: str, fields: Mapping[str, Any]) -> Response[Any]:
    """Return the response with a registered name.

    Parameters
    ----------
    name
        The name.
    fields
        Its fields by name, numbers in SI units or texts as in a study file.

    Raises
    ------
    InputError
        If a field is wrong or missing.

    Examples
    --------
    >>> from roughcontact.faces import build_response
    >>> build_response("leakage", {"viscosity": "1 mPa.s", "pressure_drop": 1e5})
    GapFlow(axis=0, viscosity=0.001, pressure_drop=100000.0)
    """
    response: Response[Any] = build_part(responses, name, fields, name)
    return response


@guarded
def tabulate_answers(answers: Answers) -> dict[str, list[Estimate]]:
    """Return a column for each number that responses have answered, in the order of the solutions; nan without one.

    Parameters
    ----------
    answers
        The results of each response, one for each solution, by the name of the response.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.faces import tabulate_answers
    >>> columns = tabulate_answers({"stiffness": [rc.Estimate(2e6, 1e4, "N/m")]})
    >>> print(*columns["stiffness"])
    2 MN/m +- 0.5 %
    """
    columns: dict[str, list[Estimate]] = {}
    for name, found in answers.items():
        numbers = [list_estimates(result) for result in found]
        for part, unit in {part: one.unit for several in numbers for part, one in several.items()}.items():
            absent = Estimate(math.nan, math.nan, unit)
            columns[f"{name} {part}".strip()] = [several.get(part, absent) for several in numbers]
    return columns


def add_answers(table: Table, answers: Answers) -> Table:
    """Return a table of states with a column for each number that responses have answered, a result for each row."""
    return Table({**table.columns, **tabulate_answers(answers)}, table.units, table.left)


@guarded
def list_answer_warnings(answers: Answers, solutions: Sequence[ContactSolution] = ()) -> list[str]:
    """Return a sentence for the warnings of each rule, with the names of the numbers that it concerns.

    Parameters
    ----------
    answers
        The results of each response, one for each solution, by the name of the response.
    solutions
        What area and maximum pressure of these are warned of is omitted: it is said there.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.faces import list_answer_warnings
    >>> found = rc.Estimate(2e6, 1e6, "N/m", warnings=("the grid is coarse",))
    >>> list_answer_warnings({"stiffness": [found], "conductance": [found]})
    ['stiffness, conductance: the grid is coarse']
    """
    estimates = [one for solution in solutions for one in (solution.area(), solution.peak_pressure())]
    said = {text for one in estimates for text in one.warnings}
    names: dict[str, dict[str, None]] = {}
    texts: dict[str, str] = {}
    for name, column in tabulate_answers(answers).items():
        for text in (text for one in column for text in one.warnings if text not in said):
            names.setdefault(kind_of(text), {})[_in_words(name)] = None
            texts[kind_of(text)] = text
    return [f"{', '.join(names[kind])}: {text}" for kind, text in texts.items()]


def _in_words(name: str) -> str:
    return name.replace("_", " ").replace("-", " ")


def describe_answers_elsewhere(answers: Answers, loads: Sequence[str]) -> str:
    """Return how much the answers at each load differ at other places, in words; empty where it is not known."""
    found = []
    for name, column in tabulate_answers(answers).items():
        differences = zip(map(format_sampling, column), loads, strict=True)
        texts = [f"{text} at {load}" if len(loads) > 1 else text for text, load in differences if text]
        found += [f"{_in_words(name)} {', '.join(texts)}"] if texts else []
    return f"{'; '.join(found)} (standard deviation)" if found else ""


@guarded
def ask_states(
    asked: Mapping[str, Response[Any]],
    states: Sequence[ContactSolution],
    on_answer: Callable[[str], object] = lambda name: None,
) -> tuple[dict[str, list[Any]], dict[str, str]]:
    """Return what responses say of the states of a cycle or a path: some, such as unstable ones, have no answer.

    Parameters
    ----------
    asked
        The responses by their names.
    states
        The states; one that is there twice is asked once. Of a state with friction the stress is that under pressure
        and traction, the others are those of its normal contact.
    on_answer
        Called with the name of the response before each answer.

    Returns
    -------
    tuple
        The results of each response, one for each state, None without one; and by the name of the response how many
        have none, and why.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.faces import ask_states
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> solution = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6)).solve(force=1.0)
    >>> answers, reasons = ask_states({"perimeter": rc.responses.create("perimeter")}, [solution])
    >>> print(*answers["perimeter"], reasons)
    93.07 µm +- 0.3 % {}
    """
    found: dict[str, list[Any]] = {}
    reasons: dict[str, str] = {}
    # By their identity, while they live.
    different = {id(state): state for state in states}
    for name, response in asked.items():
        results: dict[int, Any] = {}
        missing = []
        for key, state in different.items():
            on_answer(name)
            try:
                results[key] = state.response(response)
            except RoughContactError as error:
                results[key] = None
                missing.append(error.marked if isinstance(error, InputError) else str(error))
        found[name] = [results[id(state)] for state in states]
        if missing:
            has_none = len(missing) == len(different)
            count = "no state has an" if has_none else f"{len(missing)} of {len(different)} states have no"
            reasons[name] = Sentence(f"{count} answer: {missing[0]}")
    return found, reasons


@guarded
def write_report(
    solutions: Sequence[ContactSolution] | StatePath,
    path: Path,
    answers: Answers = _NO_ANSWERS,
) -> None:
    """Write the report of one load or several, of a cycle or a path with friction, with answers of responses.

    Parameters
    ----------
    solutions
        The solutions, cycle or path.
    path
        The HTML file.
    answers
        The results of each response by its name, one for each solution or row of the table.
    """
    subject: Any = solutions
    if not isinstance(solutions, StatePath):
        subject = Sweep(tuple(solutions)) if len(solutions) > 1 else solutions[0]
    page_or_file(lambda: find_view("page")(subject, answers), path)
