"""The flow through the gap beside the package reynoldsflow, on the same gaps: the table of docs/use/leakage.md.

Needs a separate environment with the other package, which is not a dependency of ours:

    python -m venv peers && peers/bin/pip install reynoldsflow
    export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1
    ROUGHCONTACT_PEERS=peers/bin/python python docs/studies/compare_flow.py

Both let liquid flow through sides alone. Elimination gives the exact flow of our equations; the other package gets the
loosest tolerance of a ladder with which its flow is within 0.1 % of its own at a tight one. CPU time on one thread,
ours before and after the other's, whose compiled functions have been called before.
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from doc_tables import DocTable, write_tables

import roughcontact as rc

ENOUGH = 1e-3
PEER = """
import json, sys, time
import numpy as np
from reynoldsflow import transport

gap = np.load(sys.argv[1])
enough = float(sys.argv[2])
def solve(gap, rtol):
    started = time.process_time()
    filtered, pressure, _ = transport.solve_fluid_problem(gap, rtol=rtol)
    seconds = time.process_time() - started
    return float(np.sum(2.0 * filtered[0] ** 3 * pressure[0])), seconds

n = 64
solve(gap[:n, :n] + 1e-3, 1e-8)
# Its faces are not ours: its own flow at the tightest tolerance is the true one.
true, _ = solve(gap, 1e-11)
for rtol in (1e-6, 1e-8, 1e-10):
    flow, seconds = solve(gap, rtol)
    print(json.dumps([rtol, flow / true - 1.0, seconds]), flush=True)
    if abs(flow / true - 1.0) < enough:
        break
"""


def make_contact(cells: int, load: float = 0.15) -> rc.ContactSolution:
    """Return a rough contact of 30 % contact area: eight cells a shortest wave, roll-off at an eighth of the side."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=8.0 / cells, longest=1.0, rolloff=0.125, seed=1)
    body = rc.Body(surface, rc.Elastic(1e9, 0.0))
    problem = rc.ContactProblem(body, grid=rc.Grid((cells, cells), 1.0), boundary="periodic", threads=1)
    return problem.solve(pressure=0.05 * load * 1e9)


def time_ours(solution: rc.ContactSolution) -> float:
    """Return CPU seconds of all that is returned."""
    started = time.process_time()
    solution.leakage(axis=0, viscosity=1.0 / 12.0, pressure_drop=1.0)
    return time.process_time() - started


def compare(cells: int) -> list[str]:
    solution = make_contact(cells)
    gap = np.where(solution.contact, 0.0, np.maximum(solution.gap, 0.0))
    unit = float(gap.max())
    before = time_ours(solution)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "gap.npy"
        np.save(path, gap / unit)
        command = [os.environ["ROUGHCONTACT_PEERS"], "-W", "ignore", "-c", PEER, str(path)]
        command += [str(ENOUGH)]
        lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    after = time_ours(solution)
    rtol, error, seconds = json.loads(lines[-1])
    ours = 0.5 * (before + after)
    return [
        f"{cells}",
        f"{100 * np.mean(solution.contact):.0f}",
        f"{ours:.2g}",
        f"{seconds:.2g}",
        f"{rtol:.0e}",
        f"{100 * error:.2g}",
        f"{seconds / ours:.1f}",
    ]


def make_rows() -> list[list[str]]:
    heading = ["cells along a side", "contact, %", "roughcontact, CPU s", "reynoldsflow, CPU s", "its tolerance"]
    return [[*heading, "its error, %", "ratio"], *(compare(cells) for cells in (256, 512))]


TABLES = {"flow-codes": DocTable(make_rows, seconds=120, timed=("roughcontact, CPU s", "reynoldsflow, CPU s", "ratio"))}

if __name__ == "__main__":
    write_tables(TABLES)
