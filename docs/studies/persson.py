"""The table and the figure of docs/understand/theory.md: Persson's area, gap and stiffness beside solved ones.

Self-affine surfaces of three Hurst exponents, 512 x 512 cells, eight cells on the shortest wave, roll-off at an
eighth of the side. The stiffness solved is the difference of the mean gaps at 2 % below and above the load.

python docs/studies/persson.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from doc_tables import DocTable, pick, write_tables

import roughcontact as rc
from roughcontact.plotting import add_key, style

FIGURES = Path(__file__).parent.parent / "figures"
HURST, SEEDS = (0.3, 0.5, 0.8), (1, 2, 3)
# Pressure over E* and rms slope.
LOADS = (0.003, 0.01, 0.03, 0.1, 0.2)
CELLS, WAVES, ROLLOFF = 512, 64, 8
STEP = 0.02


def measure(hurst: float, seed: int, loads: tuple[float, ...] = LOADS, cells: int = CELLS) -> np.ndarray:
    """Return for each load the solved area, and of area, mean gap and stiffness the theory beside it.

    Area and stiffness are ratios, theory over solved; the gap is theory less solved, over the rms height.
    """
    waves = WAVES * cells // CELLS
    surface = rc.SelfAffineSurface(
        hurst=hurst, rms_slope=0.1, shortest=1.0 / waves, longest=1.0, rolloff=1.0 / ROLLOFF, seed=seed
    )
    grid = rc.Grid((cells, cells), 1.0)
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.0)), grid=grid, boundary="periodic")
    heights = surface.heights(grid)
    unit = problem.plan.modulus * 0.1
    rows = []
    for load in sorted(loads, reverse=True):
        pressures = unit * load * np.array([1.0 + STEP, 1.0, 1.0 - STEP])
        above, at, below = problem.sweep(pressure=pressures).states
        theory = rc.reference.persson(heights, grid, problem.plan.modulus, pressures[1])
        gaps = [float(np.mean(one.gap)) for one in (above, at, below)]
        stiffness = (pressures[0] - pressures[2]) / (gaps[2] - gaps[0])
        area = at.area().fraction
        rows.append(
            [
                area,
                float(theory.area_fraction) / area,
                (float(theory.mean_gap) - gaps[1]) / float(heights.std()),
                float(theory.stiffness) / stiffness,
            ]
        )
    return np.array(rows[::-1])


def make_rows() -> list[list[str]]:
    found = np.array([[measure(hurst, seed) for seed in SEEDS] for hurst in HURST])
    heading = ["p / (E* slope)", "Hurst", "solved area, %", "area, theory / solved"]
    rows = [[*heading, "mean gap, (theory - solved) / rms height", "stiffness, theory / solved"]]
    for k, load in enumerate(LOADS):
        for i, hurst in enumerate(HURST):
            mean, spread = found[i, :, k].mean(axis=0), found[i, :, k].std(axis=0, ddof=1)
            cells = [f"{mean[j]:.{digits}f} ± {spread[j]:.{digits}f}" for j, digits in ((1, 3), (2, 3), (3, 3))]
            rows.append([f"{load:g}", f"{hurst:g}", f"{100 * mean[0]:.2f}", *cells])
    return rows


@style()
def draw(folder: Path = FIGURES, cells: int = 256) -> None:
    """Draw area and mean gap over the load, solved and after Persson."""
    from matplotlib.figure import Figure

    grid = rc.Grid((cells, cells), 1.0)
    figure = Figure(figsize=(9.5, 3.6), layout="constrained")
    area, gap = figure.subplots(1, 2)
    loads = np.geomspace(0.002, 0.3, 14)
    for hurst, color, marker in ((0.3, "C0", "o"), (0.8, "C1", "x")):
        surface = rc.SelfAffineSurface(
            hurst=hurst, rms_slope=0.1, shortest=8.0 / cells, longest=1.0, rolloff=1.0 / ROLLOFF, seed=1
        )
        problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.0)), grid=grid, boundary="periodic")
        heights = surface.heights(grid)
        pressures = loads * problem.plan.modulus * 0.1
        solutions = problem.sweep(pressure=pressures).states
        theory = rc.reference.persson(heights, grid, problem.plan.modulus, pressures)
        rms = float(heights.std())
        area.loglog(
            loads,
            [one.area().fraction for one in solutions],
            marker,
            color=color,
            markerfacecolor="none",
            label=f"Hurst exponent {hurst:g}",
        )
        area.loglog(loads, theory.area_fraction, "-", color=color, label=f"Persson, {hurst:g}")
        gap.semilogx(
            loads, [float(np.mean(one.gap)) / rms for one in solutions], marker, color=color, markerfacecolor="none"
        )
        gap.semilogx(loads, theory.mean_gap / rms, "-", color=color)
    area.set(xlabel="pressure / (E* rms slope)", ylabel="area over nominal area")
    gap.set(xlabel="pressure / (E* rms slope)", ylabel="mean gap / rms height", title="mean gap")
    area.set_title("real contact area", pad=34)
    add_key(area)
    for axes in (area, gap):
        axes.grid(True)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "theory_beside.png", dpi=120)


# The lines of the page: one Hurst exponent.
LINES = ("0.003; 0.8", "0.03; 0.8", "0.2; 0.8")
TABLES = {"persson": DocTable(make_rows, seconds=200, shown=pick(lines=LINES))}

if __name__ == "__main__":
    draw()
    write_tables(TABLES)
