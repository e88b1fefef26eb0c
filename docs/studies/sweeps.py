"""What a sweep of 20 loads costs, in solves without a start.

python docs/studies/sweeps.py

The constants of `predict_pressure` were chosen on surfaces of seeds 1 to 9, on this wave and this ball; the rough
surfaces of the table, of seeds from 41 on, are others.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import attrs
import numpy as np
from doc_tables import DocTable, pick, some_of, write_tables

import roughcontact as rc

LOADS = 20
# Root-mean-square slope, and the loads of 0.6 and 22 % of the cells in contact over it and the modulus.
SLOPE, LIGHT, HEAVY = 0.1, 0.0025, 0.11
SOFT, LIMITED = rc.Elastic(1.0, 0.0), rc.ElasticPerfectlyPlastic(1.0, 0.0, 0.3 * SLOPE)
TOLERANCES = (1e-5, 1e-8)
CPU, ERRORS = "CPU", ("first error of a solve", "in the sweep", "factor of an iteration")

Spacing = Callable[[float, float, int], np.ndarray]


def rough(cells: int, seed: int, material: rc.Material = SOFT) -> rc.ContactProblem:
    """Return a periodic self-affine surface against a rigid flat."""
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=SLOPE, shortest=8.0, longest=float(cells), rolloff=cells / 8, seed=seed
    )
    grid = rc.Grid((cells, cells), float(cells))
    return rc.ContactProblem(rc.Body(surface, material), grid=grid, boundary="periodic", threads=1)


def scenes() -> list[tuple[str, rc.ContactProblem, str, Sequence[float]]]:
    """Return the name, the problem, the kind of its loads and the loads of each sweep."""
    log, linear = np.geomspace, np.linspace
    wave = rc.ContactProblem(
        rc.Body(rc.WavySurface(0.5e-6, 12.5e-6), rc.Elastic(200e9, 0.3)),
        grid=rc.Grid((256, 256), 250e-6), boundary="periodic", threads=1,
    )  # fmt: skip
    ball = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(2000.0), SOFT), grid=rc.Grid((256, 256), 64.0), threads=1)
    force = 4.0 / 3.0 * 16.0**3 / 2000.0
    by_approach = rough(256, 45)
    first, last = (by_approach.solve(pressure=x * SLOPE).approach for x in (LIGHT, HEAVY))
    return [
        ("rough, 256 x 256, equal ratios", rough(256, 41), "pressure", loads(log)),
        ("rough, 256 x 256, equal steps", rough(256, 42), "pressure", loads(linear)),
        ("rough, 512 x 512, equal ratios", rough(512, 43), "pressure", loads(log)),
        ("rough, 512 x 512, equal steps", rough(512, 44), "pressure", loads(linear)),
        ("rough, given approaches, equal steps", by_approach, "approach", linear(first, last, LOADS).tolist()),
        ("rough, 82 to 99 % in contact, equal steps", rough(256, 46), "pressure", loads(linear, 0.6, 1.3)),
        ("rough, pressure limit, equal ratios", rough(256, 47, LIMITED), "pressure", loads(log)),
        ("rough, pressure limit, equal steps", rough(256, 48, LIMITED), "pressure", loads(linear)),
        ("wave, equal ratios", wave, "pressure", log(3e6, 3e8, LOADS).tolist()),
        ("ball, free boundary, equal ratios", ball, "force", log(force / 40.0, force, LOADS).tolist()),
    ]


def loads(spacing: Spacing, light: float = LIGHT, heavy: float = HEAVY) -> list[float]:
    """Return mean pressures from a light to a heavy load."""
    return [float(value) for value in spacing(light * SLOPE, heavy * SLOPE, LOADS)]


@attrs.frozen
class Cost:
    """Products of a solve without a start, products and CPU time of the sweep over those of one, and errors.

    `cold` and `warm` are the median first errors on the finest grid, without a start and in the sweep, and `factor` is
    the median by which an iteration of the sweep multiplies the error.
    """

    products: float
    sweep: float
    cpu: float
    cold: float
    warm: float
    factor: float


def measure(problem: rc.ContactProblem, kind: str, values: Sequence[float], tolerance: float) -> Cost:
    """Return what the solves and the sweep of some loads cost."""
    problem = attrs.evolve(problem, solver=problem.plan.solver.with_tolerance(tolerance))
    problem.solve(**{kind: values[0]})
    started = time.process_time()
    cold = [problem.solve(**{kind: value}) for value in values]
    between = time.process_time()
    sweep = problem.sweep(**{kind: values})
    ended = time.process_time()
    products = float(np.mean([solution.convolutions for solution in cold]))
    factors = [(one.errors[-1] / one.errors[0]) ** (1 / one.iterations) for one in sweep.states if one.iterations > 0]
    return Cost(
        products=products,
        sweep=sweep.convolutions / products,
        cpu=LOADS * (ended - between) / (between - started),
        cold=float(np.median([one.errors[0] for one in cold])),
        warm=float(np.median([one.errors[0] for one in sweep.states])),
        factor=float(np.median(factors)),
    )


def make_rows() -> list[list[str]]:
    """Return the costs of the sweep of each scene."""
    rows = [["20 loads", "products of one solve", "sweep, in solves", "at 1e-8", CPU, *ERRORS]]
    for name, problem, kind, values in some_of(scenes(), 0, 4, 5, 6, 8, 9):
        coarse, fine = (measure(problem, kind, values, tolerance) for tolerance in TOLERANCES)
        products = [f"{coarse.products:.0f}", f"{coarse.sweep:.1f}", f"{fine.sweep:.1f}", f"{coarse.cpu:.1f}"]
        errors = [f"{coarse.cold:.3f}", f"{coarse.warm:.3f}", f"{coarse.factor:.2f}"]
        rows.append([name, *products, *errors])
    return rows


# The columns and lines of the pages.
SHOWN = ("20 loads", "products of one solve", "sweep, in solves", "CPU")
LINES = (
    "rough, 512 x 512, equal ratios",
    "rough, pressure limit, equal ratios",
    "ball, free boundary, equal ratios",
)
TABLES = {"sweeps": DocTable(make_rows, seconds=60, timed=(CPU,), units=10.0, shown=pick(SHOWN, LINES))}

if __name__ == "__main__":
    write_tables(TABLES)
