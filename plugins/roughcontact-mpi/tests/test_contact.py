"""Contacts solved by two and three processes are those of one."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
import roughcontact as rc

import mpi
from alone import solve_alone
from random_problems import make_problem

pytestmark = pytest.mark.skipif(bool(mpi.missing()), reason=mpi.missing() or "MPI is there")

SCRIPT = Path(__file__).with_name("solve_cases.py")
# Shapes that two or three processes do not divide, odd ones, domains of 8 : 1, cells of 1 : 3.
SHAPES = {
    "square": ((96, 96), (1.0, 1.0)),
    "odd": ((75, 49), (1.0, 1.0)),
    "long": ((256, 32), (8.0, 1.0)),
    "wide": ((32, 256), (1.0, 8.0)),
    "cells": ((64, 64), (1.0, 3.0)),
    "low": ((2, 40), (1.0, 20.0)),
}
LOADS = {
    "light": {"pressure": 5e6},
    "force": {"force": 2e7},
    "near-full": {"pressure": 1.2e8},
    "full": {"pressure": 1e9},
    "approach": {"approach": None},
}
MIXED = ("free-periodic", "periodic-free")
CASES = [
    *(f"{shape} {boundary} light" for shape in SHAPES for boundary in ("periodic", "free")),
    *(f"{shape} {boundary} light" for shape in ("odd", "long", "wide", "cells", "low") for boundary in MIXED),
    *(f"square {boundary} {load}" for load in ("near-full", "approach") for boundary in MIXED),
    "cells free-periodic light hard",
    *(f"square {boundary} {load}" for load in LOADS if load != "light" for boundary in ("periodic", "free")),
    "square periodic light hard",
    "square free light hard",
    "cells periodic approach hard",
    *(f"random{seed}" for seed in range(6)),
]
SMOOTH = ("square periodic light", "square free light", "square periodic light hard")
# Two processes have all cases; more processes than processors wait for each other, so that three have some.
OF_THREE = (
    *(f"{shape} {boundary} light" for shape in ("odd", "low") for boundary in ("periodic", "free", *MIXED)),
    "square free light hard",
    "cells periodic approach hard",
    "square periodic near-full",
    "random0",
    "random1",
)
OF_COUNT = {2: CASES, 3: OF_THREE}


def make_case(name):
    """Return the heights and the arguments of a case."""
    if name.startswith("random"):
        heights, case = make_problem(int(name.removeprefix("random")))
        return heights, *case.values()
    kind, boundary, load, *hard = name.split()
    shape, size = SHAPES[kind]
    step = max(length / n for length, n in zip(size, shape, strict=True))
    if min(shape) < 8:
        heights = 0.01 * np.random.default_rng(7).normal(size=shape)
    else:
        rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4 * step, longest=min(size), seed=3)
        heights = rough.heights(rc.Grid(shape, size))
    given = dict(LOADS[load])
    if load == "approach":
        given["approach"] = 0.4 * float(heights.max() - heights.mean())
    return heights, size, boundary, given, 3e7 if hard else None


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder in which two and three processes have solved all cases, once."""
    place = tmp_path_factory.mktemp("cases")
    table = {}
    for name in CASES:
        heights, size, boundary, load, hardness = make_case(name)
        file = name.replace(" ", "-")
        np.save(place / f"{file}.npy", heights)
        case = {"map": file, "size": size, "boundary": boundary, "load": load, "hardness": hardness}
        case["counts"] = [count for count, names in OF_COUNT.items() if name in names]
        table[f"{file}-exact"] = {**case, "tolerance": 1e-11}
        if name in SMOOTH:
            table[f"{file}-usual"] = {**case, "counts": list(OF_COUNT), "tolerance": 1e-5}
    (place / "cases.json").write_text(json.dumps(table))
    for count in OF_COUNT:
        done = mpi.run(count, SCRIPT, place)
        assert done.returncode == 0, done.stderr
    return place


def load_case(folder, name, count):
    case = json.loads((folder / "cases.json").read_text())[name]
    alone = solve_alone(case, np.load(folder / f"{case['map']}.npy"))
    return alone, json.loads((folder / f"{name}-{count}.json").read_text()), np.load(folder / f"{name}-{count}.npy")


@pytest.mark.parametrize(("count", "case"), [(count, case) for count, names in OF_COUNT.items() for case in names])
def test_pressure_is_that_of_one_process(folder, case, count):
    alone, numbers, pressure = load_case(folder, f"{case.replace(' ', '-')}-exact", count)
    assert numbers["status"] == alone.status.name
    assert np.abs(pressure - alone.contact_pressure).max() < 1e-10 * alone.contact_pressure.max()
    assert np.array_equal(pressure > 0.0, alone.contact)
    assert abs(numbers["iterations"] - alone.iterations) <= 1
    assert numbers["approach"] == pytest.approx(alone.approach, rel=1e-9)
    assert numbers["force"] == pytest.approx(alone.force, rel=1e-9)
    assert numbers["counted_area"] == pytest.approx(alone.area("cell-count").value, rel=1e-12)
    assert numbers["area"] == pytest.approx(alone.area().value, rel=1e-6)
    assert numbers["patches"] == alone.patches.count
    assert max(numbers["residuals"].values()) <= 2e-11


@pytest.mark.parametrize("count", OF_COUNT)
@pytest.mark.parametrize("case", SMOOTH)
def test_work_is_that_of_one_process(folder, case, count):
    """At the default tolerance the flat-punch weights come from the stencil, whose halo crosses the slabs."""
    alone, numbers, pressure = load_case(folder, f"{case.replace(' ', '-')}-usual", count)
    assert numbers["iterations"] == alone.iterations
    assert numbers["convolutions"] == alone.convolutions
    assert np.abs(pressure - alone.contact_pressure).max() < 1e-4 * alone.contact_pressure.max()
    assert numbers["counted_area"] == pytest.approx(alone.area("cell-count").value, abs=2 * alone.grid.cell_area)


def test_slabs_share_the_rows(folder):
    for count in OF_COUNT:
        for name in ("odd-periodic-light-exact", "low-free-light-exact"):
            numbers = json.loads((folder / f"{name}-{count}.json").read_text())
            rows = numbers["rows"]
            assert len(rows) == count + 1
            assert (rows[0], rows[-1]) == (0, numbers["shape"][0])
            assert all(first <= last for first, last in itertools.pairwise(rows))
