"""Importing the package loads what a solve needs and nothing else."""

from __future__ import annotations

import importlib
import inspect
import json
import pickle
import re
import subprocess
import sys
from importlib.metadata import requires

import pytest

import roughcontact as rc

HEAVY = {
    "jinja2",
    "matplotlib",
    "pint",
    "rich",
    "SurfaceTopography",
    "scipy.fft",
    "scipy.ndimage",
    "scipy.optimize",
    "scipy.sparse.linalg",
    "scipy.special",
    "urllib.request",
    "pandas",
    "roughcontact.paper",
    "argparse",
    "roughcontact._faces.html",
    "roughcontact.testing",
    "roughcontact.slabs",
    "roughcontact._solve.problem.slabs",
    "hypothesis",
}


STEPS = (
    "import roughcontact as rc",
    "import scipy.fft",
    "body = rc.Body(rc.WavySurface(1e-6, 1e-4), rc.Elastic(1e9, 0.3)); "
    "solution = rc.ContactProblem(body, grid=rc.Grid((16, 16), 1e-4)).solve(pressure=1e4)",
    "solution.area()",
)


@pytest.fixture(scope="module")
def loaded():
    """The modules that each step of a script has loaded: the package, the transforms, a solve and its area."""
    probe = "import json, sys\n" + "".join(f"{step}\nprint(json.dumps(sorted(sys.modules)))\n" for step in STEPS)
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    return [set(json.loads(line)) for line in done.stdout.splitlines()]


def test_import_loads_nothing_heavy(loaded):
    assert not HEAVY & loaded[0]


def test_a_solve_loads_nothing_heavy_and_its_area_only_what_it_needs(loaded):
    _, transforms, solve, area = loaded
    assert not HEAVY & (solve - transforms)
    assert HEAVY & (area - transforms) <= {"scipy.ndimage", "scipy.optimize", "scipy.sparse.linalg"}


def test_the_core_needs_three_packages():
    core = [line for line in requires("roughcontact") if "extra ==" not in line]
    assert {re.split(r"[<>=!~ \[;]", line)[0] for line in core} == {"attrs", "numpy", "scipy"}


def test_no_dependency_is_pinned_from_above():
    assert not any("<" in line.split(";")[0] or "==" in line.split(";")[0] for line in requires("roughcontact"))


@pytest.mark.parametrize("name", rc.__all__)
def test_what_is_public_belongs_to_the_package(name):
    public = getattr(rc, name)
    if inspect.isclass(public) or inspect.isfunction(public):
        assert f"{public.__module__}.{public.__qualname__}" == f"roughcontact.{name}"
        assert pickle.loads(pickle.dumps(public)) is public


def test_a_pickle_that_names_a_private_module_is_read():
    """As they were written when classes told the modules that define them."""
    for module, name in (("_parts.grid", "Grid"), ("_solve.problem.body", "Body"), ("errors", "InputError")):
        assert pickle.loads(f"croughcontact.{module}\n{name}\n.".encode()) is getattr(rc, name)


def test_a_public_name_has_one_place_and_those_of_parts_are_few():
    modules = ("faces", "responses", "results", "slabs", "solving", "typing")
    names = [name for module in modules for name in importlib.import_module(f"roughcontact.{module}").__all__]
    assert len(set(names)) == len(names)
    assert not set(names) & set(rc.__all__)
    assert len(rc.typing.__all__) <= 60
