"""Our default solver beside tamaas, ContactMechanics and ASPHER on the same arrays, verified by one function.

Needs a separate environment with the other codes (none is a dependency of ours; tamaas is under the AGPL):

    python -m venv peers && peers/bin/pip install -e . tamaas ContactMechanics
    peers/bin/pip install aspher  # compiles; needs CMake and Eigen 3.4; skipped where it is missing
    peers/bin/python docs/studies/compare_codes.py

One process, one thread, CPU time. Ours runs before and after each other code, and the median counts; the others run
once, because some take minutes. Every code gets the tolerance with which it meets the requirement: complementarity
1e-6 of the rms height, recomputed by `measure_violation`.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import importlib.util
import statistics
import time
import warnings
from collections.abc import Callable

import attrs
import numpy as np

import roughcontact as rc

# Rms slope of the rough surfaces; required complementarity over the rms height.
SLOPE = 0.1
REQUIRED = 1e-6


@attrs.frozen(eq=False)
class Case:
    """One contact in units of E* = 1 on cells of side one."""

    name: str
    heights: np.ndarray
    mean: float
    boundary: str = "periodic"
    hardness: float | None = None


def make_rough(cells: int, seed: int = 0) -> np.ndarray:
    """Return heights with Hurst 0.8, roll-off at an eighth of the side, shortest wave of eight cells, rms slope 0.1."""
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=SLOPE, shortest=8.0, longest=float(cells), rolloff=cells / 8, seed=seed
    )
    return surface.heights(rc.Grid((cells, cells), float(cells)))


def make_cases(largest: int) -> list[Case]:
    """Return the contacts of the README's table, up to a number of cells along a side."""
    cases = [Case(f"x = 0.05, {n}", make_rough(n), 0.05 * SLOPE) for n in (512, 1024, 2048) if n <= largest]
    if largest >= 1024:
        cases += [Case(f"x = {x}, 1024", make_rough(1024), x * SLOPE) for x in (0.2, 1.0, 1.5, 3.0)]
        wave = rc.WavySurface(0.5e-6 * 1024 / 250e-6, 12.5e-6 * 1024 / 250e-6)
        cases.append(Case("bi-sinusoid, 1024", wave.heights(rc.Grid((1024, 1024), 1024.0)), 100e6 / 219.78e9))
        ball, a = rc.ParaboloidSurface(1e4), 0.15 * 1024
        force = 4 * a**3 / (3 * 1e4)
        cases.append(Case("Hertz, free, 1024", ball.heights(rc.Grid((1024, 1024), 1024.0)), force / 1024**2, "free"))
    cases.append(Case("hardness 0.3 slope, x = 0.05, 512", make_rough(512), 0.05 * SLOPE, hardness=0.3 * SLOPE))
    cases.append(Case("mean pressure 0.9 H, 512", make_rough(512), 0.27 * SLOPE, hardness=0.3 * SLOPE))
    return cases


def measure_violation(pressure: np.ndarray, case: Case) -> tuple[float, float]:
    """Return the violation of the contact conditions over the rms height, and the error of the load, by numpy's FFT."""
    n = case.heights.shape[0]
    if case.boundary == "free":
        offsets = np.minimum(np.arange(2 * n), 2 * n - np.arange(2 * n)).astype(int)
        table = rc.Love().coefficients((n + 1, n + 1), (1.0, 1.0), 1.0)[np.ix_(offsets, offsets)]
        padded = np.fft.rfft2(pressure, s=(2 * n, 2 * n)) * np.fft.rfft2(table)
        gap = np.fft.irfft2(padded)[:n, :n] - case.heights
    else:
        q = 2 * np.pi * np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None, :])
        q[0, 0] = np.inf
        gap = np.fft.irfft2(np.fft.rfft2(pressure) * 2 / q, s=(n, n)) - case.heights
    saturated = pressure >= (1 - 1e-9) * (case.hardness or np.inf)
    free = (pressure > 0) & ~saturated
    gap -= np.average(gap[free], weights=pressure[free]) if free.any() else gap[saturated].max()
    wrong = np.where(saturated, np.maximum(gap, 0), np.abs(gap))
    opened = np.sum(pressure * wrong) / pressure.sum()
    overlap = max(0.0, -gap[~saturated].min(initial=np.inf))
    return float(max(opened, overlap) / case.heights.std()), float(abs(pressure.mean() / case.mean - 1))


def solve_ours(case: Case, tolerance: float = REQUIRED) -> np.ndarray:
    material = rc.Elastic(1.0, 0.0)
    if case.hardness is not None:
        material = rc.ElasticPerfectlyPlastic(1.0, 0.0, case.hardness)
    size = float(case.heights.shape[0])
    kernel = "love" if case.boundary == "free" else "fourier"
    problem = rc.ContactProblem(
        rc.Body(rc.HeightMap(case.heights, size=size, periodic=True), material),
        boundary=case.boundary,
        kernel=kernel,
        solver=rc.ProjectedConjugateGradient(tolerance=tolerance),
        threads=1,
    )
    return np.array(problem.solve(pressure=case.mean).pressure)


def solve_tamaas(case: Case) -> np.ndarray | None:
    if case.hardness is not None:
        return None
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    n = case.heights.shape[0]
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [float(n)] * 2, [n, n])
    model.E, model.nu = 1.0, 0.0
    solver = tm.PolonskyKeerRey(model, case.heights, REQUIRED)
    if case.boundary == "free":
        tm.ModelFactory.registerNonPeriodic(model, "dcfft")
        solver.setIntegralOperator("dcfft")
    solver.max_iter = 10_000
    solver.solve(case.mean)
    return np.array(model.traction)


def solve_contact_mechanics(case: Case) -> np.ndarray | None:
    # Without a hardness it took 1.6 to 4 times as long as tamaas on 1024 x 1024 cells: minutes a case.
    if case.hardness is None and case.heights.shape[0] > 512:
        return None
    from ContactMechanics import FreeFFTElasticHalfSpace, PeriodicFFTElasticHalfSpace
    from ContactMechanics.Optimization import constrained_conjugate_gradients
    from SurfaceTopography import Topography

    n, size = case.heights.shape[0], float(case.heights.shape[0])
    space = FreeFFTElasticHalfSpace if case.boundary == "free" else PeriodicFFTElasticHalfSpace
    result = constrained_conjugate_gradients(
        space((n, n), 1.0, (size, size)),
        Topography(case.heights, (size, size)),
        hardness=case.hardness,
        external_force=case.mean * size**2,
        pentol=REQUIRED * case.heights.std(),
        maxiter=3000,
    )
    return np.abs(np.array(result.jac)[:n, :n]) if result.success else None


def solve_aspher(case: Case) -> np.ndarray | None:
    if case.hardness is not None or importlib.util.find_spec("aspher") is None:
        return None
    from aspher import solve_nested

    n, free = case.heights.shape[0], case.boundary == "free"
    # Coarser tolerances miss the requirement by a factor of four to ten; on a free boundary float32 saves no time.
    result = solve_nested(
        grid_size=n,
        gap=np.ascontiguousarray(-case.heights),
        p_nominal=case.mean,
        domain_size=float(n),
        E_star=1.0,
        tol=0.1 * REQUIRED if free else 0.01 * REQUIRED,
        precision="" if free else "float_then_double",
        backend="fft" if free else "periodic",
    )
    return np.array(result.pressure).reshape(n, n)


def measure_time(run: Callable[[Case], np.ndarray | None], case: Case) -> tuple[float, np.ndarray | None]:
    started = time.process_time()
    try:
        with warnings.catch_warnings(action="ignore"):
            pressure = run(case)
    except Exception as error:
        print(f"{run.__name__} on {case.name}: {type(error).__name__}: {error}")
        pressure = None
    return time.process_time() - started, pressure


def format_entry(seconds: float, pressure: np.ndarray | None, case: Case) -> str:
    if pressure is None:
        return "-"
    gap, _ = measure_violation(pressure, case)
    return f"{seconds:.2f}" + ("" if gap <= REQUIRED else f" (complementarity {gap:.0e})")


def main(largest: int = 1024, only: str = "") -> None:
    print("| case | ours, s | ours, gap and load | tamaas, s | ContactMechanics, s | ASPHER, s | best peer / ours |")
    print("|---|---|---|---|---|---|---|")
    for case in make_cases(largest):
        if only not in case.name:
            continue
        solve_ours(case)
        times, peers = [measure_time(solve_ours, case)], []
        for peer in (solve_tamaas, solve_contact_mechanics, solve_aspher):
            peers.append(measure_time(peer, case))
            times.append(measure_time(solve_ours, case))
        mine = statistics.median(seconds for seconds, _ in times)
        gap, load = measure_violation(times[-1][1], case)
        valid = [seconds for seconds, pressure in peers if pressure is not None]
        ratio = f"{min(valid) / mine:.0f}" if valid else "-"
        print(
            f"| {case.name} | {mine:.3f} | {gap:.0e}, load {load:.0e} "
            f"| {' | '.join(format_entry(*result, case) for result in peers)} | {ratio} |",
            flush=True,
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--largest", type=int, default=1024, help="maximum number of cells along a side (1024)")
    parser.add_argument("--only", default="", help="only the cases whose name contains this")
    options = parser.parse_args()
    main(options.largest, options.only)
