"""Two measured maps as a pair, step by step: the figure and the table of docs/use/pairs.md.

python docs/studies/measured_pair.py FOLDER, or with ROUGHCONTACT_MAPS=FOLDER

The folder holds x3p-2.x3p and opd-1.opd, example files of the SurfaceTopography project (MIT licence), which also
reads them: pip install SurfaceTopography.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
from doc_tables import DocTable, pick, write
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.results import MatchedPair

FIGURES = Path(__file__).parent.parent / "figures"
STEEL = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=6e9)
FORCES = (0.05, 0.1, 0.2, 0.4)


def matched(maps: Path) -> tuple[list[rc.HeightMap], MatchedPair]:
    """Return the roughness of both maps, and both on a common grid."""
    read = [rc.read_surface(maps / "x3p-2.x3p"), rc.read_surface(maps / "opd-1.opd", non_measured="keep")]
    rough = [read[0].separate(2).roughness, read[1].separate("plane").roughness]
    return rough, rc.match(*rough, mirrored=True, rotation=np.deg2rad(20), interpolation="cubic")


@rc.plotting.style()
def draw(maps: Path, problem: rc.ContactProblem, solution: rc.ContactSolution, folder: Path) -> None:
    rough, pair = matched(maps)
    figure = Figure(figsize=(12, 6.6), layout="constrained")
    axes = figure.subplots(2, 3)
    names = "machined", "isotropic"
    for k, side in enumerate((pair.body, pair.counterbody)):
        rc.plotting.draw_map(axes[k, 0], 1e9 * rough[k].values, rough[k].grid, "height", "nm", colors="cividis")
        rc.plotting.draw_map(axes[k, 1], 1e9 * side.heights(pair.grid), pair.grid, "height", "nm", colors="cividis")
        axes[k, 0].set_title(f"{names[k]}, form removed")
        axes[k, 1].set_title(f"{names[k]}, on the common grid")
    gap = -1e9 * problem.initial_gap
    rc.plotting.draw_map(axes[0, 2], gap, problem.plan.grid, "combined height", "nm", colors="cividis")
    axes[0, 2].set_title("sum, with a sphere")
    solution.plot("pressure", axes=axes[1, 2])
    axes[1, 2].set_title(f"pressure at {solution.force:.2g} N", pad=18.0)
    figure.savefig(folder / "measured_pair.png", dpi=130)


def make_problem(maps: Path, shape: tuple[int, int] | None = None) -> rc.ContactProblem:
    """Return the pair with the nominal sphere, on its own grid or a coarser one."""
    _, pair = matched(maps)
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


TABLES = {"measured-pair": DocTable(make_rows, seconds=100, shown=pick(lines=("0.05", "0.4")))}

if __name__ == "__main__":
    pair = make_problem(find_maps())
    print(pair.explain(), "\n")
    write("measured-pair", make_rows(pair))
    main(pair, find_maps())
