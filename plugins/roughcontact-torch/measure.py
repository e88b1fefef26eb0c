"""The tables of README.md: `python measure.py [CELLS ...]`, on each device that there is.

Times are medians of three solves, by turns on numpy's arrays and on tensors, in one process on one thread.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import attrs
import numpy as np
import roughcontact as rc
import torch
from torch.utils._python_dispatch import TorchDispatchMode

from roughcontact_torch import TorchFFT

_REPEATS = 3
# What makes the host wait for a device: numbers that are read, and lists whose length must be known.
_WAITS = ("_local_scalar_dense", "nonzero", "equal", "repeat_interleave.Tensor")
ELASTIC = rc.Elastic(1e9, 0.0)


class Operations(TorchDispatchMode):
    """Counts operations on tensors, and those for which the host waits."""

    def __init__(self) -> None:
        super().__init__()
        self.all = self.waits = 0

    def __torch_dispatch__(self, function, types, args=(), kwargs=None):
        masked = function is torch.ops.aten.index.Tensor and any(
            index is not None and index.dtype == torch.bool for index in args[1]
        )
        self.all += 1
        self.waits += masked or any(f"aten.{name}" in str(function) for name in _WAITS)
        return function(*args, **(kwargs or {}))


def rough(n: int, pressure: float) -> tuple[rc.ContactProblem, dict[str, float]]:
    """Return a rough periodic contact of rms slope 0.1, and its mean pressure over slope times modulus."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8.0, longest=float(n), rolloff=n / 8, seed=0)
    grid = rc.Grid((n, n), (float(n), float(n)))
    problem = rc.ContactProblem(rc.Body(surface, ELASTIC), grid=grid, boundary="periodic", threads=1)
    return problem, {"pressure": 0.1 * pressure * ELASTIC.young}


def sphere(n: int) -> tuple[rc.ContactProblem, dict[str, float]]:
    """Return a sphere on a free domain, four contact radii wide, and its force."""
    surface = rc.ParaboloidSurface(2000.0)
    grid = rc.Grid((n, n), (64.0, 64.0))
    problem = rc.ContactProblem(rc.Body(surface, ELASTIC), grid=grid, threads=1)
    return problem, {"force": 4 / 3 * 16.0**3 / 2000.0 * ELASTIC.young}


CASES: dict[str, Callable[[int], tuple[rc.ContactProblem, dict[str, float]]]] = {
    "rough, 8 % in contact": lambda n: rough(n, 0.05),
    "rough, 97 %": lambda n: rough(n, 1.0),
    "sphere, free": sphere,
}


def clock() -> float:
    """Return the time after what a GPU has been given is done, s."""
    if torch.cuda.is_available():
        torch.cuda.synchronize()
        return time.perf_counter()
    return time.process_time()


def measure(name: str, n: int, device: str) -> str:
    """Return the row of a case."""
    problem, load = CASES[name](n)
    ours = attrs.evolve(problem, convolver=TorchFFT(device))
    times = ([], [])
    for _ in range(1 + _REPEATS):
        for one, kept in zip((problem, ours), times, strict=True):
            begin = clock()
            solution = one.solve(**load)
            kept.append(clock() - begin)
    with Operations() as operations:
        solution = ours.solve(**load)
    iterations = sum(level.iterations for level in solution.levels)
    numpys, tensors = (float(np.median(kept[1:])) for kept in times)
    counts = f"{operations.all / iterations:.0f} | {operations.waits / iterations:.0f}"
    return f"| {name} | {n} | {device} | {numpys:.2f} | {tensors:.2f} | {tensors / numpys:.2f} | {counts} |"


if __name__ == "__main__":
    torch.set_num_threads(1)
    for cells in map(int, sys.argv[1:] or ["256", "512", "1024"]):
        for case in CASES:
            for place in ("cpu", "cuda")[: 1 + torch.cuda.is_available()]:
                print(measure(case, cells, place), flush=True)
