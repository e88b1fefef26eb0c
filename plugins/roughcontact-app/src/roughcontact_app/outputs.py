"""The files of a run: the table, the solutions, the pictures, the report."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from roughcontact import ContactSolution, FrictionalPath
from roughcontact.errors import RoughContactError
from roughcontact.faces import tabulate_answers, write_report
from roughcontact.plotting import panels
from roughcontact.results import AdhesionCycle, InterfaceLaw, LawColumn, Sweep
from roughcontact.typing import replacing

from roughcontact_app.answers import make_table, tabulate_path

# Dots beside those of a figure: a picture, 430 dots wide, is shown 750 pixels wide.
_SHARPNESS = 3
# The panels that come first; others follow in the order of their names.
_FIRST = {"solution": ("pressure", "gap", "heights", "patches"), "sweep": ("area-load", "load-approach")}


@attrs.frozen(eq=False)
class Outputs:
    """What is written of a run, in the order in which people want it.

    Attributes
    ----------
    sweep
        The solutions.
    asked
        What responses have answered, one for each solution, by their names.
    answers
        All answers; see `describe_solutions`.
    folder
        Where the files are written.
    dark
        Whether pictures are for a dark page.
    """

    sweep: Sweep
    asked: Mapping[str, Sequence[Any]]
    answers: list[dict[str, Any]]
    folder: Path
    dark: bool

    def steps(self) -> Iterator[Callable[[], dict[str, Any]]]:
        """Yield functions that write a file and return what the page is to know of it."""
        solutions = self.sweep.states
        largest = max(solutions, key=lambda solution: solution.force)
        yield self._write_table
        for index in range(len(solutions)):
            yield partial(self._write_solution, index)
        drawn: list[tuple[Sweep | ContactSolution, str]] = []
        if len(solutions) > 1:
            drawn += [(self.sweep, name) for name in _panels_of("sweep", largest)]
        first, *others = drawn + [(largest, name) for name in _panels_of("solution", largest)]
        yield partial(self._draw, *first)
        yield partial(_write_report, self.sweep.states, self.folder, self.asked)
        law = make_law(self.sweep, self.asked)
        for name in law.columns:
            yield partial(self._draw_law, law, name)
        for subject, name in others:
            yield partial(self._draw, subject, name)

    def _write_table(self) -> dict[str, Any]:
        with replacing(self.folder / "answers.csv") as unfinished:
            # The mark at the start lets spreadsheets read what is not ASCII.
            unfinished.write_text(make_table(self.answers), encoding="utf-8-sig", newline="")
        return {"role": "table", "file": "answers.csv"}

    def _write_solution(self, index: int) -> dict[str, Any]:
        name = f"solution-{index + 1}.npz"
        self.sweep.states[index].save(self.folder / name)
        return {"role": "solution", "file": name, "load": index}

    def _draw(self, subject: Sweep | ContactSolution, name: str) -> dict[str, Any]:
        draw(lambda: subject.plot(name, dark=self.dark), self.folder / f"{name}.png")
        return {"role": "picture", "file": f"{name}.png", "panel": name}

    def _draw_law(self, law: InterfaceLaw, name: str) -> dict[str, Any]:
        panel = f"{name.replace(' ', '-')}-load"
        draw(lambda: law.plot(name, dark=self.dark), self.folder / f"{panel}.png")
        return {"role": "picture", "file": f"{panel}.png", "panel": panel}


@attrs.frozen(eq=False)
class PathOutputs:
    """What is written of a path: the table of its states, its picture, all fields if they are asked for, the report.

    Attributes
    ----------
    path
        The path.
    asked
        What responses have answered for each state, by their names.
    name
        Name of the table and the picture.
    keeps_fields
        Whether its file is written.
    folder, dark
        As of `Outputs`.
    """

    path: AdhesionCycle | FrictionalPath
    asked: Mapping[str, Sequence[Any]]
    name: str
    keeps_fields: bool
    folder: Path
    dark: bool

    def steps(self) -> Iterator[Callable[[], dict[str, Any]]]:
        """Yield functions that write a file and return what the page is to know of it."""
        yield self._write_table
        yield self._draw
        if self.keeps_fields:
            yield self._write_path
        yield partial(_write_report, self.path, self.folder, self.asked)

    def _write_table(self) -> dict[str, Any]:
        tabulate_path(self.path, self.asked).to_csv(self.folder / f"{self.name}.csv")
        return {"role": "table", "file": f"{self.name}.csv"}

    def _draw(self) -> dict[str, Any]:
        draw(lambda: self.path.plot(dark=self.dark), self.folder / f"{self.name}.png")
        return {"role": "picture", "file": f"{self.name}.png", "panel": self.name}

    def _write_path(self) -> dict[str, Any]:
        self.path.save(self.folder / "path.npz")
        return {"role": "solution", "file": "path.npz", "load": 0}


def _write_report(
    subject: Sequence[ContactSolution] | AdhesionCycle | FrictionalPath,
    folder: Path,
    asked: Mapping[str, Sequence[Any]],
) -> dict[str, Any]:
    write_report(subject, folder / "report.html", asked)
    return {"role": "report", "file": "report.html"}


def draw(plot: Callable[[], Any], path: Path) -> None:
    """Draw a panel into a file.

    Parameters
    ----------
    plot
        Returns matplotlib's axes of the panel.
    path
        The PNG file.

    Raises
    ------
    MissingPackage
        If matplotlib is not installed.
    InputError
        If there is nothing to draw.
    """
    figure = plot().figure
    from matplotlib import pyplot

    try:
        with replacing(path) as unfinished:
            figure.savefig(unfinished, format="png", bbox_inches="tight", dpi=_SHARPNESS * figure.dpi)
    finally:
        pyplot.close(figure)


def make_law(sweep: Sweep, asked: Mapping[str, Sequence[Any]]) -> InterfaceLaw:
    """Return the numbers of responses over the load; without columns where they cannot be drawn over its logarithm."""
    order = np.argsort(sweep.mean_pressure)
    pressures = sweep.mean_pressure[order]
    columns = {}
    for name, row in tabulate_answers(asked).items():
        values, uncertainties = (
            np.array([getattr(one, part) for one in row])[order] for part in ("value", "uncertainty")
        )
        drawn = np.isfinite(values) & (values > 0.0)
        if pressures[0] > 0.0 and np.count_nonzero(drawn) > 1:
            columns[name] = LawColumn(name, row[0].unit, values, uncertainties)
    return InterfaceLaw(pressures, columns, (), ())


def _panels_of(subject: str, solution: ContactSolution) -> list[str]:
    found = []
    for name in panels:
        # A broken plug-in must not keep the others from being drawn.
        with contextlib.suppress(RoughContactError):
            panel = panels.create(name)
            if panel.subject == subject and (solution.tension is not None or not panel.needs_adhesion):
                found.append(name)
    first = [name for name in _FIRST[subject] if name in found]
    return first + [name for name in found if name not in first]
