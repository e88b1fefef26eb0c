"""Claims about responses, which tell from a solution how the contact behaves."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from roughcontact._solve.solution import ContactSolution, Estimate, Response
from roughcontact.errors import InputError
from roughcontact.testing.claim import DoesNotApply, claim, pickled, require
from roughcontact.testing.generic import claim_invariant, claim_repeatable, read_fields, read_numbers, require_valid
from roughcontact.testing.problems import (
    ChangedContact,
    adhesive_contact,
    list_contacts,
    mirror_images,
    scale_units,
    shifted_copies,
)

# Maximum relative difference of two numbers by rounding, of iterations in float32.
_MAX_NUMBER_DIFFERENCE = 1e-4


_all_contacts = list_contacts()
_rough_contact = list_contacts("a rough surface")


def _respond(response: Response[Any], solution: ContactSolution) -> Any:
    """Return the result; None where the response is refused in a sentence."""
    with suppress(InputError):
        return response.respond(solution)
    return None


def _estimate(response: Response[Any], solution: ContactSolution) -> list[float]:
    """Return the value of the result, if it is a finite number that is not zero."""
    result = _respond(response, solution)
    if not isinstance(result, Estimate) or not math.isfinite(result.value) or result.value == 0.0:
        raise DoesNotApply("its result is not an Estimate, or not finite, or zero")
    return [result.value]


@claim("response", "serves a rough contact")
def _serves(response: Response[Any]) -> None:
    contacts = [*(solution for _, solution in _all_contacts(response)), adhesive_contact()]
    found = (_respond(response, solution) for solution in contacts)
    require(any(result is not None for result in found), "it refuses every contact that is tried, or returns nothing")


@claim("response", "valid numbers and warnings", _all_contacts)
def _valid(response: Response[Any], solution: ContactSolution) -> None:
    result = _respond(response, solution)
    if result is not None and not isinstance(result, np.ndarray):
        require_valid(result)


claim_repeatable(
    "response",
    list_contacts("a rough surface", "a sphere"),
    lambda response, solution: read_numbers(_respond(response, solution)),
    copy=pickled,
)


def _move(response: Response[Any], solution: ContactSolution) -> tuple[ChangedContact, ...]:
    shifted = () if response.depends_on_place else shifted_copies(solution, (7, 5))
    return *mirror_images(solution), *shifted


def _scale(response: Response[Any], solution: ContactSolution) -> Iterator[ChangedContact]:
    """Give the contact in units of powers of two, and the answer to it times the power of two that suits it best."""
    if any(isinstance(value, float) for value in read_fields(response)):
        raise DoesNotApply("its fields may have units")
    one = _estimate(response, solution)[0]
    for length, stiffness in ((2.0**10, 1.0), (1.0, 2.0**-8)):
        yield ChangedContact(
            scale_units(solution, length, stiffness), lambda values: values / 2.0 ** np.round(np.log2(values / one))
        )


for _name, _changes, _detail in (
    ("mirrored and shifted contacts", _move, "the number differs"),
    ("scales with units", _scale, "in units of powers of two the number has other digits"),
):
    claim_invariant("response", _name, _rough_contact, _estimate, _changes, _MAX_NUMBER_DIFFERENCE, _detail)
