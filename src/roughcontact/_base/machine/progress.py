"""Progress on standard error: what runs, how far it has come and how long it will still take (tqdm)."""

from __future__ import annotations

import shutil
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol

from roughcontact.errors import MissingPackage, requiring

# What runs comes last, since a narrow terminal cuts it. Without a fraction of the work nothing is drawn.
_WITH_FRACTION = "{percentage:3.0f} % |{bar:10}| {elapsed} < {remaining}  {desc}"
_WITHOUT_FRACTION = "{elapsed}  {desc}"


class ChangeProgress(Protocol):
    """Show another text, and the fraction of all work that is done; None where it is not known."""

    def __call__(self, text: str, done: float | None = None) -> None: ...


@contextmanager
def show_progress(text: str, *, shown: bool = True) -> Iterator[ChangeProgress]:
    """Show a text and the time since the start on standard error; the value changes the text.

    Raises
    ------
    MissingPackage
        If it is to be shown, and tqdm is not installed.
    """
    if not shown:
        yield _show_nothing
        return
    make_bar = _import_tqdm()
    # tqdm shows nothing on a terminal that does not know its size.
    columns, lines = shutil.get_terminal_size()
    shape = {"ncols": columns - 1, "nrows": lines}
    with make_bar(desc=text, file=sys.stderr, bar_format=_WITHOUT_FRACTION, leave=False, miniters=0, **shape) as bar:

        def change(text: str, done: float | None = None) -> None:
            bar.set_description_str(text, refresh=False)
            bar.bar_format = _WITHOUT_FRACTION if done is None else _WITH_FRACTION
            bar.total = None if done is None else 1.0
            bar.n = 0.0 if done is None else min(done, 1.0)
            bar.update(0)

        yield change


def count_done(change: ChangeProgress, total: int, what: str) -> Callable[[object], None]:
    """Return a function that counts what it is called with, such as the states of a cycle."""
    found = 0
    change(f"{what} 1 of {total}", 0.0)

    def count(_: object) -> None:
        nonlocal found
        found += 1
        change(f"{what} {min(found + 1, total)} of {total}", found / total)

    return count


def tell_both(first: Callable[..., object] | None, second: Callable[..., object]) -> Callable[..., None]:
    """Return a function that calls two with its arguments: a callback of the caller, if there is one, and progress."""

    def tell(*arguments: Any) -> None:
        if first is not None:
            first(*arguments)
        second(*arguments)

    return tell


def has_tqdm() -> bool:
    """Return whether progress can be shown."""
    try:
        _import_tqdm()
    except MissingPackage:
        return False
    return True


def _import_tqdm() -> Any:
    advice = "Progress needs the package tqdm: pip install 'roughcontact[progress]'."
    # In a notebook without ipywidgets it warns, and shows text.
    with requiring(advice), warnings.catch_warnings(action="ignore"):
        from tqdm.auto import tqdm
    return tqdm


def _show_nothing(text: str, done: float | None = None) -> None:
    """Show nothing."""
