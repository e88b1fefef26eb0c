"""The area of a coarse map: the error of the estimator, and the error by the heights that scaling removed.

python docs/studies/lost_heights.py

Needs plugins/roughcontact-paper. Five minutes, and two more for running in, unless `roughcontact paper --pairs --full`
was run in the same folder before.
"""

from __future__ import annotations

import functools
import math
import sys
from pathlib import Path

import numpy as np
from doc_tables import DocTable, pick, read, write_tables
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.extrapolation import exponential
from roughcontact.plotting import style
from roughcontact_paper.synthetic_pair import SIZE, coarsen, new_pair, run_in_pair

FIGURES = Path(__file__).parent.parent / "figures"
RESULTS = Path("paper-results")
FORCES = (2.5, 10.0)
COLUMNS = ("pair", "N", "counted", "eq. 28 through the counts so far", "sub-grid", "stated")
COLUMNS += ("of that: estimator", "lost heights")


def interpolate_maps(pair: rc.ContactProblem, cells: int) -> rc.ContactProblem:
    """Return a pair with the surface between the points of its maps, by cubic splines, on a finer grid."""
    grid = rc.Grid((cells, cells), SIZE)
    bodies = [
        rc.Body(rc.PlacedMap(body.surface, interpolation="cubic"), body.material)
        for body in (pair.body, pair.counterbody)
    ]
    return rc.ContactProblem(*bodies, grid=grid)


def compare_grids(name: str, pair: rc.ContactProblem, force: float, grids: tuple[int, ...]) -> list[dict]:
    """Return the errors of each grid, in %."""
    finest = pair.plan.grid.shape[0]
    true = pair.solve(force=force).area()
    print(f"{name} {force:g} N, sub-grid area on {finest} x {finest}: {true}", file=sys.stderr)
    counted, found = [], []
    for cells in (*grids, finest):
        coarse = coarsen(pair, cells)
        solution = coarse.solve(force=force)
        area = solution.area()
        counted.append(solution.area("cell-count").value)
        reached = true if cells == finest else interpolate_maps(coarse, finest).solve(force=force).area()
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
                "std": 100 * area.uncertainty / area.value,
                "estimator": 100 * (area.value / reached.value - 1),
                "lost": 100 * (reached.value / true.value - 1),
            }
        )
    return found


def draw(axes: Axes, rows: list[list[str]], title: str) -> None:
    cells = [int(row[1]) for row in rows]
    for heading, label, dashes in (
        ("counted", "cells counted", "o-"),
        ("eq. 28 through the counts so far", "eq. 28 through the counts so far", "s-"),
        ("sub-grid", "sub-grid, total", "D-"),
        ("of that: estimator", "sub-grid, against its own coarse map", "^--"),
        ("lost heights", "coarse map, by heights that scaling removed", "v--"),
    ):
        texts = [row[COLUMNS.index(heading)].rstrip(" %") for row in rows]
        axes.plot(cells, [math.nan if text == "-" else float(text) for text in texts], dashes, label=label)
    axes.axhline(0.0, color="0.5", lw=0.8)
    axes.set_xscale("log", base=2)
    axes.set_yscale("symlog", linthresh=5.0)
    ticks = (-20, -10, -5, -2, 0, 2, 5, 10, 20, 50, 100)
    axes.set_yticks(ticks, [f"{tick:+d}" if tick else "0" for tick in ticks])
    axes.set_xticks(cells, [str(n) for n in cells])
    axes.minorticks_off()
    axes.set(title=title, ylim=(-40, 250))
    axes.grid(True)


@functools.cache
def compare_pairs(finest: int = 2048, coarsest: int = 64, maps: Path = RESULTS) -> dict[tuple[str, float], list[dict]]:
    """Return the errors of each grid, by pair and force."""
    grids = tuple(2**k for k in range(coarsest.bit_length() - 1, finest.bit_length() - 1))
    before = new_pair(finest)
    maps.mkdir(exist_ok=True)
    pairs = {"before": before, "after": run_in_pair(before, maps / f"run-in-{finest}.npz")}
    return {(name, force): compare_grids(name, pairs[name], force, grids) for name in pairs for force in FORCES}


def make_rows(**grids: int) -> list[list[str]]:
    lines = [list(COLUMNS)]
    for (name, force), found in compare_pairs(**grids).items():
        for row in found:
            errors = [f"{row[key]:+.1f} %".replace("+nan %", "-") for key in ("count", "eq. 28", "sub-grid")]
            rest = [f"{row[key]:+.1f} %" for key in ("estimator", "lost")]
            lines.append([f"{name}, {force:g} N", f"{row['cells']}", *errors, f"± {row['std']:.1f}", *rest])
    return lines


@style()
def main(lines: list[list[str]], folder: Path = FIGURES) -> None:
    """Draw the lines of the table."""
    figure = Figure(figsize=(12, 8), layout="constrained")
    panels = figure.subplots(2, len(FORCES), sharex=True, sharey=True)
    pairs = list(dict.fromkeys(row[0] for row in lines[1:]))
    for axes, pair in zip(panels.flat, pairs, strict=True):
        draw(axes, [row for row in lines[1:] if row[0] == pair], pair.replace(",", " running in,"))
    for axes in panels[:, 0]:
        axes.set_ylabel("error against the finest map, %")
    for axes in panels[-1]:
        axes.set_xlabel("cells along a side")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    figure.savefig(folder / "lost_heights.png", dpi=130)


# The columns of the page.
SHOWN = ("N", "counted", "sub-grid", "stated", "of that: estimator", "lost heights")
TABLES = {
    "lost-heights": DocTable(
        make_rows, seconds=400, shown=pick(SHOWN, tuple(f"before, 10 N; {n}" for n in (128, 512, 1024)))
    )
}

if __name__ == "__main__":
    write_tables(TABLES)
    main(read("lost-heights"))
