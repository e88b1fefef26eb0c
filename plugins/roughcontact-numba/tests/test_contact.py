"""Compiled contacts are those of numpy: pressures, certificates, files; and the choice of the convolver."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import roughcontact as rc

import roughcontact_numba
from roughcontact_numba import CompiledFFT

ELASTIC = rc.Elastic(young=200e9, poisson=0.3)
PLASTIC = rc.ElasticPerfectlyPlastic(young=200e9, poisson=0.3, hardness=2e9)
FREE, PERIODIC, MIXED = "free", "periodic", "free-periodic"


def problem(shape=(64, 64), size=(1e-3, 1e-3), boundary=PERIODIC, material=ELASTIC, seed=1, **options):
    longest = 0.5 * min(size)
    cell = max(length / cells for length, cells in zip(size, shape, strict=True))
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, longest=longest, shortest=6 * cell, seed=seed)
    body = rc.Body(surface, material)
    return rc.ContactProblem(body, grid=rc.Grid(shape, size), boundary=boundary, threads=1, **options)


CASES = {
    "light": ({}, {"pressure": 1e8}),
    "heavy": ({}, {"pressure": 8e9}),
    "full": ({}, {"pressure": 1e11}),
    "free": ({"boundary": FREE}, {"pressure": 1e9}),
    "free by approach": ({"boundary": FREE}, {"approach": 2e-6}),
    "periodic by approach": ({}, {"approach": 2e-6}),
    "mixed": ({"boundary": MIXED, "shape": (48, 80)}, {"pressure": 1e9}),
    "hard": ({"material": PLASTIC}, {"pressure": 1e9}),
    "hard by approach": ({"material": PLASTIC, "boundary": FREE}, {"approach": 3e-6}),
    "odd": ({"shape": (63, 81)}, {"pressure": 1e9}),
    "long": ({"shape": (256, 32), "size": (8e-3, 1e-3)}, {"pressure": 1e9}),
    "across": ({"shape": (32, 256), "size": (1e-3, 8e-3), "boundary": FREE}, {"pressure": 1e9}),
    "slender cells": ({"size": (3e-3, 1e-3)}, {"pressure": 1e9}),
    "256 a side": ({"shape": (256, 256)}, {"pressure": 1e9}),
}


@pytest.mark.parametrize("case", CASES)
def test_a_solution_is_that_of_numpy(case):
    options, load = CASES[case]
    compiled = problem(**options, convolver="compiled").solve(**load)
    automatic = "circular-fft" if options.get("boundary", PERIODIC) == PERIODIC else "dc-fft"
    plain = problem(**options, convolver=automatic).solve(**load)
    assert compiled.status.success
    assert compiled.residuals.error <= 2e-5
    # Both are solved to 1e-5 of the rms height; near the edge of a contact that moves a pressure by more.
    difference = np.abs(compiled.pressure - plain.pressure)
    assert difference.mean() < 1e-4 * plain.pressure.mean()
    assert compiled.area().fraction == pytest.approx(plain.area().fraction, rel=1e-3)
    assert compiled.approach == pytest.approx(plain.approach, rel=1e-4)


def test_a_limit_of_each_cell_is_kept():
    limit = np.full((64, 64), 2e9)
    limit[20:40] = 1e9
    material = rc.ElasticPerfectlyPlastic(young=200e9, poisson=0.3, hardness=limit)
    solution = problem(material=material, convolver="compiled").solve(pressure=5e8)
    assert solution.status.success
    assert (solution.pressure <= limit).all()
    assert (solution.pressure[20:40] == 1e9).any()


def test_auto_chooses_it_on_small_grids_and_says_so():
    assert isinstance(problem().plan.convolver, CompiledFFT)
    assert "compiled by numba" in str(problem().explain())
    assert not isinstance(problem(shape=(300, 300)).plan.convolver, CompiledFFT)
    assert not isinstance(problem(boundary="wrapped").plan.convolver, CompiledFFT)


def test_auto_does_without_it_where_it_cannot_be_loaded(monkeypatch):
    def fail(*_, **__):
        raise rc.InputError("The convolver 'compiled' cannot be loaded.")

    monkeypatch.setattr(rc.convolvers, "create", _refusing(rc.convolvers.create, fail))
    assert isinstance(problem().plan.convolver, rc.CircularFFT)


def _refusing(create, fail):
    return lambda name, *arguments, **fields: (fail if name == "compiled" else create)(name, *arguments, **fields)


def test_a_file_of_an_automatic_choice_needs_no_plug_in(tmp_path):
    solution = problem().solve(pressure=1e9)
    solution.save(tmp_path / "solution.npz")
    loaded = rc.load(tmp_path / "solution.npz")
    # It tells what computed it, and asks for nothing of it.
    assert any("numba" in name for name in loaded.origin.versions)
    assert loaded.origin.programs == []
    assert loaded.origin.problem["convolver"] == "auto"
    assert np.array_equal(loaded.pressure, solution.pressure)


def test_threads_give_the_same_bits():
    problems = [problem(seed=seed) for seed in range(8)]
    alone = [one.solve(pressure=1e9).pressure for one in problems]
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(lambda one: one.solve(pressure=1e9).pressure, problems))
    for one, other in zip(alone, together, strict=True):
        assert np.array_equal(one, other)


def test_adhesion_friction_and_a_sweep_go_on():
    attracted = problem(adhesion=rc.Exponential(work=0.5, range=50e-9), convolver="compiled")
    assert attracted.solve(pressure=1e8).status.success
    sheared = problem(boundary=FREE, convolver="compiled").path(
        pressure=1e9, tangential_force=[(10.0, 0.0)], friction=0.3
    )
    assert all(state.status.success for state in sheared)
    assert all(state.status.success for state in problem(convolver="compiled").sweep(pressure=[1e8, 1e9, 5e9]))


def test_the_package_is_small_and_names_its_parts():
    assert roughcontact_numba.CompiledFFT is rc.convolvers["compiled"]
