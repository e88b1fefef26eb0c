"""Two measured maps as a pair, step by step: the figure and the table of docs/pairs.md.

python docs/studies/measured_pair.py FOLDER, or with ROUGHCONTACT_MAPS=FOLDER

The folder holds x3p-2.x3p and opd-1.opd, example files of the SurfaceTopography project (MIT licence), which also
reads them: pip install SurfaceTopography.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
from doc_tables import DocTable, write
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.typing import MatchedPair

FIGURES = Path(__file__).parent.parent / "figures"
STEEL = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=6e9)
FORCES = (0.05, 0.1, 0.2, 0.4)


def matched(maps: Path) -> tuple[list[rc.HeightMap], list[rc.HeightMap], MatchedPair]:
    """Return the maps as read, their roughness, and both on a common grid."""
    read = [rc.read_surface(maps / "x3p-2.x3p"), rc.read_surface(maps / "opd-1.opd", non_measured="keep")]
    rough = [read[0].separate(2).roughness, read[1].separate("plane").roughness]
    return read, rough, rc.match(*rough, mirrored=True, rotation=np.deg2rad(20), method="cubic")


def heights(axes: Axes, values: np.ndarray, size: tuple[float, float], title: str) -> None:
    low, high = np.percentile(values, (0.5, 99.5))
    extent = (-0.5e6 * size[0], 0.5e6 * size[0], -0.5e6 * size[1], 0.5e6 * size[1])
    image = axes.imshow(1e9 * values.T, origin="lower", extent=extent, vmin=1e9 * low, vmax=1e9 * high)
    axes.figure.colorbar(image, ax=axes, label="height, nm", extend="both", location="bottom")
    axes.set(title=title, xlabel="x, µm", ylabel="y, µm")


def draw(maps: Path, problem: rc.ContactProblem, solution: rc.ContactSolution, folder: Path) -> None:
    read, rough, pair = matched(maps)
    figure = Figure(figsize=(14, 11.5), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.45, 1))
    top = upper.subplots(1, 4, width_ratios=(0.83, 0.83, 1.26, 1.26))
    panels = lower.subplots(1, 4)
    names = "machined", "isotropic"
    for k in (0, 1):
        heights(top[2 * k], read[k].values, read[k].size, f"{names[k]}, as read")
        heights(top[2 * k + 1], rough[k].values, rough[k].size, f"{names[k]}, form removed")
    for axes, side, name in zip(panels[:2], (pair.body, pair.counterbody), names, strict=True):
        heights(axes, side.heights(pair.grid), pair.grid.size, f"{name}, on the common grid")
    heights(panels[2], -problem.initial_gap, pair.grid.size, "sum, with a sphere")
    kinds = solution.contact.astype(float) + solution.saturated
    lx, ly = pair.grid.size
    extent = (-0.5e6 * lx, 0.5e6 * lx, -0.5e6 * ly, 0.5e6 * ly)
    colors = ListedColormap(["#2b4c8c", "#f4d35e", "#d1495b"])
    image = panels[3].imshow(
        kinds.T, origin="lower", extent=extent, cmap=colors, vmin=-0.5, vmax=2.5, interpolation="nearest"
    )
    bar = figure.colorbar(image, ax=panels[3], ticks=[0, 1, 2], location="bottom")
    bar.ax.set_xticklabels(["open", "contact", "saturated"])
    panels[3].set(title=f"contact at {solution.force:.2g} N", xlabel="x, µm", ylabel="y, µm")
    figure.savefig(folder / "measured_pair.png", dpi=110)


def make_problem(maps: Path, shape: tuple[int, int] | None = None) -> rc.ContactProblem:
    """Return the pair with the nominal sphere, on its own grid or a coarser one."""
    *_, pair = matched(maps)
    grid = pair.grid if shape is None else rc.Grid(shape, pair.grid.size)
    ball = pair.body + rc.SphereSurface(radius=5e-3)
    return rc.ContactProblem(rc.Body(ball, STEEL), rc.Body(pair.counterbody, STEEL), grid=grid)


def find_maps() -> Path:
    """Return the folder of the maps: the argument, or what the environment names."""
    for named in (*sys.argv[1:2], os.environ.get("ROUGHCONTACT_MAPS", "")):
        if (Path(named) / "x3p-2.x3p").exists():
            return Path(named)
    raise SystemExit("give the folder of x3p-2.x3p and opd-1.opd, or set ROUGHCONTACT_MAPS to it")


def make_rows(problem: rc.ContactProblem | None = None) -> list[list[str]]:
    problem = problem or make_problem(find_maps())
    finer = rc.on_grid(problem, tuple(4 * n for n in problem.plan.grid.shape))
    lines = [["force, N", "counted, um2", "sub-grid, um2", "refined, um2", "saturated, um2", "patches"]]
    for force in FORCES:
        solution = problem.solve(force=force)
        counted, saturated = solution.area("cell-count"), solution.saturated_area()
        areas = [solution.area(), finer.solve(force=force).area()]
        texts = [f"{1e12 * area.value:.1f} ± {1e12 * area.uncertainty:.1f}" for area in areas]
        texts += [f"{1e12 * saturated.value:.2f}", f"{solution.patches.count}"]
        lines.append([f"{force:g}", f"{1e12 * counted.value:.1f}", *texts])
    return lines


def main(problem: rc.ContactProblem, maps: Path, folder: Path = FIGURES) -> None:
    worn = rc.run_in(problem, force=FORCES[-1])
    print(f"\n{worn}\n")
    again = worn.problem.solve(force=FORCES[-1])
    print(f"reloaded: {again.area()}, saturated {again.saturated_area()}")
    draw(maps, problem, problem.solve(force=FORCES[-1]), folder)


TABLES = {"measured-pair": DocTable(make_rows, seconds=100)}

if __name__ == "__main__":
    pair = make_problem(find_maps())
    print(pair.explain(), "\n")
    write("measured-pair", make_rows(pair))
    main(pair, find_maps())
