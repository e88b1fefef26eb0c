"""An accuracy instead of a grid: met, at what cost, and refused in words where the heights cannot give it."""

from __future__ import annotations

import functools
import math
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from scenes import each_once, make_rough

STEEL, SOFT = rc.Elastic(200e9, 0.3), rc.Elastic(1.0, 0.0)
# Converged area of the paper's wave at 100 MPa over nominal.
TRUE = 1.14192e-2


def wave(cells, waves=20, phase=(1.0, 2.0), **options):
    body = rc.Body(rc.WavySurface(0.5e-6, 250e-6 / waves, phase), STEEL)
    return rc.ContactProblem(body, grid=rc.Grid((cells, cells), 250e-6), boundary="periodic", **options)


rough = partial(make_rough, 512, 64.0, SOFT, hurst=0.6, rms_slope=0.1, shortest=2.0, longest=64.0, rolloff=16.0)


def map_problem(periodic=False):
    grid = rc.Grid((64, 64), 64.0)
    heights = rc.SelfAffineSurface(hurst=0.6, rms_slope=0.1, shortest=4.0, longest=64.0, seed=3).heights(grid)
    boundary = "periodic" if periodic else "free"
    return rc.ContactProblem(rc.Body(rc.HeightMap(heights, 64.0, periodic=periodic), SOFT), boundary=boundary)


@each_once(
    {
        "cells": [96, 1024],
        "phase": [(0.0, 0.0), (1.0, 2.0)],
    }
)
def test_the_area_lies_within_what_is_asked_whatever_the_grid(cells, phase):
    solution = wave(cells, phase=phase).solve(pressure=100e6, area_within=0.01)
    assert solution.area().fraction == pytest.approx(TRUE, rel=0.01)
    accuracy = solution.accuracy
    assert accuracy.met
    assert 2.0 * solution.area().uncertainty <= 0.01 * solution.area().value
    assert accuracy.trials[-1].shape == solution.grid.shape
    assert solution.grid.size == (250e-6, 250e-6)
    assert solution.grid.shape[0] < 1024
    for words in ("area within 1 %", "reached", f"{solution.grid.shape[0]} x", "tolerance      2.5e-04", "blend"):
        assert words in str(solution)


def test_a_looser_accuracy_takes_a_coarser_grid():
    cells = [rough(seed=1).solve(pressure=0.005, area_within=within).grid.cells for within in (0.1, 0.01, 0.004)]
    assert cells == sorted(cells)
    assert cells[0] < cells[-1]


def test_waves_that_the_first_grid_takes_for_longer_ones_are_found():
    """30 waves on 32 cells look like 2 waves of 16 cells."""
    problem = wave(32, waves=30)
    seen = problem.solve(pressure=100e6).area()
    assert seen.uncertainty < 0.01 * seen.value
    true = wave(576, waves=30).solve(pressure=100e6).area()
    assert abs(seen.value / true.value - 1.0) > 0.1
    area = problem.solve(pressure=100e6, area_within=0.02).area()
    assert area.fraction == pytest.approx(true.fraction, rel=0.02)


def test_the_maximum_pressure_may_be_asked_for():
    radius, curvature = 3.0, 100.0
    problem = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(curvature, (0.2, 0.3)), SOFT), grid=rc.Grid((64, 64), 16.0)
    )
    solution = problem.solve(force=4 / 3 * radius**3 / curvature, peak_within=0.01)
    assert solution.peak_pressure().value == pytest.approx(2 * radius / (np.pi * curvature), rel=0.01)
    assert "maximum pressure within 1 %" in str(solution)
    assert solution.accuracy.area_within is None
    assert "estimator" not in str(solution.accuracy)


def test_a_map_is_solved_on_its_own_grid_and_says_what_it_cannot_give():
    problem = map_problem()
    with pytest.raises(rc.NotConverged, match="known at the points of a map only") as caught:
        problem.solve(pressure=1e-3, area_within=1e-4)
    assert "64 x 64" in str(caught.value)
    solution = problem.solve(pressure=1e-3, area_within=1e-4, throw=False)
    assert solution.status.success
    assert not solution.accuracy.met
    assert "NOT reached: the heights" in " ".join(str(solution).split())
    np.testing.assert_array_equal(solution.pressure, caught.value.solution.pressure)
    reached = 2.1 * solution.area().uncertainty / solution.area().value
    assert problem.solve(pressure=1e-3, area_within=min(reached, 1.0)).grid == problem.plan.grid


def test_a_map_known_between_its_points_is_refined_but_not_coarsened():
    problem = map_problem(periodic=True)
    assert problem.solve(pressure=1e-3, area_within=0.9).grid == problem.plan.grid
    assert problem.solve(pressure=1e-3, area_within=0.005).grid.cells > problem.plan.grid.cells


@pytest.mark.parametrize(("shape", "size"), [((2, 40), (2e-6, 4e-5)), ((37, 3), (9e-5, 3e-6))])
def test_the_cells_that_an_accuracy_may_take_are_bounded(monkeypatch, shape, size):
    """By a multiple of those of the map, or a number for the smallest maps."""
    heights = 1e-8 * np.random.default_rng(1).standard_normal(shape)
    body = rc.Body(rc.HeightMap(heights, size, periodic=True), rc.Elastic(2e11, 0.3))
    problem = rc.ContactProblem(body, boundary="periodic")
    for unasked in (2**12, 2**14):
        monkeypatch.setattr("roughcontact._solve.problem.accuracy._MAX_UNASKED_CELLS", unasked)
        allowed = max(unasked, 64 * problem.plan.grid.cells)
        with pytest.raises(
            rc.NotConverged, match=f"more than the {allowed} to which this grid of {shape[0]} x"
        ) as caught:
            problem.solve(pressure=1e8, area_within=1e-4)
        trials = caught.value.solution.accuracy.trials
        assert allowed / 64 < math.prod(trials[-1].shape) <= allowed
        assert caught.value.solution.grid.shape == trials[-1].shape


@functools.cache
def find_fine_area(body, boundary):
    problem = rc.ContactProblem(body, grid=rc.Grid((160, 160), 1e-5), boundary=boundary)
    return problem.solve(pressure=3e7).area().value


@pytest.mark.filterwarnings("error", "ignore::roughcontact.errors.ContactWarning")
@each_once(
    {
        "shape": [(2, 64), (64, 2), (1, 64), (2, 31)],
        "boundary": ["free", "periodic"],
    }
)
def test_grids_of_two_cells_are_refined(shape, boundary):
    body = rc.Body(rc.WavySurface(1e-8, (1e-5, 5e-6)), rc.Elastic(2e11, 0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid(shape, 1e-5), boundary=boundary)
    solution = problem.solve(pressure=3e7, area_within=0.1)
    assert solution.area().value == pytest.approx(find_fine_area(body, boundary), rel=0.1)
    assert min(solution.grid.shape) > 2


def test_more_cells_than_memory_holds_are_refused(leave_memory):
    problem = wave(128)
    leave_memory(2**25)
    with pytest.raises(rc.NotConverged, match=r"too little memory \(this process may take only") as caught:
        problem.solve(pressure=100e6, area_within=1e-5)
    assert caught.value.solution.status.success
    assert len(caught.value.solution.accuracy.trials) > 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"approach": 1e-8, "area_within": 0.01}, "pressure= or force="),
        ({"pressure": 1e8, "area_within": 0.01, "start": np.ones((64, 64))}, "omit start="),
        ({"pressure": 1e8, "area_within": 0.0}, "area_within= must be"),
        ({"pressure": 1e8, "area_within": 1.5}, "at most 1"),
        ({"pressure": 1e8, "peak_within": "1 %"}, "peak_within= must be"),
        ({"pressure": 1e8, "area_within": 0.01, "tolerance": 0.0}, "tolerance"),
        ({"pressure": 1e8, "tolerance": "fine"}, "tolerance"),
    ],
)
def test_contradictory_arguments_get_a_sentence(arguments, words):
    with pytest.raises(rc.InputError, match=words):
        wave(64).solve(**arguments)


class TestTolerance:
    def test_it_follows_from_the_accuracy_and_can_be_given(self):
        assert wave(128).solve(pressure=100e6, area_within=0.1).accuracy.tolerance == 1e-3
        solution = wave(128).solve(pressure=100e6, area_within=0.1, tolerance=1e-8)
        assert solution.accuracy.tolerance == 1e-8
        assert solution.residuals.error <= 2e-8
        kept = wave(128, solver=rc.ProjectedConjugateGradient(tolerance=1e-6)).solve(pressure=100e6, area_within=0.1)
        assert kept.accuracy.tolerance == 1e-6
        assert wave(64).solve(pressure=100e6, tolerance=1e-3).convolutions < wave(64).solve(pressure=100e6).convolutions

    def test_without_it_a_solve_keeps_every_bit(self):
        problem = wave(96)
        default, stated = problem.solve(pressure=100e6), problem.solve(pressure=100e6, tolerance=1e-5)
        assert default.accuracy is None
        np.testing.assert_array_equal(default.pressure, stated.pressure)

    def test_the_certificate_is_that_of_the_looser_tolerance(self, tmp_path):
        solution = rough(seed=2).solve(pressure=0.005, area_within=0.02)
        assert 1e-5 < solution.residuals.error <= 2 * solution.accuracy.tolerance
        assert solution.status is rc.Status.CONVERGED
        rc.ContactProblem(**solution.origin.problem).verify(solution)
        with pytest.raises(rc.InputError, match="status"):
            rc.on_grid(rough(seed=2), solution.grid.shape).verify(solution)
        solution.save(tmp_path / "s.npz")
        assert rc.ContactSolution.load(tmp_path / "s.npz").grid == solution.grid

    @each_once(
        {
            "within": [0.1, 0.01],
            "seed": [1, 2, 3],
        }
    )
    def test_the_algebraic_error_is_a_small_part_of_the_uncertainty(self, seed, within):
        problem = rough(seed=seed)
        loose = problem.solve(pressure=0.0025, area_within=within)
        tight = rc.on_grid(problem, loose.grid.shape).solve(pressure=0.0025)
        assert abs(loose.area().value / tight.area().value - 1.0) <= 0.1 * 0.5 * within


@pytest.mark.slow
def test_the_command_line_asks_for_an_accuracy(tmp_path, capsys):
    problem = map_problem()
    np.save(tmp_path / "map.npy", problem.body.surface.values)
    arguments = [
        "solve",
        str(tmp_path / "map.npy"),
        "--size",
        "64m",
        "--unit",
        "1m",
        "--young",
        "1Pa",
        "--poisson",
        "0",
    ]
    arguments += ["--pressure", "0.001Pa", "-o", str(tmp_path / "out")]
    assert main([*arguments, "--area-within", "100%", "--tolerance", "1e-6"]) in (0, 3)
    assert "area within 100 %" in capsys.readouterr().out
    assert main([*arguments, "--area-within", "0.0001"]) not in (0, 3)
    shown = capsys.readouterr()
    assert "NOT reached" in shown.out
    assert "finer map" in shown.err
    assert (tmp_path / "out" / "solution.npz").exists()


@pytest.mark.slow
@pytest.mark.parametrize("number", range(6))
def test_a_sample_of_the_study_is_met(number, monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "docs" / "studies"))
    sys.modules.pop("accuracy", None)
    import accuracy

    make = list(accuracy.CLASSES.values())[number]
    monkeypatch.setattr(accuracy, "FIXED", ())
    rows = np.array(list(accuracy.cases_of(make, 5)))
    assert (np.abs(rows[:, 0]) <= accuracy.WITHIN).all()
    assert not np.isnan(rows[:, 1]).any()
