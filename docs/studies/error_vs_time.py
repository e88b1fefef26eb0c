"""Error against run time on the paper's wave at 100 MPa: one solve on N x N cells, each area estimator.

Writes docs/figures/error_vs_time.png and its table in docs/trust/standing.md. At N = 160, 200, 240, 260 and 320 a
wave has a whole number of cells, and every summit meets the grid in the same way; on the other grids their errors
average. Times are CPU times of the solve and its area, kernel included, medians over repeats after a warm-up. The
converged values come from plugins/roughcontact-paper, which must be installed.

    python docs/studies/error_vs_time.py
"""

from __future__ import annotations

import functools
import statistics
import time
from pathlib import Path

from doc_tables import DocTable, read, some_of, write_tables
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.plotting import LIGHT, add_key, scale_axes, style
from roughcontact_paper import published

FIGURES = Path(__file__).parent.parent / "figures"
GRIDS = (64, 128, 160, 200, 240, 250, 256, 260, 320, 512, 1024)
# Waves along a side.
WAVES = 20
REPEATS = 5
NAMES = ("cell-count", "perimeter", "blend")
# Decimals of the errors in the table.
DIGITS = {"perimeter": 1, "blend": 3}


def problem(cells: int) -> rc.ContactProblem:
    """Return twenty wavelengths a side on a periodic domain."""
    surface = rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6)
    body = rc.Body(surface, rc.Elastic(young=200e9, poisson=0.3))
    return rc.ContactProblem(body, grid=rc.Grid((cells, cells), 250e-6), boundary="periodic", threads=1)


@functools.cache
def measure(cells: int, repeats: int = REPEATS) -> dict[str, float]:
    """Return errors and standard deviations in per cent, and the median CPU time in seconds."""
    times = []
    for _ in some_of(range(repeats + 1), 0, 1):
        started = time.process_time()
        solution = problem(cells).solve(pressure=100e6)
        solution.area()
        times.append(time.process_time() - started)
    errors = {name: 100 * (100 * solution.area(name).fraction / published.TRUE_AREA[100] - 1) for name in NAMES}
    stds = {
        f"{name} std": 100 * 100 * solution.area(name).uncertainty / solution.grid.area / published.TRUE_AREA[100]
        for name in NAMES
    }
    peak, true = solution.peak_pressure(), 1e9 * published.TRUE_P_MAX[100]
    stds["p_max std"], p_max = 100 * peak.uncertainty / true, 100 * (peak.value / true - 1)
    return {"cpu": statistics.median(times[1:]), "p_max": p_max, "iterations": solution.iterations, **errors, **stds}


def make_rows(grids: tuple[int, ...] = GRIDS, repeats: int = REPEATS) -> list[list[str]]:
    lines = [["N", "CPU time, s", "iterations", "cell count, %", "perimeter, % (std)", "blend, % (std)"]]
    lines[0].append("maximum pressure, % (std)")
    for cells in some_of(grids, 0, 1, 2, 5, 6):
        row = measure(cells, repeats)
        areas = [f"{row[name]:+.{digits}f} (± {row[f'{name} std']:.{digits}f})" for name, digits in DIGITS.items()]
        known = [f"{cells}", f"{row['cpu']:.3f}", f"{row['iterations']}", f"{row['cell-count']:+.1f}"]
        lines.append([*known, *areas, f"{row['p_max']:+.2f} (± {row['p_max std']:.2f})"])
    return lines


def _points(rows: dict[int, dict[str, float]], name: str) -> tuple[list[float], list[float]]:
    return [row["cpu"] for row in rows.values()], [abs(row[name]) for row in rows.values()]


@style()
def draw(rows: dict[int, dict[str, float]], path: Path) -> None:
    figure = Figure(figsize=(6, 4.2), layout="constrained")
    axes = figure.subplots()
    alike = {cells: row for cells, row in rows.items() if cells % WAVES == 0}
    others = {cells: row for cells, row in rows.items() if cells % WAVES}
    joined = {cells: row for cells, row in others.items() if cells.bit_count() == 1}
    for name, marker in (("cell-count", "o"), ("perimeter", "s"), ("blend", "D"), ("p_max", "^")):
        label = "maximum pressure" if name == "p_max" else f"area, {name}"
        (line,) = axes.loglog(*_points(joined, name), f"{marker}-", label=label)
        axes.loglog(*_points(others, name), marker, color=line.get_color())
        axes.loglog(*_points(alike, name), marker, color=line.get_color(), markerfacecolor="none")
    for cells, row in joined.items():
        place = row["cpu"], row["cell-count"]
        text, shift = (f"N = {cells}", (5, 4)) if cells == min(joined) else (f"{cells}", (1, -13))
        axes.annotate(text, place, xytext=shift, textcoords="offset points", fontsize=8)
    times = [row["cpu"] for row in rows.values()]
    axes.set_xlim(0.8 * min(times), 1.35 * max(times))
    axes.plot([], [], "o", color=LIGHT.ink, markerfacecolor="none", label="open: whole cells a wave")
    scale_axes(axes, x="CPU time of one solve, s", y="error, %", logarithmic="xy")
    ticks = [0.02, 0.05, 0.1, 0.2]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    add_key(axes)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)


def read_rows() -> dict[int, dict[str, float]]:
    """Return what the stored table holds."""
    names = ("cpu", "iterations", "cell-count", "perimeter", "blend", "p_max")
    lines = read("error-vs-time")[1:]
    return {
        int(line[0]): {name: float(text.split()[0]) for name, text in zip(names, line[1:], strict=True)}
        for line in lines
    }


def main(grids: tuple[int, ...] = GRIDS, repeats: int = REPEATS, folder: Path = FIGURES) -> None:
    draw({cells: measure(cells, repeats) for cells in grids}, folder / "error_vs_time.png")


TABLES = {"error-vs-time": DocTable(make_rows, seconds=14, timed=("CPU time, s", "iterations"), units=2)}

if __name__ == "__main__":
    write_tables(TABLES)
    draw(read_rows(), FIGURES / "error_vs_time.png")
