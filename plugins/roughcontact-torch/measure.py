"""The default solver on tensors beside numpy's arrays: `python measure.py [CELLS ...]`, on each device that there is.

Times are medians of three solves, by turns on numpy's arrays and on tensors, in one process on one thread. With
`masked` first: the work of the default solver on numpy's arrays beside that of the masked one on tensors. With `slabs`
first: what one, two and three processes on processors send each other, and the memory of each.
"""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import attrs
import numpy as np
import roughcontact as rc
import torch
from torch.utils._python_dispatch import TorchDispatchMode

from roughcontact_torch import MaskedConjugateGradient, Processes, SlabTensor, TorchFFT, ending_all, solve_on_slabs
from roughcontact_torch.masked_descent import MaskedDescent
from roughcontact_torch.masked_grid import MaskedGrid

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


def rough(
    n: int, pressure: float, *, shortest: float = 8.0, boundary: str = "periodic", limit: float | None = None
) -> tuple[rc.ContactProblem, dict[str, float]]:
    """Return a rough contact of rms slope 0.1; mean pressure and its limit are over slope times modulus."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=shortest, longest=float(n), rolloff=n / 8, seed=0)
    material = ELASTIC if limit is None else rc.ElasticPerfectlyPlastic(1e9, 0.0, 0.1 * limit * ELASTIC.young)
    grid = rc.Grid((n, n), (float(n), float(n)))
    problem = rc.ContactProblem(rc.Body(surface, material), grid=grid, boundary=boundary, threads=1)
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


MASKED: dict[str, Callable[[int], tuple[rc.ContactProblem, dict[str, float]]]] = {
    "periodic, 8 cells, x = 0.05": lambda n: rough(n, 0.05),
    "periodic, 8 cells, x = 0.2": lambda n: rough(n, 0.2),
    "periodic, 8 cells, x = 1": lambda n: rough(n, 1.0),
    "periodic, 2 cells, x = 0.2": lambda n: rough(n, 0.2, shortest=2.0),
    "periodic, limit 0.3, x = 0.1": lambda n: rough(n, 0.1, limit=0.3),
    "free, 8 cells, x = 0.05": lambda n: rough(n, 0.05, boundary="free"),
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


def compare_masked(name: str, n: int) -> str:
    """Return the row of a case: iterations and products of both solvers, what the host reads, and operations."""
    problem, load = MASKED[name](n)
    ours = attrs.evolve(problem, convolver=TorchFFT(), solver=MaskedConjugateGradient())
    expected = problem.solve(**load)
    readings = []
    read = MaskedGrid.read
    MaskedGrid.read = lambda grid, *numbers: readings.append(len(numbers)) or read(grid, *numbers)
    with Operations() as operations:
        found = ours.solve(**load)
    MaskedGrid.read = read
    iterations = sum(level.iterations for level in found.levels)
    counts = (f"{one.iterations} / {one.convolutions}" for one in (expected, found))
    cells = np.count_nonzero(found.contact != expected.contact)
    pressure = np.abs(found.pressure - expected.pressure).max() / expected.pressure.max()
    work = f"{len(readings)} in {iterations} | {operations.all / iterations:.0f}"
    return f"| {name} | {n} | {' | '.join(counts)} | {work} | {cells} | {pressure:.0e} |"


# Contacts on slabs: mean pressure and its limit over slope times modulus, None a given approach; and the boundary.
SLABS: dict[str, tuple[float | None, float | None, str]] = {
    "periodic, x = 0.05": (0.05, None, "periodic"),
    "periodic, x = 1": (1.0, None, "periodic"),
    "periodic, limit 0.3, x = 0.1": (0.1, 0.3, "periodic"),
    "periodic, approach": (None, None, "periodic"),
    "free, x = 0.05": (0.05, None, "free"),
}


def measure_memory(work: Callable[[], object]) -> tuple[object, float]:
    """Return a result, and the bytes by which the memory of this process has grown at most meanwhile; on Linux."""
    Path("/proc/self/clear_refs").write_text("5")
    before = _resident("VmRSS")
    found = work()
    return found, _resident("VmHWM") - before


def _resident(name: str) -> float:
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024.0 * next(float(line.split()[1]) for line in lines if line.startswith(name))


def measure_slabs(name: str, n: int, processes: Processes) -> str:
    """Return the row of a case on slabs."""
    x, limit, boundary = SLABS[name]
    problem, _ = rough(n, 1.0, limit=limit)
    heights = problem.body.surface.heights(problem.grid)
    load = {"approach": 0.5 * float(heights.max() - heights.mean())} if x is None else {"pressure": 0.1 * x * 1e9}
    slab = SlabTensor.field(heights[processes.own_rows(n)], processes, n)
    counts = []
    iterate = MaskedDescent.iterate

    def count(descent, *arguments):
        before = processes.reductions, processes.exchanges
        found = iterate(descent, *arguments)
        if descent.grid.shape == (n, n):
            counts.append((processes.reductions - before[0], processes.exchanges - before[1]))
        return found

    material = problem.body.material
    # What torch loads at first does not count.
    few = heights[:64, :64][processes.own_rows(64)]
    solve_on_slabs(SlabTensor.field(few, processes, 64), 64.0, material, pressure=1e6, boundary=boundary)
    del heights
    processes.reductions = processes.exchanges = processes.sent = 0
    MaskedDescent.iterate = count
    found, memory = measure_memory(lambda: solve_on_slabs(slab, problem.grid, material, boundary=boundary, **load))
    MaskedDescent.iterate = iterate
    reductions, exchanges = max(counts)
    all_counts = f"{processes.reductions} | {processes.exchanges} | {processes.sent / 2**20:.1f}"
    arrays = memory / (8 * n * slab.tensor.shape[0])
    work = f"{found.iterations} / {found.convolutions} | {np.count_nonzero(found.contact)}"
    row = f"{reductions} | {exchanges} | {all_counts} | {arrays:.0f}"
    return f"| {name} | {n} | {processes.count} | {work} | {row} |"


def start_slabs(cells: list[str]) -> None:
    """Print the rows of one, two and three processes; what an array leaves goes back to the system at once."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "MALLOC_MMAP_THRESHOLD_": "65536"}
    for n in cells:
        for case, count in itertools.product(SLABS, (1, 2, 3)):
            start = [sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node", str(count)]
            subprocess.run([*start, __file__, "slabs-of", case, n], env=environment, check=True)


if __name__ == "__main__":
    torch.set_num_threads(1)
    if sys.argv[1:2] == ["slabs"]:
        start_slabs(sys.argv[2:] or ["512", "1024"])
        sys.exit()
    if sys.argv[1:2] == ["slabs-of"]:
        started = Processes("cpu")
        with ending_all(started):
            row = measure_slabs(sys.argv[2], int(sys.argv[3]), started)
            if started.rank == 0:
                print(row, flush=True)
        sys.exit()
    if sys.argv[1:2] == ["masked"]:
        for cells in map(int, sys.argv[2:] or ["256", "512", "1024"]):
            for case in MASKED:
                print(compare_masked(case, cells), flush=True)
        sys.exit()
    for cells in map(int, sys.argv[1:] or ["256", "512", "1024"]):
        for case in CASES:
            for place in ("cpu", "cuda")[: 1 + torch.cuda.is_available()]:
                print(measure(case, cells, place), flush=True)
