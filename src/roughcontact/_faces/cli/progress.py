"""A line on the terminal that says what runs, for how long, and how long it will still take."""

from __future__ import annotations

import math
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol, TextIO

from roughcontact._solve.solvers import Step

# Seconds after which the line is shown first, and between two of them.
_REDRAW_SECONDS = 1.0
# Seconds at the start whose work says nothing about the rest: what is found in a folder, for instance.
_FIRST_SECONDS = 0.5
# Smallest fraction of the work from which the rest is estimated.
_MIN_FRACTION = 0.02
# Seconds from which on the time left is stated in minutes.
_MIN_MINUTES = 100.0


class ChangeProgress(Protocol):
    """Show another text, and the fraction of all work that is done; None where it is not known."""

    def __call__(self, text: str, done: float | None = None) -> None: ...


@contextmanager
def show_progress(text: str, *, quiet: bool = False) -> Iterator[ChangeProgress]:
    """Show a text, the seconds since the start and the time left on standard error, if that is a terminal.

    The value changes the text. The line is drawn once a second, by a thread of its own: also while nothing reports
    progress.
    """
    stream = sys.stderr
    line = _Line(text)
    if quiet or not stream.isatty():
        yield line.change
        return
    done = threading.Event()
    thread = threading.Thread(target=line.redraw, args=(stream, done), daemon=True)
    thread.start()
    try:
        yield line.change
    finally:
        done.set()
        thread.join()
        line.clear(stream)


class _Line:
    """The text, when it was started, how far it has come, and how many characters it takes on the terminal."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.started = time.monotonic()
        self.shown = 0
        # When the work began to tell the time left, and its fraction then; the end that was estimated last.
        self._base = (self.started, 0.0)
        self._end = math.nan

    def change(self, text: str, done: float | None = None) -> None:
        self.text = text
        now = time.monotonic()
        if done is None:
            self._end = math.nan
        elif now - self.started < _FIRST_SECONDS:
            self._base = (now, done)
        elif done - self._base[1] >= _MIN_FRACTION:
            begun, before = self._base
            self._end = begun + (now - begun) * (1.0 - before) / (done - before)

    def redraw(self, stream: TextIO, done: threading.Event) -> None:
        while not done.wait(_REDRAW_SECONDS):
            width = shutil.get_terminal_size().columns - 1
            now = time.monotonic()
            shown = f"{now - self.started:.0f} s{_write_left(self._end - now)}  {self.text}"[:width]
            stream.write(f"\r{shown:<{self.shown}}")
            stream.flush()
            self.shown = len(shown)

    def clear(self, stream: TextIO) -> None:
        if self.shown:
            stream.write(f"\r{'':{self.shown}}\r")
            stream.flush()


def _write_left(seconds: float) -> str:
    """Return the time left in words; empty where it is not known, or nothing is left of it."""
    if not seconds >= 1.0:
        return ""
    return f", about {seconds:.0f} s left" if seconds < _MIN_MINUTES else f", about {seconds / 60.0:.0f} min left"


def count_done(change: ChangeProgress, total: int, what: str) -> Callable[[object], None]:
    """Return a function that counts what it is called with, such as the states of a cycle."""
    found = 0
    change(f"{what} 1 of {total}", 0.0)

    def count(_: object) -> None:
        nonlocal found
        found += 1
        change(f"{what} {min(found + 1, total)} of {total}", found / total)

    return count


def describe_steps(
    change: ChangeProgress, what: str, find_fraction: Callable[[Step], float | None]
) -> Callable[[Step], None]:
    """Return a function for `on_step=` that shows the grid, the iteration and how far the error has fallen.

    `find_fraction` gives the fraction of all work that is done after a step; None if it is not known.
    """

    def on_step(step: Step) -> None:
        nx, ny = step.shape
        text = f"{what}: {nx} x {ny} cells, iteration {step.iteration}, error {step.error:.0e}"
        change(text, find_fraction(step))

    return on_step


def count_solves(
    shape: tuple[int, int], tolerance: float, part: tuple[int, int] = (0, 1)
) -> Callable[[Step], float | None]:
    """Return a function for `describe_steps`, of solves on one grid: the number of the solve, from zero, and of all."""
    first, count = part
    return lambda step: (first + step.fraction(shape, tolerance)) / count


def count_grids(
    shape: tuple[int, int], tolerance: float, doublings: int | None, *, refined: bool = True
) -> Callable[[Step], float | None]:
    """Return a function for `describe_steps`, of solves on ever finer grids, the first of `shape`: work is by cells.

    `doublings` of the cells along a side are to come; if None, each grid may be the last one, as it should be by what
    the grids before have shown: for the first of those that are `refined` nothing is known.
    """
    current = shape
    done = 0
    total = math.prod(shape) * sum(1 << 2 * level for level in range((doublings or 0) + 1))

    def find_fraction(step: Step) -> float | None:
        nonlocal current, done, total
        if math.prod(step.shape) > math.prod(current):
            done += math.prod(current)
            current = step.shape
            if doublings is None:
                total = done + math.prod(current)
        if doublings is None and refined and done == 0:
            return None
        return (done + math.prod(current) * step.fraction(current, tolerance)) / total

    return find_fraction
