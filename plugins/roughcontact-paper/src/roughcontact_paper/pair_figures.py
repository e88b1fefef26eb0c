"""Figures 8 to 13 of the paper, for the synthetic pair."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import roughcontact as rc
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from roughcontact.plotting import LIGHT, style

from roughcontact_paper.output import label_grids
from roughcontact_paper.pair_tables import FORCES, STATES, PairCase, fit_counts, local_contact, select
from roughcontact_paper.synthetic_pair import BALL_RADIUS, SIZE, STEEL

_COLORS = LIGHT.lines[:3]
# Open cells, cells in contact, and saturated ones; the edge.
_KINDS = (LIGHT.open, LIGHT.body, LIGHT.limit)
_EDGE = LIGHT.edge
# Half the side of the domain, and half the window of Figure 13, um.
_HALF = 0.5e6 * SIZE
_HALF_WINDOW = 3.0
_EXTENT = (-_HALF, _HALF, -_HALF, _HALF)
_PLACE = {"xlabel": "x, µm", "ylabel": "y, µm"}


def draw_pair_figures(pairs: Mapping[str, rc.ContactProblem], cases: Sequence[PairCase]) -> Mapping[str, Figure]:
    """Return Figures 8 to 13 by name."""
    with style():
        heights = {state: _find_heights(pairs[state]) for state in STATES}
        # The same colours before and after, so that the figures can be compared.
        limits = {name: np.percentile(values, (0.1, 99.9)) for name, values in heights[STATES[0]].items()}
        return {
            "figure8": _draw_heights(heights[STATES[0]], limits, STATES[0]),
            "figure9": _draw_heights(heights[STATES[1]], limits, STATES[1]),
            "figure10": _draw_areas(cases),
            "figure11": _draw_extrapolations(cases),
            "figure12": _draw_pressures(cases),
            "figure13": _draw_local_contact(cases),
        }


def _find_heights(pair: rc.ContactProblem) -> dict[str, npt.NDArray[np.float64]]:
    """Return the heights of both bodies, um."""
    grid = pair.plan.grid
    sphere = rc.SphereSurface(BALL_RADIUS).heights(grid)
    return {
        "ball without its sphere": 1e6 * (pair.body.surface.heights(grid) - sphere),
        "ring": 1e6 * pair.counterbody.surface.heights(grid),
    }


def _draw_heights(
    heights: Mapping[str, npt.NDArray[np.float64]], limits: Mapping[str, npt.NDArray[np.float64]], state: str
) -> Figure:
    """Figures 8 and 9: the heights of both bodies."""
    figure = Figure(figsize=(11, 4.6), layout="compressed")
    for axes, (name, values) in zip(figure.subplots(1, 2), heights.items(), strict=True):
        low, high = limits[name]
        image = axes.imshow(values.T, origin="lower", extent=_EXTENT, cmap="cividis", vmin=low, vmax=high)
        figure.colorbar(image, ax=axes, label="height, µm", extend="both")
        axes.set(title=f"{name}, {state}", **_PLACE)
    return figure


def _draw_areas(cases: Sequence[PairCase]) -> Figure:
    """Figure 10: areas against the grid, with two standard deviations."""
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    for axes, state in zip(figure.subplots(1, 2, sharey=True), STATES, strict=True):
        for force, color in zip(FORCES, _COLORS, strict=True):
            of_load = select(cases, state, force)
            cells = [case.cells for case in of_load]
            _plot_counted_areas(axes, of_load, force, color, "o-")
            axes.errorbar(
                cells,
                [1e12 * case.area.value for case in of_load],
                [2e12 * case.area.uncertainty for case in of_load],
                fmt="D--",
                ms=5,
                color=color,
                mfc="w",
                capsize=3,
                label=f"{force:g} N, sub-grid",
            )
        _finish(axes, state)
    _name(figure, 6)
    return figure


def _plot_counted_areas(axes: Axes, of_load: Sequence[PairCase], force: float, color: str, style: str) -> None:
    cells = [case.cells for case in of_load]
    axes.plot(cells, [1e12 * case.counted for case in of_load], style, color=color, label=f"{force:g} N, counted")


def _finish(axes: Axes, state: str) -> None:
    label_grids(axes)
    axes.set(title=state, ylim=(0, 1.05 * axes.dataLim.y1))
    if state == STATES[0]:
        axes.set_ylabel("real contact area, µm²")
    axes.grid(True)


def _name(figure: Figure, columns: int) -> None:
    """Name the lines above the panels, where they hide nothing."""
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=columns)


def _draw_extrapolations(cases: Sequence[PairCase]) -> Figure:
    """Figure 11: eq. 28 through the counted areas, and the sub-grid area of the finest grid."""
    figure = Figure(figsize=(11, 5.2), layout="constrained")
    for axes, state in zip(figure.subplots(1, 2, sharey=True), STATES, strict=True):
        for force, color in zip(FORCES, _COLORS, strict=True):
            of_load = select(cases, state, force)
            decay = fit_counts(of_load)
            cells = np.geomspace(of_load[0].cells, 1.4 * of_load[-1].cells, 300)
            curve = decay.value + decay.parameters["k"] * np.exp(-cells / decay.parameters["t"])
            _plot_counted_areas(axes, of_load, force, color, "o")
            axes.plot(cells, curve, "-", color=color, label=f"eq. 28: {decay.value:.0f} µm²")
            last = of_load[-1].area
            value = 1e12 * last.value
            axes.axhline(value, color=color, ls=":", label=f"sub-grid: {value:.0f} µm²")
        _finish(axes, state)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)
    return figure


def _draw_pressures(cases: Sequence[PairCase]) -> Figure:
    """Figure 12: pressure distributions at 10 N on the finest grid, in the same colours."""
    figure = Figure(figsize=(10.5, 5.0), layout="compressed")
    places = figure.subplots(1, 2, sharey=True)
    highest = float(STEEL.hardness) / 1e9
    for axes, state in zip(places, STATES, strict=True):
        case = select(cases, state, FORCES[-1])[-1]
        shown = np.where(case.pressure > 0.0, case.pressure / 1e9, np.nan).T
        image = axes.imshow(shown, origin="lower", extent=_EXTENT, cmap="viridis", vmin=0.0, vmax=highest)
        axes.set_facecolor(LIGHT.open)
        axes.set(title=f"{state}, 10 N: {case.patches} contact patches", xlim=(-100, 100), ylim=(-100, 100))
        axes.set_xlabel(_PLACE["xlabel"])
    places[0].set_ylabel(_PLACE["ylabel"])
    figure.colorbar(image, ax=places, label=f"contact pressure, GPa; hardness {highest:g} GPa")
    return figure


def _draw_local_contact(cases: Sequence[PairCase]) -> Figure:
    """Figure 13: one small contact on the four finest grids, after running in at 10 N."""
    of_load = select(cases, STATES[1], FORCES[-1])[-4:]
    x, y = (1e6 * value for value in local_contact(of_load[-1], SIZE))
    figure = Figure(figsize=(8.6, 8.9), layout="constrained")
    for axes, case in zip(figure.subplots(2, 2).flat, of_load, strict=False):
        edges = np.linspace(-_HALF, _HALF, case.cells + 1)
        i, j = (_cells_near(edges, centre, 1.5 * _HALF_WINDOW) for centre in (x, y))
        kinds = (case.pressure > 0.0).astype(int) + (case.pressure >= STEEL.hardness)
        axes.pcolormesh(
            edges[i.start : i.stop + 1],
            edges[j.start : j.stop + 1],
            kinds[i, j].T,
            cmap=ListedColormap(_KINDS),
            vmin=0,
            vmax=2,
            edgecolors="0.75",
            linewidth=0.3,
        )
        lines = [1e6 * line for line in case.edge]
        axes.add_collection(LineCollection(lines, colors=_EDGE, linewidths=1.8, joinstyle="round"))
        axes.set(xlim=(x - _HALF_WINDOW, x + _HALF_WINDOW), ylim=(y - _HALF_WINDOW, y + _HALF_WINDOW))
        axes.set(aspect="equal", **_PLACE)
        axes.set_title(f"{case.cells} x {case.cells}")
    names: list[Artist] = [
        Patch(color=color, label=name) for color, name in zip(_KINDS, ("open", "contact", "saturated"), strict=True)
    ]
    names.append(Line2D([], [], color=_EDGE, linewidth=1.8, label="sub-grid edge"))
    figure.legend(handles=names, title="10 N, run in", loc="outside upper center", ncols=4)
    return figure


def _cells_near(edges: npt.NDArray[np.float64], centre: float, reach: float) -> slice:
    """Return the indices of the cells within a distance from a position."""
    first, last = np.searchsorted(edges, (centre - reach, centre + reach))
    return slice(max(int(first) - 1, 0), min(int(last) + 1, len(edges) - 1))
