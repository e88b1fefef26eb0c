"""The figure and the table of docs/use/interface_laws.md: area, stiffness and mean gap of an interface over the load.

python docs/studies/interface_law.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from doc_tables import DocTable, pick, write_tables

import roughcontact as rc
from roughcontact.plotting import style

FIGURES = Path(__file__).parent.parent / "figures"
SEEDS = (1, 2, 3)


def make_law(seed: int, cells: int = 512) -> rc.results.InterfaceLaw:
    """Return the law of a steel surface on a flat of steel."""
    steel = rc.Elastic(young=210e9, poisson=0.3)
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.05, shortest=3.125e-6, longest=200e-6, rolloff=12.5e-6, seed=seed
    )
    problem = rc.ContactProblem(
        rc.Body(surface, steel),
        rc.Body(rc.FlatSurface(), steel),
        grid=rc.Grid((cells, cells), 200e-6),
        boundary="periodic",
    )
    heat = rc.responses.create("conductance", 45.0)
    return rc.interface_law(problem, np.geomspace(5e6, 800e6, 12), ["stiffness", heat])


def make_rows() -> list[list[str]]:
    rows = [["column", "seed", "exponent", "from", "to", "maximum misfit"]]
    for seed in SEEDS:
        law = make_law(seed)
        for name in ("area", "stiffness", "conductance", "mean_gap"):
            fit = law.fit(name)
            cells = ["none", "", "", ""]
            if fit is not None:
                low, high = (f"{1e-6 * pressure:.0f} MPa" for pressure in fit.pressures)
                cells = [f"{fit.exponent:.3f} ± {fit.exponent_std:.3f}", low, high, f"{100 * fit.misfit:.1f} %"]
            rows.append([name.replace("_", " "), str(seed), *cells])
    return rows


@style()
def draw(folder: Path = FIGURES, cells: int = 512) -> None:
    from matplotlib.figure import Figure

    law = make_law(2, cells)
    figure = Figure(figsize=(12, 3.8), layout="constrained")
    for axes, name in zip(figure.subplots(1, 3), ("area", "mean_gap", "conductance"), strict=True):
        law.plot(name, axes)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "interface_law.png", dpi=120)


TABLES = {
    "interface-law": DocTable(
        make_rows,
        seconds=150,
        shown=pick(lines=("area; 2", "stiffness; 2", "stiffness; 1")),
    )
}

if __name__ == "__main__":
    draw()
    write_tables(TABLES)
