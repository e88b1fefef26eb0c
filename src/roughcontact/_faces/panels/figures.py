"""Figures: panels of one subject side by side, in light or dark, their size and titles."""

from __future__ import annotations

import base64
import importlib.util
import io
import math
import textwrap
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import attrs

from roughcontact._base.archive import replacing
from roughcontact._base.arrays import Array
from roughcontact._base.units import counted, si, with_spread
from roughcontact._faces.panels.base import Panel, panels
from roughcontact._faces.panels.maps import proportion
from roughcontact._faces.panels.theme import apply_theme, require_matplotlib, style, theme_of
from roughcontact._parts.grid import Grid
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Side of a square map, and the space of labels beside and below it, inches.
_MAP_INCHES = 3.0
_INCHES_BESIDE_MAP = 1.3
_INCHES_BELOW_MAP = 0.65
# Width and height of axes with curves, inches.
_CURVE_INCHES = (3.6, 2.9)
# Smallest width and height of a panel alone and of one among others, inches.
_MIN_INCHES_ALONE = (2.8, 2.4)
_MIN_INCHES_OF_SEVERAL = (1.3, 0.8)
# Width over height from which maps are stacked, and below which they stand in one row.
_MIN_STACKED_RATIO = 2.2
_MAX_ROW_RATIO = 0.55
# Pixels an inch of saved figures: at least the first number, at most the second, else one for each cell.
_DPI_RANGE = (150.0, 300.0)
# Dots to an inch on a page: sharp on paper where three pictures stand side by side.
_PAGE_DPI = 130
# The panels of a figure where none is named.
_STANDARD_PANELS = {
    "solution": ("heights", "pressure", "gap", "patches"),
    "surface": ("map", "spectrum", "bearing-curve", "autocorrelation"),
    "sweep": ("load-approach", "area-load", "stiffness-load"),
}
# Most characters in a line of a sentence that stands in place of a panel.
_REFUSAL_CHARACTERS = 40
# Characters of a title on an inch, and the height of a line, inches.
_TITLE_CHARACTERS_PER_INCH = 13.0
_TITLE_LINE_INCHES = 0.18


@attrs.frozen
class Layout:
    """How a figure is laid out.

    Attributes
    ----------
    rows, columns
        Number of panels along each direction.
    size
        Width and height, inches.
    dpi
        Pixels an inch that show every cell.
    engine
        Name of the layout engine.
    """

    rows: int
    columns: int
    size: tuple[float, float]
    dpi: float
    engine: str


def arrange(kind: str, subject: Any, count: int) -> Layout:
    """Return the layout of a number of panels of a subject."""
    if kind == "sweep":
        width, height = _CURVE_INCHES
        return Layout(1, count, (count * width, height), _DPI_RANGE[0], "constrained")
    return _arrange_maps(subject.grid, count, "compressed" if kind == "solution" else "constrained")


def _arrange_maps(grid: Grid, count: int, engine: str) -> Layout:
    ratio = proportion(grid)
    columns = math.ceil(math.sqrt(count))
    if engine == "compressed" and ratio < _MAX_ROW_RATIO:
        columns = count
    if engine == "compressed" and ratio > _MIN_STACKED_RATIO:
        columns = 1
    rows = math.ceil(count / columns)
    # Narrow maps are larger along their longer side.
    side = _MAP_INCHES * max(ratio, 1.0 / ratio) ** (0.35 if engine == "compressed" else 0.1)
    width, height = (side, side / ratio) if ratio > 1.0 else (side * ratio, side)
    dpi = max(grid.shape[0] / width, grid.shape[1] / height)
    if engine == "constrained":
        width = max(width, _CURVE_INCHES[0] - 0.7)
        height = max(height, _CURVE_INCHES[1] - 0.5)
    # Legends and curves need as much beside and below narrow domains.
    smallest = _MIN_INCHES_ALONE if count == 1 else _MIN_INCHES_OF_SEVERAL
    width = max(width, smallest[0])
    height = max(height, smallest[1])
    if count == 1:
        # Constrained layout cuts the labels of a map alone: it is sized before its proportions are.
        engine = "compressed"
    size = (columns * (width + _INCHES_BESIDE_MAP), rows * (height + _INCHES_BELOW_MAP))
    return Layout(rows, columns, size, min(max(dpi, _DPI_RANGE[0]), _DPI_RANGE[1]), engine)


def title_of(kind: str, subject: Any) -> str:
    """Return the title of a figure of the subject."""
    titles = {"solution": title_of_solution, "surface": title_of_surface, "sweep": title_of_sweep}
    return titles[kind](subject)


def title_of_solution(solution: Any) -> str:
    """Return the answer of a solution with its uncertainty, its load, and whether it has warnings."""
    area = solution.area()
    free = solution.boundary.value == "free"
    load = si(solution.force, "N", 3) if free else f"{si(solution.mean_pressure, 'Pa', 3)} mean pressure"
    percent = with_spread(100.0 * area.fraction, 100.0 * area.uncertainty / solution.grid.area).replace("+-", "±")
    text = f"Contact area {percent} % of nominal at {load}, {solution.boundary.value} boundary"
    count = len({*solution.warnings, *area.warnings})
    if not solution.status.success:
        text = f"NOT CONVERGED. {text}"
    return f"{text}\n{counted(count, 'warning')}" if count else text


def title_of_surface(sampled: Any) -> str:
    """Return the rms height of a surface and its cells."""
    rms = si(sampled.rms_height, "m", 3)
    nx, ny = sampled.grid.shape
    lx, ly = sampled.grid.size
    size = si(lx, "m", 4) if lx == ly else f"{si(lx, 'm', 4)} x {si(ly, 'm', 4)}"
    return f"Rms height {rms} on {size}, {nx} x {ny} cells"


def loads_of(sweep: Any) -> tuple[Array, str, str]:
    """Return the loads of a sweep, their name and their unit: forces on a free boundary, else mean pressures."""
    if sweep.states[0].boundary.value == "free":
        return sweep.force, "force", "N"
    return sweep.mean_pressure, "mean pressure", "Pa"


def title_of_sweep(sweep: Any) -> str:
    """Return the number of loads and their range."""
    loads, name, unit = loads_of(sweep)
    low, high = (si(float(bound), unit, 3) for bound in (loads.min(), loads.max()))
    return f"{counted(len(loads), 'load')}, {name} {low if low == high else f'{low} to {high}'}"


def plot(kind: str, subject: Any, panel: str | Panel | None, axes: Any, dark: bool) -> Any:
    """Return the axes of one panel, or the figure of all standard panels of a kind of subject, made by pyplot."""
    require_matplotlib()
    from matplotlib import pyplot
    from matplotlib.axes import Axes

    if axes is not None and not (isinstance(axes, Axes) and axes.name == "rectilinear"):
        raise InputError.about("The axes", axes, "plane, rectangular Axes of matplotlib, or None")
    if panel is None and axes is not None:
        raise InputError("Axes hold one panel: name it, as in plot('pressure', axes=axes).")
    chosen = None if panel is None else _resolve(kind, panel)
    if chosen is not None and axes is not None:
        with style(theme_of(axes).is_dark):
            chosen.draw(subject, axes)
        return axes
    from roughcontact._faces.panels.figure_view import FigureView

    with style(dark):
        figure = pyplot.figure(FigureClass=FigureView)
        try:
            if chosen is None:
                return _fill(figure, kind, subject)
            drawn = _fill_one(figure, chosen, subject)
            add_title(figure, wrap_title(figure, title_of(kind, subject)))
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
    if kind not in _STANDARD_PANELS:
        raise InputError.about("What is drawn", kind, f"one of {', '.join(map(repr, _STANDARD_PANELS))}")
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
    """Draw all standard panels; in place of a panel that refuses the subject, write why."""
    layout = _arrange(figure, kind, subject, len(_STANDARD_PANELS[kind]))
    places = figure.subplots(layout.rows, layout.columns, squeeze=False).ravel()
    for name, axes in zip(_STANDARD_PANELS[kind], places, strict=True):
        try:
            panels.create(name).draw(subject, axes)
        except InputError as error:
            axes.cla()
            axes.set_axis_off()
            axes.text(
                0.5,
                0.5,
                textwrap.fill(str(error), _REFUSAL_CHARACTERS),
                ha="center",
                va="center",
                transform=axes.transAxes,
            )
    add_title(figure, wrap_title(figure, title_of(kind, subject)))
    _keep_colors(figure)
    return figure


def _arrange(figure: Any, kind: str, subject: Any, count: int) -> Layout:
    layout = arrange(kind, subject, count)
    figure.set_size_inches(layout.size)
    figure.set_layout_engine(layout.engine)
    figure.saving_dpi = layout.dpi
    return layout


def wrap_title(figure: Any, title: str) -> list[str]:
    """Return the lines of a title, as wide as the figure at most."""
    width = int(_TITLE_CHARACTERS_PER_INCH * figure.get_size_inches()[0])
    return [line for part in title.split("\n") for line in textwrap.wrap(part, width)]


def add_title(figure: Any, lines: Sequence[str]) -> None:
    """Write a title, and make the figure higher for it."""
    width, height = figure.get_size_inches()
    figure.set_size_inches(width, height + _TITLE_LINE_INCHES * len(lines))
    figure.suptitle("\n".join(lines))


def _fill_one(figure: Any, panel: Panel, subject: Any) -> Any:
    return fill_alone(figure, panel.subject, subject, partial(panel.draw, subject))


def fill_alone(figure: Any, kind: str, subject: Any, draw: Callable[[Any], object]) -> Any:
    """Return the axes of a figure that holds nothing else, as large as a subject of this kind needs, once drawn."""
    _arrange(figure, kind, subject, 1)
    axes = figure.add_subplot()
    draw(axes)
    _keep_colors(figure)
    return axes


def _keep_colors(figure: Any) -> None:
    """Give the colours and sizes of the theme to ticks that are made later, at drawing."""
    from matplotlib import rcParams

    color = rcParams["xtick.color"]
    size = rcParams["xtick.labelsize"]
    for axes in figure.axes:
        axes.tick_params(which="both", color=color, labelcolor=color, labelsize=size)


def write_picture(figure: Any, path: Path, **options: Any) -> None:
    """Write a figure in the format of the ending, completely or not at all; the options are those of `savefig`."""
    # In memory: when a disk is full, some formats fail in other ways than by an error of the system.
    content = io.BytesIO()
    figure.savefig(content, format=path.suffix.removeprefix("."), **options)
    with replacing(path) as partial:
        partial.write_bytes(content.getvalue())


def save_figure(drawn: Any, path: Path) -> None:
    """Write the figure of what `plot` returns, as `write_picture` does, and let pyplot forget it."""
    write_picture(drawn.figure, path)
    forget_figure(drawn)


def forget_figure(drawn: Any) -> None:
    """Let pyplot forget the figure of what `plot` returns."""
    from matplotlib import pyplot

    pyplot.close(drawn.figure)


def can_draw() -> bool:
    """Return whether the package that draws is installed; it is not imported."""
    return importlib.util.find_spec("matplotlib") is not None


def draw_panel(kind: str, subject: Any, name: str) -> str:
    """Return a panel as a PNG file in a data: address, dark on light as on paper."""
    return write_png(make_figure(kind, subject, name))


def write_png(figure: Any) -> str:
    """Return a figure as a PNG file in a data: address."""
    return f"data:image/png;base64,{base64.b64encode(draw_png(figure, dpi=_PAGE_DPI)).decode()}"


def draw_png(figure: Any, **options: Any) -> bytes:
    """Return the content of a PNG file of a figure; the options are those of `savefig`."""
    content = io.BytesIO()
    figure.savefig(content, format="png", **options)
    return content.getvalue()
