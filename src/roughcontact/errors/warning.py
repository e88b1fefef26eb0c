"""Warnings: each points to the user's line; those of an answer are given when a script asks for it."""

from __future__ import annotations

import abc
import contextlib
import sys
import threading
import traceback
import types
import warnings
from collections.abc import Iterator
from typing import Any

from roughcontact.errors import ContactWarning


class _Thread(threading.local):
    """Whether the caller in a thread says the warnings of answers itself."""

    says_warnings = False


_THREAD = _Thread()


class Answer:
    """A base of answers, whose `warnings` a script gets by `warnings.warn` when it asks for one."""

    __slots__ = ()


class AskedOf(abc.ABC):
    """A base of solutions, whose own `warnings` a script gets by `warnings.warn` with the first answer."""

    __slots__ = ()

    @abc.abstractmethod
    def _is_first_answer(self) -> bool:
        """Return whether no answer was given before this one."""


def warn(text: str, category: type[Warning] = UserWarning) -> None:
    """Give a warning that points to the line from which this package was called."""
    frames = enumerate(traceback.walk_stack(sys._getframe(1)), start=2)
    level = next((level for level, (frame, _) in frames if not _is_inside(frame)), 1)
    warnings.warn(text, category, stacklevel=level)


@contextlib.contextmanager
def saying_warnings() -> Iterator[None]:
    """Give no warnings of answers in this thread: it says them itself, as the command line does."""
    before = _THREAD.says_warnings
    _THREAD.says_warnings = True
    try:
        yield
    finally:
        _THREAD.says_warnings = before


def warn_of(found: object, args: tuple[Any, ...]) -> None:
    """Give the warnings of an answer, and those of the solution that was asked for it if they are not given yet."""
    if _THREAD.says_warnings or not isinstance(found, Answer):
        return
    texts = dict.fromkeys(getattr(found, "warnings", ()))
    if args and isinstance(args[0], AskedOf) and args[0]._is_first_answer():
        texts = dict.fromkeys(getattr(args[0], "warnings", ())) | texts
    for text in texts:
        warn(str(text), ContactWarning)


def _is_inside(frame: types.FrameType) -> bool:
    """Return whether a frame is of this package, or of what stands between two of its calls."""
    return frame.f_globals.get("__name__", "").partition(".")[0] in ("roughcontact", "functools", "attr")
