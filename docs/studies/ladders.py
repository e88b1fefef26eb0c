"""What a ladder of grids gives beside its finest grid: the rms error of the area, a table of docs/understand/area.md.

    python docs/studies/ladders.py

On each ladder of three grids: the area of the finest, Richardson's extrapolation at second order, and the mean of the
three weighted by the inverse of their variances. Places, phases and seeds are drawn at random.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from doc_tables import DocTable, pick, write_tables

import roughcontact as rc
from roughcontact.extrapolation import richardson

# Order at which corrected areas were extrapolated.
ORDER = 2.0
STEEL, SOFT = rc.Elastic(200e9, 0.3), rc.Elastic(1.0, 0.0)
# Converged areas of the paper's wave over nominal, by pressure, Pa (tests/problems/test_refinement.py).
WAVES = {50e6: 0.71689e-2, 100e6: 1.14192e-2, 200e6: 1.82266e-2}


def scenes(seeds: int) -> Iterator[tuple[str, rc.ContactProblem, dict[str, float], float]]:
    """Yield class, problem on the coarsest grid, load and true area, m2."""
    random = np.random.default_rng(14)
    for cells in (60, 70, 80, 90, 100):
        for pressure, fraction in WAVES.items():
            phase = (0.0, 0.0) if cells % 20 == 0 else random.uniform(0.0, 2.0 * np.pi, 2)
            body = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6, phase), STEEL)
            problem = rc.ContactProblem(body, grid=rc.Grid((cells, cells), 250e-6), boundary="periodic")
            kind = (
                "wave, whole cells, 12 to 20 on the finest"
                if cells % 20 == 0
                else "wave, any phase, 14 and 18 cells on the finest"
            )
            yield kind, problem, {"pressure": pressure}, fraction * 250e-6**2
    for per_wave in (2, 4):
        for seed in range(seeds):
            for x in (0.005, 0.05, 0.2):
                surface = rc.SelfAffineSurface(
                    hurst=float(random.choice([0.5, 0.8])), rms_slope=0.1, shortest=1.0, longest=32.0, rolloff=16.0,
                    seed=1000 + seed,
                )  # fmt: skip
                problem = rc.ContactProblem(
                    rc.Body(surface, SOFT), grid=rc.Grid((32 * per_wave, 32 * per_wave), 32.0), boundary="periodic"
                )
                load = {"pressure": 0.1 * x}
                cells = 32 * 32
                true = rc.on_grid(problem, (cells, cells)).solve(**load).area().value
                yield f"rough, {per_wave} to {4 * per_wave} cells", problem, load, true
    for _ in range(4 * seeds):
        radius, center = random.uniform(1.5, 6.0), random.uniform(-1.0, 1.0, 2)
        curvature = 1e3
        force = 4.0 / 3.0 * radius**3 / curvature
        body = rc.Body(rc.ParaboloidSurface(curvature, center), SOFT)
        problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 32.0))
        yield "ball, 1.5 to 6 cells, then finer", problem, {"force": force}, np.pi * radius**2


def make_rows(seeds: int = 4) -> list[list[str]]:
    errors: dict[str, list[tuple[float, ...]]] = {}
    for kind, problem, load, true in scenes(seeds):
        ladder = rc.extrapolate(problem, **load, levels=3)
        areas = ladder.areas
        weights = np.array([area.uncertainty**-2.0 for area in areas])
        mean = float(np.sum(weights * [area.value for area in areas]) / weights.sum())
        limit = richardson(ladder.cells, [area.value for area in areas], ORDER)
        values = areas[-1].value, limit.value, mean
        errors.setdefault(kind, []).append(tuple(100.0 * (value / true - 1.0) for value in values))
    lines = [["ladders of three grids", "number", "finest, %", "Richardson, %", "weighted mean, %"]]
    for kind, rows in errors.items():
        lines.append([kind, f"{len(rows)}", *(f"{rms:.3f}" for rms in np.sqrt(np.mean(np.square(rows), axis=0)))])
    return lines


TABLES = {
    "ladders": DocTable(
        make_rows,
        seconds=120,
        units=3,
        shown=pick(
            ("ladders of three grids", "finest, %", "Richardson, %"),
            ("wave, whole cells, 12 to 20 on the finest", "rough, 2 to 8 cells", "ball, 1.5 to 6 cells, then finer"),
        ),
    )
}

if __name__ == "__main__":
    write_tables(TABLES)
