"""Figures 4 to 6 of the paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import FixedLocator, NullLocator

from roughcontact.paper import printed
from roughcontact.paper.scene import WAVELENGTH, Case, summit_positions
from roughcontact.paper.tables import fits

_DPI = 150


def draw_all(cases: Sequence[Case], folder: Path) -> tuple[Path, ...]:
    """Draw figures 4, 5 and 6 as PNG files into `folder` and return their paths."""
    return saved({"figure4": _errors(cases), "figure5": _summit(cases), "figure6": _extrapolations(cases)}, folder)


def saved(figures: Mapping[str, Figure], folder: Path) -> tuple[Path, ...]:
    """Write figures as PNG files into `folder` and return their paths."""
    paths = []
    for name, figure in figures.items():
        path = folder / f"{name}.png"
        figure.savefig(path, dpi=_DPI)
        paths.append(path)
    return tuple(paths)


def _of_load(cases: Sequence[Case], load: int) -> list[Case]:
    return [case for case in cases if case.load == load]


def grid_axis(axes: Axes) -> None:
    """Make the x axis that of the cells along a side."""
    axes.set_xscale("log", base=2)
    axes.xaxis.set_major_locator(FixedLocator(printed.GRIDS))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xticklabels([str(cells) for cells in printed.GRIDS])
    axes.set_xlabel("cells along a side")


def _errors(cases: Sequence[Case]) -> Figure:
    """Figure 4: errors against the grid."""
    figure = Figure(figsize=(11, 4), layout="constrained")
    for axes, load in zip(figure.subplots(1, 3, sharey=True), printed.LOADS, strict=True):
        chosen = _of_load(cases, load)
        cells = [case.cells for case in chosen]
        ours = {
            "area, cells counted": ([case.area for case in chosen], printed.TRUE_AREA, "o-"),
            "area, perimeter estimator": ([case.perimeter_area for case in chosen], printed.TRUE_AREA, "s-"),
            "maximum pressure": ([case.p_max for case in chosen], printed.TRUE_P_MAX, "^-"),
        }
        for label, (values, true, style) in ours.items():
            axes.plot(cells, 100 * np.abs(np.array(values) / true[load] - 1), style, label=label)
        for print_, analytic, style, label in (
            (printed.SAM_AREA, printed.ANALYTIC_AREA, "kx", "area, as printed"),
            (printed.SAM_P_MAX, printed.ANALYTIC_P_MAX, "k+", "maximum pressure, as printed"),
        ):
            axes.plot(printed.GRIDS, 100 * np.abs(np.array(print_[load]) / analytic[load] - 1), style, label=label)
        axes.set_yscale("log")
        grid_axis(axes)
        axes.set_title(f"{load} MPa")
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel("error, % (ours: against converged;\nprinted: against eq. 26, 27)")
    figure.axes[0].legend(fontsize=8)
    return figure


def _summit(cases: Sequence[Case]) -> Figure:
    """Figure 5: the cells in contact on one summit at the four finest grids, 100 MPa."""
    figure = Figure(figsize=(8.4, 8.4), layout="constrained")
    radius = 1e6 * np.sqrt(printed.TRUE_AREA[100] / 100 / np.pi) * WAVELENGTH
    chosen = _of_load(cases, 100)[-4:]
    for axes, case in zip(figure.subplots(2, 2).flat, chosen, strict=False):
        position, half = 1e6 * summit_positions(case), 0.5e6 * case.spacing
        edges = np.append(position - half, position[-1] + half)
        lines = {"edgecolors": "0.6", "linewidth": 0.2} if case.cells <= 1024 else {}
        axes.pcolormesh(
            edges, edges, case.summit.T, cmap=ListedColormap(["#2b4c8c", "#f4d35e"]), vmin=0, vmax=1, **lines
        )
        axes.add_patch(Circle((0, 0), radius, fill=False, edgecolor="#d1495b", linewidth=1.8))
        window = 2.6 * radius
        axes.set(xlim=(-window, window), ylim=(-window, window), aspect="equal")
        axes.set_title(f"{case.cells} x {case.cells}: count {100 * (case.area / printed.TRUE_AREA[100] - 1):+.1f} %")
        axes.set(xlabel="x from the summit, µm", ylabel="y, µm")
    figure.suptitle("Cells in contact on one summit at 100 MPa (yellow) and the true contact (red)")
    return figure


def _extrapolations(cases: Sequence[Case]) -> Figure:
    """Figure 6: extrapolation by eq. 28."""
    figure = Figure(figsize=(7, 5), layout="constrained")
    axes = figure.subplots()
    for color, load in zip(("#1b6ca8", "#d1495b", "#3c8d53"), printed.LOADS, strict=True):
        chosen = _of_load(cases, load)
        decay, _ = fits(cases, load)
        cells = np.geomspace(printed.GRIDS[0], 1.4 * printed.GRIDS[-1], 300)
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
            printed.TRUE_AREA[load],
            color=color,
            linestyle=":",
            label=f"converged: {printed.TRUE_AREA[load]:.3f} %",
        )
    grid_axis(axes)
    axes.set(ylabel="real contact area, % of nominal", ylim=(0, None))
    axes.legend(fontsize=8, ncols=3, loc="upper right")
    axes.grid(alpha=0.3)
    return figure
