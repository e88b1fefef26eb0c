"""The law of a lubricated film on the page: flow factors and asperity pressure over the separation, and their files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import attrs
from roughcontact import ContactProblem, Estimate, HeightMap, film_law
from roughcontact.errors import InputError
from roughcontact.faces import FilmPlan, plan_film, write_column
from roughcontact.results import FilmLaw
from roughcontact.typing import Array

from roughcontact_app.answers import describe_quantity, make_answer
from roughcontact_app.outputs import Offers, Step, draw, offer_picture
from roughcontact_app.responses import finite
from roughcontact_app.scene import MEASURED, Scene
from roughcontact_app.settings import PREFIXES, Settings, WrongSetting, reading, separation_values

_MODELS = ("greenwood-tripp", "persson", "patir-cheng")
_STATUS = "converged: each contact and each flow within its tolerance"


def is_film(settings: Settings) -> bool:
    """Return whether the law of a film is asked for."""
    return settings["load"] == "film"


def repeat_scene(settings: Settings, scene: Scene) -> Scene:
    """Return the scene of a film law, a map mirrored at its borders where that is chosen, or raise `InputError`."""
    if settings["surface"] == "sphere":
        raise WrongSetting("A ball has no flow factors: choose a rough surface, such as a map.", "surface")
    if settings["ball"]:
        raise WrongSetting("A film law is of nominally flat walls: add no ball or cylinder.", "ball")
    if settings["mirror_borders"] == "no" or settings["surface"] not in MEASURED:
        return scene
    if scene.counterbody is not None:
        sentence = "Two maps that are placed on each other cannot be mirrored at their borders: choose 'as it is'."
        raise WrongSetting(sentence, "mirror_borders")
    assert isinstance(scene.surface, HeightMap)
    mirrored = scene.surface.mirror_borders()
    return attrs.evolve(scene, surface=mirrored, grid=mirrored.grid)


def plan(settings: Settings, problem: ContactProblem) -> FilmPlan:
    """Return what the film law will take, or raise `InputError` where there is none."""
    separations = separation_values(settings)
    for prefix, name in zip(PREFIXES, ("body", "counterbody"), strict=True):
        body = getattr(problem, name)
        missing = body.non_measured(problem.plan.grid)
        if missing is not None and missing.any():
            sentence = "Points that were not measured would let no liquid pass: fill them."
            raise WrongSetting(sentence, f"{prefix}non_measured")
        if problem.remembers and body.material.bring_laws(name):
            sentence = "A film law has one state for each separation, but this material remembers: choose another one."
            raise WrongSetting(sentence, f"{prefix}material")
    with reading("separations"):
        return plan_film(problem, separations, sampling=settings["sampling"] == "yes")


def solve(settings: Settings, problem: ContactProblem, send: Callable[[dict[str, Any]], None]) -> FilmLaw:
    """Return the law, with messages on the way."""

    def tell(done: int, total: int) -> None:
        text = f"separation {done} of {total}, those of the quarters included"
        send({"phase": "solving", "fraction": done / total, "text": text})

    return film_law(problem, separation_values(settings), sampling=settings["sampling"] == "yes", on_row=tell)


def describe(law: FilmLaw) -> list[dict[str, Any]]:
    """Return the answer at each separation: all columns with their uncertainty, and how much other places differ."""
    columns: dict[str, tuple[list[Estimate], Array | None]] = {
        "separation over Sq": ([Estimate(float(one), 0.0, "") for one in law.separations], None),
        "separation": ([Estimate(float(one * law.rms_height), 0.0, "m") for one in law.separations], None),
    }
    for name, column in law.columns.items():
        estimates = [
            Estimate(float(value), float(own), column.unit)
            for value, own in zip(column.values, column.uncertainties, strict=True)
        ]
        columns[name.replace("_", " ")] = (estimates, column.sampling)
    texts = {name: write_column(estimates) for name, (estimates, _) in columns.items()}
    note = f"Fits beside the columns: {'; '.join(_list_fits(law))}."
    answers = []
    for row, separation in enumerate(law.separations):
        quantities = [
            describe_quantity(name, estimates[row], texts[name][row])
            | ({} if sampling is None else {"sampling": finite(float(sampling[row]))})
            for name, (estimates, sampling) in columns.items()
        ]
        answers.append(make_answer(f"{separation:g} Sq", quantities, (), status=_STATUS, certified=True, note=note))
    return answers


def _list_fits(law: FilmLaw) -> list[str]:
    found = []
    for model in _MODELS:
        try:
            found.append(str(law.fit(model)))
        except InputError:
            continue
    return found or ["none, there are too few separations"]


@attrs.frozen(eq=False)
class FilmOutputs(Offers):
    """What may be asked for of a film law: report, tables for other programs, and a picture of each main column.

    Attributes
    ----------
    law
        The law.
    units
        Of the files in which they may be chosen, as `FilmLaw.to_text` takes them.
    folder
        Where the files are written.
    dark
        Whether pictures are for a dark page.
    """

    law: FilmLaw
    units: str
    folder: Path
    dark: bool

    def steps(self) -> Iterator[Step]:
        """Yield the report, the tables, a text of two columns for each column, and the pictures."""
        law = self.law
        yield {"role": "report", "file": "report.html"}, partial(law.to_html, self.folder / "report.html")
        yield {"role": "table", "file": "film.csv"}, partial(law.to_csv, self.folder / "film.csv")
        yield {"role": "json", "file": "film.json"}, partial(law.to_json, self.folder / "film.json")
        comsol = partial(law.to_comsol, self.folder / "film-comsol.txt", units=self.units)
        yield {"role": "comsol", "file": "film-comsol.txt"}, comsol
        for name in law.columns:
            file = f"{name.replace('_', '-')}.txt"
            write = partial(law.to_text, self.folder / file, name, units=self.units)
            yield {"role": "text", "file": file, "column": name.replace("_", " ")}, write
        for name in law.short_table().columns:
            if name in law.columns:
                panel = name.replace("_", "-")
                plot = partial(law.plot, name, dark=self.dark)
                yield offer_picture(panel), partial(draw, plot, self.folder / f"{panel}.png")
