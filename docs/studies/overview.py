"""The figure of the README: a rough surface, its contact pressure, and the error of the contact area.

The printed and converged areas come from plugins/roughcontact-paper, which must be installed.

python docs/studies/overview.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.panel import add_key, scale_axes, style
from roughcontact_paper import published

FIGURES = Path(__file__).parent.parent / "figures"


def rough_contact(cells: int) -> rc.ContactSolution:
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=2e-6, longest=50e-6, rolloff=25e-6, seed=4)
    problem = rc.ContactProblem(
        rc.Body(surface, rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=6e9)),
        grid=rc.Grid((cells, cells), 100e-6),
        boundary="periodic",
    )
    return problem.solve(pressure=200e6)


def blended(cells: int) -> float:
    """Return the error of the default area on the paper's wave at 100 MPa, %."""
    body = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6, phase=(1.0, 2.0)), rc.Elastic(young=200e9, poisson=0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((cells, cells), 250e-6), boundary="periodic")
    return abs(1e4 * problem.solve(pressure=100e6).area().fraction / published.TRUE_AREA[100] - 100)


def main(cells: int = 512, largest: int = 2048, folder: Path = FIGURES) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with style():
        draw(rough_contact(cells), largest).savefig(folder / "overview.png", dpi=120)


def draw(solution: rc.ContactSolution, largest: int) -> Figure:
    figure = Figure(figsize=(13, 4), layout="constrained")
    heights, pressure, areas = figure.subplots(1, 3)
    solution.plot("heights", axes=heights)
    solution.plot("pressure", axes=pressure)
    area = solution.area()
    for axes, title in (
        (heights, "a rough surface"),
        (pressure, f"its contact: {100 * area.fraction:.2f} ± {100 * area.uncertainty / solution.grid.area:.2f} %"),
        (areas, "error of the contact area"),
    ):
        axes.set_title(title, pad=18)
    counted = 100 * (np.array(published.SAM_AREA[100]) / published.TRUE_AREA[100] - 1)
    areas.plot(published.GRIDS, counted, "o-", label="counted cells")
    grids = [n for n in published.GRIDS if n <= largest]
    # The converged area is known to 0.001 %.
    areas.plot(grids, [max(blended(n), 1e-3) for n in grids], "D-", label="blend, the default")
    scale_axes(areas, x="cells along a side", y="error, %", logarithmic="xy")
    areas.set_xticks(published.GRIDS, [str(n) for n in published.GRIDS], minor=False)
    areas.set_xticks([], minor=True)
    for cells, error in zip(published.GRIDS, counted, strict=True):
        areas.annotate(f"+{error:.0f} %", (cells, error), xytext=(5, 5), textcoords="offset points", fontsize=8)
    areas.set(xlim=(50, 4500), ylim=(7e-4, 900))
    add_key(areas)
    return figure


if __name__ == "__main__":
    main()
