"""Fields over the plane as images, in true proportions, and the sub-grid edge of the contact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from roughcontact._answers.areas import LevelSet
from roughcontact._base.arrays import Array, Mask
from roughcontact._base.units import prefixed
from roughcontact._faces.panels.curves import add_key, scale_axes
from roughcontact._faces.panels.theme import plain_logarithms, theme_of
from roughcontact._parts.grid import Grid
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors.door import guarded

# Ratio of the sides above which a domain is not drawn in true proportions: too narrow to be seen.
_MAX_TRUE_ASPECT = 6.0
# The same of a plane over the depth, beside which a colour bar stands, and its ratio where it is not true.
_MAX_TRUE_SHALLOWNESS = 3.5
_SHALLOW_ASPECT = 2.0
# Percentiles between which the colours lie if a few pits or spikes would use most of them: where the range of all
# values is more than this ratio times the range between the percentiles.
_COLOR_PERCENTILES = (0.1, 99.9)
_MAX_RANGE_RATIO = 1.3
# Width of a colour bar over the mean side of its map.
_COLORBAR_WIDTH = 0.05
# Width of the line of the edge over the width of a cell, and its bounds, points.
_EDGE_WIDTH_CELLS = 0.3
_MIN_EDGE_POINTS = 0.03
_MAX_EDGE_POINTS = 1.0
# Mean width of the contact patches, cells, below which the line is thinner, so that it does not hide them.
_NARROW_PATCH_CELLS = 8.0


def length_scale(grid: Grid) -> tuple[float, str]:
    """Return the factor of lengths in the plane, and their unit: one for both axes."""
    return prefixed(0.5 * max(grid.size), "m")


def proportion(grid: Grid) -> float:
    """Return width over height of a drawn map."""
    lx, ly = grid.size
    ratio = lx / ly
    return ratio if 1.0 / _MAX_TRUE_ASPECT <= ratio <= _MAX_TRUE_ASPECT else (2.0 if ratio > 1.0 else 0.5)


def set_plane(axes: Any, grid: Grid) -> tuple[float, float, float, float]:
    """Label axes as the plane of a grid, its origin at the centre, and return the extent of images on them."""
    from matplotlib.ticker import MaxNLocator

    lx, ly = grid.size
    factor, unit = length_scale(grid)
    extent = (-0.5 * lx * factor, 0.5 * lx * factor, -0.5 * ly * factor, 0.5 * ly * factor)
    ratio = proportion(grid)
    true = ratio == lx / ly
    axes.set(xlim=extent[:2], ylim=extent[2:], xlabel=f"x, {unit}", ylabel=f"y, {unit}")
    axes.set_aspect("equal" if true else extent[1] / extent[3] / ratio)
    for axis, bins in ((axes.xaxis, 6.0 * min(ratio, 1.0)), (axes.yaxis, 6.0 / max(ratio, 1.0))):
        axis.set_major_locator(MaxNLocator(nbins=max(3, round(bins)), steps=[1, 2, 2.5, 5, 10], min_n_ticks=3))
    return extent


@guarded
def draw_map(
    axes: Any,
    values: Array,
    grid: Grid,
    label: str,
    unit: str,
    *,
    colors: str = "viridis",
    limits: tuple[float, float] | None = None,
    logarithmic: bool = False,
) -> Any:
    """Draw a field as an image with a colour bar, and return the image.

    Parameters
    ----------
    axes
        Axes of matplotlib.
    values
        Shape `grid.shape`, in the unit that is named; NaN where nothing is drawn.
    grid
        The cells.
    label, unit
        Name of the field and its unit, such as ``"µm"``, for the colour bar; an empty unit is omitted.
    colors
        Name of a colour map.
    limits
        Values at the ends of the colours, in the same unit; None: the range of nearly all values.
    logarithmic
        Whether the colours follow the logarithm of the values.
    """
    from matplotlib.colors import LogNorm, Normalize

    low, high, extend = _find_limits(values, limits, logarithmic)
    image = axes.imshow(
        values.T.astype(np.float32),
        origin="lower",
        extent=set_plane(axes, grid),
        cmap=colors,
        norm=LogNorm(low, high) if logarithmic else Normalize(low, high),
        aspect=axes.get_aspect(),
        interpolation="auto",
        interpolation_stage="rgba",
    )
    add_colorbar(axes, image, f"{label}, {unit}" if unit else label, extend)
    return image


@guarded
def draw_section(
    axes: Any, values: Array, grid: Grid, interfaces: Array, label: str, unit: str, *, axis: int = 0
) -> Any:
    """Draw a field of layers below a surface in a plane over the depth, with a colour bar from zero, and return it.

    Proportions are true unless the plane is too shallow to be seen so.

    Parameters
    ----------
    axes
        Axes of matplotlib.
    values
        The field, at least zero, shape (layers, cells along the plane), in SI units; NaN where nothing is drawn.
    grid
        The cells of a layer.
    interfaces
        Depths between the layers, from the surface on, shape (layers + 1,), m.
    label, unit
        Name of the field, and its SI unit, empty without one, for the colour bar.
    axis
        0 for a plane along x, 1 for one along y.
    """
    half = 0.5 * grid.size[axis]
    length, length_unit = length_scale(grid)
    highest = float(np.nanmax(values, initial=0.0))
    factor, named = prefixed(highest, unit) if unit else (1.0, "")
    ends = length * np.linspace(-half, half, values.shape[1] + 1)
    depths = length * interfaces
    image = axes.pcolormesh(
        ends, depths, factor * values, cmap="viridis", vmin=0.0, vmax=factor * highest or 1.0, rasterized=True
    )
    scale_axes(axes, x=f"{'xy'[axis]}, {length_unit}", y=f"depth, {length_unit}")
    axes.grid(False)
    axes.set(xlim=(ends[0], ends[-1]), ylim=(depths[-1], 0.0))
    ratio = 2.0 * half / float(interfaces[-1])
    axes.set_aspect(1.0 if ratio <= _MAX_TRUE_SHALLOWNESS else ratio / _SHALLOW_ASPECT)
    add_colorbar(axes, image, f"{label}, {named}" if named else label, "neither")
    return image


def _find_limits(values: Array, limits: tuple[float, float] | None, logarithmic: bool) -> tuple[float, float, str]:
    known = values[np.isfinite(values)]
    if not known.size:
        known = np.array((0.1, 1.0))
    low, high = _spread(known) if limits is None else limits
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    beyond = extend[bool(known.min() < low), bool(known.max() > high)]
    if logarithmic and not high > 1.01 * low:
        return 0.5 * low, 2.0 * high, beyond
    if not high > low:
        step = 0.5 * abs(high) or 1.0
        return low - step, high + step, beyond
    return float(low), float(high), beyond


def _spread(known: Array) -> tuple[float, float]:
    """Return the values between which colours lie: all of them, unless few reach far beyond the others."""
    low, high = np.percentile(known, _COLOR_PERCENTILES)
    full = float(known.min()), float(known.max())
    return full if full[1] - full[0] <= _MAX_RANGE_RATIO * (high - low) else (float(low), float(high))


def add_colorbar(axes: Any, image: Any, label: str, extend: str) -> None:
    """Add a colour bar beside axes, as high as these where the figure has a layout that makes room for it."""
    from matplotlib.colors import LogNorm
    from matplotlib.ticker import MaxNLocator

    figure = axes.get_figure()
    ink = theme_of(axes).ink
    if figure.get_layout_engine() is None:
        bar = figure.colorbar(image, ax=axes, extend=extend, fraction=0.046, pad=0.03)
    else:
        left, right = axes.get_xlim()
        low, high = axes.get_ylim()
        # The depth of a section grows downwards.
        ratio = (right - left) / abs(high - low) if axes.get_aspect() == 1.0 else 1.0
        width = _COLORBAR_WIDTH / ratio**0.5
        bar = figure.colorbar(image, cax=axes.inset_axes((1.0 + 0.6 * width, 0.0, width, 1.0)), extend=extend)
    if isinstance(image.norm, LogNorm):
        bar.formatter = bar.minorformatter = plain_logarithms()
    else:
        bar.ax.yaxis.set_major_locator(MaxNLocator(nbins=6, min_n_ticks=3))
    bar.set_label(label, color=ink)
    bar.outline.set_edgecolor(ink)
    bar.ax.tick_params(which="both", color=ink, labelcolor=ink)


@guarded
def draw_mask(axes: Any, mask: Mask, color: str) -> None:
    """Draw marked cells, shape `grid.shape`, in one colour over a map."""
    from matplotlib.colors import ListedColormap

    shown = np.ma.masked_where(~mask.T, np.zeros(mask.T.shape, dtype=np.uint8))
    axes.imshow(
        shown,
        origin="lower",
        extent=(*axes.get_xlim(), *axes.get_ylim()),
        cmap=ListedColormap([color]),
        aspect=axes.get_aspect(),
        interpolation="auto",
        interpolation_stage="rgba",
    )


def mark_non_measured(axes: Any, mask: Mask | None) -> list[tuple[str, str]]:
    """Draw the non-measured points, if there are any, and return their entry in the legend."""
    if mask is None or not mask.any():
        return []
    color = theme_of(axes).unknown
    draw_mask(axes, mask, color)
    return [(color, "non-measured")]


def name_colors(axes: Any, named: Sequence[tuple[str, str]]) -> None:
    """Add a legend of colours above axes, so that it hides nothing: pairs of colour and name."""
    from matplotlib.patches import Patch

    if named:
        handles = [Patch(facecolor=color, edgecolor="none", label=name) for color, name in named]
        add_key(axes, handles)


def draw_edges(axes: Any, solution: ContactSolution, color: str) -> None:
    """Draw the edge of the contact on axes that show the plane of a solution.

    A line that crosses a periodic border is drawn at both sides of the domain.
    """
    from matplotlib.collections import LineCollection

    size = np.array(solution.grid.size)
    factor, _ = length_scale(solution.grid)
    ends = np.array(solution.boundary.free_axes)
    lines: list[Array] = []
    for line in LevelSet().contours(solution):
        first = np.where(ends, 0, np.ceil(-0.5 - line.max(axis=0) / size)).astype(int)
        last = np.where(ends, 0, np.floor(0.5 - line.min(axis=0) / size)).astype(int)
        shifts = [(i, j) for i in range(first[0], last[0] + 1) for j in range(first[1], last[1] + 1)]
        lines.extend(line + np.array(shift) * size for shift in shifts)
    across = 72.0 * axes.get_window_extent().width / axes.get_figure(root=True).dpi
    finest = min(1.0, _measure_patches(solution) / _NARROW_PATCH_CELLS) * _EDGE_WIDTH_CELLS
    width = min(max(finest * across / solution.grid.shape[0], _MIN_EDGE_POINTS), _MAX_EDGE_POINTS)
    axes.add_collection(
        LineCollection([factor * line for line in lines], colors=color, linewidths=width, joinstyle="round"),
        autolim=False,
    )


def _measure_patches(solution: ContactSolution) -> float:
    """Return the mean width of the contact patches, cells: the width of strips of the same area and edge."""
    area = solution.area()
    return 2.0 * area.value / (area.perimeter * solution.grid.cell_area**0.5) if area.perimeter > 0.0 else np.inf
