"""Claims about panels: pictures of a solution, a surface or a sweep."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from roughcontact._base.arrays import RealArray
from roughcontact._solve.problem import Sweep
from roughcontact.errors import InputError, MissingPackage, RoughContactError
from roughcontact.plotting import Panel, SampledSurface, make_figure
from roughcontact.testing.claim import DoesNotApply, claim, claim_repeatable, pickled, require
from roughcontact.testing.problems import adhesive_contact, list_contacts, rough_contact

_SUBJECTS = ("solution", "surface", "sweep")


def _list_subjects(panel: Panel) -> Iterator[tuple[str, Any]]:
    """Yield the subjects on which a panel is tried, with their names; none if its kind of subject is unknown."""
    if panel.needs_law is not None:
        raise DoesNotApply(f"it draws states with the law {panel.needs_law.__name__} alone, of which the kit has none")
    rough = rough_contact(0.05)
    if panel.subject == "solution":
        names = "a rough surface", "a plastic rough surface on a free boundary", "a sphere", "full contact"
        yield from list_contacts(*names)(panel)
    if panel.needs_adhesion:
        yield "surfaces that attract each other", adhesive_contact()
    if panel.subject == "surface":
        heights = -rough.initial_gap
        lost = np.where(np.arange(heights.size).reshape(heights.shape) % 7 == 0, np.nan, heights)
        yield "a periodic surface", SampledSurface(heights, rough.grid, True)
        yield "a map with non-measured points", SampledSurface(lost, rough.grid, False)
        yield "a flat", SampledSurface(0.0 * heights, rough.grid, False)
    if panel.subject == "sweep":
        yield "three loads", Sweep(tuple(rough_contact(load) for load in (0.02, 0.05, 0.1)))
        yield "one load", Sweep((rough,))


def _draw(panel: Panel, subject: Any) -> Any:
    """Return the figure; None where the panel refuses the subject in a sentence."""
    try:
        return make_figure(panel.subject, subject, panel)
    except MissingPackage as reason:
        raise DoesNotApply(str(reason)) from reason
    except InputError:
        return None


def _read_pixels(figure: Any) -> RealArray:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return np.array(canvas.buffer_rgba())


@claim("panel", "subject")
def _subject(panel: Panel) -> str:
    require(panel.subject in _SUBJECTS, f"it draws {panel.subject!r}, but there are {', '.join(_SUBJECTS)}")
    return panel.subject


@claim("panel", "draws or refuses")
def _draws(panel: Panel) -> str:
    drawn = []
    for label, subject in _list_subjects(panel):
        try:
            figure = _draw(panel, subject)
        except RoughContactError as error:
            raise AssertionError(f"{label}: {error}") from error
        if figure is None:
            continue
        drawn.append(label)
        marks = any(axes.has_data() or axes.texts for axes in figure.axes)
        require(marks, f"{label}: nothing is drawn; an InputError says why there is nothing to draw")
    require(drawn, "it refuses every subject that is tried")
    return ", ".join(drawn)


def _ask_pixels(panel: Panel, subject: Any) -> list[RealArray]:
    figure = _draw(panel, subject)
    return [] if figure is None else [_read_pixels(figure)]


claim_repeatable("panel", _list_subjects, _ask_pixels, copy=pickled)
