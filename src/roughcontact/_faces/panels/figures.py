"""Figures: panels of one subject side by side, in light or dark."""

from __future__ import annotations

import io
import textwrap
from pathlib import Path
from typing import Any

from roughcontact._base.archive import replacing
from roughcontact._faces.panels.base import Panel, panels
from roughcontact._faces.panels.layout import Layout, arrange, title_of
from roughcontact._faces.panels.theme import apply_theme, require_matplotlib, style, theme_of
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# The panels of a figure where none is named.
_STANDARD = {
    "solution": ("heights", "pressure", "gap", "patches"),
    "surface": ("map", "spectrum", "bearing-curve", "autocorrelation"),
    "sweep": ("load-approach", "area-load", "stiffness-load"),
}
# Characters in a line of a sentence that stands in place of a panel.
_WIDTH = 40
# Characters of a title that an inch holds, and the height of a line, inches.
_PER_INCH = 13.0
_LINE = 0.18


def plot(kind: str, subject: Any, panel: str | Panel | None, axes: Any, dark: bool) -> Any:
    """Return the axes of one panel, or the figure of all standard panels of a kind of subject, made by pyplot."""
    require_matplotlib()
    from matplotlib import pyplot
    from matplotlib.axes import Axes

    from roughcontact._faces.panels.figure_view import FigureView

    if axes is not None and not (isinstance(axes, Axes) and axes.name == "rectilinear"):
        raise InputError.about("The axes", axes, "plane, rectangular Axes of matplotlib, or None")
    if panel is None and axes is not None:
        raise InputError("Axes hold one panel: name it, as in plot('pressure', axes=axes).")
    chosen = None if panel is None else _resolve(kind, panel)
    if chosen is not None and axes is not None:
        with style(theme_of(axes).is_dark):
            chosen.draw(subject, axes)
        return axes
    with style(dark):
        figure = pyplot.figure(FigureClass=FigureView)
        try:
            if chosen is None:
                return _fill(figure, kind, subject)
            drawn = _fill_one(figure, chosen, subject)
            _add_title(figure, title_of(kind, subject))
            return drawn
        except BaseException:
            pyplot.close(figure)
            raise


@guarded
def make_figure(kind: str, subject: Any, panel: str | Panel | None = None, dark: bool = False) -> Any:
    """Return the figure that ``plot`` draws, but without pyplot, to be saved in any thread; one panel has no title.

    Parameters
    ----------
    kind, subject
        ``"solution"`` and a `ContactSolution`, ``"surface"`` and a `SampledSurface`, or ``"sweep"`` and a sweep.
    panel
        Registered name or instance of one panel; None for the standard ones.
    dark
        Whether the background is dark.

    Raises
    ------
    InputError
        If there is no such panel, or it draws something else or refuses the subject.
    MissingPackage
        If matplotlib, of the extra ``plot``, is not installed.
    """
    if kind not in _STANDARD:
        raise InputError.about("What is drawn", kind, f"one of {', '.join(map(repr, _STANDARD))}")
    require_matplotlib()
    from roughcontact._faces.panels.figure_view import FigureView

    with apply_theme(dark):
        figure = FigureView()
        if panel is None:
            return _fill(figure, kind, subject)
        _fill_one(figure, _resolve(kind, panel), subject)
        return figure


def _resolve(kind: str, panel: str | Panel) -> Panel:
    chosen = panels.resolve(panel)
    if chosen.subject != kind:
        known = ", ".join(repr(name) for name in panels if panels[name].subject == kind)
        raise InputError(
            f"The panel {panel!r} draws a {chosen.subject}, not a {kind}: the panels of a {kind} are {known}."
        )
    return chosen


def _fill(figure: Any, kind: str, subject: Any) -> Any:
    """Draw all standard panels, where one refuses, what it says."""
    layout = _arrange(figure, kind, subject, len(_STANDARD[kind]))
    places = figure.subplots(layout.rows, layout.columns, squeeze=False).ravel()
    for name, axes in zip(_STANDARD[kind], places, strict=True):
        try:
            panels.create(name).draw(subject, axes)
        except InputError as error:
            axes.cla()
            axes.set_axis_off()
            axes.text(0.5, 0.5, textwrap.fill(str(error), _WIDTH), ha="center", va="center", transform=axes.transAxes)
    _add_title(figure, title_of(kind, subject))
    _keep_colors(figure)
    return figure


def _arrange(figure: Any, kind: str, subject: Any, count: int) -> Layout:
    layout = arrange(kind, subject, count)
    figure.set_size_inches(layout.size)
    figure.set_layout_engine(layout.engine)
    figure.saving_dpi = layout.dpi
    return layout


def _add_title(figure: Any, title: str) -> None:
    """Write a title in lines that are no longer than the figure is wide, on paper added for them."""
    width, height = figure.get_size_inches()
    lines = [line for part in title.split("\n") for line in textwrap.wrap(part, int(_PER_INCH * width))]
    figure.set_size_inches(width, height + _LINE * len(lines))
    figure.suptitle("\n".join(lines))


def _fill_one(figure: Any, panel: Panel, subject: Any) -> Any:
    _arrange(figure, panel.subject, subject, 1)
    axes = figure.add_subplot()
    panel.draw(subject, axes)
    _keep_colors(figure)
    return axes


def _keep_colors(figure: Any) -> None:
    """Let ticks that are made later, at drawing, have the colours and sizes of the theme."""
    from matplotlib import rcParams

    color = rcParams["xtick.color"]
    size = rcParams["xtick.labelsize"]
    for axes in figure.axes:
        axes.tick_params(which="both", color=color, labelcolor=color, labelsize=size)


def save_figure(drawn: Any, path: Path) -> None:
    """Write what `plot` has drawn in the format of the ending, completely or not at all, and let pyplot forget it."""
    from matplotlib import pyplot

    content = io.BytesIO()
    drawn.figure.savefig(content, format=path.suffix.removeprefix("."))
    pyplot.close(drawn.figure)
    with replacing(path) as partial:
        partial.write_bytes(content.getvalue())
