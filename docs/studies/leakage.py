"""The table and the figure of docs/use/leakage.md: the flow through rough gaps on several grids.

python docs/studies/leakage.py          # the table
python docs/studies/leakage.py figure   # docs/figures/leakage.png
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from doc_tables import DocTable, pick, write_tables
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.plotting import LIGHT, style

FIGURES = Path(__file__).parent.parent / "figures"
WATER = {"viscosity": 1e-3, "pressure_drop": 1e5}
# Surfaces that set no weight of the uncertainty; its weights are set on seeds 1 to 12.
FRESH = range(31, 41)
GRIDS, FINEST = (64, 96, 128, 256), 512


def make_problem(seed: int, cells: int) -> rc.ContactProblem:
    """Return a rough contact of 16 shortest waves a side, with a Hurst exponent, boundary and cells that change."""
    surface = rc.SelfAffineSurface(
        hurst=(0.8, 0.5, 0.3)[seed % 3], rms_slope=0.05, shortest=1.0 / 16, longest=1.0, rolloff=0.25, seed=seed
    )
    grid = rc.Grid((cells, cells), (1.0, (1.0, 0.7, 1.6)[seed // 2 % 3]))
    body = rc.Body(surface, rc.Elastic(1e9, 0.3))
    return rc.ContactProblem(body, grid=grid, boundary=("periodic", "free")[seed % 2], threads=1)


def find_errors() -> dict[tuple[int, bool], list[tuple[float, float]]]:
    """Return error and uncertainty over the flow, for each grid and for light and heavy contact."""
    found: dict[tuple[int, bool], list[tuple[float, float]]] = {}
    for seed in FRESH:
        for x in (0.05, 0.1, 0.15, 0.19):
            flows = []
            for cells in (*GRIDS, FINEST):
                problem = make_problem(seed, cells)
                solution = problem.solve(pressure=0.05 * x * problem.plan.modulus)
                flows.append((cells, solution.leakage(axis=seed % 2, **WATER)))
            finest = flows.pop()[1].value
            for cells, flow in flows:
                if flow.connected:
                    pair = abs(1.0 - finest / flow.value), flow.uncertainty / flow.value
                    found.setdefault((cells, x > 0.12), []).append(pair)
    return found


def list_errors() -> list[list[str]]:
    heading = ["contact, %", "cells a shortest wave", "flows", "error: median, 95 %"]
    rows = [[*heading, "stated: median, %", "within 2 std, %"]]
    for (cells, heavy), pairs in sorted(find_errors().items(), key=lambda one: (one[0][1], one[0][0])):
        error, stated = (100.0 * column for column in np.array(pairs).T)
        rows.append(
            [
                "26 to 40" if heavy else "8 to 23",
                f"{cells // 16}",
                f"{len(pairs)}",
                f"{np.median(error):.2g}, {np.quantile(error, 0.95):.2g}",
                f"{np.median(stated):.2g}",
                f"{100.0 * np.mean(error < 2.0 * stated):.0f}",
            ]
        )
    return rows


@style()
def draw(folder: Path = FIGURES) -> None:
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=100e-6, rolloff=25e-6, seed=7)
    steel = rc.Elastic(young=210e9, poisson=0.3)
    problem = rc.ContactProblem(rc.Body(surface, steel), grid=rc.Grid((384, 384), 100e-6), boundary="periodic")
    solution = problem.solve(pressure=0.1 * 0.13 * problem.plan.modulus)
    flow = solution.leakage(axis=0, **WATER)
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    place = {"origin": "lower", "extent": (-50, 50, -50, 50)}
    image = left.imshow(flow.fluid_pressure.T / 1e5, cmap="viridis", **place)
    figure.colorbar(image, ax=left, label="pressure of the liquid, bar")
    speed = 1e12 * np.hypot(*flow.flux)
    top = float(np.quantile(speed, 0.999))
    shown = np.where(speed > 0.0, speed, np.nan).T
    image = right.imshow(shown, cmap="viridis", norm=LogNorm(1e-4 * top, top), **place)
    figure.colorbar(image, ax=right, label="flow over width, µm²/s")
    for axes in (left, right):
        axes.set_facecolor(LIGHT.unknown)
        axes.plot(*(1e6 * one for one in flow.throat.place), "o", ms=14, mfc="none", mec="white", mew=2.5)
        axes.set(xlabel="x, µm", ylabel="y, µm")
    left.set_title(f"contact (grey) {100 * solution.area().fraction:.0f} %, critical throat (circle)")
    right.set_title(f"{1e18 * flow.value:.0f} µm³/s from left to right")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "leakage.png", dpi=110)


# The columns of the page.
SHOWN = ("contact, %", "cells a shortest wave", "error: median, 95 %", "stated: median, %")
TABLES = {
    "leakage": DocTable(
        list_errors,
        seconds=400,
        shown=pick(SHOWN, ("8 to 23; 4", "8 to 23; 8", "26 to 40; 8", "26 to 40; 16")),
    )
}

if __name__ == "__main__":
    if sys.argv[1:] == ["figure"]:
        draw()
    else:
        write_tables(TABLES)
