"""What the contacts of a study do: numbers of registered responses in its records."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from typing import Any

import attrs

from roughcontact._base.archive.plain import key_of
from roughcontact._base.units import printable
from roughcontact._solve.solution import ContactSolution, Response, list_estimates, responses
from roughcontact._work.studies.asking import list_answer_warnings
from roughcontact.errors import InputError

_ALLOWED = "a registered name, a Response, or a list of them"


@attrs.frozen
class Answer:
    """The numbers of a response.

    Attributes
    ----------
    key
        That of the response with its fields.
    numbers
        Value, standard deviation and unit by name; the name of a single number is empty.
    """

    key: str = attrs.field(converter=printable)
    numbers: Mapping[str, tuple[float, float, str]]

    @classmethod
    def of(cls, stated: Answer | Mapping[str, Any]) -> Answer:
        """Return an answer from its fields, as a list of records states them."""
        if isinstance(stated, Answer):
            return stated
        numbers = {
            printable(name): (float(value), float(uncertainty), printable(unit))
            for name, (value, uncertainty, unit) in stated["numbers"].items()
        }
        return cls(stated["key"], numbers)


def read_answers(value: Mapping[str, Any]) -> dict[str, Answer]:
    """Return the answers of a record by the name of the response."""
    return {printable(name): Answer.of(one) for name, one in value.items()}


def read_responses(value: Any) -> tuple[Response[Any], ...]:
    """Return responses from registered names and instances, or raise `InputError`; each kind once."""
    given = [value] if isinstance(value, (str, Response)) else value
    if not isinstance(given, (list, tuple)):
        raise InputError.about("The responses of a study", value, _ALLOWED)
    found = []
    for one in given:
        if not isinstance(one, (str, Response)):
            raise InputError.about("A response of a study", one, _ALLOWED)
        found.append(responses.create(one) if isinstance(one, str) else one)
    names = [name_of(one) for one in found]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"The response {name!r} is asked for twice: its columns have one name.")
    return tuple(found)


@attrs.frozen(eq=False)
class Question:
    """A response that a study asks of each contact.

    Attributes
    ----------
    response
        The response.
    name
        Its registered name.
    key
        That of the response with its fields.
    """

    response: Response[Any]
    name: str
    key: str

    @classmethod
    def of(cls, response: Response[Any]) -> Question:
        """Return a question from its response."""
        return cls(response, name_of(response), key_of(response))


def name_of(response: Response[Any]) -> str:
    """Return the registered name of a response, or raise `InputError` if it has none."""
    name = responses.name_of(type(response))
    if name is None:
        raise InputError(f"{type(response).__name__} is not registered, so that its columns have no name.")
    return name


def find_answers(
    solution: ContactSolution, asked: Sequence[Question], known: Mapping[str, Answer]
) -> tuple[dict[str, Answer], dict[str, Exception], list[str]]:
    """Return the answers of a solution by name, the errors of those that it refuses, and the warnings of new ones.

    Known answers are kept as they are.
    """
    answers = dict(known)
    errors: dict[str, Exception] = {}
    results: dict[str, list[Any]] = {}
    for question in asked:
        name = question.name
        if has_answers(known, [question]):
            continue
        answers.pop(name, None)
        # Responses are plug-ins.
        try:
            result = solution.response(question.response)
            estimates = list_estimates(result)
            if not estimates:
                raise InputError("it has no single number")
            numbers = {part: (float(one.value), float(one.uncertainty), one.unit) for part, one in estimates.items()}
            answers[name] = Answer(question.key, numbers)
            results[name] = [result]
        except Exception as error:
            errors[name] = error
    said: list[str] = []
    # What the area is warned of is said with it; its estimator is a plug-in.
    with contextlib.suppress(Exception):
        said = list_answer_warnings(results, [solution]) if results else []
    return answers, errors, said


def has_answers(known: Mapping[str, Answer], asked: Sequence[Question]) -> bool:
    """Return whether answers are those of the responses, with the same fields."""
    return all(one.name in known and known[one.name].key == one.key for one in asked)
