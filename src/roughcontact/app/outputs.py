"""The files of a run: the table, the solutions, the pictures in light and dark, the report."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import attrs

from roughcontact._problem.sweep import Sweep
from roughcontact._solution import ContactSolution
from roughcontact.app.answers import make_table
from roughcontact.archive import replacing
from roughcontact.errors import MissingPackage, RoughContactError
from roughcontact.grid import Grid
from roughcontact.panel import panels

# Dots per inch of a picture, at first and at most: a cell of a large grid is then about a dot, of a few inches of axes.
_COARSEST, _FINEST, _INCHES = 130, 400, 4.0
# The panels that come first; others follow in the order of their names.
_FIRST = {"solution": ("pressure", "gap", "heights", "patches"), "sweep": ("area-load", "load-approach")}
_SCHEMES = {"light": False, "dark": True}


@attrs.frozen(eq=False)
class Outputs:
    """What is written of a run, in the order in which people want it.

    Attributes
    ----------
    sweep
        The solutions.
    answers
        Their answers; see `describe_solution`.
    folder
        Where the files are written.
    """

    sweep: Sweep
    answers: list[dict[str, Any]]
    folder: Path

    def steps(self) -> Iterator[Callable[[], dict[str, Any]]]:
        """Yield functions that write a file and return what the page is to know of it."""
        solutions = self.sweep.solutions
        main = max(range(len(solutions)), key=lambda index: solutions[index].force)
        yield self._write_table
        for index in range(len(solutions)):
            yield partial(self._write_solution, index)
        if len(solutions) > 1:
            for name in _panels_of("sweep"):
                yield partial(self._draw, self.sweep, name, solutions[0].grid)
        for name in _panels_of("solution"):
            yield partial(self._draw, solutions[main], name, solutions[main].grid)
        for index in range(len(solutions)):
            yield partial(self._write_report, index)

    def _write_table(self) -> dict[str, Any]:
        with replacing(self.folder / "answers.csv") as partial_file:
            # The mark at the start lets spreadsheets read the micro signs.
            partial_file.write_text(make_table(self.answers), encoding="utf-8-sig", newline="")
        return {"file": "answers.csv", "role": "table"}

    def _write_solution(self, index: int) -> dict[str, Any]:
        name = f"solution-{index + 1}.npz"
        self.sweep.solutions[index].save(self.folder / name)
        return {"file": name, "role": "solution", "load": index}

    def _write_report(self, index: int) -> dict[str, Any]:
        name = f"report-{index + 1}.html"
        self.sweep.solutions[index].to_html(self.folder / name)
        return {"file": name, "role": "report", "load": index}

    def _draw(self, subject: Sweep | ContactSolution, name: str, grid: Grid) -> dict[str, Any]:
        return draw_panel(lambda dark: subject.plot(name, dark=dark), name, grid, self.folder)


def draw_panel(draw: Callable[[bool], Any], name: str, grid: Grid, folder: Path) -> dict[str, Any]:
    """Draw a panel in light and in dark; return the names of the files.

    Parameters
    ----------
    draw
        Returns matplotlib's axes of the panel, given whether the background is dark.
    name
        The name of the panel.
    grid
        The cells, which the sharpness follows from.
    folder
        Where the files are written.

    Raises
    ------
    MissingPackage
        If matplotlib is not installed.
    InputError
        If there is nothing to draw.
    """
    try:
        from matplotlib import pyplot
    except ImportError:
        raise MissingPackage("Pictures need matplotlib: pip install 'roughcontact[plot]'.") from None
    dpi = min(max(_COARSEST, max(grid.shape) / _INCHES), _FINEST)
    files = {}
    for scheme, dark in _SCHEMES.items():
        files[scheme] = f"{name}-{scheme}.png"
        axes = draw(dark)
        try:
            with replacing(folder / files[scheme]) as partial_file:
                axes.figure.savefig(partial_file, dpi=dpi, format="png")
        finally:
            pyplot.close(axes.figure)
    return {"role": "picture", "panel": name, "pictures": files}


def _panels_of(subject: str) -> list[str]:
    found = []
    for name in panels:
        # A broken plug-in must not keep the others from being drawn.
        with contextlib.suppress(RoughContactError):
            if panels.create(name).subject == subject:
                found.append(name)
    first = [name for name in _FIRST[subject] if name in found]
    return first + [name for name in found if name not in first]
