"""Figures 8 to 13 of the paper, for the synthetic pair."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import roughcontact as rc
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from roughcontact_paper.output import label_grids
from roughcontact_paper.pair_tables import FORCES, STATES, PairCase, fit_counts, local_contact, select
from roughcontact_paper.synthetic_pair import BALL_RADIUS, SIZE, STEEL

_COLORS = ("#1b6ca8", "#d1495b", "#3c8d53")
# Half the side of the domain, and half the window of Figure 13, um.
_HALF = 0.5e6 * SIZE
_HALF_WINDOW = 3.0
_EXTENT = (-_HALF, _HALF, -_HALF, _HALF)
_PLACE = {"xlabel": "x, µm", "ylabel": "y, µm"}


def draw_pair_figures(pairs: Mapping[str, rc.ContactProblem], cases: Sequence[PairCase]) -> Mapping[str, Figure]:
    """Return Figures 8 to 13 by name."""
    return {
        "figure8": _draw_heights(pairs[STATES[0]], STATES[0]),
        "figure9": _draw_heights(pairs[STATES[1]], STATES[1]),
        "figure10": _draw_areas(cases),
        "figure11": _draw_extrapolations(cases),
        "figure12": _draw_pressures(cases),
        "figure13": _draw_local_contact(cases),
    }


def _draw_heights(pair: rc.ContactProblem, state: str) -> Figure:
    """Figures 8 and 9: the heights of both bodies."""
    figure = Figure(figsize=(11, 4.6), layout="compressed")
    grid = pair.plan.grid
    sphere = rc.SphereSurface(BALL_RADIUS).heights(grid)
    maps = {
        "ball without its sphere": pair.body.surface.heights(grid) - sphere,
        "ring": pair.counterbody.surface.heights(grid),
    }
    for axes, (name, values) in zip(figure.subplots(1, 2), maps.items(), strict=True):
        heights = 1e6 * values
        low, high = np.percentile(heights, (0.1, 99.9))
        image = axes.imshow(heights.T, origin="lower", extent=_EXTENT, cmap="viridis", vmin=low, vmax=high)
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
        _finish(axes, state, 2)
    return figure


def _plot_counted_areas(axes: Axes, of_load: Sequence[PairCase], force: float, color: str, style: str) -> None:
    cells = [case.cells for case in of_load]
    axes.plot(cells, [1e12 * case.counted for case in of_load], style, color=color, label=f"{force:g} N, counted")


def _finish(axes: Axes, state: str, columns: int) -> None:
    label_grids(axes)
    axes.set(title=state, ylim=(0, 1.35 * axes.dataLim.y1))
    if state == STATES[0]:
        axes.set_ylabel("real contact area, µm²")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, ncols=columns, loc="upper right")


def _draw_extrapolations(cases: Sequence[PairCase]) -> Figure:
    """Figure 11: eq. 28 through the counted areas, and the sub-grid area of the finest grid."""
    figure = Figure(figsize=(11, 4.6), layout="constrained")
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
        _finish(axes, state, 3)
    return figure


def _draw_pressures(cases: Sequence[PairCase]) -> Figure:
    """Figure 12: pressure distributions at 10 N on the finest grid."""
    figure = Figure(figsize=(11, 4.8), layout="compressed")
    for axes, state in zip(figure.subplots(1, 2), STATES, strict=True):
        case = select(cases, state, FORCES[-1])[-1]
        shown = np.where(case.pressure > 0.0, case.pressure / 1e9, np.nan).T
        highest = float(STEEL.hardness) / 1e9
        image = axes.imshow(
            shown, origin="lower", extent=_EXTENT, cmap="plasma", vmin=0.0, vmax=highest, interpolation="nearest"
        )
        axes.set_facecolor("0.92")
        figure.colorbar(image, ax=axes, label="contact pressure, GPa")
        axes.set(title=f"{state}, 10 N: {case.patches} contact patches", xlim=(-100, 100), ylim=(-100, 100), **_PLACE)
    return figure


def _draw_local_contact(cases: Sequence[PairCase]) -> Figure:
    """Figure 13: one small contact on the four finest grids, after running in at 10 N."""
    of_load = select(cases, STATES[1], FORCES[-1])[-4:]
    x, y = (1e6 * value for value in local_contact(of_load[-1], SIZE))
    figure = Figure(figsize=(8.6, 8.6), layout="constrained")
    for axes, case in zip(figure.subplots(2, 2).flat, of_load, strict=False):
        edges = np.linspace(-_HALF, _HALF, case.cells + 1)
        i, j = (_cells_near(edges, centre, 1.5 * _HALF_WINDOW) for centre in (x, y))
        kinds = (case.pressure > 0.0).astype(int) + (case.pressure >= STEEL.hardness)
        axes.pcolormesh(
            edges[i.start : i.stop + 1],
            edges[j.start : j.stop + 1],
            kinds[i, j].T,
            cmap=ListedColormap(["#2b4c8c", "#f4d35e", "#f2a541"]),
            vmin=0,
            vmax=2,
            edgecolors="0.6",
            linewidth=0.3,
        )
        axes.add_collection(LineCollection(list(1e6 * case.edge), colors="#d1495b", linewidths=2.0))
        axes.set(xlim=(x - _HALF_WINDOW, x + _HALF_WINDOW), ylim=(y - _HALF_WINDOW, y + _HALF_WINDOW))
        axes.set(aspect="equal", **_PLACE)
        axes.set_title(f"{case.cells} x {case.cells}")
    figure.suptitle("10 N, run in: cells in contact (yellow), saturated (orange), and the sub-grid edge (red)")
    return figure


def _cells_near(edges: npt.NDArray[np.float64], centre: float, reach: float) -> slice:
    """Return the indices of the cells within a distance from a position."""
    first, last = np.searchsorted(edges, (centre - reach, centre + reach))
    return slice(max(int(first) - 1, 0), min(int(last) + 1, len(edges) - 1))
