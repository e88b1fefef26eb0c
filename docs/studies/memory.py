"""Peak memory of a solve, measured and as the plan states it, in float64 arrays of the grid's size.

    python docs/studies/memory.py

Each solve runs in its own process. The measured value is the peak resident memory beyond that before the solve, after
a small solve has loaded all libraries. What is released is given back at once: by default glibc keeps blocks below 32
MiB for later, which adds up to a third, by chance.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import roughcontact as rc

# Boundary, hardness over E* slope (0: none), mean pressure over E* slope.
CASES = (
    ("periodic", 0.0, 0.005),
    ("periodic", 0.0, 0.05),
    ("periodic", 0.0, 0.5),
    ("wrapped", 0.0, 0.05),
    ("free", 0.0, 0.005),
    ("free", 0.0, 0.05),
    ("free", 0.0, 0.5),
    ("periodic", 0.3, 0.05),
    ("free", 0.3, 0.05),
)


def problem(cells: int, boundary: str, hardness: float) -> rc.ContactProblem:
    """Return a rough surface of rms slope 0.1 on a rigid flat; E* slope is 100 MPa."""
    side = 1e-4
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.1, longest=side, rolloff=side / 8, shortest=8 * side / cells, seed=3
    )
    material = rc.ElasticPerfectlyPlastic(1e9, 0.0, 1e8 * hardness) if hardness else rc.Elastic(1e9, 0.0)
    return rc.ContactProblem(rc.Body(surface, material), grid=rc.Grid((cells, cells), side), boundary=boundary)


def read_status(name: str) -> int:
    """Return an entry of this process's memory status, bytes."""
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(name))


def measure(cells: int, boundary: str, hardness: float, load: float) -> tuple[float, float, float]:
    """Return the fraction of cells in contact, and the peak measured and stated, in arrays of the grid's size."""
    small = problem(64, boundary, hardness)
    small.solve(pressure=1e8 * load).area()
    large = problem(cells, boundary, hardness)
    array = 8 * large.plan.grid.cells
    before = read_status("VmRSS")
    # This resets the peak.
    Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")
    solution = large.solve(pressure=1e8 * load)
    fraction = float((solution.contact & ~solution.saturated).mean())
    return fraction, (read_status("VmHWM") - before) / array, large.plan.memory_at(fraction) / array


def measure_in_process(cells: int, boundary: str, hardness: float, load: float) -> tuple[float, float, float]:
    command = f"import json, memory; print(json.dumps(memory.measure({cells}, {boundary!r}, {hardness}, {load})))"
    folder = Path(__file__).parent
    environment = os.environ | {"MALLOC_MMAP_THRESHOLD_": str(2**17)}
    done = subprocess.run(
        [sys.executable, "-c", command], cwd=folder, env=environment, capture_output=True, text=True, check=True
    )
    fraction, measured, stated = json.loads(done.stdout)
    return fraction, measured, stated


def main(grids: tuple[int, ...] = (1024, 2048)) -> None:
    print(
        "| boundary | hardness / E* slope | N | unsaturated contact | measured | stated | error |\n" + "|---" * 7 + "|"
    )
    for cells in grids:
        for boundary, hardness, load in CASES:
            fraction, measured, stated = measure_in_process(cells, boundary, hardness, load)
            limit = f"{hardness:g}" if hardness else "none"
            error = f"{100 * (stated / measured - 1):+.0f} %"
            row = (boundary, limit, cells, f"{100 * fraction:.1f} %", f"{measured:.1f}", f"{stated:.1f}", error)
            print(f"| {' | '.join(map(str, row))} |")


if __name__ == "__main__":
    main()
