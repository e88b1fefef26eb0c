"""Cost of the area beside that of the solve, on the page "Which area estimator?".

    python docs/studies/area_cost.py

CPU times: run it with one thread, OMP_NUM_THREADS=1, for only the solve uses more.
"""

from __future__ import annotations

import statistics
import time

from doc_tables import DocTable, pick, some_of, write_tables
from which_estimator import wavy

import roughcontact as rc

GRIDS = (256, 512, 1024)
REPEATS = 5
STEEL = rc.Elastic(young=200e9, poisson=0.3)
# E* times the rms slope, Pa.
SCALE = 0.1 * 200e9 / 0.91


def rough(cells: int) -> rc.ContactProblem:
    """Return a periodic surface of 31 shortest waves a side, rms slope 0.1, the same one on every grid."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=3.2e-6, longest=50e-6, rolloff=25e-6, seed=3)
    return rc.ContactProblem(rc.Body(surface, STEEL), grid=rc.Grid((cells, cells), 100e-6), boundary="periodic")


def balls(cells: int) -> rc.ContactProblem:
    """Return two balls, free."""
    steel, brass = (
        rc.Body(rc.SphereSurface(radius=1e-3), STEEL),
        rc.Body(rc.SphereSurface(radius=2e-3), rc.Elastic(young=100e9, poisson=0.35)),
    )
    return rc.ContactProblem(steel, brass, grid=rc.Grid((cells, cells), 100e-6))


CASES = {
    "the paper's wave, 50 MPa": (wavy, {"pressure": 50e6}),
    "self-affine, 5 % contact": (rough, {"pressure": 0.025 * SCALE}),
    "self-affine, 20 % contact": (rough, {"pressure": 0.1 * SCALE}),
    "two balls, free": (balls, {"force": 1.0}),
}


def measure(problem: rc.ContactProblem, load: dict[str, float]) -> tuple[int, float, float]:
    """Return the number of patches and the medians of the CPU times of solve and area, s."""
    solves, areas = [], []
    # The first round imports and prepares what the others need.
    for _ in some_of(range(REPEATS + 1), 0, 1):
        started = time.process_time()
        solution = problem.solve(**load)
        solved = time.process_time()
        solution.area()
        solves.append(solved - started)
        areas.append(time.process_time() - solved)
    return solution.patches.count, statistics.median(solves[1:]), statistics.median(areas[1:])


def make_table() -> list[list[str]]:
    lines = [["contact", "N", "patches", "solve, s", "area, s", "area over solve, %"]]
    for name, (make, load) in CASES.items():
        for cells in some_of(GRIDS, 0, 1):
            patches, solve, area = measure(make(cells), load)
            lines.append([name, str(cells), str(patches), f"{solve:.3f}", f"{area:.4f}", f"{100 * area / solve:.0f}"])
    return lines


TIMES = ("solve, s", "area, s", "area over solve, %")
# The lines of the page.
LINES = ("the paper's wave, 50 MPa; 1024", "self-affine, 5 % contact; 1024")
TABLES = {"area-cost": DocTable(make_table, seconds=40, timed=TIMES, shown=pick(lines=LINES))}

if __name__ == "__main__":
    write_tables(TABLES)
