"""The figure of the README: a rough surface, its contact pressure, and the error of the contact area.

The printed and converged areas come from plugins/roughcontact-paper, which must be installed.

python docs/studies/overview.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import roughcontact as rc
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
    solution = rough_contact(cells)
    figure = Figure(figsize=(13, 4), layout="constrained")
    heights, pressure, areas = figure.subplots(1, 3)
    extent = (-50, 50, -50, 50)
    image = heights.imshow(-1e6 * solution.initial_gap.T, origin="lower", extent=extent)
    figure.colorbar(image, ax=heights, label="height, µm")
    heights.set(title="rough surface", xlabel="x, µm", ylabel="y, µm")
    shown = np.where(solution.contact, solution.pressure / 1e9, np.nan).T
    image = pressure.imshow(shown, origin="lower", extent=extent, cmap="plasma")
    figure.colorbar(image, ax=pressure, label="contact pressure, GPa")
    pressure.set(title=f"contact pressure ({solution.iterations} iterations)", xlabel="x, µm")
    pressure.set_facecolor("0.92")
    counted = 100 * (np.array(published.SAM_AREA[100]) / published.TRUE_AREA[100] - 1)
    areas.loglog(published.GRIDS, counted, "o-", label="counted cells (the paper)")
    grids = [n for n in published.GRIDS if n <= largest]
    areas.loglog(grids, [blended(n) for n in grids], "D-", label="blend, the default estimator")
    areas.legend(loc="lower left")
    areas.set_xticks(published.GRIDS, [str(n) for n in published.GRIDS], minor=False)
    areas.set_xticks([], minor=True)
    areas.set(title="error of the contact area", xlabel="cells along a side", ylabel="error, %")
    areas.grid(alpha=0.3, which="both")
    for cells, error in zip(published.GRIDS, counted, strict=True):
        areas.annotate(f"+{error:.0f} %", (cells, error), xytext=(5, 5), textcoords="offset points")
    areas.set(xlim=(50, 4500), ylim=(1e-3, 900))
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "overview.png", dpi=120)


if __name__ == "__main__":
    main()
