"""The door: every error that a public call meets becomes a `RoughContactError`, in one place."""

from __future__ import annotations

import builtins
import collections.abc
import contextlib
import difflib
import enum
import functools
import inspect
import numbers
import re
import sys
import threading
import types
import typing
import warnings
import weakref
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import numpy as np

from roughcontact.errors import (
    ContactWarning,
    FileError,
    InputError,
    MissingPackage,
    OutOfMemory,
    RoughContactError,
    UnexpectedError,
    WrongCall,
    short,
    shorten,
)

T = TypeVar("T")
# Size of a number whose square and its inverse float64 holds.
_MIN_SQUARED = 1e-150
# Characters of another package's message that a sentence repeats.
_MESSAGE = 240


class _Thread(threading.local):
    """Whether a thread is inside a public call, and whether its caller says the warnings of answers itself."""

    inside = False
    says_warnings = False


_THREAD = _Thread()
# The special methods that are public operations; the others belong to Python.
_OPERATIONS = (
    "__init__",
    "__str__",
    "__repr__",
    "__add__",
    "__getitem__",
    "__iter__",
    "__len__",
    "__contains__",
    "__call__",
    "__getattr__",
)
_GUARDED: set[type] = set()
# The solutions whose own warnings have been given.
_WARNED: weakref.WeakSet[Any] = weakref.WeakSet()


def guarded(public: T) -> T:
    """Return a public function or class, every call of which ends in a result or in a `RoughContactError`.

    The outermost call translates what it meets. Inside it nothing changes, so that this package sees all errors as they
    are, and the errors of a user's callback pass (see `outside`). A class is changed in place.
    """
    value: Any = public
    if isinstance(public, type):
        for cls in (*public.__mro__, *_descendants(public)):
            if cls.__module__.partition(".")[0] == "roughcontact" and cls not in _GUARDED:
                _GUARDED.add(cls)
                _guard_class(cls)
        return public
    return typing.cast(T, _guard_function(value, value.__name__))


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
    text = shorten(_message(error).rstrip("."), _MESSAGE)
    reason = f"{type(error).__name__}: {text}" if text else type(error).__name__
    if isinstance(error, MemoryError):
        return OutOfMemory(f"{call} needs more memory than there is{': ' if text else ''}{text}.")
    if isinstance(error, ModuleNotFoundError) and error.name:
        return MissingPackage(f"{call} needs the package {error.name}, which is not installed.")
    if isinstance(error, OSError):
        where = f" {short(error.filename)}" if error.filename is not None else ""
        return FileError(f"{call} failed at the file{where}: {error.strerror or text or type(error).__name__}.")
    if isinstance(error, TypeError) and (method := re.match(r"([\w.<>]+)\(\) (takes|missing|got) ", text)):
        return InputError(f"{call} failed: {text}. The method {method[1]} must take the arguments of its base class.")
    if isinstance(error, ValueError) and _comes_from_attrs(error):
        return InputError(f"{call} failed: {text}.")
    if part := _foreign_part(error):
        return UnexpectedError(f"{call} failed in {part}: {reason}.")
    advice = "If its arguments are as documented, please report this as a fault of roughcontact."
    return UnexpectedError(f"{call} failed: {reason}. {advice}")


def warn(text: str, category: type[Warning] = UserWarning) -> None:
    """Give a warning that points to the line from which this package was called."""
    frame: types.FrameType | None = sys._getframe(1)
    level = 2
    while frame is not None and _is_inside(frame):
        frame = frame.f_back
        level += 1
    warnings.warn(text, category, stacklevel=level)


class Answer:
    """A base of answers, whose `warnings` a script gets by `warnings.warn` when it asks for one."""

    __slots__ = ()


class AskedOf:
    """A base of solutions, whose own `warnings` a script gets by `warnings.warn` with the first answer."""

    __slots__ = ()


@contextlib.contextmanager
def saying_warnings() -> Iterator[None]:
    """Give no warnings of answers in this thread: it says them itself, as the command line does."""
    before = _THREAD.says_warnings
    _THREAD.says_warnings = True
    try:
        yield
    finally:
        _THREAD.says_warnings = before


def _warn_of(found: object, args: tuple[Any, ...]) -> None:
    """Give the warnings of an answer, and those of the solution that was asked for it if they are not given yet."""
    if _THREAD.says_warnings or not isinstance(found, Answer):
        return
    texts = dict.fromkeys(getattr(found, "warnings", ()))
    if args and isinstance(args[0], AskedOf) and args[0] not in _WARNED:
        _WARNED.add(args[0])
        texts = dict.fromkeys(getattr(args[0], "warnings", ())) | texts
    for text in texts:
        warn(str(text), ContactWarning)


def _is_inside(frame: types.FrameType) -> bool:
    """Return whether a frame is of this package, or of what stands between two of its calls."""
    return frame.f_globals.get("__name__", "").partition(".")[0] in ("roughcontact", "functools", "attr")


def _message(error: Exception) -> str:
    try:
        return " ".join(str(error).split())
    # An exception class of the caller's may fail to describe itself.
    except Exception:
        return ""


def _descendants(cls: type) -> Iterator[type]:
    found: list[type] = cls.__subclasses__()
    for derived in found:
        yield from (derived, *_descendants(derived))


def _guard_class(cls: type) -> None:
    if issubclass(cls, enum.Enum):
        if "_missing_" not in vars(cls):
            cls._missing_ = classmethod(_refuse_member)  # type: ignore[assignment, method-assign]
        return
    for name, member in list(vars(cls).items()):
        if (name.startswith("_") and name not in _OPERATIONS) or getattr(member, "__isabstractmethod__", False):
            continue
        call = cls.__name__ if name == "__init__" else f"{cls.__name__}.{name}"
        if isinstance(member, types.FunctionType):
            setattr(cls, name, _guard_function(member, call))
        elif isinstance(member, (classmethod, staticmethod)):
            setattr(cls, name, type(member)(_guard_function(member.__func__, call)))
        elif isinstance(member, property) and member.fget is not None:
            setattr(cls, name, member.getter(_guard_function(member.fget, call)))
        elif isinstance(member, functools.cached_property):
            member.func = _guard_function(member.func, call)


def _refuse_member(cls: Any, value: object) -> None:
    if not _THREAD.inside:
        raise InputError.about(cls.__name__, value, " or ".join(repr(member.value) for member in cls))


def _guard_function(function: Callable[..., Any], call: str) -> Callable[..., Any]:
    if inspect.isgeneratorfunction(function):
        return _guard_generator(function, call)

    @functools.wraps(function)
    def guard(*args: Any, **kwargs: Any) -> Any:
        if _THREAD.inside:
            return function(*args, **kwargs)
        _THREAD.inside = True
        try:
            found = function(*args, **kwargs)
            _warn_of(found, args)
            return found
        except Exception as error:
            if isinstance(error, AttributeError) and function.__name__ == "__getattr__":
                raise
            changed = _explained(error, call, function, args, kwargs)
            if changed is error:
                raise
            raise changed from error
        finally:
            _THREAD.inside = False

    return guard


def _guard_generator(function: Callable[..., Iterator[Any]], call: str) -> Callable[..., Iterator[Any]]:
    @functools.wraps(function)
    def guard(*args: Any, **kwargs: Any) -> Iterator[Any]:
        try:
            yield from function(*args, **kwargs)
        except Exception as error:
            changed = _explained(error, call, function, args, kwargs)
            if changed is error:
                raise
            raise changed from error

    return guard


def _explained(error: Exception, call: str, function: Any, args: Any, kwargs: Any) -> Exception:
    """Return the error of a call: a `WrongCall` for arguments that do not fit its signature, or the translated one."""
    changed = translated(error, call)
    if not isinstance(changed, UnexpectedError) and not isinstance(error, TypeError):
        return changed
    signature = inspect.signature(function)
    try:
        given = signature.bind(*args, **kwargs).arguments
    except TypeError as wrong:
        guess = _guess(signature, kwargs)
        sentence = f"{call}({', '.join(_names(signature))}): {wrong}.{guess}"
        return _misplaced(call, signature, args) or WrongCall(sentence)
    hints = typing.get_type_hints(function, {}, _Names(vars(sys.modules[function.__module__])))
    for name, value in given.items():
        if name in hints and not _is_a(value, hints[name]):
            kind = signature.parameters[name].annotation
            return WrongCall.about(f"{name}= of {call}", value, f"of type {getattr(kind, '__name__', kind)}")
    return _misfit(error, call, given) or changed


class _Names(dict[str, Any]):
    """The names of a module, and those that it imports for annotations alone: public ones, or else any type."""

    def __missing__(self, name: str) -> Any:
        package = sys.modules["roughcontact"]
        found = (getattr(place, name, None) for place in (builtins, package, package.typing))
        return next((one for one in found if one is not None), Any)


def _names(signature: inspect.Signature) -> list[str]:
    return [name for name in signature.parameters if name not in ("self", "cls")]


def _guess(signature: inspect.Signature, given: dict[str, Any]) -> str:
    """Return which name of a parameter is meant by the first that is none; empty if none is near."""
    unknown = [name for name in given if name not in signature.parameters]
    close = difflib.get_close_matches(unknown[0], _names(signature), n=1, cutoff=0.6) if unknown else []
    return f" Did you mean {close[0]}=?" if close else ""


def _misplaced(call: str, signature: inspect.Signature, args: Any) -> WrongCall | None:
    """Return the error of an argument that must be given by name, but is not; None if there is none."""
    kinds = {name: one.kind for name, one in signature.parameters.items()}
    named = [name for name, kind in kinds.items() if kind is inspect.Parameter.KEYWORD_ONLY]
    places = sum(
        kind in (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD) for kind in kinds.values()
    )
    if not named or len(args) <= places:
        return None
    value = short(args[places])
    others = f", or {', '.join(f'{name}=' for name in named[1:])}" if named[1:] else ""
    return WrongCall(f"{call} takes what was given as {value} by name: write {named[0]}={value}{others}.")


def _misfit(error: Exception, call: str, given: dict[str, Any]) -> InputError | None:
    """Return the error of an argument that lacks what the call needs, or whose value does not fit; None otherwise."""
    if isinstance(error, ArithmeticError):
        extreme = [f"{name}={short(value)}" for name, value in given.items() if _is_extreme(value)]
        if extreme:
            return InputError(f"{call} cannot be computed for {', '.join(extreme)}: {_message(error)}.")
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


def _is_a(value: object, hint: Any) -> bool:
    """Return whether a value may stand where a type is asked for."""
    kind = typing.get_origin(hint) or hint
    of = typing.get_args(hint)
    if kind in (typing.Union, types.UnionType):
        return any(_is_a(value, one) for one in of)
    if kind in (float, int):
        number = numbers.Real if kind is float else numbers.Integral
        return isinstance(value, number) and not isinstance(value, bool)
    if kind is collections.abc.Callable:
        return callable(value)
    if kind is np.ndarray:
        try:
            return isinstance(value, (kind, list, tuple)) and np.asarray(value).dtype.kind in "biuf"
        except ValueError:
            return False
    if kind in (collections.abc.Sequence, collections.abc.Iterable, tuple) and of:
        no_list = isinstance(value, (str, bytes, collections.abc.Mapping)) or not hasattr(value, "__iter__")
        if no_list or not isinstance(value, (list, tuple, np.ndarray)):
            return not no_list
        fits = getattr(value, "ndim", 1) > 0 and (kind is not tuple or of[-1] is Ellipsis or len(value) == len(of))
        return fits and all(_is_a(item, of[0]) for item in value)
    # Any is a class from Python 3.11 on.
    return kind is Any or not isinstance(kind, type) or isinstance(value, kind)


def _comes_from_attrs(error: Exception) -> bool:
    """Return whether a validator of attrs raised an error, as those of plug-ins do."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace is not None and trace.tb_frame.f_globals.get("__name__", "").partition(".")[0] == "attr"


def _foreign_part(error: Exception) -> str:
    """Return the innermost method of a class from outside this package that an error came through, or nothing."""
    found = ""
    trace = error.__traceback__
    while trace is not None:
        cls = type(trace.tb_frame.f_locals.get("self"))
        is_ours = cls.__module__.partition(".")[0] == "roughcontact"
        if not is_ours and any(base in _GUARDED for base in cls.__mro__):
            found = f"{cls.__name__}.{trace.tb_frame.f_code.co_name}"
        trace = trace.tb_next
    return found
