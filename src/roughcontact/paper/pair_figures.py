"""Figures 8 to 13 of the paper, for the stand-in pair."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from roughcontact.body import Body
from roughcontact.paper.figures import grid_axis, saved
from roughcontact.paper.pairs import FORCES, LOCAL_WINDOW, STATES, PairCase, chosen, fit, local_contact
from roughcontact.paper.stand_in import BALL_RADIUS, SIZE, STEEL
from roughcontact.problem import ContactProblem
from roughcontact.surfaces import SphereSurface

_COLORS = ("#1b6ca8", "#d1495b", "#3c8d53")
_HALF = 0.5e6 * SIZE
_EXTENT = (-_HALF, _HALF, -_HALF, _HALF)
_PLACE = {"xlabel": "x, µm", "ylabel": "y, µm"}


def draw_pairs(pairs: Mapping[str, ContactProblem], cases: Sequence[PairCase], folder: Path) -> tuple[Path, ...]:
    """Draw figures 8 to 13 as PNG files into `folder` and return their paths."""
    figures = {
        "figure8": _profiles(pairs[STATES[0]], STATES[0]),
        "figure9": _profiles(pairs[STATES[1]], STATES[1]),
        "figure10": _areas(cases),
        "figure11": _extrapolations(cases),
        "figure12": _pressures(cases),
        "figure13": _local(cases),
    }
    return saved(figures, folder)


def _profiles(pair: ContactProblem, state: str) -> Figure:
    """Figures 8 and 9: the heights of both bodies."""
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    grid = pair.plan.grid
    form = SphereSurface(BALL_RADIUS).heights(grid)
    names = {"ball, less its sphere": (pair.body, form), "ring": (pair.counter, 0.0)}
    for axes, (name, (body, less)) in zip(figure.subplots(1, 2), names.items(), strict=True):
        heights = 1e6 * (_heights(body, pair) - less)
        low, high = np.percentile(heights, (0.1, 99.9))
        image = axes.imshow(heights.T, origin="lower", extent=_EXTENT, cmap="viridis", vmin=low, vmax=high)
        figure.colorbar(image, ax=axes, label="height, µm", extend="both")
        axes.set(title=f"{name}, {state}", **_PLACE)
    return figure


def _heights(body: Body, pair: ContactProblem) -> np.ndarray:
    return body.surface.heights(pair.plan.grid)


def _areas(cases: Sequence[PairCase]) -> Figure:
    """Figure 10: areas against the grid."""
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    for axes, state in zip(figure.subplots(1, 2, sharey=True), STATES, strict=True):
        for force, color in zip(FORCES, _COLORS, strict=True):
            of_load = chosen(cases, state, force)
            cells = [case.cells for case in of_load]
            _counted(axes, of_load, force, color, "o-")
            values, bars = (
                1e12 * np.array([getattr(case.area, name) for case in of_load]) for name in ("value", "uncertainty")
            )
            axes.errorbar(
                cells,
                values,
                2 * bars,
                fmt="D--",
                ms=5,
                color=color,
                mfc="w",
                capsize=3,
                label=f"{force:g} N, sub-grid",
            )
        _finish(axes, state, 2)
    return figure


def _counted(axes: Axes, of_load: Sequence[PairCase], force: float, color: str, style: str) -> None:
    cells = [case.cells for case in of_load]
    axes.plot(cells, [1e12 * case.counted for case in of_load], style, color=color, label=f"{force:g} N, counted")


def _finish(axes: Axes, state: str, columns: int) -> None:
    grid_axis(axes)
    axes.set(title=state, ylabel="real contact area, µm²", ylim=(0, 1.35 * axes.dataLim.y1))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, ncols=columns, loc="upper right")


def _extrapolations(cases: Sequence[PairCase]) -> Figure:
    """Figure 11: eq. 28 through the counted areas, and the sub-grid area of the finest grid."""
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    for axes, state in zip(figure.subplots(1, 2, sharey=True), STATES, strict=True):
        for force, color in zip(FORCES, _COLORS, strict=True):
            of_load = chosen(cases, state, force)
            decay = fit(of_load)
            cells = np.geomspace(of_load[0].cells, 1.4 * of_load[-1].cells, 300)
            curve = decay.value + decay.parameters["k"] * np.exp(-cells / decay.parameters["t"])
            _counted(axes, of_load, force, color, "o")
            axes.plot(cells, curve, "-", color=color, label=f"eq. 28: {decay.value:.0f}")
            last = of_load[-1].area
            value = 1e12 * last.value
            axes.axhline(value, color=color, ls=":", label=f"sub-grid: {value:.0f}")
        _finish(axes, state, 3)
    return figure


def _pressures(cases: Sequence[PairCase]) -> Figure:
    """Figure 12: pressure distributions at 10 N on the finest grid."""
    figure = Figure(figsize=(11, 4.8), layout="constrained")
    for axes, state in zip(figure.subplots(1, 2), STATES, strict=True):
        case = chosen(cases, state, FORCES[-1])[-1]
        shown = np.where(case.pressure > 0.0, case.pressure / 1e9, np.nan).T
        highest = float(STEEL.hardness) / 1e9
        image = axes.imshow(
            shown, origin="lower", extent=_EXTENT, cmap="plasma", vmin=0.0, vmax=highest, interpolation="nearest"
        )
        axes.set_facecolor("0.92")
        figure.colorbar(image, ax=axes, label="contact pressure, GPa")
        axes.set(title=f"{state}, 10 N: {case.contacts} contacts", xlim=(-100, 100), ylim=(-100, 100), **_PLACE)
    return figure


def _local(cases: Sequence[PairCase]) -> Figure:
    """Figure 13: one small contact on the four finest grids, after running in at 10 N."""
    of_load = chosen(cases, STATES[1], FORCES[-1])[-4:]
    x, y = (1e6 * value for value in local_contact(of_load[-1], SIZE))
    half = 0.5e6 * LOCAL_WINDOW
    figure = Figure(figsize=(8.6, 8.6), layout="constrained")
    for axes, case in zip(figure.subplots(2, 2).flat, of_load, strict=False):
        edges = np.linspace(-_HALF, _HALF, case.cells + 1)
        i, j = (_near(edges, centre, 1.5 * half) for centre in (x, y))
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
        axes.set(xlim=(x - half, x + half), ylim=(y - half, y + half), aspect="equal", **_PLACE)
        axes.set_title(f"{case.cells} x {case.cells}")
    figure.suptitle("A small contact, run in, 10 N: touching (yellow), at the limit (orange), sub-grid edge (red)")
    return figure


def _near(edges: np.ndarray, centre: float, reach: float) -> slice:
    """Return the cells within a reach from a position."""
    first, last = np.searchsorted(edges, (centre - reach, centre + reach))
    return slice(max(int(first) - 1, 0), min(int(last) + 1, len(edges) - 1))
