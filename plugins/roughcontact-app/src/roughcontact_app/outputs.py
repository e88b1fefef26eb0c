"""The files that may be asked for of a run: the table, the solutions, the pictures, the report."""

from __future__ import annotations

import contextlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar

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
# What the page is to know of a file, and what writes it.
Step: TypeAlias = tuple[dict[str, Any], Callable[[], object]]

# Dots beside those of a figure: a picture, 430 dots wide, is shown 750 pixels wide.
_SHARPNESS = 3
# The panels that come first; others follow in the order of their names.
_FIRST = {"solution": ("pressure", "gap", "heights", "patches"), "sweep": ("area-load", "load-approach")}


class Offers(ABC):
    """What may be asked for of a run; each file is written when it is."""

    @abstractmethod
    def steps(self) -> Iterator[Step]:
        """Yield what the page is to know of each file, in the order in which people want them, and what writes it."""

    def list_files(self) -> list[dict[str, Any]]:
        """Return what the page is to know of each file."""
        return [about for about, _ in self.steps()]

    def write(self, file: str) -> None:
        """Write a file, or raise `RoughContactError`."""
        next(write for about, write in self.steps() if about["file"] == file)()


@attrs.frozen(eq=False)
class Outputs(Offers):
    """What may be asked for of solutions.

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

    def steps(self) -> Iterator[Step]:
        """Yield the table, the solutions and the pictures, of which the first is looked at first, and the report."""
        solutions = self.sweep.states
        largest = max(solutions, key=lambda solution: solution.force)
        yield {"role": "table", "file": "answers.csv"}, self._write_table
        yield from _offer_solutions(solutions, self.folder)
        drawn: list[tuple[Sweep | ContactSolution, str]] = []
        if len(solutions) > 1:
            drawn += [(self.sweep, name) for name in _panels_of("sweep", largest)]
        first, *others = drawn + [(largest, name) for name in _panels_of("solution", largest)]
        yield self._offer_picture(*first)
        yield _offer_report(self.sweep.states, self.folder, self.asked)
        law = make_law(self.sweep, self.asked)
        for name in law.columns:
            panel = f"{name.replace(' ', '-')}-load"
            yield (
                offer_picture(panel),
                partial(draw, partial(law.plot, name, dark=self.dark), self.folder / f"{panel}.png"),
            )
        for subject, name in others:
            yield self._offer_picture(subject, name)

    def _write_table(self) -> None:
        with replacing(self.folder / "answers.csv") as unfinished:
            # The mark at the start lets spreadsheets read what is not ASCII.
            unfinished.write_text(make_table(self.answers), encoding="utf-8-sig", newline="")

    def _offer_picture(self, subject: Sweep | ContactSolution, name: str) -> Step:
        return offer_picture(name), partial(
            draw, partial(subject.plot, name, dark=self.dark), self.folder / f"{name}.png"
        )


@attrs.frozen(eq=False)
class PathOutputs(Offers, Generic[P]):
    """What may be asked for of a path: table, picture, report, and all fields of one with friction.

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

    def steps(self) -> Iterator[Step]:
        """Yield the table, the picture, the fields and the report."""
        yield self._offer_table()
        plot = partial(self.path.plot, dark=self.dark)
        yield offer_picture(self.name), partial(draw, plot, self.folder / f"{self.name}.png")
        if isinstance(self.path, FrictionalPath):
            yield self._offer_path()
        yield _offer_report(self.path, self.folder, self.asked)

    def _offer_table(self) -> Step:
        file = f"{self.name}.csv"
        return {"role": "table", "file": file}, lambda: tabulate_path(self.path, self.asked).to_csv(self.folder / file)

    def _offer_path(self) -> Step:
        return {"role": "path", "file": "path.npz"}, partial(self.path.save, self.folder / "path.npz")


@attrs.frozen(eq=False)
class CourseOutputs(PathOutputs[LoadPath]):
    """What may be asked for of a path on which the surfaces change: its states one by one, too, and a moving picture.

    Pictures of the states are drawn from their solutions.
    """

    def steps(self) -> Iterator[Step]:
        """Yield the table, the picture of the path, its states, the report and the moving picture."""
        yield self._offer_table()
        yield (
            offer_picture("course"),
            partial(draw, partial(draw_course, self.path, self.dark), self.folder / "course.png"),
        )
        yield from _offer_solutions(self.path.states, self.folder)
        about, save = self._offer_path()
        yield about, save
        shown = ["pressure", "gap"]
        shown += [name for name in _panels_of("solution", self.path[-1]) if panels[name].needs_law is not None]
        for panel in shown:
            yield self._describe_states(panel), save
        yield _offer_report(self.path, self.folder, self.asked)
        animate = partial(self.path.animate, self.folder / "path.gif", dark=self.dark)
        yield {"role": "animation", "file": "path.gif"}, animate

    def _describe_states(self, panel: str) -> dict[str, Any]:
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


def _offer_solutions(states: Sequence[ContactSolution], folder: Path) -> Iterator[Step]:
    for index, state in enumerate(states):
        name = f"solution-{index + 1}.npz"
        yield {"role": "solution", "file": name, "load": index}, partial(state.save, folder / name)


def _offer_report(
    subject: Sequence[ContactSolution] | StatePath, folder: Path, asked: Mapping[str, Sequence[Any]]
) -> Step:
    return {"role": "report", "file": "report.html"}, partial(write_report, subject, folder / "report.html", asked)


def offer_picture(panel: str) -> dict[str, Any]:
    """Return what the page is to know of the picture of a panel."""
    return {"role": "picture", "file": f"{panel}.png", "panel": panel}


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
