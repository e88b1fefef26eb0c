"""Figures: panels of one subject side by side, in light or dark."""

from __future__ import annotations

from typing import Any

from roughcontact.errors import InputError, MissingPackage
from roughcontact.panel import Panel, panels

# The panels of a figure where none is named.
_STANDARD = {
    "solution": ("heights", "pressure", "gap", "patches"),
    "surface": ("map", "spectrum", "bearing-curve", "autocorrelation"),
    "sweep": ("load-approach", "area-load", "stiffness-load"),
}


def plot(kind: str, subject: Any, panel: str | Panel | None, axes: Any, dark: bool) -> Any:
    """Return the axes of one panel, or the figure of all standard panels of a kind of subject."""
    try:
        from matplotlib import pyplot
        from matplotlib.axes import Axes
    except ImportError:
        raise MissingPackage("Drawing needs matplotlib: pip install 'roughcontact[plot]'.") from None
    if axes is not None and not isinstance(axes, Axes):
        raise InputError.about("The axes", axes, "an Axes of matplotlib, or None")
    with pyplot.style.context("dark_background" if dark else "default"):
        if panel is None:
            if axes is not None:
                raise InputError("Axes hold one panel: name it, as in plot('pressure', axes=axes).")
            names = _STANDARD[kind]
            figure = pyplot.figure(figsize=(4.8 * len(names), 4.2), layout="constrained")
            for place, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
                panels.create(name).draw(subject, place)
            return figure
        chosen = panels.resolve(panel)
        if chosen.subject != kind:
            raise InputError(f"The panel {panel!r} draws a {chosen.subject}, not a {kind}.")
        target = pyplot.figure(layout="constrained").add_subplot() if axes is None else axes
        chosen.draw(subject, target)
        return target


def make_figure(kind: str, subject: Any, panel: str | Panel | None = None, dark: bool = False) -> Any:
    """Return the figure that `plot` draws, but one that pyplot does not know of: to be saved, in any thread."""
    from matplotlib.figure import Figure

    figure = Figure(layout="constrained")
    plot(kind, subject, panel, figure.add_subplot(), dark)
    return figure
