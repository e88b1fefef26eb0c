"""The sentence for a call that failed by its arguments, found after the failure: a call that succeeds pays nothing."""

from __future__ import annotations

import collections.abc
import difflib
import inspect
import numbers
import sys
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from roughcontact.errors import InputError, WrongCall, message_of, short

# Size of a number whose square and its inverse float64 holds.
_MIN_SQUARED = 1e-150
# Modules with the names that annotations take from elsewhere.
_PUBLIC_MODULES = tuple(f"roughcontact.{name}" for name in ("faces", "responses", "results", "solving", "typing"))
_PUBLIC_MODULES += ("roughcontact",)
# What is taken for a number; True and False are not.
_NUMBERS = {float: numbers.Real, int: numbers.Integral}


def find_misfit(
    error: Exception, call: str, function: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]
) -> InputError | None:
    """Return the error of a failed call's argument that fits neither its signature nor its type, nor the others."""
    signature = inspect.signature(function)
    try:
        given = signature.bind(*args, **kwargs).arguments
    except TypeError as wrong:
        return _misplaced(call, signature, args) or _mismatched(call, signature, kwargs, wrong)
    hints = _types_of(function)
    for name, value in given.items():
        if not _is_a(value, hints.get(name, Any)):
            kind = signature.parameters[name].annotation
            return WrongCall.about(f"{name}= of {call}", value, f"of type {getattr(kind, '__name__', kind)}")
    return _unusable(error, call, given)


def _misplaced(call: str, signature: inspect.Signature, args: tuple[Any, ...]) -> WrongCall | None:
    """Return the error of an argument that must be given by name, but is not; None if there is none."""
    kinds = [one.kind for one in signature.parameters.values()]
    named = [f"{name}=" for name, one in signature.parameters.items() if one.kind is one.KEYWORD_ONLY]
    places = sum(kind <= inspect.Parameter.POSITIONAL_OR_KEYWORD for kind in kinds)
    if not named or len(args) <= places:
        return None
    value = short(args[places])
    others = f", or {', '.join(named[1:])}" if named[1:] else ""
    return WrongCall(f"{call} takes what was given as {value} by name: write {named[0]}{value}{others}.")


def _mismatched(call: str, signature: inspect.Signature, kwargs: dict[str, Any], wrong: TypeError) -> WrongCall:
    """Return the error of a call that omits an argument, or has one too many, and which name may be meant."""
    names = [name for name in signature.parameters if name not in ("self", "cls")]
    unknown = [name for name in kwargs if name not in signature.parameters]
    close = difflib.get_close_matches(unknown[0], names, n=1, cutoff=0.6) if unknown else []
    guess = f" Did you mean {close[0]}=?" if close else ""
    return WrongCall(f"{call}({', '.join(names)}): {wrong}.{guess}")


def _types_of(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the types of a function's arguments; names imported for annotations alone are public, or of typing."""
    public = [sys.modules[name] for name in _PUBLIC_MODULES]
    places = (typing, *public, sys.modules[function.__module__])
    return typing.get_type_hints(function, {name: one for place in places for name, one in vars(place).items()})


def _is_a(value: object, hint: Any) -> bool:
    """Return whether a value may stand where a type is asked for."""
    kind = typing.get_origin(hint) or hint
    of = typing.get_args(hint)
    if kind in (typing.Union, types.UnionType):
        return any(_is_a(value, one) for one in of)
    if kind in _NUMBERS:
        return isinstance(value, _NUMBERS[kind]) and not isinstance(value, bool)
    if kind is np.ndarray:
        return isinstance(value, (np.ndarray, list, tuple)) and _holds_numbers(value)
    if kind in (collections.abc.Sequence, collections.abc.Iterable, tuple) and of:
        return _is_list(value, of, None if kind is not tuple or of[-1] is Ellipsis else len(of))
    # Any is a class from Python 3.11 on.
    return kind is Any or not isinstance(kind, type) or isinstance(value, kind)


def _holds_numbers(value: np.ndarray[Any, Any] | list[Any] | tuple[Any, ...]) -> bool:
    try:
        return np.asarray(value).dtype.kind in "biuf"
    except ValueError:
        return False


def _is_list(value: object, of: tuple[Any, ...], length: int | None) -> bool:
    """Return whether a value holds items of a type, as many as asked for; one that can be read once is not read."""
    if isinstance(value, (str, bytes, Mapping)) or not hasattr(value, "__iter__"):
        return False
    if not isinstance(value, (list, tuple, np.ndarray)):
        return True
    fits = getattr(value, "ndim", 1) > 0 and length in (None, len(value))
    return fits and all(_is_a(item, of[0]) for item in value)


def _unusable(error: Exception, call: str, given: dict[str, Any]) -> InputError | None:
    """Return the error of an argument that lacks what the call needs, or whose value does not fit; None otherwise."""
    if isinstance(error, ArithmeticError):
        extreme = [f"{name}={short(value)}" for name, value in given.items() if _is_extreme(value)]
        if extreme:
            return InputError(f"{call} cannot be computed for {', '.join(extreme)}: {message_of(error)}.")
    if isinstance(error, AttributeError):
        for name, value in given.items():
            if name != "self" and value is error.obj:
                return InputError.about(f"{name}= of {call}", value, f"an object that has {error.name!r}")
    if isinstance(error, ValueError) and "could not be broadcast" in str(error):
        arrays = {name: value for name, value in given.items() if isinstance(value, (np.ndarray, list, tuple))}
        if len(arrays) > 1:
            shapes = ", ".join(f"{name} of shape {np.shape(value)}" for name, value in arrays.items())
            return InputError(f"The arguments of {call} must fit each other, but they are {shapes}.")
    return None


def _is_extreme(value: object) -> bool:
    """Return whether a value is a number by which float64 cannot divide, or whose square it does not hold."""
    if not isinstance(value, numbers.Real):
        return False
    size: Any = abs(value)
    return not _MIN_SQUARED < size < 1.0 / _MIN_SQUARED
