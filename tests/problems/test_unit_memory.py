"""Bounds of memory: what a machine has, what a limit means, what a solve asks for."""

from __future__ import annotations

import tracemalloc

import pytest

import roughcontact as rc
from roughcontact._base.machine import limit_of_memory, require_memory
from roughcontact._solve.problem import accuracy
from roughcontact._solve.problem.friction_plan import _FRICTION_ARRAYS, _STATE_ARRAYS, memory_of_friction
from roughcontact.solving import available_memory, require_memory_of_solve
from test_memory import STEEL, WAVY, contact, push

NAN = float("nan")


def test_of_an_unknown_machine_a_size_is_assumed(tmp_path, monkeypatch):
    assert available_memory(tmp_path) is None
    monkeypatch.setattr("roughcontact._base.machine.available_memory", lambda: None)
    require_memory(36 * 2**30, "A solve", "choose fewer cells")
    with pytest.raises(rc.InputError, match=r"what this machine has is not known, and 36 GiB is assumed"):
        require_memory(37 * 2**30, "A solve", "choose fewer cells")


@pytest.mark.parametrize(("limit", "size"), [
    (2**20, 2**20), ("8 GiB", 2**33), ("1.5MiB", 3 * 2**19), ("500 MB", 500_000_000), (" 7 kB ", 7000), ("12B", 12),
    ("3 bytes", 3), (1e6, 1_000_000), (None, None),
])  # fmt: skip
def test_a_limit_is_a_number_of_bytes_or_a_text(limit, size):
    assert limit_of_memory(limit) == size


@pytest.mark.parametrize("limit", ["8", "GiB", "-1 GiB", "8 gib", "1e3 MB", "0 B", "", "8 GiB more", 0, -5, NAN, True])
def test_what_is_not_a_limit_is_refused(limit):
    with pytest.raises(rc.InputError, match=r"The limit of the memory must be a"):
        limit_of_memory(limit)


def test_a_finer_grid_that_no_longer_fits_when_it_is_solved_is_a_shortfall(monkeypatch):
    """The heights of the finer grid take memory too."""
    solve, calls = accuracy.run_solve, []

    def once(problem, *args, **options):
        calls.append(problem)
        if len(calls) > 1:
            require_memory_of_solve(problem.plan.grid, problem.boundary, 2**20)
        return solve(problem, *args, **options)

    monkeypatch.setattr(accuracy, "run_solve", once)
    problem = contact(WAVY, grid=rc.Grid((64, 64), 1e-4), boundary="periodic")
    solution = problem.solve(pressure=1e5, area_within=1e-6, throw=False)
    assert solution.grid.shape == (64, 64)
    assert "too little memory" in solution.accuracy.shortfall


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("counterbody", [STEEL, rc.Rigid()], ids=["like", "unlike"])
def test_friction_takes_hardly_more_than_is_asked_for(boundary, counterbody):
    """What is refused would not have fitted: the memory at light contact, for which is asked, is taken."""
    for cells in (32, 256):
        problem, force = push(cells, counterbody, boundary)
        cells_bytes = 8 * problem.plan.grid.cells
        _ = problem.initial_gap
        tracemalloc.start()
        problem.slide(force=force, friction=0.1)
        peak = tracemalloc.get_traced_memory()[1] / cells_bytes
        tracemalloc.stop()
    unlike = counterbody is not STEEL
    asked = _FRICTION_ARRAYS[boundary == "free"][unlike]
    assert 0.9 * peak < asked < peak
    states = []
    # The first path loads what the others use.
    for count in (1, 1, 3):
        problem, _ = push(256, counterbody, boundary)
        pushed = [(0.01 * k * force, 0.0) for k in range(1, count + 1)]
        tracemalloc.start()
        path = problem.path(force=[force] * count, tangential_force=pushed, friction=0.1, substeps=1)
        states.append(tracemalloc.get_traced_memory()[0] / cells_bytes)
        tracemalloc.stop()
        assert len(path) == count
    taken = states[2] - states[1]
    assert 0.8 * taken < 2 * _STATE_ARRAYS[unlike] <= taken + 0.5


@pytest.mark.slow
@pytest.mark.parametrize("counterbody", [STEEL, rc.Rigid()], ids=["like", "unlike"])
@pytest.mark.parametrize("substeps", [1, 2])
def test_what_laws_remember_is_counted(counterbody, substeps):
    """Of two laws of wear, of states that begin with one another or between their increments."""
    taken, asked = [], []
    # The first path loads what the others use.
    for count in (1, 1, 3):
        laws = (rc.EnergyWear(1e-15), rc.EnergyWear(1e-15, of="counterbody"))
        problem, force = push(256, counterbody, laws=laws)
        pushed = [(0.01 * force, 0.0), (-0.01 * force, 0.0)]
        tracemalloc.start()
        path = problem.path(force=force, tangential_force=pushed * count, friction=0.1, substeps=substeps)
        taken.append(tracemalloc.get_traced_memory()[0])
        tracemalloc.stop()
        states = len(path) + 1
        apart = 0 if max(path.increments) == 1 else states
        asked.append(memory_of_friction(problem.plan, states, apart))
    stated, found = (one[2] - one[1] for one in (asked, taken))
    assert 0.8 * found < stated < 1.1 * found
