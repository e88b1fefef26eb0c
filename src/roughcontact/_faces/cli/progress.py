"""A line on the terminal that says what runs, and for how long."""

from __future__ import annotations

import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

from roughcontact._solve.solvers import Step

# Seconds after which the line is shown first, and between two of them.
_REDRAW_SECONDS = 1.0


@contextmanager
def show_progress(text: str, *, quiet: bool = False) -> Iterator[Callable[[str], None]]:
    """Show a text and the seconds since the start on standard error, if that is a terminal; the value changes the text.

    The line is drawn once a second, by a thread of its own: also while nothing reports progress.
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
    """The text, when it was started, and how many characters it takes on the terminal."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.started = time.monotonic()
        self.shown = 0

    def change(self, text: str) -> None:
        self.text = text

    def redraw(self, stream: TextIO, done: threading.Event) -> None:
        while not done.wait(_REDRAW_SECONDS):
            width = shutil.get_terminal_size().columns - 1
            shown = f"{time.monotonic() - self.started:.0f} s  {self.text}"[:width]
            stream.write(f"\r{shown:<{self.shown}}")
            stream.flush()
            self.shown = len(shown)

    def clear(self, stream: TextIO) -> None:
        if self.shown:
            stream.write(f"\r{'':{self.shown}}\r")
            stream.flush()


def describe_steps(change: Callable[[str], None], what: str = "solving") -> Callable[[Step], None]:
    """Return a function for `on_step=` that shows the grid, the iteration and how far the error has fallen."""

    def on_step(step: Step) -> None:
        nx, ny = step.shape
        change(f"{what}: {nx} x {ny} cells, iteration {step.iteration}, error {step.error:.0e}")

    return on_step
