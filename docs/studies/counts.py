"""Iterations and products of the default solver by the grid: the table of docs/trust/solver_cost.md.

python docs/studies/counts.py
"""

from __future__ import annotations

from doc_tables import DocTable, pick, some_of, write_tables

import roughcontact as rc

GRIDS = tuple(2**k for k in range(7, 12))
SLOPE = 0.1
# Boundary, cells of the shortest wave, mean pressure over E* slope, and the largest grid.
CASES = (
    ("periodic", 8, 0.05, 2048),
    ("periodic", 8, 0.2, 2048),
    ("periodic", 8, 1.0, 1024),
    ("periodic", 2, 0.2, 1024),
    ("free", 8, 0.05, 2048),
)


def solve(cells: int, boundary: str, shortest: int, load: float) -> rc.ContactSolution:
    side = float(cells)
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=SLOPE, shortest=float(shortest), longest=side, rolloff=side / 8, seed=0
    )
    body = rc.Body(surface, rc.Elastic(1.0, 0.0))
    return rc.ContactProblem(body, grid=rc.Grid((cells, cells), side), boundary=boundary).solve(pressure=load * SLOPE)


def make_rows() -> list[list[str]]:
    grids = some_of(GRIDS, 0, 1, 2)
    rows = [["case", *map(str, grids)]]
    for boundary, shortest, load, largest in CASES:
        row = [f"{boundary}, {shortest} cells, x = {load:g}"]
        for cells in grids:
            solution = solve(cells, boundary, shortest, load) if cells <= largest else None
            row.append("" if solution is None else f"{solution.iterations} / {solution.convolutions}")
        rows.append(row)
    return rows


# Counts of machines with other transforms may differ by an iteration.
LINES = (
    "periodic, 8 cells, x = 0.05",
    "periodic, 8 cells, x = 0.2",
    "periodic, 2 cells, x = 0.2",
    "free, 8 cells, x = 0.05",
)
TABLES = {"counts": DocTable(make_rows, seconds=60, units=3, shown=pick(("case", "128", "512", "2048"), LINES))}

if __name__ == "__main__":
    write_tables(TABLES)
