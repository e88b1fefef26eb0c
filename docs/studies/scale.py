"""CPU and wall time and peak memory of one solve over the cells of the grid, on one thread and on two.

    python docs/studies/scale.py            # the table of docs/trust/solver_cost.md: about half an hour, 8 GiB
    python docs/studies/scale.py 1024       # up to 1024 x 1024 cells, printed only
    python docs/studies/scale.py products   # wall time of one product on one thread and on two

The contact is that of memory.py at x = 0.05, a rough surface with 10 % of the cells in contact, to the default
tolerance. Each solve runs in its own process and includes the preparation of the kernel, but not that of the heights.
Times are minima: of several solves on small grids, and of `TIMES` processes. Memory is what the solve adds to the
resident memory at its peak, the result included.
"""

from __future__ import annotations

import ctypes
import json
import subprocess
import sys
import time
from pathlib import Path

import attrs
import numpy as np
from doc_tables import DocTable, format_rows, pick, write_tables
from memory import problem, read_status

from roughcontact._base.machine import use_threads

GRIDS = tuple(2**k for k in range(7, 14))
LARGEST = {"periodic": 8192, "free": 4096}
LOAD = 0.05
# Cells that are solved in all for one time, and processes.
CELLS, TIMES = 2**20, 2


def measure(cells: int, boundary: str, threads: int) -> tuple[float, float, int, int]:
    """Return CPU time, wall time, s, products, and peak memory, bytes, of one solve."""
    problem(128, boundary, 0.0).solve(pressure=1e8 * LOAD)
    rough = attrs.evolve(problem(cells, boundary, 0.0), threads=threads)
    # What was freed and is still resident would hide what the solve takes.
    ctypes.CDLL(None).malloc_trim(0)
    before = read_status("VmRSS")
    # This resets the peak.
    Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")
    times, memory = [], 0
    for _ in range(max(1, CELLS // cells**2)):
        wall, cpu = time.perf_counter(), time.process_time()
        solution = rough.solve(pressure=1e8 * LOAD)
        times.append((time.process_time() - cpu, time.perf_counter() - wall))
        memory = memory or read_status("VmHWM") - before
        # Its kernel is not prepared yet.
        rough = attrs.evolve(rough)
    cpu, wall = np.min(times, axis=0).tolist()
    return cpu, wall, solution.convolutions, memory


def measure_in_process(cells: int, boundary: str, threads: int) -> tuple[float, float, int, int]:
    command = f"import json, scale; print(json.dumps(scale.measure({cells}, {boundary!r}, {threads})))"
    folder, found = Path(__file__).parent, []
    for _ in range(TIMES):
        done = subprocess.run([sys.executable, "-c", command], cwd=folder, capture_output=True, text=True, check=True)
        found.append(json.loads(done.stdout))
    cpu, wall, products, memory = np.min(found, axis=0).tolist()
    return cpu, wall, int(products), int(memory)


def make_rows(grids: tuple[int, ...] = GRIDS) -> list[list[str]]:
    heading = "boundary|N|products|CPU, s|wall, s|wall on two threads, s|peak memory, MiB|arrays of the grid"
    lines = [heading.split("|")]
    for boundary, largest in LARGEST.items():
        for cells in (cells for cells in grids if cells <= largest):
            cpu, wall, products, memory = measure_in_process(cells, boundary, 1)
            _, beside, _, _ = measure_in_process(cells, boundary, 2)
            # Three digits, without an exponent.
            figures = (f"{float(f'{value:.3g}'):g}" for value in (cpu, wall, beside, memory / 2**20))
            lines.append([boundary, str(cells), str(products), *figures, f"{memory / (8 * cells**2):.1f}"])
            print(" | ".join(lines[-1]), file=sys.stderr, flush=True)
    return lines


def print_products(grids: tuple[int, ...] = GRIDS[:-1], repeats: int = 20) -> None:
    """Print the minimum wall time of a product in float32 on one thread and on two, ms, alternately measured."""
    for cells in grids:
        convolution = problem(cells, "periodic", 0.0).convolution
        pressure, best = np.random.default_rng(0).random((cells, cells)).astype(np.float32), {1: np.inf, 2: np.inf}
        for _ in range(max(5, repeats * 1024 // cells)):
            for threads in best:
                with use_threads(threads):
                    started = time.perf_counter()
                    convolution.apply(pressure)
                    best[threads] = min(best[threads], time.perf_counter() - started)
        print(f"{cells:5}: {1e3 * best[1]:8.2f} {1e3 * best[2]:8.2f} {best[2] / best[1]:5.2f}", flush=True)


TIMED = ("CPU, s", "wall, s", "wall on two threads, s", "peak memory, MiB", "arrays of the grid")
# The columns and lines of the page.
SHOWN = ("boundary", "N", "CPU, s", "wall on two threads, s", "peak memory, MiB")
LINES = tuple(f"{boundary}; {n}" for boundary in ("periodic", "free") for n in (512, 1024, 4096, 8192))
TABLES = {"scale": DocTable(make_rows, seconds=1200, timed=TIMED, shown=pick(SHOWN, LINES))}

if __name__ == "__main__":
    match sys.argv[1:]:
        case []:
            write_tables(TABLES)
        case ["products"]:
            print_products()
        case [largest]:
            print(format_rows(make_rows(tuple(cells for cells in GRIDS if cells <= int(largest)))))
