"""Curves with bands of two standard deviations, and axes that name a quantity and its unit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._faces.panels.theme import plain_logarithms, theme_of
from roughcontact.errors.door import guarded

# Lowest end of a band over the value, on logarithmic axes.
_MIN_BAND_FRACTION = 0.05
# Characters of a legend on an inch, and the space of a mark and of the blank behind a column, in characters.
_LEGEND_CHARACTERS_PER_INCH = 22.0
_LEGEND_MARK_CHARACTERS = 10


@guarded
def draw_band(
    axes: Any,
    x: Array,
    values: Array,
    deviations: Array,
    *,
    label: str = "",
    marker: str = "o",
    color: str | None = None,
) -> Any:
    """Draw a curve and a band of two standard deviations around it, shapes (n,); return its line."""
    cycle = theme_of(axes).lines
    color = cycle[len(axes.lines) % len(cycle)] if color is None else color
    (line,) = axes.plot(x, values, marker=marker, linestyle="-", color=color, label=label or "_curve")
    low = (
        np.maximum(values - 2.0 * deviations, _MIN_BAND_FRACTION * values)
        if np.all(values >= 0.0)
        else values - 2.0 * deviations
    )
    axes.fill_between(x, low, values + 2.0 * deviations, color=color, alpha=0.25, linewidth=0.0)
    return line


@guarded
def scale_axes(axes: Any, *, x: str, y: str, logarithmic: str = "") -> None:
    """Name both axes, choose their scales and ticks, and draw a grid.

    Parameters
    ----------
    axes
        Axes of matplotlib.
    x, y
        Quantities with their units, such as ``"pressure, MPa"``.
    logarithmic
        ``"x"``, ``"y"``, ``"xy"`` or none of them.
    """
    from matplotlib.ticker import MaxNLocator

    axes.set(xlabel=x, ylabel=y)
    for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
        if name in logarithmic:
            axes.set(**{f"{name}scale": "log"})
            axis.set_major_formatter(plain_logarithms())
            axis.set_minor_formatter(plain_logarithms())
        else:
            axis.set_major_locator(MaxNLocator(nbins=6, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3))
    axes.grid(True, which="major", color=theme_of(axes).ink, alpha=0.15, linewidth=0.5)


def say(axes: Any, text: str) -> None:
    """Write a remark above axes, so that it hides nothing."""
    axes.set_title(text, loc="left", fontsize=8, color=theme_of(axes).ink)


def add_key(axes: Any, handles: Sequence[Any] | None = None) -> None:
    """Add a legend of the labelled artists, or of `handles`, above axes, so that it hides nothing."""
    shown = axes.get_legend_handles_labels()[0] if handles is None else list(handles)
    room = _LEGEND_CHARACTERS_PER_INCH * axes.get_window_extent().width / axes.get_figure(root=True).dpi
    axes.legend(
        handles=shown,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=_count_columns([len(one.get_label()) for one in shown], room),
        handlelength=1.2,
        columnspacing=1.2,
        borderaxespad=0.2,
        frameon=False,
        labelcolor=theme_of(axes).ink,
    )


def _count_columns(lengths: Sequence[int], room: float) -> int:
    """Return the number of columns of a legend, filled one after the other, for a width of `room` characters."""
    for count in range(len(lengths), 1, -1):
        columns = np.array_split(np.array(lengths), count)
        if sum(int(column.max()) + _LEGEND_MARK_CHARACTERS for column in columns) <= room:
            return count
    return 1
