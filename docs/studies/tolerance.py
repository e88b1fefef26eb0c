"""How far area and maximum pressure move with the tolerance of the solver: the constants of `_problem/accuracy.py`.

python docs/studies/tolerance.py
"""

from __future__ import annotations

from collections.abc import Iterator

import attrs
import numpy as np

import roughcontact as rc

STEEL, SOFT = rc.Elastic(200e9, 0.3), rc.Elastic(1.0, 0.0)
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


def contacts() -> Iterator[tuple[str, rc.ContactProblem, dict[str, float]]]:
    """Yield name, problem and load of each contact."""
    random = np.random.default_rng(5)
    for cells in (192, 256, 384):
        for _ in range(2):
            wave = rc.WavySurface(0.5e-6, 12.5e-6, random.uniform(0.0, 6.0, 2))
            grid = rc.Grid((cells, cells), 250e-6)
            yield "wave", rc.ContactProblem(rc.Body(wave, STEEL), grid=grid, boundary="periodic"), {"pressure": 100e6}
    for cells, shortest in ((256, 2.0), (256, 1.0), (384, 1.0)):
        for pressure in (0.0005, 0.0025, 0.01):
            for seed in (1, 2, 3):
                yield "rough", rough(cells, shortest, seed, SOFT), {"pressure": pressure}
    for seed in (1, 2):
        yield "capped", rough(256, 2.0, seed, rc.ElasticPerfectlyPlastic(1.0, 0.0, 0.03)), {"pressure": 0.005}
    for cells, material in ((64, SOFT), (128, SOFT), (128, rc.ElasticPerfectlyPlastic(1.0, 0.0, 1.5e-3))):
        for _ in range(3):
            ball = rc.ParaboloidSurface(2000.0, random.uniform(-0.5, 0.5, 2))
            grid = rc.Grid((cells, cells), 64.0)
            yield "ball", rc.ContactProblem(rc.Body(ball, material), grid=grid), {"pressure": 3e-5}


def rough(cells: int, shortest: float, seed: int, material: rc.Material) -> rc.ContactProblem:
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.1, shortest=shortest, longest=64.0, rolloff=32.0, seed=seed
    )  # fmt: skip
    return rc.ContactProblem(rc.Body(surface, material), grid=rc.Grid((cells, cells), 64.0), boundary="periodic")


def main() -> None:
    """Print the maximum change of area and pressure, and the part of the convolutions, at each tolerance."""
    found: dict[str, list[list[tuple[float, ...]]]] = {}
    for name, problem, load in contacts():
        exact = problem.solve(**load)
        area, peak = exact.area().value, float(exact.pressure.max())
        solutions = [
            attrs.evolve(problem, solver=rc.ProjectedConjugateGradient(tolerance=tolerance)).solve(**load)
            for tolerance in TOLERANCES
        ]
        found.setdefault(name, []).append(
            [
                (
                    abs(solution.area().value / area - 1.0),
                    abs(float(solution.pressure.max()) / peak - 1.0),
                    solution.convolutions / exact.convolutions,
                )
                for solution in solutions
            ]
        )
    for name, rows in found.items():
        table = np.array(rows)
        for k, tolerance in enumerate(TOLERANCES):
            area, peak, work = table[:, k, 0].max(), table[:, k, 1].max(), table[:, k, 2].mean()
            print(f"{name:7} {len(rows):3} {tolerance:.0e}  area {area:.1e}  pressure {peak:.1e}  work {work:.2f}")


if __name__ == "__main__":
    main()
