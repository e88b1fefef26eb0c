"""The area of a coarse map: what the estimator gets wrong, and what scaling has taken away.

python docs/studies/lost_heights.py

Five minutes, and two more for running in, unless `roughcontact paper --pairs --full` was run in the same folder before.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.extrapolation import exponential
from roughcontact.paper.stand_in import SIZE, fresh, scaled, worn

FIGURES = Path(__file__).parent.parent / "figures"
RESULTS = Path("paper-results")
FORCES = (2.5, 10.0)
COLUMNS = (
    "pair",
    "N",
    "count / true",
    "eq. 28 / true",
    "sub-grid / true",
    "its bar",
    "sub-grid / true of the coarse map",
    "coarse map / true",
)


def smooth(pair: rc.ContactProblem, cells: int) -> rc.ContactProblem:
    """Return a pair with the surface between the points of its maps, by cubic splines, on a finer grid."""
    grid = rc.Grid((cells, cells), SIZE)
    bodies = [rc.Body(rc.PlacedMap(body.surface, method="cubic"), body.material) for body in (pair.body, pair.counter)]
    return rc.ContactProblem(*bodies, grid=grid)


def rows(name: str, pair: rc.ContactProblem, force: float, grids: tuple[int, ...]) -> list[dict]:
    """Return what each grid makes of a pair, as errors in %."""
    finest = pair.plan.grid.shape[0]
    true = pair.solve(force=force).area()
    print(f"{name} {force:g} N, sub-grid area on {finest} x {finest}: {true}", file=sys.stderr)
    counted, found = [], []
    for cells in (*grids, finest):
        coarse = scaled(pair, cells)
        solution = coarse.solve(force=force)
        area = solution.area()
        counted.append(solution.area("cell-count").value)
        reached = true if cells == finest else smooth(coarse, finest).solve(force=force).area()
        extrapolated = (
            exponential(grids[: len(counted)] + (finest,) * (cells == finest), counted).value
            if len(counted) > 2
            else np.nan
        )
        found.append(
            {
                "cells": cells,
                "count": 100 * (counted[-1] / true.value - 1),
                "eq. 28": 100 * (extrapolated / true.value - 1),
                "sub-grid": 100 * (area.value / true.value - 1),
                "bar": 100 * area.uncertainty / area.value,
                "estimator": 100 * (area.value / reached.value - 1),
                "lost": 100 * (reached.value / true.value - 1),
            }
        )
    return found


def draw(axes: Axes, found: list[dict], title: str) -> None:
    cells = [row["cells"] for row in found]
    for key, label, style in (
        ("count", "cells counted", "o-"),
        ("eq. 28", "counts so far, eq. 28", "s-"),
        ("sub-grid", "sub-grid, in all", "D-"),
        ("estimator", "sub-grid against its own coarse map", "^--"),
        ("lost", "heights lost by scaling", "v--"),
    ):
        axes.plot(cells, [row[key] for row in found], style, label=label)
    axes.axhline(0.0, color="0.5", lw=0.8)
    axes.set_xscale("log", base=2)
    axes.set_yscale("symlog", linthresh=5.0)
    ticks = (-20, -10, -5, -2, 0, 2, 5, 10, 20, 50, 100)
    axes.set_yticks(ticks, [f"{tick:+d}" if tick else "0" for tick in ticks])
    axes.set_xticks(cells, [str(n) for n in cells])
    axes.minorticks_off()
    axes.set(title=title, xlabel="cells along a side", ylim=(-40, 250))
    axes.grid(alpha=0.3)


def main(finest: int = 2048, coarsest: int = 64, folder: Path = FIGURES, maps: Path = RESULTS) -> None:
    grids = tuple(2**k for k in range(coarsest.bit_length() - 1, finest.bit_length() - 1))
    before = fresh(finest)
    maps.mkdir(exist_ok=True)
    after = worn(before, maps / f"run-in-{finest}.npz")
    figure = Figure(figsize=(12, 8), layout="constrained")
    panels = figure.subplots(2, len(FORCES), sharex=True, sharey=True)
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|")
    for line, (name, pair) in zip(panels, (("before", before), ("after", after)), strict=True):
        for axes, force in zip(line, FORCES, strict=True):
            found = rows(name, pair, force, grids)
            for row in found:
                values = (row[key] for key in ("count", "eq. 28", "sub-grid"))
                rest = (row[key] for key in ("estimator", "lost"))
                texts = [f"{value:+.1f}" for value in values] + [f"± {row['bar']:.1f}"] + [f"{v:+.1f}" for v in rest]
                print(f"| {name}, {force:g} N | {row['cells']} | " + " | ".join(texts).replace("+nan", "-") + " |")
            draw(axes, found, f"{name} running in, {force:g} N")
        line[0].set_ylabel("off the sub-grid area of the finest map, %")
    panels[0, 0].legend(fontsize=9)
    figure.savefig(folder / "lost_heights.png", dpi=130)


if __name__ == "__main__":
    main()
