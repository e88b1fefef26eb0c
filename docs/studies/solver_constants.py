"""What the constants of the default solver are worth: the products of a set of contacts when each is halved or doubled.

    python docs/studies/solver_constants.py

Products are convolutions and inverse convolutions, as in docs/trust/solver_cost.md, in all contacts together over those
with the values as they are. Constants that change no product are varied in CPU time. Last, the rounding of transforms.
"""

from __future__ import annotations

import statistics
import time
from types import ModuleType
from unittest import mock

import numpy as np
import scipy.fft

import roughcontact as rc
from roughcontact._parts.kernels import BoundKernel
from roughcontact._solve.convolvers import base, inverse
from roughcontact._solve.solvers import grids, passes, projection
from roughcontact._solve.solvers.conjugate import descent, nested_iteration, preconditioner, refinement, solver

PRODUCTS: dict[ModuleType, str] = {
    base: "_PADDING_FACTOR _PADDING_CELLS",
    inverse: "_MIN_AMPLITUDE",
    projection: "_STEP_LOAD_ERROR",
    preconditioner: (
        "_MAX_CHANGED_FRACTION _PASSIVE_ALLOWANCE _MAX_STENCIL_FRACTION _STENCIL_REACH _MIN_WEIGHT "
        "LONG_WAVE_CUT _BLOCK_RESOLUTION _MAX_BLOCK_CELLS _MIN_BLOCKS _MAX_BLOCK_STEPS _BLOCK_RESIDUAL "
        "MAX_CUT_EXPONENT _MIN_SINGULAR_RATIO _RELEASE_PART"
    ),
    descent: (
        "FIRST_LENGTH MAX_LENGTH CAREFUL_LENGTH _FULL_STEP_PART SHORTENED_STEP_PART MIN_CONJUGATE_SLOPE "
        "_LATE_ERROR_FRACTION _SLOW_ERROR_RATIO _MAX_SLOW_ITERATIONS _MAX_IDLE_ITERATIONS"
    ),
    refinement: (
        "_SUPPORT_STIFFNESS _FLOAT32_GAIN _FLOAT32_ERROR _EARLY_GOAL_FACTOR _GOAL_FRACTION _MAX_IDLE_VERIFICATIONS"
    ),
    grids: "_MIN_COARSE_CELLS",
    nested_iteration: (
        "_MAX_ESTIMATE_CELLS _COARSE_TOLERANCE _COARSE_ITERATIONS _ESTIMATE_TOLERANCE "
        "_ESTIMATE_ITERATIONS _NEARLY_FULL_FRACTION _APPROACH_MARGIN _WINDOW_MULTIPLE _MAX_WINDOW_FRACTION"
    ),
    solver: "_MAX_APPROACH_ITERATIONS _FIRST_POWER _MIN_MISSING_FRACTION",
}
# What halving or doubling would make no sense of: factors next to one, and powers of two.
VALUES = {
    "_PADDING_FACTOR": (1.125, 1.5),
    "_GOAL_FRACTION": (0.5, 0.9),
    "_FULL_STEP_PART": (0.6, 0.95),
    "_NEARLY_FULL_FRACTION": (0.4, 0.8),
    "_APPROACH_MARGIN": (1.0, 1.1),
    "_MAX_WINDOW_FRACTION": (0.5, 0.9),
}
TIMES: dict[ModuleType, str] = {
    passes: "_DENSE_FRACTION _SPARSE_ROW_FRACTION",
    projection: "_MAX_NEAR_FRACTION _REACH_FACTOR",
}


def rough(cells: int, boundary: str, shortest: float = 8.0, hardness: float | None = None) -> rc.ContactProblem:
    """Return a self-affine surface of rms slope 0.1 on an elastic half-space, E* = 1, lengths in cells."""
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.1, shortest=shortest, longest=float(cells), rolloff=cells / 8, seed=0
    )
    material = rc.Elastic(1.0, 0.0) if hardness is None else rc.ElasticPerfectlyPlastic(1.0, 0.0, hardness)
    return rc.ContactProblem(rc.Body(surface, material), grid=rc.Grid((cells, cells), float(cells)), boundary=boundary)


def contacts() -> list[tuple[rc.ContactProblem, dict[str, float]]]:
    """Return loads from light to nearly full contact, given approaches, limits, a ball and steps near full contact."""
    found: list[tuple[rc.ContactProblem, dict[str, float]]] = []
    for boundary in ("free", "periodic"):
        found += [(rough(128, boundary), {"pressure": share * 0.1}) for share in (0.01, 0.05, 0.2, 1.0)]
        found += [(rough(128, boundary, 2.0), {"pressure": 0.02})]
        found += [(rough(128, boundary, hardness=0.03), {"pressure": share * 0.03}) for share in (0.05, 0.3, 0.9)]
        problem = rough(128, boundary)
        found += [(problem, {"approach": share * float(problem.initial_gap.mean())}) for share in (0.2, 0.5, 0.9)]
    ball = rc.Body(rc.ParaboloidSurface(1e-2, center=(2e-4, -1e-4)), rc.Elastic(1e11, 0.3))
    found += [(rc.ContactProblem(ball, grid=rc.Grid((256, 256), 1e-3)), {"pressure": p}) for p in (1e5, 1e6, 1e7)]
    steps = rc.HeightMap(
        np.round(2.0 * np.random.default_rng(2).standard_normal((50, 12))), (50.0, 10.0), periodic=True
    )
    problem = rc.ContactProblem(rc.Body(steps, rc.Elastic(1.0, 0.0)), boundary="periodic")
    return [*found, (problem, {"approach": (1.0 - 1e-7) * float(problem.initial_gap.mean())})]


CONTACTS = contacts()


def products() -> tuple[int, int]:
    """Return the products of all contacts, and how many did not converge."""
    solutions = [problem.solve(throw=False, **load) for problem, load in CONTACTS]
    return sum(s.convolutions for s in solutions), sum(not s.status.success for s in solutions)


def variants(module: ModuleType, name: str) -> tuple[float, float]:
    """Return the values to be tried."""
    value = getattr(module, name)
    return VALUES.get(name, (type(value)(value / 2), 2 * value))


def seconds() -> float:
    """Return the CPU time of three contacts of 512 x 512 cells, the median of five."""
    problems = [(rough(512, "periodic"), 5e-3), (rough(512, "periodic"), 0.05), (rough(512, "free", 8.0, 0.03), 5e-3)]
    times = []
    for _ in range(5):
        started = time.process_time()
        for problem, pressure in problems:
            problem.solve(pressure=pressure)
        times.append(time.process_time() - started)
    return statistics.median(times)


def transform_rounding(cells: int, boundary: rc.Boundary) -> float:
    """Return the rounding of a convolution of random pressures over its largest term, in eps."""
    convolver = rc.DCFFT() if boundary is rc.Boundary.FREE else rc.CircularFFT()
    kernel, grid = BoundKernel(rc.Love()), rc.Grid((cells, cells), float(cells))
    pressure = np.random.default_rng(0).random(grid.shape)
    displacement = convolver.prepare(kernel, grid, boundary).apply(pressure)
    # The same transforms in extended precision; a table of the responses of a grid laid out for both signs.
    if boundary is rc.Boundary.FREE:
        mx, my = convolver.transform_shape(grid, boundary)
        table, offsets = kernel.coefficients(grid.shape, grid.spacing), [np.arange(m) for m in (mx, my)]
        i, j = (np.minimum(offset, offset.size - offset) for offset in offsets)
        outside = (i >= cells)[:, np.newaxis] | (j >= cells)
        even = np.where(outside, 0.0, table[np.ix_(np.minimum(i, cells - 1), np.minimum(j, cells - 1))])
        symbol = scipy.fft.fft2(even.astype(np.longdouble))
    else:
        mx, my = grid.shape
        q = [2.0 * np.pi * np.fft.fftfreq(n) for n in grid.shape]
        symbol = kernel.spectrum(q[0][:, np.newaxis], q[1][np.newaxis, :], grid.spacing).astype(np.longdouble)
    exact = scipy.fft.ifft2(symbol * scipy.fft.fft2(pressure.astype(np.longdouble), s=(mx, my))).real[:cells, :cells]
    largest = max(float(np.abs(displacement).max()), float(pressure.max()))
    return float(np.abs(displacement - exact).max()) / largest / float(np.finfo(np.float64).eps)


def main() -> None:
    """Print all tables."""
    base, failed = products()
    print(f"{len(CONTACTS)} contacts, {base} products, {failed} not converged\n")
    print(f"{'constant':<36} {'value':>8}   products over those at that value (not converged)")
    for module, names in PRODUCTS.items():
        for name in names.split():
            row = []
            for value in variants(module, name):
                with mock.patch.object(module, name, value):
                    count, failed = products()
                row.append(f"{value:>8.3g}: {count / base:5.3f}" + (f" ({failed})" if failed else ""))
            label = f"{module.__name__.split('.')[-1]}.{name}"
            print(f"{label:<36} {getattr(module, name):>8.3g}   {'   '.join(row)}", flush=True)
    print()
    seconds()
    for module, names in TIMES.items():
        for name in names.split():
            row, usual = [], seconds()
            for value in variants(module, name):
                with mock.patch.object(module, name, value):
                    row.append(f"{value:>8.3g}: {seconds() / usual:5.3f}")
            label = f"{module.__name__.split('.')[-1]}.{name}"
            print(f"{label:<36} {getattr(module, name):>8.3g}   CPU time {'   '.join(row)}", flush=True)
    print()
    for boundary in (rc.Boundary.FREE, rc.Boundary.PERIODIC):
        for cells in (64, 512, 2048):
            print(f"rounding, {boundary}, {cells} x {cells}: {transform_rounding(cells, boundary):.1f} eps", flush=True)


if __name__ == "__main__":
    main()
