"""How far area and maximum pressure move with the tolerance of the solver, for `_solve/problem/accuracy.py`.

python docs/studies/tolerance.py
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from doc_tables import DocTable, pick, some_of, write_tables

import roughcontact as rc

STEEL, SOFT = rc.Elastic(200e9, 0.3), rc.Elastic(1.0, 0.0)
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
CHANGES = ("largest change of the area", "of the maximum pressure", "convolutions, of those at 1e-8")


def contacts() -> Iterator[tuple[rc.ContactProblem, dict[str, float]]]:
    """Yield the problem and the load of each contact: waves, rough ones without and with a limit, balls."""
    random = np.random.default_rng(5)
    for cells in (192, 256, 384):
        for _ in range(2):
            wave = rc.WavySurface(0.5e-6, 12.5e-6, random.uniform(0.0, 6.0, 2))
            grid = rc.Grid((cells, cells), 250e-6)
            yield rc.ContactProblem(rc.Body(wave, STEEL), grid=grid, boundary="periodic"), {"pressure": 100e6}
    for cells, shortest in ((256, 2.0), (256, 1.0), (384, 1.0)):
        for pressure in (0.0005, 0.0025, 0.01):
            for seed in (1, 2, 3):
                yield rough(cells, shortest, seed, SOFT), {"pressure": pressure}
    for seed in (1, 2):
        yield rough(256, 2.0, seed, rc.ElasticPerfectlyPlastic(1.0, 0.0, 0.03)), {"pressure": 0.005}
    for cells, material in ((64, SOFT), (128, SOFT), (128, rc.ElasticPerfectlyPlastic(1.0, 0.0, 1.5e-3))):
        for _ in range(3):
            ball = rc.ParaboloidSurface(2000.0, random.uniform(-0.5, 0.5, 2))
            grid = rc.Grid((cells, cells), 64.0)
            yield rc.ContactProblem(rc.Body(ball, material), grid=grid), {"pressure": 3e-5}


def rough(cells: int, shortest: float, seed: int, material: rc.Material) -> rc.ContactProblem:
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.1, shortest=shortest, longest=64.0, rolloff=32.0, seed=seed
    )  # fmt: skip
    return rc.ContactProblem(rc.Body(surface, material), grid=rc.Grid((cells, cells), 64.0), boundary="periodic")


def make_rows() -> list[list[str]]:
    """Return the largest changes of area and pressure at each tolerance, and the mean fraction of the convolutions."""
    found = []
    for problem, load in some_of(list(contacts()), 0, 6, 24, 33, 39):
        exact = problem.solve(**load, tolerance=1e-8)
        solutions = [problem.solve(**load, tolerance=tolerance) for tolerance in TOLERANCES]
        found.append([_compare(solution, exact) for solution in solutions])
    table = np.array(found)
    changes, work = table[..., :2].max(axis=0), table[..., 2].mean(axis=0)
    return [
        ["tolerance", *CHANGES],
        *(
            [f"{tolerance:.0e}", f"{area:.1e}", f"{peak:.1e}", f"{part:.2f}"]
            for tolerance, (area, peak), part in zip(TOLERANCES, changes, work, strict=True)
        ),
    ]


def _compare(solution: rc.ContactSolution, exact: rc.ContactSolution) -> tuple[float, float, float]:
    return (
        abs(solution.area().value / exact.area().value - 1.0),
        abs(float(solution.pressure.max()) / float(exact.pressure.max()) - 1.0),
        solution.convolutions / exact.convolutions,
    )


TABLES = {
    "tolerance": DocTable(make_rows, seconds=30, timed=CHANGES, shown=pick(lines=("1e-02", "1e-04", "1e-05", "1e-06")))
}

if __name__ == "__main__":
    write_tables(TABLES)
