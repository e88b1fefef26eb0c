"""Normal stiffness: accuracy on balls, ellipses and rough surfaces, cost and figure: see docs/use/stiffness.md.

python docs/studies/stiffness.py
"""

from __future__ import annotations

import math
import statistics
import time
from pathlib import Path

import numpy as np
from doc_tables import DocTable, pick, some_of, write_tables
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import roughcontact as rc
from roughcontact._answers.linear.tangent import Tangent
from roughcontact.plotting import LIGHT, add_key, style

FIGURES = Path(__file__).parent.parent / "figures"
STEEL = rc.Elastic(young=210e9, poisson=0.3)
MODULUS = 210e9 / 0.91
RADIUS, CELL, SIZE = 5e-3, 1e-6, 256e-6
# Loads over E* times the rms slope.
LOADS = (0.01, 0.05, 0.2, 1.0)


def press_ball(cells: float, place: tuple[float, float], ratio: float = 1.0, aspect: float = 1.0) -> rc.Estimate:
    """Return the error of the stiffness of Hertz's contact, relative, with its uncertainty."""
    radii = RADIUS, RADIUS * ratio
    force = 4 / 3 * MODULUS * (cells * CELL) ** 3 / (RADIUS * math.sqrt(ratio))
    count = 2 * math.ceil(1.25 * cells * max(ratio, 1.0) ** 0.4 + 6)
    grid = rc.Grid((count, math.ceil(count / aspect)), count * CELL)
    centre = place[0] * grid.spacing[0], place[1] * grid.spacing[1]
    problem = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(radii, centre), STEEL), grid=grid)
    found, exact = problem.solve(force=force).stiffness(), hertz(radii, force)
    return rc.Estimate(found.value / exact - 1, found.uncertainty / exact, "")


def hertz(radii: tuple[float, float], force: float) -> float:
    """Return the stiffness of Hertz's contact, N/m: Johnson, Contact Mechanics (1985), section 4.2."""
    ratio = max(radii) / min(radii)
    if ratio == 1.0:
        return 2 * MODULUS * (3 * force * radii[0] / (4 * MODULUS)) ** (1 / 3)

    def miss(m: float) -> float:
        return float((ellipe(m) / (1 - m) - ellipk(m)) / (ellipk(m) - ellipe(m)) - ratio)

    m = brentq(miss, 1e-9, 1 - 1e-12)
    axis = (3 * force * max(radii) * (ellipk(m) - ellipe(m)) / (math.pi * MODULUS * m)) ** (1 / 3)
    return float(math.pi * MODULUS * axis / ellipk(m))


SUMMARY = ["mean error, %", "rms error, %", "mean uncertainty, %", "within two, %"]


def summarize(found: list[rc.Estimate]) -> list[str]:
    """Return the cells of `SUMMARY` for errors with their uncertainties, over the value."""
    errors, stds = (100 * np.array([getattr(one, name) for one in found]) for name in ("value", "uncertainty"))
    inside = 100 * np.mean(np.abs(errors) <= 2 * stds)
    return [f"{errors.mean():+.2f}", f"{np.sqrt(np.mean(errors**2)):.2f}", f"{stds.mean():.2f}", f"{inside:.0f}"]


def make_balls(radii: tuple[int, ...] = (3, 6, 12, 24), draws: int = 12) -> list[list[str]]:
    rows = [["radius, cells", "contact", *SUMMARY]]
    for cells in some_of(radii, 0, 1, 2):
        rng = np.random.default_rng(100 + cells)
        for name, ratio, aspect in (("ball", 1.0, 1.0), ("ball on cells 1 x 2", 1.0, 2.0), ("radii 1 : 4", 4.0, 1.0)):
            places = rng.uniform(-0.5, 0.5, (draws, 2))
            rows.append([str(cells), name, *summarize([press_ball(cells, place, ratio, aspect) for place in places])])
    return rows


def rough(cells: int, hurst: float, seed: int, boundary: str = "periodic", *, wide: bool = False) -> rc.ContactProblem:
    """Return a rough surface of 16 shortest waves a side, or with a roll-off at an eighth of the side."""
    waves = (
        {"shortest": SIZE / 16, "longest": SIZE / 2} if not wide else {"shortest": 8 * SIZE / cells, "longest": SIZE}
    )
    rolloff = {"rolloff": SIZE / 8} if wide else {}
    surface = rc.SelfAffineSurface(hurst=hurst, rms_slope=0.1, seed=seed, **waves, **rolloff)
    grid = rc.Grid((cells, cells), SIZE)
    return rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary=boundary, threads=1)


def make_rough(
    seeds: tuple[int, ...] = (11, 12, 13, 14), grids: tuple[int, ...] = (64, 128, 256), fine: int = 512
) -> list[list[str]]:
    rows = [["boundary, p/(E* slope)", "cells a shortest wave", *SUMMARY]]
    for boundary, load in (*(("periodic", load) for load in (0.01, 0.05, 0.2, 0.6)), ("free", 0.02), ("free", 0.2)):
        found: dict[int, list[rc.Estimate]] = {cells: [] for cells in grids}
        for seed in seeds:
            for hurst in (0.8, 0.3):
                pressure = load * 0.1 * MODULUS
                exact, *others = (
                    rough(cells, hurst, seed, boundary).solve(pressure=pressure).stiffness() for cells in (fine, *grids)
                )
                for cells, one in zip(grids, others, strict=True):
                    error, std = one.value / exact.value - 1, one.uncertainty / exact.value
                    found[cells].append(rc.Estimate(error, std, ""))
        rows += [[f"{boundary}, {load:g}", str(cells // 16), *summarize(found[cells])] for cells in grids]
    return rows


def measure(cells: int, boundary: str, load: float, repeats: int) -> list[float]:
    """Return the CPU time of a solve, s, and those of area, stiffness and conductance after it, over it."""
    problem = rough(cells, 0.8, 3, boundary, wide=True)
    times = []
    for _ in range(repeats + 1):
        clock = [time.process_time()]
        solution = problem.solve(pressure=load * 0.1 * MODULUS)
        for work in (solution.area, solution.stiffness, lambda: solution.conductance(50.0)):  # noqa: B023 - called here
            clock.append(time.process_time())
            work()
        times.append(np.diff([*clock, time.process_time()]))
    # The first round imports and prepares what the others need.
    solve, *others = (statistics.median(column) for column in zip(*times[1:], strict=True))
    return [solve, *(other / solve for other in others)]


def make_cost(grids: tuple[int, ...] = (512, 1024), repeats: int = 3) -> list[list[str]]:
    parts = ("solve, s", "area, %", "stiffness, %", "conductance, %")
    rows = [["boundary, cells", "p/(E* slope)", *parts]]
    for cells in grids:
        for boundary in ("periodic", "free"):
            for load in LOADS:
                solve, *others = measure(cells, boundary, load, repeats)
                shares = (f"{100 * other:.0f}" for other in others)
                rows.append([f"{boundary}, {cells}²", f"{load:g}", f"{solve:.2f}", *shares])
    return rows


def draw_answer(axes: Axes, cells: int) -> None:
    """Draw where a rough contact answers a small approach."""
    solution = rough(cells, 0.8, 3).solve(pressure=0.1 * 0.1 * MODULUS)
    answer = Tangent(solution).solve(np.ones((cells, cells)), 1e-3).values
    field = np.where(solution.contact, 1e-15 * answer, np.nan)
    extent = (-5e5 * SIZE, 5e5 * SIZE) * 2
    image = axes.imshow(field.T, origin="lower", extent=extent, cmap="viridis", vmax=np.nanpercentile(field, 98))
    axes.figure.colorbar(image, ax=axes, label="answer to an approach, dp/dδ, GPa/µm")
    axes.set(xlabel="x, µm", ylabel="y, µm")


def draw_balls(axes: Axes, draws: int) -> None:
    """Draw the errors of balls over their radius, and two standard deviations."""
    rng, radii = np.random.default_rng(5), np.geomspace(2, 30, draws)
    found = [press_ball(cells, rng.uniform(-0.5, 0.5, 2)) for cells in radii]
    errors, stds = (100 * np.array([getattr(one, name) for one in found]) for name in ("value", "uncertainty"))
    axes.errorbar(radii, errors, 2 * stds, fmt="o", color=LIGHT.lines[0], ms=4, lw=1)
    axes.axhline(0, color="0.5", lw=1)
    axes.set(xscale="log", xlabel="contact radius, cells", ylabel="error, %", title="ball, ± two standard deviations")
    axes.set_ylim(-3, 3)
    axes.minorticks_off()
    axes.set_xticks([2, 5, 10, 20], ["2", "5", "10", "20"])


def draw_law(axes: Axes, cells: int, loads: int) -> None:
    """Draw the stiffness of surfaces of three Hurst exponents over the load."""
    for hurst, color in zip((0.3, 0.5, 0.8), LIGHT.lines, strict=False):
        problem = rough(cells, hurst, 4, wide=True)
        height = float(problem.initial_gap.std())
        pressures = np.geomspace(3e-3, 0.4, loads) * 0.1 * MODULUS
        found = [one.stiffness().value for one in problem.sweep(pressure=pressures.tolist()).states]
        law = np.array(found) / SIZE**2 * height / pressures
        axes.plot(pressures / (0.1 * MODULUS), law, "o-", color=color, ms=4, label=f"Hurst exponent {hurst:g}")
    add_key(axes)
    axes.set(xscale="log", ylim=(0, None), xlabel="p / (E* slope)", ylabel="k h$_{rms}$ / p")


@style()
def main(cells: int = 256, draws: int = 24, loads: int = 8, folder: Path = FIGURES) -> None:
    figure = Figure(figsize=(13, 4), layout="constrained")
    answer, balls, law = figure.subplots(1, 3)
    draw_answer(answer, cells)
    draw_balls(balls, draws)
    draw_law(law, cells, loads)
    figure.savefig(folder / "stiffness.png", dpi=110)


# The lines of the page.
RADII = ("3", "6", "12")
ROUGH = ("periodic, 0.01", "periodic, 0.2", "periodic, 0.6", "free, 0.2")
COSTS = ("periodic, 1024²; 0.2", "periodic, 1024²; 1", "free, 1024²; 0.2")
TABLES = {
    "stiffness-balls": DocTable(make_balls, seconds=12, units=3, shown=pick(lines=RADII)),
    "stiffness-rough": DocTable(make_rough, seconds=150, units=3, shown=pick(lines=ROUGH)),
    "stiffness-cost": DocTable(
        make_cost, seconds=150, timed=("solve, s", "area, %", "stiffness, %", "conductance, %"), shown=pick(lines=COSTS)
    ),
}

if __name__ == "__main__":
    write_tables(TABLES)
    main()
