"""CUDA graphs on and off, many contacts at once, and the roofline: `python measure_graphs.py`, in at most ten minutes.

On a machine with CUDA, or on a processor with `--cells 64 --count 4`, where a graph is the iteration done again.
Wall times by the masked solver. What was not begun after `--seconds` is omitted, so that the last lines may be missing:
compilation takes half a minute a grid. Expected are, each printed when it is known,

    | product, cells | ms | bytes | GB/s | of a copy's | flops | TFLOP/s | of a matrix product's |
    | 4096, 8192 | a product in float32 reaches half of the bandwidth of a copy or more, and little of the arithmetic |
    | at once, cells | way | contacts | solver, ms a contact | with certificate |
    | 256 | one by one; with graphs; as one; as one, compiled: each several times as fast as the line before it |
    | graphs, cells | iteration | solve, s | iterations / products | GPU memory, GiB |
    | 4096, 8192 | eager, and as a graph; compiled, and as a graph: graphs gain on the coarse grids, where launches take
      longer than the passes, and less at 8192 than at 4096; compiled iterations move a third of the bytes |

Bytes are those of a product at least: each transform reads and writes its field twice, the symbol is read once. On
a processor, 64 cells a side, one thread, a graph gains nothing, and four contacts as one take about half the time.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import attrs
import roughcontact as rc
import torch
from measure import ELASTIC, rough
from roughcontact.solving import make_task

from roughcontact_torch import MaskedConjugateGradient, TorchFFT, solve_at_once, solve_on_device
from roughcontact_torch.graph import GraphedIteration, record_graph

STARTED = time.perf_counter()
REPEATS = 3
ON_GPU = torch.cuda.is_available()
# A copy and a product of matrices that show what the device can do.
COPIED, SIDE = (2**28, 8192) if ON_GPU else (2**22, 512)
# Contacts that are solved one by one.
FEW = 16


@attrs.frozen
class Graphed(MaskedConjugateGradient):
    """The masked solver whose iteration is recorded as a graph or not, compiled or not."""

    graph: bool = attrs.field(default=False, kw_only=True)

    def _iteration(self, descent: Any, blocks: Any) -> Callable[[Any], Any]:
        iterate = torch.compile(descent.iterate, dynamic=False) if self.compiled else descent.iterate
        whole = partial(iterate, blocks=blocks)
        return GraphedIteration(whole, record_graph if ON_GPU else lambda work: work) if self.graph else whole

    def __str__(self) -> str:
        return ("compiled" if self.compiled else "eager") + (", as a graph" if self.graph else "")


def measure(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Return the median wall time, s, after one run that is not counted."""
    times = []
    for _ in range(1 + repeats):
        begin = time.perf_counter()
        work()
        if ON_GPU:
            torch.cuda.synchronize()
        times.append(time.perf_counter() - begin)
    return sorted(times[1:])[repeats // 2]


def make_problem(cells: int, solver: Graphed) -> tuple[rc.ContactProblem, float]:
    """Return a rough contact on tensors, and its mean pressure."""
    problem, load = rough(cells, 0.05)
    return attrs.evolve(problem, convolver=TorchFFT("cuda" if ON_GPU else "cpu"), solver=solver), load["pressure"]


def print_roofline(cells: int, bandwidth: float, arithmetic: float) -> None:
    """Print bytes and flops of a product in float32 beside what the device does."""
    problem, _ = make_problem(cells, Graphed())
    device = "cuda" if ON_GPU else "cpu"
    field = problem.convolution.from_numpy(torch.rand((cells, cells), device=device).numpy(force=True))
    seconds = measure(lambda: problem.convolution.apply(field), 20)
    # Two transforms of 16 bytes a cell, half of the waves read and written, and the symbol.
    moved = (2 * 16 + 8 + 2) * cells**2
    operations = 2 * 2.5 * cells**2 * math.log2(cells**2) + cells**2
    rate = moved / seconds
    speed = operations / seconds
    print(
        f"| product, {cells} | {1e3 * seconds:.3g} | {moved:.3g} | {1e-9 * rate:.0f} | {rate / bandwidth:.2f} "
        f"| {operations:.3g} | {1e-12 * speed:.2g} | {speed / arithmetic:.3f} |",
        flush=True,
    )


def print_at_once(cells: int, count: int, solver: Graphed, *, single: bool) -> None:
    """Print the time of a contact, one by one or of all as one, in the solver alone and with its certificate."""
    problem, pressure = make_problem(cells, solver)
    surface = problem.body.surface
    several = [
        attrs.evolve(problem, body=rc.Body(attrs.evolve(surface, seed=seed), ELASTIC))
        for seed in range(min(count, FEW) if single else count)
    ]
    tasks = [make_task(one.plan, one.initial_gap, one.require_load(pressure=pressure)) for one in several]
    groups = [[task] for task in tasks] if single else [tasks]
    alone = measure(lambda: [solver.solve_all(problem.convolution, group) for group in groups], 1)
    if single:
        whole = measure(lambda: [one.solve(pressure=pressure) for one in several], 1)
    else:
        whole = measure(lambda: solve_at_once(several, [pressure] * count), 1)
    times = " | ".join(f"{1e3 * seconds / len(several):.3g}" for seconds in (alone, whole))
    way = "one by one" if single else "as one"
    print(f"| at once, {cells} | {way}, {solver} | {len(several)} | {times} |", flush=True)


def print_graph(cells: int, solver: Graphed) -> None:
    """Print a solve and its certificate on the device."""
    problem, pressure = make_problem(cells, solver)
    if ON_GPU:
        torch.cuda.reset_peak_memory_stats()
    found = solve_on_device(problem, pressure=pressure)
    seconds = measure(lambda: solve_on_device(problem, pressure=pressure))
    memory = f"{torch.cuda.max_memory_allocated() / 2**30:.2g}" if ON_GPU else "-"
    work = f"{found.iterations} / {found.convolutions}"
    print(f"| graphs, {cells} | {solver} | {seconds:.4g} | {work} | {memory} |", flush=True)


def measure_device() -> tuple[float, float]:
    """Return the bytes a second of a copy, and the operations a second of a product of matrices in float32."""
    device = "cuda" if ON_GPU else "cpu"
    source = torch.rand(COPIED, device=device)
    target = torch.empty_like(source)
    matrix = torch.rand((SIDE, SIDE), device=device)
    copied = measure(lambda: target.copy_(source), 9)
    return 8 * COPIED / copied, 2 * SIDE**3 / measure(lambda: matrix @ matrix)


def main(sides: list[int], cells: int, count: int, seconds: float) -> None:
    """Print all lines in the order of what they tell."""
    print(torch.cuda.get_device_name() if ON_GPU else "processor", "torch", torch.__version__)
    bandwidth, arithmetic = measure_device()
    print(f"copy {1e-9 * bandwidth:.0f} GB/s, matrix product {1e-12 * arithmetic:.3g} TFLOP/s in float32", flush=True)
    plain, graph = Graphed(), Graphed(graph=True)
    compiled, both = Graphed(compiled=True), Graphed(compiled=True, graph=True)
    work = [partial(print_roofline, side, bandwidth, arithmetic) for side in sides]
    work += [partial(print_at_once, cells, count, solver, single=True) for solver in (plain, graph)]
    work += [partial(print_at_once, cells, count, solver, single=False) for solver in (plain, graph)]
    work += [partial(print_graph, side, solver) for side in sides for solver in (plain, graph)]
    work += [partial(print_at_once, cells, count, both, single=False)]
    work += [partial(print_graph, side, solver) for side in sides for solver in (both, compiled)]
    for step in work:
        if time.perf_counter() - STARTED < seconds:
            step()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sides", type=int, nargs="+", default=[4096, 8192], help="cells a side, with graphs and not")
    parser.add_argument("--cells", type=int, default=256, help="cells a side of contacts that are solved at once (256)")
    parser.add_argument("--count", type=int, default=256, help="how many of them (256)")
    parser.add_argument("--seconds", type=float, default=420.0, help="after which nothing more is begun (420)")
    options = parser.parse_args()
    torch.set_num_threads(1)
    main(options.sides if ON_GPU else [options.cells], options.cells, options.count, options.seconds)
