"""The door: every error that a public call meets becomes a `RoughContactError`, in one place."""

from __future__ import annotations

import enum
import functools
import re
import threading
import traceback
import types
import typing
from collections.abc import Callable
from itertools import zip_longest
from typing import Any, TypeVar

from roughcontact.errors import (
    FileError,
    InputError,
    MissingPackage,
    OutOfMemory,
    RoughContactError,
    UnexpectedError,
    message_of,
    short,
    shorten,
)
from roughcontact.errors.arguments import find_misfit
from roughcontact.errors.warning import warn_of

T = TypeVar("T")
# Characters of another package's message that a sentence repeats.
_MESSAGE = 240
# How the text of an error begins that Python raises for a call, and of one that a validator of attrs raises.
_OF_CALL = re.compile(r"([\w.<>]+)\(\) (takes|missing|got) ")
_OF_ATTRS = re.compile(r"(Length of )?'\w+' must |.*<\w+ validator")
# The special methods that are public operations; the others belong to Python.
_OPERATIONS = {"__init__", "__str__", "__repr__", "__add__", "__getitem__", "__iter__", "__len__", "__contains__"}
_OPERATIONS |= {"__call__", "__getattr__", "__format__", "__mul__", "__rmul__", "__truediv__", "__neg__", "__radd__"}
_OPERATIONS |= {"__sub__", "__rsub__"}


class _Thread(threading.local):
    """Whether a thread is inside a public call."""

    inside = False


_THREAD = _Thread()
_GUARDED: set[type] = set()


def guarded(public: T) -> T:
    """Return a public function or class, every call of which ends in a result or in a `RoughContactError`.

    The outermost call translates what it meets. Inside it nothing changes, so that this package sees all errors as they
    are, and the errors of a user's callback pass (see `outside`). A class is changed in place, with its bases and what
    is derived from it.

    Examples
    --------
    >>> from roughcontact.errors.door import guarded
    >>> @guarded
    ... def divide(load: float, area: float) -> float:
    ...     return load / area
    >>> divide(6.0, 2.0)
    3.0
    >>> divide(6.0, 0.0)
    Traceback (most recent call last):
        ...
    roughcontact.InputError: divide cannot be computed for area=0.0: float division by zero.
    """
    if not isinstance(public, type):
        return typing.cast(T, _guard(public, public.__name__))  # type: ignore[arg-type, attr-defined]
    for cls in public.__mro__:
        if _is_ours(cls) and cls not in _GUARDED:
            _GUARDED.add(cls)
            _guard_class(cls)
    found: list[type] = public.__subclasses__()
    for derived in found:
        guarded(derived)
    return public


def outside(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a user's function for calls from inside: its errors pass as they are."""

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        before = _THREAD.inside
        _THREAD.inside = False
        try:
            return function(*args, **kwargs)
        except Exception as error:
            error.__dict__["of_callback"] = True
            raise
        finally:
            _THREAD.inside = before

    return call


def translated(error: Exception, call: str) -> Exception:
    """Return the `RoughContactError` for an error that a call met; warnings and a callback's errors are not changed."""
    if isinstance(error, (RoughContactError, Warning)) or "of_callback" in error.__dict__:
        return error
    text = shorten(message_of(error).rstrip("."), _MESSAGE)
    because = f": {text}" if text else ""
    part = _foreign_part(error)
    place = f" in {part}" if part else ""
    match error:
        case MemoryError():
            return OutOfMemory(f"{call} needs more memory than there is{because}.")
        case ModuleNotFoundError(name=str(package)):
            return MissingPackage(f"{call} needs the package {package}, which is not installed.")
        case OSError(filename=file):
            where = f" {short(file)}" if file is not None else ""
            return FileError(f"{call} failed at the file{where}: {error.strerror or text or type(error).__name__}.")
        case TypeError() if found := _OF_CALL.match(text):
            advice = f"The method {found[1]} must take the arguments of its base class."
            return InputError(f"{call} failed: {text}. {advice}")
        case TypeError() | ValueError() if _OF_ATTRS.match(text):
            return InputError(f"{call} failed{place}: {text}.")
    advice = "" if part else " If its arguments are as documented, please report this as a fault of roughcontact."
    return UnexpectedError(f"{call} failed{place}: {type(error).__name__}{because}.{advice}")


def _is_ours(cls: type) -> bool:
    return cls.__module__.partition(".")[0] == "roughcontact"


def _guard_class(cls: type) -> None:
    if issubclass(cls, enum.Enum):
        if "_missing_" not in vars(cls):
            cls._missing_ = classmethod(_refuse_member)  # type: ignore[assignment, method-assign]
        return
    for name, member in list(vars(cls).items()):
        if (name.startswith("_") and name not in _OPERATIONS) or getattr(member, "__isabstractmethod__", False):
            continue
        # A base may be a part of one public class, which users know.
        owner = vars(cls).get("_public_name", cls.__name__)
        call = owner if name == "__init__" else f"{owner}.{name}"
        if isinstance(member, types.FunctionType):
            setattr(cls, name, _guard(member, call))
        elif isinstance(member, (classmethod, staticmethod)):
            setattr(cls, name, type(member)(_guard(member.__func__, call)))
        elif isinstance(member, property) and member.fget is not None:
            setattr(cls, name, member.getter(_guard(member.fget, call)))
        elif isinstance(member, functools.cached_property):
            member.func = _guard(member.func, call)


def _refuse_member(cls: Any, value: object) -> None:
    if not _THREAD.inside:
        raise InputError.about(cls.__name__, value, " or ".join(repr(member.value) for member in cls))


def _guard(function: Callable[..., Any], call: str) -> Callable[..., Any]:
    @functools.wraps(function)
    def guard(*args: Any, **kwargs: Any) -> Any:
        if _THREAD.inside:
            return function(*args, **kwargs)
        _THREAD.inside = True
        try:
            try:
                found = function(*args, **kwargs)
                warn_of(found, args)
                return found
            except Exception as error:
                changed = _explained(error, call, function, args, kwargs)
                if changed is error:
                    raise
                raise changed from error
        except BaseException as shown:
            _forget_door(shown, shown.__cause__)
            raise
        finally:
            _THREAD.inside = False

    return guard


def _explained(error: Exception, call: str, function: Any, args: Any, kwargs: Any) -> Exception:
    """Return the error of a call: a `WrongCall` for arguments that do not fit its signature, or the translated one."""
    if function.__name__ == "__getattr__":
        # Cached properties are computed there by attrs, while a class has special names that its objects lack.
        is_computed = not args[1].startswith("_") and hasattr(type(args[0]), args[1])
        return translated(error, call.replace("__getattr__", args[1])) if is_computed else error
    changed = translated(error, call)
    is_unclear = isinstance(changed, UnexpectedError) or isinstance(error, TypeError)
    return (is_unclear and find_misfit(error, call, function, args, kwargs)) or changed


def _forget_door(*errors: BaseException | None) -> None:
    """Take the calls of this module out of the tracebacks of errors, which then show what was called."""
    for error in filter(None, errors):
        kept: list[types.TracebackType] = []
        trace = error.__traceback__
        while trace is not None:
            if trace.tb_frame.f_code.co_filename != __file__:
                kept.append(trace)
            trace = trace.tb_next
        for outer, inner in zip_longest(kept, kept[1:]):
            outer.tb_next = inner
        error.__traceback__ = kept[0] if kept else None


def _foreign_part(error: Exception) -> str:
    """Return the innermost method of a class from outside this package that an error came through, or nothing."""
    found = ""
    for frame, _ in traceback.walk_tb(error.__traceback__):
        cls = type(frame.f_locals.get("self"))
        if not _is_ours(cls) and any(map(_is_ours, cls.__mro__)):
            found = f"{cls.__name__}.{frame.f_code.co_name}"
    return found
