"""The table of docs/use/leakage.md on the load that closes all paths: coarse grids beside 32 cells a shortest wave.

python docs/studies/percolation.py
"""

from __future__ import annotations

import numpy as np
from doc_tables import DocTable, pick, write_tables
from leakage import make_problem

import roughcontact as rc
from roughcontact.responses import find_percolation

# Surfaces on which no weight of the uncertainty was set.
FRESH = range(41, 51)
GRIDS, FINEST = (64, 128, 256), 512


def make_rows() -> list[list[str]]:
    loads: dict[int, list[rc.Estimate]] = {cells: [] for cells in (*GRIDS, FINEST)}
    contact: dict[int, list[float]] = {cells: [] for cells in loads}
    for seed in FRESH:
        for cells, kept in loads.items():
            found = find_percolation(make_problem(seed, cells), axis=seed % 2)
            kept.append(found.pressure)
            contact[cells].append(100.0 * found.area_fraction.value)
    headings = ["error: median, maximum, %", "stated: median, %", "within 2 std, %"]
    rows = [["cells a shortest wave", *headings, "contact: mean, range, %"]]
    exact = np.array([load.value for load in loads[FINEST]])
    for cells, kept in loads.items():
        values, stds = (np.array([getattr(load, name) for load in kept]) for name in ("value", "uncertainty"))
        error, stated = 100.0 * np.abs(values / exact - 1.0), 100.0 * stds / values
        judged = [f"{np.median(error):.2g}, {error.max():.2g}", f"{np.median(stated):.2g}"]
        judged += [f"{100.0 * np.mean(error < 2.0 * stated):.0f}"]
        areas = contact[cells]
        closed = f"{np.mean(areas):.0f}, {min(areas):.0f} to {max(areas):.0f}"
        rows.append([f"{cells // 16}", *(judged if cells < FINEST else ["-"] * 3), closed])
    return rows


TABLES = {"percolation": DocTable(make_rows, seconds=400, shown=pick(lines=("4", "8", "16")))}

if __name__ == "__main__":
    write_tables(TABLES)
