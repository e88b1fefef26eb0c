"""Figures 4 to 6 of the paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import roughcontact as rc
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from roughcontact.plotting import LIGHT, style

from roughcontact_paper import published
from roughcontact_paper.output import label_grids
from roughcontact_paper.wave import AMPLITUDE, SIZE, WAVELENGTH, WaveCase, summit_positions
from roughcontact_paper.wave_tables import fit_areas


def draw_wave_figures(cases: Sequence[WaveCase]) -> Mapping[str, Figure]:
    """Return Figures 3 to 6 by name."""
    with style():
        return {
            "figure3": _draw_surface(),
            "figure4": _draw_errors(cases),
            "figure5": _draw_summit(cases),
            "figure6": _draw_extrapolations(cases),
        }


def _draw_surface() -> Figure:
    """Figure 3: the sinusoidal surface, four waves of it in space, and its section through the summits."""
    figure = Figure(figsize=(11, 4.4), layout="constrained")
    left = figure.add_subplot(1, 2, 1, projection="3d")
    right = figure.add_subplot(1, 2, 2)
    grid = rc.Grid((128, 128), 4 * WAVELENGTH)
    heights = 1e6 * rc.WavySurface(AMPLITUDE, WAVELENGTH).heights(grid)
    x, y = np.broadcast_arrays(1e6 * grid.x, 1e6 * grid.y)
    left.plot_surface(x, y, heights, cmap="cividis", rcount=128, ccount=128)
    left.set_box_aspect((1, 1, 0.25))
    left.set(title="(a) 4 of 20 x 20 waves", xlabel="x, µm", ylabel="y, µm", zlabel="z, µm", zticks=(-1, 0, 1))
    along = np.linspace(-0.5 * SIZE, 0.5 * SIZE, 4001)
    for place, label in ((0.0, "through the summits"), (0.5 * WAVELENGTH, "half a wave beside them")):
        waves = np.cos(2 * np.pi * along / WAVELENGTH) + np.cos(2 * np.pi * place / WAVELENGTH)
        right.plot(1e6 * along, 1e6 * AMPLITUDE * waves, label=label)
    right.set(xlabel="x, µm", ylabel="z, µm", xlim=(-0.5e6 * SIZE, 0.5e6 * SIZE), ylim=(-1.2, 1.2))
    right.set_title("(b) sections", pad=22)
    right.legend(ncols=2, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)
    right.grid(True)
    return figure


def _of_load(cases: Sequence[WaveCase], load: int) -> list[WaveCase]:
    return [case for case in cases if case.load == load]


def _draw_errors(cases: Sequence[WaveCase]) -> Figure:
    """Figure 4: errors against the grid."""
    figure = Figure(figsize=(11, 4.2), layout="constrained")
    for axes, load in zip(figure.subplots(1, 3, sharey=True), published.LOADS, strict=True):
        chosen = _of_load(cases, load)
        cells = [case.cells for case in chosen]
        for label, values, true, marker in (
            ("area, counted cells", [case.area for case in chosen], published.TRUE_AREA, "o-"),
            ("area, sub-grid", [case.default_area for case in chosen], published.TRUE_AREA, "s-"),
            ("maximum pressure", [case.p_max for case in chosen], published.TRUE_P_MAX, "^-"),
        ):
            axes.plot(cells, _errors(values, true[load]), marker, label=label)
        for label, printed, true, marker in (
            ("area, as printed", published.SAM_AREA, published.TRUE_AREA, "x"),
            ("maximum pressure, as printed", published.SAM_P_MAX, published.TRUE_P_MAX, "+"),
        ):
            axes.plot(published.GRIDS, _errors(printed[load], true[load]), marker, color=LIGHT.ink, ms=6, label=label)
        axes.set_yscale("log")
        label_grids(axes)
        axes.set_title(f"{load} MPa")
        axes.grid(True)
    figure.axes[0].set_ylabel("magnitude of the error against the\nconverged values, %")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    return figure


def _errors(values: Sequence[float], true: float) -> list[float]:
    return [100 * abs(value / true - 1) for value in values]


def _draw_summit(cases: Sequence[WaveCase]) -> Figure:
    """Figure 5: the cells in contact on one summit at the four finest grids, 100 MPa."""
    figure = Figure(figsize=(8.4, 8.4), layout="constrained")
    radius = 1e6 * np.sqrt(published.TRUE_AREA[100] / 100 / np.pi) * WAVELENGTH
    chosen = _of_load(cases, 100)[-4:]
    for axes, case in zip(figure.subplots(2, 2).flat, chosen, strict=False):
        position = 1e6 * summit_positions(case)
        half = 0.5e6 * case.spacing
        edges = np.append(position - half, position[-1] + half)
        lines = {"edgecolors": "0.75", "linewidth": 0.2} if case.cells <= 1024 else {}
        axes.pcolormesh(
            edges, edges, case.summit.T, cmap=ListedColormap([LIGHT.open, LIGHT.body]), vmin=0, vmax=1, **lines
        )
        axes.add_patch(Circle((0, 0), radius, fill=False, edgecolor=LIGHT.limit, linewidth=2.2))
        window = 2.6 * radius
        axes.set(xlim=(-window, window), ylim=(-window, window), aspect="equal")
        axes.set_title(
            f"{case.cells} x {case.cells}: counted area {100 * (case.area / published.TRUE_AREA[100] - 1):+.1f} %"
        )
        axes.set(xlabel="x from the summit, µm", ylabel="y, µm")
    names = [
        Patch(color=LIGHT.body, label="cells in contact"),
        Line2D([], [], color=LIGHT.limit, linewidth=2.2, label="circle of the converged area"),
    ]
    figure.legend(handles=names, title="one summit at 100 MPa", loc="outside upper center", ncols=2)
    return figure


def _draw_extrapolations(cases: Sequence[WaveCase]) -> Figure:
    """Figure 6: extrapolation by eq. 28."""
    figure = Figure(figsize=(7, 5), layout="constrained")
    axes = figure.subplots()
    for color, load in zip(LIGHT.lines[:3], published.LOADS, strict=True):
        chosen = _of_load(cases, load)
        decay, _ = fit_areas(cases, load)
        cells = np.geomspace(published.GRIDS[0], 1.4 * published.GRIDS[-1], 300)
        curve = decay.value + decay.parameters["k"] * np.exp(-cells / decay.parameters["t"])
        axes.plot(
            [case.cells for case in chosen],
            [case.area for case in chosen],
            "o",
            color=color,
            label=f"{load} MPa, counted",
        )
        axes.plot(cells, curve, "-", color=color, label=f"eq. 28 fitted: {decay.value:.3f} %")
        axes.axhline(
            published.TRUE_AREA[load],
            color=color,
            linestyle=":",
            label=f"converged: {published.TRUE_AREA[load]:.3f} %",
        )
    label_grids(axes)
    axes.set(ylabel="real contact area, % of nominal", ylim=(0, None))
    axes.legend(ncols=3, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)
    axes.grid(True)
    return figure
