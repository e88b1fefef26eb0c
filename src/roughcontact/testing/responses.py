"""Claims about responses: what a contact does, asked of its solution."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from roughcontact._parts.grid import Boundary
from roughcontact._solve.solution import ContactSolution, Estimate, Response
from roughcontact.errors import InputError
from roughcontact.testing.claim import DoesNotApply, claim, pickled, require
from roughcontact.testing.problems import full_contact, mirror, rough_contact, scale_units, shift, sphere_contact

# Relative difference of two numbers that is rounding of iterations in float32.
_CLOSE = 1e-4


def _solutions(_: object) -> Iterator[tuple[str, ContactSolution]]:
    yield "a rough surface", rough_contact(0.05)
    yield "a rough surface on a free boundary", rough_contact(0.05, Boundary.FREE)
    yield "a plastic rough surface", rough_contact(0.05, Boundary.PERIODIC, True)
    yield "a sphere", sphere_contact(5.0, (0.3, 0.1))
    yield "full contact", full_contact()


def _few(_: object) -> Iterator[tuple[str, ContactSolution]]:
    yield "a rough surface", rough_contact(0.05)
    yield "a sphere", sphere_contact(5.0, (0.3, 0.1))


def _respond(response: Response[Any], solution: ContactSolution) -> Any:
    """Return the result; None where the response is refused in a sentence."""
    with suppress(InputError):
        return response.respond(solution)
    return None


def _read_numbers(result: object) -> list[Any]:
    """Return the numbers and arrays that a result is or holds as fields."""
    if isinstance(result, (int, float, np.ndarray)):
        return [np.asarray(result)]
    return [np.asarray(value) for value in _read_fields(result) if isinstance(value, (int, float, np.ndarray))]


def _read_fields(part: object) -> list[Any]:
    """Return the values of the fields of an object of attrs; none of others."""
    return [getattr(part, field.name) for field in getattr(type(part), "__attrs_attrs__", ())]


def _require_estimate(response: Response[Any], solution: ContactSolution) -> Estimate:
    """Return the result if it is a finite number that is not zero."""
    result = _respond(response, solution)
    if not isinstance(result, Estimate) or not math.isfinite(result.value) or result.value == 0.0:
        raise DoesNotApply("its result is not an Estimate, or not finite, or zero")
    return result


def _compare(one: Estimate, other: Estimate) -> float:
    error = abs(other.value / one.value - 1.0)
    require(error <= _CLOSE, f"the number differs by {error:.1e}")
    return error


@claim("response", "serves a rough contact")
def _serves(response: Response[Any]) -> None:
    found = (_respond(response, solution) for _, solution in _solutions(response))
    require(any(result is not None for result in found), "it refuses every contact that is tried, or returns nothing")


@claim("response", "valid numbers and warnings", _solutions)
def _valid(response: Response[Any], solution: ContactSolution) -> None:
    result = _respond(response, solution)
    if result is None or isinstance(result, np.ndarray):
        return
    uncertainty = getattr(result, "uncertainty", 0.0)
    warnings = getattr(result, "warnings", ())
    require(np.all(np.asarray(uncertainty) >= 0.0), f"an uncertainty of {uncertainty}")
    valid = isinstance(warnings, tuple) and all(isinstance(text, str) and text for text in warnings)
    require(valid, f"`warnings` must be a tuple of sentences, not {warnings!r}")
    require(not any(np.isnan(values).any() for values in _read_numbers(result)), "a number that is not a number")
    require(str(result).strip(), "its text is empty")


@claim("response", "repeatable", _few)
def _repeatable(response: Response[Any], solution: ContactSolution) -> None:
    one, two = (_read_numbers(_respond(asked, solution)) for asked in (response, pickled(response)))
    same = len(one) == len(two) and all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, two, strict=True))
    require(same, "a copy of it, asked for the same contact, gives other numbers")


@claim("response", "mirrored and shifted contacts")
def _moved(response: Response[Any]) -> float:
    solution = rough_contact(0.05)
    one = _require_estimate(response, solution)
    shifted = () if response.depends_on_place else (shift(solution, (7, 5)),)
    others = (mirror(solution, (0,)), mirror(solution, (1,)), *shifted)
    return max(_compare(one, _require_estimate(response, other)) for other in others)


@claim("response", "scales with units")
def _units(response: Response[Any]) -> None:
    if any(isinstance(value, float) for value in _read_fields(response)):
        raise DoesNotApply("its fields may have units")
    solution = rough_contact(0.05)
    one = _require_estimate(response, solution)
    for length, stiffness in ((2.0**10, 1.0), (1.0, 2.0**-8)):
        ratio = _require_estimate(response, scale_units(solution, length, stiffness)).value / one.value
        power = round(math.log2(ratio)) if ratio > 0.0 else 0
        error = abs(ratio / 2.0**power - 1.0)
        require(error <= _CLOSE, f"in units of powers of two the number has other digits, by {error:.1e}")
