"""The errors that roughcontact raises, a small tree with one root."""

from __future__ import annotations

import contextlib
import difflib
import re
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from roughcontact.errors.sentence import Argument as Argument
from roughcontact.errors.sentence import Sentence as Sentence
from roughcontact.errors.sentence import Spell as Spell
from roughcontact.errors.sentence import argument as argument
from roughcontact.errors.sentence import either as either
from roughcontact.errors.sentence import write_number as write_number

# Characters of a value that a message repeats.
_MAX_VALUE_CHARACTERS = 80
# Characters of known names that a sentence has, and how many of more names it has.
_MAX_NAMES_CHARACTERS = 400
_NEAREST_NAMES = 8
# A word longer than any path in a message, and the maximum length of a message, characters.
_LONG_WORD = re.compile(r"\S{500,}")
_MAX_SENTENCE_CHARACTERS = 4000


class RoughContactError(Exception):
    """The root of every error raised on purpose by this package.

    Examples
    --------
    >>> import roughcontact as rc
    >>> issubclass(rc.InputError, rc.RoughContactError)
    True
    """

    def __str__(self) -> str:
        return _shorten_words(super().__str__())


class InputError(RoughContactError, ValueError):
    """Bad input: the sentence says which value, what was given, what is allowed and what to do.

    Examples
    --------
    >>> import roughcontact as rc
    >>> try:
    ...     rc.Elastic(young=-1.0, poisson=0.3)
    ... except rc.InputError as error:
    ...     print(error)
    Young's modulus must be a finite number, above 0 (Pa), but got -1.0.
    """

    def __init__(self, sentence: str = "", **others: Any) -> None:
        super().__init__(Sentence(sentence), **others)

    @property
    def marked(self) -> str:
        """The sentence with the marks of its arguments, for another sentence that repeats it."""
        first = self.args[0] if self.args else ""
        return first.marked if isinstance(first, Sentence) else str(self)

    def spell(self, spell: Spell, *, scripts: bool = False) -> str:
        """Return the sentence as a face says it; see `Sentence.spell`."""
        return _shorten_words(Sentence(self.marked).spell(spell, scripts=scripts))

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
        sentence = f"{what} must be {allowed}, but got {short(got)}."
        return cls(f"{sentence} {advice}" if advice else sentence)

    @classmethod
    def unknown(cls, kind: str, name: object, known: Iterable[str], listed: str = "") -> InputError:
        """Compose the sentence for a name that is not known, with those that may be meant.

        Parameters
        ----------
        kind
            What the names are of.
        name
            The name that was given.
        known
            The names that there are.
        listed
            What lists all names, where they are too many for a sentence.
        """
        return cls(f"There is no {kind} named {short(name)}.{name_known(name, known, listed)}")


def name_known(name: object, known: Iterable[str], listed: str = "") -> str:
    """Return what a sentence says of the names that there are, behind that one is not known; it begins with a blank.

    Those that may be meant come first: names of which it is a word, or the closest one. Of names that are too many for
    a sentence only the closest are said, and `listed`, which lists all.
    """
    names = sorted(known)
    word = str(name)[:_MAX_VALUE_CHARACTERS].lower()
    meant = [one for one in names if word in re.split(r"[\W_]+", one.lower())]
    meant = meant or difflib.get_close_matches(word, names, n=1, cutoff=0.5)
    *others, last = map(repr, meant or [""])
    guess = f" Did you mean {', '.join(others)}{' or ' if others else ''}{last}?" if meant else ""
    text = ", ".join(names) or "none"
    if len(text) > _MAX_NAMES_CHARACTERS:
        nearest = difflib.get_close_matches(word, names, n=_NEAREST_NAMES, cutoff=0.0)
        text = f"{', '.join(nearest)} and {len(names) - len(nearest)} others{listed and f' ({listed} lists them)'}"
    return f"{guess} Known: {text}."


class ContactWarning(UserWarning):
    """Why an answer or a contact must not be trusted, given by `warnings.warn` to a script that asks for the answer.

    The same sentences are in the ``warnings`` of the answer and of the solution, and are given once for each solution.
    Filters of Python choose what happens: ``warnings.filterwarnings("ignore", category=rc.ContactWarning)`` is silent,
    ``"error"`` in its place raises.

    Examples
    --------
    >>> import warnings
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> solution = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6)).solve(force=60.0)
    >>> with warnings.catch_warnings(record=True, action="always") as given:
    ...     area = solution.area()
    >>> any(one.category is rc.ContactWarning for one in given)
    True
    """


class NotEnoughMemory(InputError):
    """A request needs more memory than there is; `available` states in words how much there is."""

    available = ""


class NoSuchItem(InputError, IndexError):
    """There is no item at this position of a sequence."""


class NoSuchField(InputError, AttributeError):
    """The result was computed without what this field describes."""


class WrongCall(InputError, TypeError):
    """Arguments of a call are missing, unknown, misplaced or of a wrong type."""


class MissingPackage(RoughContactError, ImportError):
    """An optional package is needed and is not installed; the message says how to install it.

    Examples
    --------
    >>> import roughcontact as rc
    >>> try:
    ...     figure = rc.examples.ball().plot()
    ... except rc.MissingPackage as error:
    ...     print(error)
    >>> issubclass(rc.MissingPackage, ImportError)
    True
    """


@contextlib.contextmanager
def requiring(advice: str) -> Iterator[None]:
    """Raise `MissingPackage` with this advice if a package that is imported in the context is not installed."""
    try:
        yield
    except ImportError:
        raise MissingPackage(advice) from None


class FileError(RoughContactError, OSError):
    """A file or folder could not be read or written.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> solution = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6)).solve(force=1.0)
    >>> try:
    ...     solution.save("/dev/null/solution.npz")
    ... except (rc.FileError, rc.InputError):
    ...     print("not written")
    not written
    """


class NotWritten(FileError):
    """A file could not be written; a former file of this name is unchanged."""

    def __str__(self) -> str:
        return _shorten_words(f"The file {self.filename!r} cannot be written: {self.strerror}.")


class NotConverged(RoughContactError, RuntimeError):
    """The solver stopped without a certified solution.

    Attributes
    ----------
    reason
        What did not converge.
    solution
        The unfinished `ContactSolution`, with its `status` and `residuals`.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> solver = rc.PolonskyKeer(max_iterations=1)
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), solver=solver)
    >>> try:
    ...     problem.solve(force=1.0)
    ... except rc.NotConverged as error:
    ...     print(error.solution.iterations)
    1
    """

    def __init__(self, reason: str, solution: Any) -> None:
        super().__init__(reason, solution)
        self.reason = _shorten_words(reason)
        self.solution = solution

    def __str__(self) -> str:
        return f"{self.reason} The solution reached is in .solution of this error; solve(..., throw=False) returns it."


class StudyStopped(RoughContactError, RuntimeError):
    """A study could not continue; its solutions are on disk, and the study, run again, continues from them.

    Examples
    --------
    >>> import roughcontact as rc
    >>> def run_again(study, folder):
    ...     try:
    ...         return study.run(folder)
    ...     except rc.StudyStopped:
    ...         return study.run(folder)
    >>> issubclass(rc.StudyStopped, RuntimeError)
    True
    """


class OutOfMemory(RoughContactError, MemoryError):
    """The system has refused the memory for a computation.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class Huge(rc.FlatSurface):
    ...     def heights(self, grid):
    ...         raise MemoryError
    >>> body = rc.Body(Huge(), rc.Elastic(1e9, 0.3))
    >>> try:
    ...     rc.ContactProblem(body, grid=rc.Grid((8, 8), 1e-3))
    ... except rc.OutOfMemory as error:
    ...     print(type(error.__cause__).__name__)
    MemoryError
    """


class UnexpectedError(RoughContactError, RuntimeError):
    """A call failed in an unforeseen way; its `__cause__` is the original error.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class Broken(rc.FlatSurface):
    ...     def heights(self, grid):
    ...         raise ZeroDivisionError
    >>> body = rc.Body(Broken(), rc.Elastic(1e9, 0.3))
    >>> try:
    ...     rc.ContactProblem(body, grid=rc.Grid((8, 8), 1e-3))
    ... except rc.UnexpectedError as error:
    ...     print(type(error.__cause__).__name__)
    ZeroDivisionError
    """


def short(value: object) -> str:
    """Return a short text for a value in a message."""
    if isinstance(value, (np.ndarray, np.dtype)):
        return f"an array of shape {getattr(value, 'shape', '?')} and type {getattr(value, 'dtype', '?')}"
    if isinstance(value, np.generic):
        # Without the name of its type.
        value = value.item()
    try:
        text = " ".join(repr(value).split())
    # The repr of a user's class may fail.
    except Exception:
        text = f"a {type(value).__name__}"
    is_own = type(value).__module__ != "builtins" and len(text) > _MAX_VALUE_CHARACTERS
    return f"a {type(value).__name__}" if is_own or "array(" in text else shorten(text, _MAX_VALUE_CHARACTERS)


def message_of(error: Exception) -> str:
    """Return the text of an error in one line; empty if its class fails to describe it."""
    # The validators of attrs, which is imported later, give more than a text.
    is_of_attrs = len(error.args) > 1 and type(error.args[1]).__name__ == "Attribute"
    try:
        return " ".join(str(error.args[0] if is_of_attrs else error).split())
    # An exception class of the caller's.
    except Exception:
        return ""


def _shorten_words(text: str) -> str:
    """Return a message with long words, and the whole, shortened."""
    return shorten(
        _LONG_WORD.sub(lambda found: shorten(found[0], _MAX_VALUE_CHARACTERS), text), _MAX_SENTENCE_CHARACTERS
    )


def shorten(text: str, longest: int) -> str:
    """Return a text, cut to at most `longest` characters."""
    return text if len(text) <= longest else text[: longest - 3] + "..."
