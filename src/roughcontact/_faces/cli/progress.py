"""What the command line says of the work that runs, on a terminal."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from roughcontact._base.machine.progress import ChangeProgress, has_tqdm
from roughcontact._base.machine.progress import show_progress as show_bar
from roughcontact._solve.solvers import Step


@contextmanager
def show_progress(text: str, *, quiet: bool = False) -> Iterator[ChangeProgress]:
    """Show what runs on standard error, if that is a terminal and tqdm is installed; the value changes the text."""
    with show_bar(text, shown=not quiet and sys.stderr.isatty() and has_tqdm()) as change:
        yield change


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
