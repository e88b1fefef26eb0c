"""Kernels and bytes of the masked solver, counted without a GPU: `python measure_bytes.py [CELLS]`.

First those of an iteration, one operation at a time and compiled, and of a whole solve; then the time in which an H100
moves the bytes, computed. Compilation takes about a minute for each case.
"""

from __future__ import annotations

import logging
import math
import sys
from typing import NamedTuple

import attrs
import torch
from measure import MASKED
from torch._inductor import compile_fx, config, metrics
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves

from roughcontact_torch import MaskedConjugateGradient, TorchFFT
from roughcontact_torch.masked_descent import MaskedDescent

CASES = ("periodic, 8 cells, x = 0.05", "periodic, limit 0.3, x = 0.1", "free, 8 cells, x = 0.05")
# An H100 (SXM5) by its data sheet: bytes, and operations in float32, a second; and the part of the bandwidth reached.
BANDWIDTH = 3.35e12
OPERATIONS = 67e12
REACHED = 0.8
SIDES = (4096, 8192, 16384, 32768)


class Work(NamedTuple):
    """Kernels, those of them that pass over a field, and bytes."""

    kernels: int
    on_fields: int
    bytes: float


class Traffic(TorchDispatchMode):
    """Counts kernels, and bytes if each reads its arguments once and writes its result once, transforms twice."""

    def __init__(self, cells: int) -> None:
        super().__init__()
        self.cells = cells
        self.kernels = self.on_fields = self.bytes = 0

    def __torch_dispatch__(self, function, types, args=(), kwargs=None):
        found = function(*args, **(kwargs or {}))
        given, made = (
            [one for one in tree_leaves(values) if isinstance(one, torch.Tensor)] for values in ((args, kwargs), found)
        )
        places = {one.untyped_storage().data_ptr() for one in given}
        moved = function._schema.is_mutable or any(one.untyped_storage().data_ptr() not in places for one in made)
        # An allocation, or another view of a tensor, moves nothing.
        if moved and "empty" not in str(function):
            passes = 2 if "_fft_" in str(function) else 1
            self.kernels += 1
            self.on_fields += any(one.numel() >= self.cells // 2 for one in (*given, *made))
            self.bytes += sum(passes * one.numel() * one.element_size() for one in (*given, *made))
        return found

    @property
    def work(self) -> Work:
        """What was counted."""
        return Work(self.kernels, self.on_fields, self.bytes)


class Solve(NamedTuple):
    """A solve: all its work, its iterations on all grids in those of the finest, and arguments of the last one."""

    work: Work
    iterations: float
    arguments: tuple


def solve(name: str, n: int) -> Solve:
    """Return the work of a solve with its certificate, one operation at a time."""
    problem, load = MASKED[name](n)
    ours = attrs.evolve(problem, convolver=TorchFFT("cpu"), solver=MaskedConjugateGradient())
    # The prepared convolution does not count.
    ours.solve(**load)
    calls = []
    iterate = MaskedDescent.iterate

    def keep(*arguments):
        calls[:] = [arguments]
        return iterate(*arguments)

    MaskedDescent.iterate = keep
    with Traffic(n * n) as traffic:
        found = ours.solve(**load)
    MaskedDescent.iterate = iterate
    cells = sum(level.iterations * math.prod(level.shape) for level in found.levels)
    return Solve(traffic.work, cells / n**2, calls[0])


def count_eager(arguments: tuple) -> Work:
    """Return the work of an iteration, one operation at a time."""
    descent, *others = arguments
    with Traffic(descent.grid.cells) as traffic:
        descent.iterate(*others)
    return traffic.work


def count_compiled(arguments: tuple) -> Work:
    """Return the work of an iteration as the compiler fuses it, which must take it whole."""
    descent, *others = arguments
    torch.compiler.reset()
    metrics.reset()
    torch.compile(descent.iterate, dynamic=False, fullgraph=True)(*others)
    # The compiler counts words of four bytes, and each transform once.
    nodes = [(node, 4 * words) for node, words in metrics.nodes_num_elem if words]
    transforms = sum(size for node, size in nodes if "_fft_" in str(getattr(node.node, "python_kernel_name", "")))
    on_fields = sum(size >= 2 * descent.grid.cells for _, size in nodes)
    return Work(len(nodes), on_fields, sum(size for _, size in nodes) + transforms)


def print_times(name: str, n: int, solved: Solve, eager: Work, compiled: Work) -> None:
    """Print ms in which an H100 moves the bytes: of both iterations, of the rest of a solve, of both solves; flops."""
    iterations = solved.iterations
    rest = solved.work.bytes - iterations * eager.bytes
    whole = [solved.work.bytes, rest + iterations * compiled.bytes]
    for side in SIDES:
        moved = [(side / n) ** 2 * one for one in (eager.bytes, compiled.bytes, rest, *whole)]
        # Two pairs of real transforms in an iteration.
        operations = 4 * 2.5 * side**2 * math.log2(side**2)
        times = [*(one / (REACHED * BANDWIDTH) for one in moved), operations / OPERATIONS]
        print(f"| {name} | {side} | {' | '.join(f'{1e3 * one:.3g}' for one in times)} |", flush=True)


if __name__ == "__main__":
    torch.set_num_threads(1)
    config.force_disable_caches = True
    # The compiler counts bytes where they are logged.
    compile_fx.inductor_metrics_log.setLevel(logging.INFO)
    compile_fx.inductor_metrics_log.addFilter(lambda _: False)
    n = int(sys.argv[1]) if sys.argv[1:] else 256
    for case in CASES:
        solved = solve(case, n)
        works = (count_eager(solved.arguments), count_compiled(solved.arguments))
        counts = " | ".join(f"{one.kernels} ({one.on_fields}) | {one.bytes / n**2:.0f}" for one in works)
        print(f"| {case} | {solved.iterations:.1f} | {counts} | {solved.work.bytes / n**2:.0f} |", flush=True)
        print_times(case, n, solved, *works)
