"""The suite of asv runs as it stands, on small grids."""

from __future__ import annotations

import inspect
import itertools
import math
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from suite import small, solves

KINDS = ("time_", "peakmem_", "track_", "timeraw_")
CLASSES = [
    kind
    for module in (small, solves)
    for _, kind in inspect.getmembers(module, inspect.isclass)
    if kind.__module__ == module.__name__
]
CASES = [
    (kind, name)
    for kind in CLASSES
    for name, _ in inspect.getmembers(kind, inspect.isfunction)
    if name.startswith(KINDS)
]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name"), CASES)
def test_a_benchmark_runs(monkeypatch, kind, name):
    monkeypatch.setattr(solves, "CELLS", 64)
    lists = getattr(kind, "params", ())
    lists = [lists] if lists and isinstance(lists[0], str) else lists
    # The plug-in compiles; and small grids are the smallest of theirs here.
    several = [given for given in itertools.product(*lists) if not {"compiled", *small.CELLS[1:]} & {*given}]
    for parameters in several:
        benchmark = kind()
        if hasattr(benchmark, "setup"):
            benchmark.setup(*parameters)
        found = getattr(benchmark, name)(*parameters)
        if name.startswith("timeraw_"):
            subprocess.run([sys.executable, "-c", found], check=True)
        elif name.startswith("track_"):
            assert math.isfinite(found)
        else:
            assert found is None


def test_the_tracked_errors_are_those_of_the_area():
    errors = []
    for name, cells in itertools.product(*solves.AreaError.params):
        benchmark = solves.AreaError()
        benchmark.setup(name, cells)
        error, std = benchmark.track_error(name, cells), benchmark.track_uncertainty(name, cells)
        assert abs(error) < 2 * std + 0.02
        errors.append(abs(error))
    assert max(errors) < 5.0
