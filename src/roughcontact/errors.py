"""The errors that roughcontact raises, a small tree with one root."""

from __future__ import annotations

from typing import Any


class RoughContactError(Exception):
    """The root of every error raised on purpose by this package."""


class InputError(RoughContactError, ValueError):
    """What was asked for cannot be done: says what, the value got, what is allowed and what to do."""

    @classmethod
    def about(cls, what: str, got: object, allowed: str, advice: str = "") -> InputError:
        """Compose the sentence from its four parts.

        Parameters
        ----------
        what
            The quantity, in the words of the field.
        got
            The value that was given.
        allowed
            What would have been accepted.
        advice
            What to do, when that is not plain from `allowed`.
        """
        sentence = f"{what} must be {allowed}, but got {_short(got)}."
        return cls(f"{sentence} {advice}" if advice else sentence)


class MissingPackage(RoughContactError, ImportError):
    """An optional package is needed for what was asked, and is not installed."""


class NotConverged(RoughContactError, RuntimeError):
    """The solver stopped without a certified solution.

    Attributes
    ----------
    solution
        The `ContactSolution` as far as it came, its `status` and `residuals` included.
    """

    def __init__(self, message: str, solution: Any) -> None:
        super().__init__(message, solution)
        self.solution = solution

    def __str__(self) -> str:
        return str(self.args[0])


class StudyStopped(RoughContactError, RuntimeError):
    """A study could not go on; what was solved is on disk, and run again it goes on where it stopped."""


def _short(value: object, longest: int = 80) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= longest else text[: longest - 3] + "..."
