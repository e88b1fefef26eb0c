"""Figures and tables of the page "Which area estimator?".

Writes docs/figures/one_summit.png (the edge of one contact at four resolutions, by each estimator),
docs/figures/estimator_errors.png (errors against the grid) and the page's two tables.

    python docs/studies/which_estimator.py
"""

from __future__ import annotations

import statistics
import time
from functools import lru_cache
from pathlib import Path

import attrs
import numpy as np
from doc_tables import DocTable, read, show_none, some_of, write_tables
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.plotting import LIGHT, scale_axes, style
from roughcontact_paper import published

FIGURES = Path(__file__).parent.parent / "figures"
NAMES = ("cell-count", "perimeter", "level-set", "level-set-richardson", "hertz", "blend")
GRIDS = (100, 128, 160, 200, 256, 320, 512, 1024)
ROUGH_GRIDS = (64, 128, 256, 512)
LOAD = 100  # MPa
WAVES = 20  # a side
WAVE = 12.5e-6


def wavy(cells: int, waves: int = WAVES, phase: tuple[float, float] = (0.0, 0.0)) -> rc.ContactProblem:
    """Return the paper's wave, a summit in the middle of the domain unless the phase says otherwise."""
    surface = rc.WavySurface(amplitude=0.5e-6, wavelength=WAVE, phase=phase)
    body = rc.Body(surface, rc.Elastic(young=200e9, poisson=0.3))
    return rc.ContactProblem(body, grid=rc.Grid((cells, cells), waves * WAVE), boundary="periodic", threads=1)


def rough(cells: int) -> rc.ContactProblem:
    """Return a surface of 32 shortest waves a side, Hurst exponent 0.8, rms slope 0.1, the same one on every grid."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=1.0, longest=16.0, rolloff=8.0, seed=51)
    known = rc.HeightMap(surface.heights(rc.Grid((128, 128), 32.0)), size=32.0, periodic=True)
    body = rc.Body(known.resample((cells, cells), "fourier"), rc.Elastic(1.0, 0.0))
    return rc.ContactProblem(body, boundary="periodic", threads=1)


def draw_summit(axes: Axes, cells: int) -> None:
    """Draw one contact of the paper's wave by each estimator."""
    solution = wavy(cells, waves=1, phase=(1.0, 2.0)).solve(pressure=1e6 * LOAD)
    dx, _ = solution.grid.spacing
    x, y = 1e6 * solution.grid.x.ravel(), 1e6 * solution.grid.y.ravel()
    peak = -np.array((1.0, 2.0)) / (2 * np.pi) * WAVE * 1e6
    shown = np.where(solution.contact, solution.pressure, np.nan).T / 1e9
    axes.pcolormesh(x - peak[0], y - peak[1], shown, cmap="Greys", vmin=0, vmax=25)
    true = np.sqrt(published.TRUE_AREA[LOAD] / 100 / np.pi) * WAVE * 1e6
    angle = np.linspace(0, 2 * np.pi, 200)
    blue, orange, black, *_ = LIGHT.lines
    axes.plot(true * np.cos(angle), true * np.sin(angle), "-", color=black, lw=3, label="true")
    for number, line in enumerate(rc.LevelSet().contours(solution)):
        axes.plot(*(1e6 * line - peak).T, "-", color=orange, label="_" * (number > 0) + "level-set")
    # Circles of the same area, for these two have no edge.
    for name, dashes, color in (("cell-count", "-.", blue), ("blend", ":", "white")):
        radius = np.sqrt(solution.area(name).value / np.pi) * 1e6
        axes.plot(radius * np.cos(angle), radius * np.sin(angle), dashes, color=color, lw=1.6, label=name)
    axes.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3), aspect="equal", xlabel="x, µm")
    axes.set_title(f"{WAVE / dx:.3g} cells a wave ({np.count_nonzero(solution.contact)} in contact)")


def measure_errors(problems: dict[int, rc.ContactProblem], load: float, true: float, repeats: int) -> dict[int, dict]:
    """Return errors and uncertainties in per cent, and CPU times in seconds, on each grid."""
    rows = {}
    for cells, problem in problems.items():
        solves, row = [], {}
        for _ in some_of(range(repeats), 0):
            started = time.process_time()
            solution = attrs.evolve(problem).solve(pressure=load)
            solves.append(time.process_time() - started)
        for name in NAMES:
            times = []
            for _ in some_of(range(repeats), 0):
                fresh = attrs.evolve(solution)
                started = time.process_time()
                area = fresh.area(name)
                times.append(time.process_time() - started)
            row[name] = (
                100 * (area.fraction / true - 1),
                100 * area.uncertainty / area.value,
                statistics.median(times),
            )
        rows[cells] = {"solve": statistics.median(solves), **row}
    return rows


def make_table(rows: dict[int, dict]) -> list[list[str]]:
    lines = [["N", "solve, s", "blend, s", *(f"{name}, %" for name in NAMES)]]
    for cells, row in rows.items():
        found = [f"{row[name][0]:+.3g} (± {row[name][1]:.2g})" for name in NAMES]
        lines.append([str(cells), f"{row['solve']:.3f}", f"{row['blend'][2]:.3f}", *found])
    return lines


@lru_cache
def measure_wave(grids: tuple[int, ...] = GRIDS, repeats: int = 3) -> dict[int, dict]:
    problems = {n: wavy(n) for n in some_of(grids, 0, 1, 2, 4, 6)}
    return measure_errors(problems, 1e6 * LOAD, published.TRUE_AREA[LOAD] / 100, repeats)


@lru_cache
def measure_rough(grids: tuple[int, ...] = ROUGH_GRIDS, finest: int = 1024, repeats: int = 3) -> dict[int, dict]:
    true = rough(finest).solve(pressure=2.5e-3).area().fraction
    return measure_errors({n: rough(n) for n in some_of(grids, 0, 1, 2)}, 2.5e-3, true, repeats)


def draw_errors(axes: Axes, lines: list[list[str]], waves: float, title: str) -> None:
    """Draw the errors of a table over the grid: filled where a wave has no whole number of cells."""
    cells = [int(line[0]) for line in lines[1:]]
    whole = [waves > 0 and n % waves == 0 for n in cells]
    colors = (*LIGHT.lines[:5], LIGHT.limit)
    for name, marker, color in zip(NAMES, "os^v<D", colors, strict=True):
        column = lines[0].index(f"{name}, %")
        errors = [max(abs(float(line[column].split()[0])), 1e-3) for line in lines[1:]]
        found = [(n, error) for n, error, cut in zip(cells, errors, whole, strict=True) if not cut]
        axes.plot(*zip(*found, strict=True), f"{marker}-", color=color, label=name)
        alike = [(n, error) for n, error, cut in zip(cells, errors, whole, strict=True) if cut]
        axes.plot([n for n, _ in alike], [error for _, error in alike], marker, color=color, mfc="none")
    scale_axes(axes, x="cells along a side", y="error of the area, %", logarithmic="xy")
    axes.set_title(title)
    axes.set_xticks(cells, [str(n) for n in cells])
    axes.set_xticks([], minor=True)


def main(wave: list[list[str]], rough_lines: list[list[str]], folder: Path = FIGURES) -> None:
    """Draw both figures, the second from the lines of the tables."""
    folder.mkdir(parents=True, exist_ok=True)
    with style():
        figure = Figure(figsize=(13, 4.1), layout="constrained")
        panels = figure.subplots(1, 4, sharey=True)
        for axes, cells in zip(panels, (8, 16, 32, 64), strict=True):
            draw_summit(axes, cells)
        panels[0].set_ylabel("y, µm")
        handles, names = panels[-1].get_legend_handles_labels()
        # White is seen on the cells, not on the paper.
        figure.legend(handles, names, loc="outside upper center", ncols=4, facecolor="0.6", frameon=True)
        figure.savefig(folder / "one_summit.png", dpi=120)

        figure = Figure(figsize=(11, 4.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        draw_errors(left, wave, WAVES, f"the paper's wave, {LOAD} MPa (open: whole cells a wave)")
        draw_errors(right, rough_lines, 0, "self-affine, 6 % contact, 2 to 16 cells a shortest wave")
        figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=6)
        figure.savefig(folder / "estimator_errors.png", dpi=120)


TIMES = ("solve, s", "blend, s")
TABLES = {
    "wave-estimators": DocTable(lambda: make_table(measure_wave()), seconds=40, timed=TIMES, units=2, shown=show_none),
    "rough-estimators": DocTable(
        lambda: make_table(measure_rough()), seconds=30, timed=TIMES, units=2, shown=show_none
    ),
}

if __name__ == "__main__":
    write_tables(TABLES)
    main(read("wave-estimators"), read("rough-estimators"))
