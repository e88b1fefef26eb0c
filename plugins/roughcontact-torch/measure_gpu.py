"""The table of a GPU in README.md: `python measure_gpu.py [masked] [CELLS ...]`, on a machine with CUDA.

Wall times: medians of repeated solves after one that is not counted.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import attrs
import numpy as np
import torch
from measure import CASES
from roughcontact._solve.problem.task import make_task

from roughcontact_torch import TorchFFT

_REPEATS = 3
# Solves of larger grids on numpy's arrays take minutes.
_BOTH = 4096


def median(work: Callable[[], object], repeats: int = _REPEATS) -> float:
    """Return the median wall time, s."""
    times = []
    for _ in range(1 + repeats):
        begin = time.perf_counter()
        work()
        torch.cuda.synchronize()
        times.append(time.perf_counter() - begin)
    return float(np.median(times[1:]))


def measure(name: str, n: int, solver: str) -> str:
    """Return the row of a case."""
    problem, load = CASES[name](n)
    ours = attrs.evolve(problem, convolver=TorchFFT("cuda"), solver=solver)
    torch.cuda.reset_peak_memory_stats()
    products = ours.solve(**load).convolutions
    memory = torch.cuda.max_memory_allocated() / 2**30
    whole = median(lambda: ours.solve(**load))
    task = make_task(ours.plan, ours.initial_gap, ours.require_load(**load))
    alone = median(lambda: ours.plan.solver.solve(ours.convolution, task))
    field = ours.convolution.from_numpy(np.random.default_rng(0).random((n, n), dtype=np.float32))
    product = 1e3 * median(lambda: ours.convolution.apply(field))
    others = ["", ""]
    if n <= _BOTH:
        hosts = (attrs.evolve(problem, threads=threads) for threads in (1, "auto"))
        others = [f"{median(lambda host=host: host.solve(**load), 1):.2f}" for host in hosts]
    figures = f"{products} | {whole:.2f} | {alone:.2f} | {product:.2f} | {memory:.2g} | {' | '.join(others)}"
    return f"| {name} | {n} | {figures} |"


if __name__ == "__main__":
    torch.set_num_threads(1)
    words = sys.argv[1:]
    masked = words[:1] == ["masked"]
    for cells in map(int, words[masked:] or ["512", "1024", "2048", "4096", "8192"]):
        for case in CASES if cells <= _BOTH else list(CASES)[:1]:
            print(measure(case, cells, "masked" if masked else "auto"), flush=True)
