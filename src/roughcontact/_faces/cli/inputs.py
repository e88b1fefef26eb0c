"""What was asked for, as data that JSON can hold: responses, wanted answers and studies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import roughcontact as rc
from roughcontact._solve.problem import (
    RequiredLoad,
    describe_loads,
    describe_part,
    describe_problem,
    describe_value,
)
from roughcontact._work.studies import Study, name_of


def describe_responses(asked: Mapping[str, rc.Response[Any]]) -> dict[str, Any]:
    """Return what is asked of a contact, with its fields, by name; empty if nothing is."""
    return {"responses": {name: describe_part(one) for name, one in asked.items()}} if asked else {}


def describe_wanted(answer: rc.Response[Any], required: RequiredLoad) -> dict[str, Any]:
    """Return the answer for which a load was asked, and what was wanted of it."""
    return {"solve_for": {"answer": describe_part(answer), **describe_value(required.wanted, required.answer.unit)}}


def describe_study(study: Study) -> dict[str, Any]:
    """Return the problems of a study by name, and what each is solved at and asked for."""
    return {
        "problems": {name: describe_problem(problem) for name, problem in study.problems.items()},
        "load": describe_loads(study.loads),
        "seeds": list(study.seeds),
        "areas": list(study.areas),
        **describe_responses({name_of(one): one for one in study.responses}),
        **study.loading.describe(),
    }
