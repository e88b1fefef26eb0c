"""The files of a run: the table, the solutions, the pictures, the report."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeVar

import attrs
import numpy as np
from roughcontact import ContactSolution, FrictionalPath
from roughcontact.errors import RoughContactError
from roughcontact.faces import name_load, tabulate_answers, write_report
from roughcontact.plotting import draw_course, panels
from roughcontact.results import InterfaceLaw, LawColumn, LoadPath, Sweep
from roughcontact.results import Path as StatePath
from roughcontact.typing import replacing

from roughcontact_app.answers import make_table, tabulate_path

P = TypeVar("P", bound=StatePath)

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
            yield partial(_write_solution, solutions, index, self.folder)
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

    def _draw(self, subject: Sweep | ContactSolution, name: str) -> dict[str, Any]:
        draw(lambda: subject.plot(name, dark=self.dark), self.folder / f"{name}.png")
        return {"role": "picture", "file": f"{name}.png", "panel": name}

    def _draw_law(self, law: InterfaceLaw, name: str) -> dict[str, Any]:
        panel = f"{name.replace(' ', '-')}-load"
        draw(lambda: law.plot(name, dark=self.dark), self.folder / f"{panel}.png")
        return {"role": "picture", "file": f"{panel}.png", "panel": panel}


@attrs.frozen(eq=False)
class PathOutputs(Generic[P]):
    """What is written of a path: the table of its states, its picture, all fields of one with friction, the report.

    Attributes
    ----------
    path
        The path.
    asked
        What responses have answered for each state, by their names.
    name
        Name of the table and the picture.
    folder, dark
        As of `Outputs`.
    """

    path: P
    asked: Mapping[str, Sequence[Any]]
    name: str
    folder: Path
    dark: bool

    def steps(self) -> Iterator[Callable[[], dict[str, Any]]]:
        """Yield functions that write a file and return what the page is to know of it."""
        yield self._write_table
        yield self._draw
        if isinstance(self.path, FrictionalPath):
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
        return {"role": "path", "file": "path.npz"}


@attrs.frozen(eq=False)
class CourseOutputs(PathOutputs[LoadPath]):
    """What is written of a path on which the surfaces change: its states one by one, too, and a moving picture.

    Pictures of the states are not drawn before they are looked at.
    """

    def steps(self) -> Iterator[Callable[[], dict[str, Any]]]:
        """Yield functions that write a file and return what the page is to know of it."""
        yield self._write_table
        yield self._draw
        for index in range(len(self.path)):
            yield partial(_write_solution, self.path.states, index, self.folder)
        yield self._write_path
        yield partial(self._offer_states, "pressure")
        yield partial(self._offer_states, "gap")
        for name in _panels_of("solution", self.path[-1]):
            if panels[name].needs_law is not None:
                yield partial(self._offer_states, name)
        yield partial(_write_report, self.path, self.folder, self.asked)
        yield self._animate

    def _draw(self) -> dict[str, Any]:
        draw(lambda: draw_course(self.path, self.dark), self.folder / "course.png")
        return {"role": "picture", "file": "course.png", "panel": "course"}

    def _offer_states(self, panel: str) -> dict[str, Any]:
        """Return that a panel of each state may be looked at, the names of the states, and the end of the colours."""
        _, places = self.path.label_states()
        numbers = [f"state {number}" for number in range(1, len(self.path) + 1)]
        names = [
            ", ".join(dict.fromkeys((number, place, name_load(state))))
            for number, place, state in zip(numbers, places, self.path, strict=True)
        ]
        # One scale for all states.
        highest = max(float(state.contact_pressure.max()) for state in self.path)
        fields = {"highest": highest} if panel == "pressure" and highest > 0.0 else {}
        return {"role": "picture", "file": "path.npz", "panel": panel, "states": names, "fields": fields}

    def _animate(self) -> dict[str, Any]:
        self.path.animate(self.folder / "path.gif", dark=self.dark)
        return {"role": "animation", "file": "path.gif"}


def _write_solution(states: Sequence[ContactSolution], index: int, folder: Path) -> dict[str, Any]:
    name = f"solution-{index + 1}.npz"
    states[index].save(folder / name)
    return {"role": "solution", "file": name, "load": index}


def _write_report(
    subject: Sequence[ContactSolution] | StatePath,
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
        Returns matplotlib's axes of the panel, or a figure of several.
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
            if panel.subject == subject and panel.fits(solution):
                found.append(name)
    first = [name for name in _FIRST[subject] if name in found]
    return first + [name for name in found if name not in first]
