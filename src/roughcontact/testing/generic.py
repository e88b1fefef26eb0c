"""Claims of several kinds of part, each written once: a kind applies them with its cases and its way of asking."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np

from roughcontact._base.arrays import RealArray
from roughcontact.testing.claim import Cases, claim, require, require_close, require_equal
from roughcontact.testing.problems import ChangedContact

# A function of the part and the arguments of a case that returns arrays or numbers.
Ask: TypeAlias = Callable[..., Iterable[Any]]


def claim_repeatable(
    kind: str,
    cases: Cases | None,
    ask: Ask,
    disturb: Callable[..., object] = lambda *_: None,
    copy: Callable[[Any], Any] = lambda part: part,
) -> None:
    """Claim that a part gives the same bits a second time.

    `disturb` makes another call in between; `copy` returns the part that is called the second time.
    """

    @claim(kind, "repeatable", cases)
    def test(part: object, *case: Any) -> None:
        first = [np.asarray(values) for values in ask(part, *case)]
        kept = [values.copy() for values in first]
        disturb(part, *case)
        for values, before in zip(first, kept, strict=True):
            require_equal(values, before, "a later call changes the result of an earlier one")
            # A caller may write into the arrays; the part must not hand out its own memory.
            if values.flags.writeable:
                values[...] = 7.0
        second = list(ask(copy(part), *case))
        require(len(second) == len(kept), "a second call gives results of another kind")
        for values, before in zip(second, kept, strict=True):
            require_equal(values, before, "a second call gives another result")


def claim_input_unchanged(
    kind: str, cases: Cases, prepare: Callable[..., tuple[Mapping[str, Any], Callable[[], object]]]
) -> None:
    """Claim that a part does not write into its arguments: arrays by name, prepared with the call that takes them."""

    @claim(kind, "input unchanged", cases)
    def test(part: object, *case: Any) -> None:
        given, call = prepare(part, *case)
        kept = {name: values.copy() for name, values in given.items()}
        call()
        for name, values in given.items():
            require_equal(values, kept[name], f"it writes into the {name}")


def claim_powers_of_two(
    kind: str,
    cases: Cases,
    scale: Callable[..., Iterable[tuple[RealArray, RealArray]]],
    factors: Iterable[tuple[float, ...]],
    words: str,
) -> None:
    """Claim that powers of two as units change no bit: `scale` gives results in other units, and the expected ones."""

    @claim(kind, "powers of two change no bit", cases)
    def test(part: object, *case: Any) -> None:
        for chosen in factors:
            for found, expected in scale(part, *case, *chosen):
                require_equal(found, expected, words.format(*chosen))


def claim_invariant(
    kind: str,
    name: str,
    cases: Cases,
    ask: Ask,
    changes: Callable[..., Iterable[ChangedContact]],
    tolerance: float,
    detail: str,
) -> None:
    """Claim that the answer to a moved or scaled contact, moved or scaled back, is the answer to the contact."""

    @claim(kind, name, cases)
    def test(part: object, *case: Any) -> float | None:
        expected = np.asarray(ask(part, *case))
        return max(
            (
                require_close(changed.restore(np.asarray(ask(part, changed.solution))), expected, tolerance, detail)
                for changed in changes(part, *case)
            ),
            default=None,
        )


def read_numbers(result: object) -> list[RealArray]:
    """Return the numbers and arrays that a result is or holds as fields."""
    values = [result] if isinstance(result, (int, float, np.ndarray)) else read_fields(result)
    return [np.asarray(value) for value in values if isinstance(value, (int, float, np.ndarray))]


def read_fields(part: object) -> list[Any]:
    """Return the values of the fields of an object of attrs; none of others."""
    return [getattr(part, field.name) for field in getattr(type(part), "__attrs_attrs__", ())]


def require_array(values: RealArray, shape: tuple[int, ...]) -> None:
    """Raise `AssertionError` unless an array has the shape and float64 numbers."""
    require(values.shape == shape, f"an array of shape {values.shape} where {shape} is needed")
    require(values.dtype == np.float64, f"numbers of type {values.dtype} where float64 is needed")


def require_valid(result: Any) -> None:
    """Raise `AssertionError` unless numbers, uncertainty, warnings and text of a result are valid."""
    uncertainty = getattr(result, "uncertainty", 0.0)
    warnings = getattr(result, "warnings", ())
    require(np.all(np.asarray(uncertainty) >= 0.0), f"an uncertainty of {uncertainty}")
    valid = isinstance(warnings, tuple) and all(isinstance(text, str) and text for text in warnings)
    require(valid, f"`warnings` must be a tuple of sentences, not {warnings!r}")
    require(not any(np.isnan(values).any() for values in read_numbers(result)), "a number that is not a number")
    require(str(result).strip(), "its text is empty")
