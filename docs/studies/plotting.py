"""The figures of docs/use/plotting.md: every panel that ships, and a solution on a dark background.

python docs/studies/plotting.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.plotting import make_figure, style

FIGURES = Path(__file__).parent.parent / "figures"
STEEL = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=6e9)
SURFACE = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=4e-6, longest=50e-6, rolloff=25e-6, seed=4)


def main(cells: int = 256, folder: Path = FIGURES) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    grid = rc.Grid((cells, cells), 100e-6)
    problem = rc.ContactProblem(rc.Body(SURFACE, STEEL), grid=grid, boundary="periodic")
    solution = problem.solve(pressure=400e6)
    sweep = problem.sweep(pressure=np.geomspace(10e6, 1e9, 8))
    sampled = rc.plotting.SampledSurface(SURFACE.heights(grid), grid, True)
    make_figure("solution", solution, dark=True).savefig(folder / "plotting_solution_dark.png", dpi=110)
    for kind, subject in (("solution", solution), ("surface", sampled), ("sweep", sweep)):
        make_figure(kind, subject).savefig(folder / f"plotting_{kind}.png", dpi=110)
    with style():
        figure = Figure(figsize=(12, 3.8), layout="constrained")
        for axes, name in zip(figure.subplots(1, 3), ("profile", "pressure-histogram", "patch-sizes"), strict=True):
            solution.plot(name, axes=axes)
        figure.savefig(folder / "plotting_more.png", dpi=110)


if __name__ == "__main__":
    main()
