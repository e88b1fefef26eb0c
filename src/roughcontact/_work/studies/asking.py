"""Responses in tables of names and numbers, for the command line and the page: their fields, and their answers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias, get_type_hints

import attrs

from roughcontact._base.arrays import Array, Pair
from roughcontact._base.registry import Registry
from roughcontact._base.units import Estimate
from roughcontact._solve.problem import Sweep
from roughcontact._solve.solution import (
    ContactSolution,
    Response,
    list_estimates,
    page_or_file,
    responses,
    writers,
)
from roughcontact._work.studies.form import Form, list_fields
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# What each response that was asked for says of each solution, by the name of the response.
Answers: TypeAlias = Mapping[str, Sequence[Any]]
_NO_ANSWERS: Answers = MappingProxyType({})


@attrs.frozen
class ResponseField:
    """A field of a response, as a form asks for it.

    Attributes
    ----------
    name
        The name.
    unit
        SI unit of its number; empty for a number without one, None if it is not a number.
    is_pair
        Whether it is one number or two.
    is_needed
        Whether it has no default.
    plain_unit
        Unit of a number that a text may omit, such as ``"W/(m K) or S/m"``: the ``plain_unit`` in the metadata of
        the field; empty without one.
    """

    name: str
    unit: str | None
    is_pair: bool
    is_needed: bool
    plain_unit: str = ""


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
    fields: tuple[ResponseField, ...]
    is_array: bool


@guarded
def describe_response(name: str) -> ResponseForm:
    """Return what a form asks for the response with a registered name; `InputError` if it cannot be loaded.

    Examples
    --------
    >>> from roughcontact.typing import describe_response
    >>> [(field.name, field.unit) for field in describe_response("leakage").fields if field.is_needed]
    [('viscosity', 'Pa s'), ('pressure_drop', 'Pa')]
    """
    cls = responses[name]
    line = (cls.__doc__ or "").partition("\n")[0].partition(":math:")[0].strip(" ,.")
    fields = []
    # Those of a class that is not of attrs are for scripts.
    for field, found in list_fields(cls).items() if attrs.has(cls) else ():
        plain = "" if found.kind in (float, Pair) else None
        unit = plain if found.unit is None else found.unit
        fields.append(ResponseField(field, unit, found.kind == Pair, found.required, found.plain_unit))
    is_array = get_type_hints(cls.respond).get("return") == Array
    return ResponseForm(line[:1].lower() + line[1:], tuple(fields), is_array)


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
    >>> rc.typing.build_part(rc.surfaces, "sphere", {"radius": "5 mm"}, "the ball")
    SphereSurface(radius=0.005, center=(0.0, 0.0))
    """
    form = Form()
    part = form.read(registry.base, {**fields, "type": name}, "")
    for place, error in form.faults:
        raise InputError(f"{what}{place and f' {place}'}: {error}") from error
    return part


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
    >>> from roughcontact.typing import build_response
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
    >>> from roughcontact.typing import tabulate_answers
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


@guarded
def write_report(solutions: Sequence[ContactSolution], path: Path, answers: Answers = _NO_ANSWERS) -> None:
    """Write the report of one load or several, with what responses have answered.

    Parameters
    ----------
    solutions
        The solutions.
    path
        The HTML file.
    answers
        The results of each response, one for each solution, by the name of the response.
    """
    writer: Any = writers.create("html")
    several = len(solutions) > 1
    subject: Any = Sweep(tuple(solutions)) if several else solutions[0]
    page_or_file(lambda: (writer.sweep_text if several else writer.text)(subject, answers), path)
