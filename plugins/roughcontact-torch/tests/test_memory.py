"""The memory that `explain` states for the masked solver is that of a process which solves."""

import os
import re
import subprocess
import sys

import pytest
import roughcontact as rc

from test_contact import problem
from test_masked import FREE_PERIODIC, tensors

# Peak of the resident memory in a solve. Small problems first load the libraries; each array is given back at once.
SCRIPT = """
import pathlib, re, torch
import numpy as np
import roughcontact as rc
from roughcontact_torch import MaskedConjugateGradient, TorchFFT, solve_on_device

def read(name):
    return 1024 * int(re.search(name + r":\\s+(\\d+)", pathlib.Path("/proc/self/status").read_text())[1])

def make(n):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8.0, longest=float(n), seed=0)
    material = rc.ElasticPerfectlyPlastic(1.0, 0.0, {hardness})
    parts = {{"convolver": TorchFFT("cpu"), "solver": MaskedConjugateGradient(), "threads": 1}}
    grid = rc.Grid((n, n), (float(n), float(n)))
    return rc.ContactProblem(rc.Body(surface, material), grid=grid, boundary={boundary!r}, **parts)

torch.set_num_threads(1)
make(64).{solve}
problem = make({n})
before = read("VmRSS")
pathlib.Path("/proc/self/clear_refs").write_text("5")
solution = problem.{solve}
print((read("VmHWM") - before) / problem.plan.memory)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the peak of the memory is that of Linux")
@pytest.mark.parametrize(
    ("n", "boundary", "hardness", "solve"),
    [
        (512, "periodic", 1.0, "solve(pressure=0.005)"),
        (512, "free", 0.03, "solve(pressure=0.01)"),
        pytest.param(1024, FREE_PERIODIC, 1.0, "solve(pressure=0.02)", marks=pytest.mark.slow),
        pytest.param(1024, "periodic", 1.0, "solve(approach=1.0)", marks=pytest.mark.slow),
        pytest.param(1024, "periodic", 0.03, "solve(pressure=0.01)", marks=pytest.mark.slow),
        pytest.param(1024, "free", 1.0, "solve(pressure=0.005)", marks=pytest.mark.slow),
    ],
    ids=str,
)
def test_the_stated_memory_is_the_peak(n, boundary, hardness, solve):
    script = SCRIPT.format(n=n, boundary=boundary, hardness=hardness, solve=solve)
    environment = os.environ | {"MALLOC_MMAP_THRESHOLD_": "65536"}
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment)
    assert float(run.stdout) == pytest.approx(1.0, rel=0.2)


@pytest.mark.parametrize(("boundary", "arrays"), [("periodic", 19.0), ("free", 23.6), (FREE_PERIODIC, 23.6)], ids=str)
def test_the_explanation_states_it(boundary, arrays):
    stated = re.search(r"memory .*?\(([0-9.]+) arrays of the grid\)", problem(boundary=boundary, **tensors()).explain())
    assert float(stated[1]) == pytest.approx(arrays, rel=1e-2)
    assert rc.ProjectedConjugateGradient().memory_arrays(rc.Boundary.FREE) is None
