"""CPU time saved by omitting what a problem does not need.

    python docs/studies/omitted.py

Both variants run in turn in one process; medians of the CPU time.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from unittest import mock

import numpy as np

import roughcontact as rc
from roughcontact._solve.solvers.conjugate import nested_iteration

SIDE = 1e-4


def rough(cells: int, boundary: str, hardness: float | None = None) -> rc.ContactProblem:
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.1, longest=SIDE, rolloff=SIDE / 8, shortest=8 * SIDE / cells, seed=3
    )
    material = rc.Elastic(1e9, 0.0) if hardness is None else rc.ElasticPerfectlyPlastic(1e9, 0.0, hardness)
    grid = rc.Grid((cells, cells), SIDE)
    return rc.ContactProblem(rc.Body(surface, material), grid=grid, boundary=boundary, threads=1)


def compare(one: Callable[[], object], other: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Return the median CPU times of both, s, run in turn after a warm-up."""
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(repeats + 1):
        for run, samples in zip((one, other), times, strict=True):
            started = time.process_time()
            run()
            samples.append(time.process_time() - started)
    first, second = (statistics.median(samples[1:]) for samples in times)
    return first, second


def padding(cells: int, repeats: int) -> tuple[float, float]:
    """Return the times of a convolution on a periodic domain, and zero-padded on a free one."""
    pressure = np.random.default_rng(0).random((cells, cells))
    plain, padded = (rough(cells, boundary).convolution for boundary in ("periodic", "free"))
    return compare(lambda: plain.apply(pressure), lambda: padded.apply(pressure), repeats)


def precision(cells: int, repeats: int) -> tuple[float, float]:
    """Return the times of a convolution in float32 and in float64."""
    double = np.random.default_rng(0).random((cells, cells))
    single, convolution = double.astype(np.float32), rough(cells, "free").convolution
    return compare(lambda: convolution.apply(single), lambda: convolution.apply(double), repeats)


def hardness(cells: int, repeats: int) -> tuple[float, float]:
    """Return the times of a solve without a hardness, and with one that is never reached."""
    free, limited = rough(cells, "periodic"), rough(cells, "periodic", 1e12)
    return compare(lambda: free.solve(pressure=5e6), lambda: limited.solve(pressure=5e6), repeats)


def window(cells: int, repeats: int) -> tuple[float, float]:
    """Return the times of a solve on the cells that can touch, and on all, of a contact a fifth of the domain wide."""
    ball = rc.Body(rc.ParaboloidSurface(1e-3), rc.Elastic(2e11, 0.3))
    problem = rc.ContactProblem(ball, grid=rc.Grid((cells, cells), SIDE), threads=1)

    def solve_all() -> None:
        with mock.patch.object(nested_iteration, "find_window", return_value=None):
            problem.solve(force=0.3)

    return compare(lambda: problem.solve(force=0.3), solve_all, repeats)


VARIANTS = {
    "padding, on a periodic boundary (one convolution)": padding,
    "float64, in the iterations (one convolution)": precision,
    "the pressure limit, without a hardness (one solve)": hardness,
    "cells that cannot touch (one solve of a ball)": window,
}


def main(cells: int = 1024, repeats: int = 5) -> None:
    print(f"| omitted, {cells} x {cells} cells | without, CPU s | with, CPU s | saved |\n|---|---|---|---|")
    for name, run in VARIANTS.items():
        without, with_ = run(cells, repeats)
        print(f"| {name} | {without:.3f} | {with_:.3f} | {100 * (1 - without / with_):.0f} % |")


if __name__ == "__main__":
    main()
