"""The figure of the README: a rough surface, its contact pressure, and the error of its contact area on finer grids.

python docs/studies/overview.py
"""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.plotting import LIGHT, scale_axes, style

FIGURES = Path(__file__).parent.parent / "figures"
# Cells along a side: of the maps, of the errors, and of the reference.
DRAWN, GRIDS, REFERENCE = 512, (64, 128, 256, 512, 1024), 2048


def press(cells: int) -> rc.ContactSolution:
    """Return the contact of one rough surface, of 4 um waves and longer, with a flat at 200 MPa."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=4e-6, longest=50e-6, rolloff=25e-6, seed=4)
    steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=6e9)
    grid = rc.Grid((cells, cells), 100e-6)
    return rc.ContactProblem(rc.Body(surface, steel), grid=grid, boundary="periodic").solve(pressure=200e6)


def main(drawn: int = DRAWN, reference: int = REFERENCE, folder: Path = FIGURES) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with style():
        draw(drawn, reference).savefig(folder / "overview.png", dpi=160)


def draw(drawn: int, reference: int) -> Figure:
    figure = Figure(figsize=(10.6, 3.4), layout="constrained")
    heights, pressure, errors = figure.subplots(1, 3)
    solution = press(drawn)
    solution.plot("heights", axes=heights)
    solution.plot("pressure", axes=pressure)
    area = solution.area()
    draw_errors(errors, reference)
    for axes, title in (
        (heights, "a rough surface"),
        (pressure, f"its contact: {100 * area.fraction:.2f} ± {100 * area.uncertainty / solution.grid.area:.2f} %"),
        (errors, "error of its contact area"),
    ):
        axes.set_title(title, pad=18)
    return figure


def draw_errors(axes, reference: int) -> None:
    """Draw errors against the finest grid, whose uncertainty is the floor."""
    true = press(reference).area()
    grids = [cells for cells in GRIDS if cells < reference]
    solutions = [press(cells) for cells in grids]
    counted, estimated = (
        [100 * abs(solution.area(name).value / true.value - 1) for solution in solutions]
        for name in ("cell-count", "blend")
    )
    floor = 100 * true.uncertainty / true.value
    axes.plot(grids, counted, "o-", label="counted cells")
    axes.plot(grids, estimated, "D-", label="default estimate")
    stated = [100 * solution.area().uncertainty / true.value for solution in solutions]
    axes.plot(grids, stated, ":", color="C1", label="its uncertainty")
    axes.axhspan(1e-4, floor, color=LIGHT.open, zorder=0)
    lowest = 0.3 * min(floor, *estimated)
    axes.text(0.9 * grids[0], 1.3 * lowest, f"uncertainty of the\nreference: {floor:.2g} %", fontsize=8)
    scale_axes(axes, x="cells along a side", y="error, %", logarithmic="xy")
    axes.set_xticks(grids, [str(cells) for cells in grids], minor=False)
    axes.set_xticks([], minor=True)
    axes.set(xlim=(0.8 * grids[0], 1.3 * grids[-1]), ylim=(lowest, 20 * max(counted)))
    axes.legend(loc="upper right", fontsize=8, frameon=False)


if __name__ == "__main__":
    main()
