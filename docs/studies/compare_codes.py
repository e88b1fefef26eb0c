"""Our solvers beside those of tamaas on the same periodic rough surfaces, checked by one independent function.

Needs an environment of its own with tamaas in it (it is under the AGPL and no dependency of ours):

    python -m venv peers && peers/bin/pip install -e . tamaas && peers/bin/python docs/studies/compare_codes.py

Everything runs in one process on one thread; ours runs before and after each peer; CPU times.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import statistics
import time

import numpy as np

import roughcontact as rc

SLOPE, YOUNG = 0.1, 1.0


def surface(cells: int) -> np.ndarray:
    """Hurst 0.8, roll-off at an eighth of the side, shortest wave of eight cells, rms slope 0.1."""
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=SLOPE, shortest=8 / cells, longest=1.0, rolloff=1 / 8, seed=0)
    return rough.heights(rc.Grid((cells, cells), 1.0))


def violation(pressure: np.ndarray, heights: np.ndarray, mean: float) -> tuple[float, float]:
    """Complementarity with the least gap at zero, in rms heights, and the error of the load: plain numpy."""
    n = heights.shape[0]
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(n, 1 / n)[:, None], np.fft.fftfreq(n, 1 / n)[None, :])
    q[0, 0] = np.inf
    gap = np.fft.ifft2(np.fft.fft2(pressure) * 2 / (YOUNG * q)).real - heights
    gap -= gap.min()
    return float(np.sum(pressure * gap) / pressure.sum() / heights.std()), abs(pressure.mean() / mean - 1)


def ours(solver: rc.Solver, heights: np.ndarray, mean: float) -> tuple[float, np.ndarray, int]:
    started = time.process_time()
    body = rc.Body(rc.HeightMap(heights, size=1.0, periodic=True), rc.Elastic(YOUNG, 0.0))
    solution = rc.ContactProblem(body, boundary="periodic", kernel="fourier", solver=solver).solve(pressure=mean)
    return time.process_time() - started, np.array(solution.pressure), solution.iterations


def tamaas(tolerance: float, heights: np.ndarray, mean: float) -> tuple[float, np.ndarray, int]:
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    started = time.process_time()
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [1.0, 1.0], list(heights.shape))
    model.E, model.nu = YOUNG, 0.0
    solver = tm.PolonskyKeerRey(model, heights, tolerance)
    solver.max_iter = 5000
    solver.solve(mean)
    return time.process_time() - started, np.array(model.traction), -1


def main(grids: tuple[int, ...] = (256, 512, 1024), share: float = 0.05) -> None:
    mean = share * SLOPE * YOUNG
    print("| N | solver | iterations | CPU time, s | complementarity | load error |")
    print("|---|---|---|---|---|---|")
    for cells in grids:
        heights = surface(cells)
        runs = {
            "ours, spectral-gradient": lambda h: ours(rc.SpectralGradient(tolerance=1e-6), h, mean),
            "ours, polonsky-keer": lambda h: ours(rc.PolonskyKeer(tolerance=1e-6), h, mean),
            "tamaas, PolonskyKeerRey": lambda h: tamaas(1e-6, h, mean),
        }
        results: dict[str, list[tuple[float, np.ndarray, int]]] = {name: [] for name in runs}
        for _ in range(3):
            for name, run in runs.items():
                results[name].append(run(heights))
        for name, found in results.items():
            gap, load = violation(found[-1][1], heights, mean)
            cpu = statistics.median(item[0] for item in found)
            count = found[-1][2] if found[-1][2] >= 0 else "-"
            print(f"| {cells} | {name} | {count} | {cpu:.2f} | {gap:.1e} | {load:.1e} |", flush=True)


if __name__ == "__main__":
    main()
