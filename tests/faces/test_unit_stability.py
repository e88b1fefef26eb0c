"""The checks of a report of stability, one by one."""

from __future__ import annotations

import math
import sys

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._work.reports.stability_checks import (
    check_area,
    check_kernel,
    check_model,
    shift_half_cell,
    sum_displacement,
)
from roughcontact._work.reports.stability_report import RULES, SolvedProblem
from roughcontact.typing import Load
from scenes import GRID, ROUGH, WRAPPERS, make_problem
from test_stability import FAIL, PAGE, PASS, SKIPPED, STEEL, rough


def test_a_resolved_contact_passes_every_check():
    report = rc.stability(rough(128, cells=16.0), pressure=5e8)
    assert report.verdict is PASS
    skipped = {check.name for check in report.checks if check.verdict is SKIPPED}
    assert skipped == {"kernel: digits lost", "crown", "edge contact", "tilt"}
    assert [check.name for check in report.checks] == list(RULES)
    assert report.solution.status is rc.Status.CONVERGED


def test_an_unconverged_solution_fails_and_is_not_checked_further():
    report = rc.stability(rough(solver=rc.SpectralGradient(max_iterations=1)), pressure=5e8)
    assert report.verdict is FAIL
    assert "maximum number of iterations" in report["convergence"].finding
    assert {check.name for check in report.checks} == set(RULES)
    assert report["area: warnings"].verdict is SKIPPED
    assert math.isnan(report["slope"].value)
    text = str(report)
    assert text.count("the solution is not converged") == 1
    assert text.count("as above") == len(RULES) - 5


def test_a_periodic_map_is_shifted_by_half_a_cell():
    heights = rough().body.surface.heights(rough().plan.grid)
    for surface in (rc.HeightMap(heights, 64.0, periodic=True), rc.HeightMap(heights, 64.0)):
        problem = rc.ContactProblem(rc.Body(surface, STEEL), boundary="periodic")
        twice = shift_half_cell(shift_half_cell(problem))
        np.testing.assert_allclose(twice.body.surface.values, np.roll(heights, (1, 1), (0, 1)), atol=1e-13)
    tilted = rc.HeightMap(heights + np.arange(64)[:, None], 64.0)
    with pytest.raises(rc.InputError, match="not known between its points"):
        shift_half_cell(rc.ContactProblem(rc.Body(tilted, STEEL), boundary="periodic"))


def test_a_surface_known_everywhere_is_shifted_by_half_a_cell():
    grid = rc.Grid((32, 48), (1e-3, 2e-3))
    aside = np.array(grid.spacing) / 2
    flat = rc.PlacedMap(rc.HeightMap(np.eye(40), 4e-3), interpolation="cubic")
    surface = rc.ParaboloidSurface(1e-2) + rc.WavySurface(1e-6, 1e-4) + flat
    moved = shift_half_cell(rc.ContactProblem(rc.Body(surface, STEEL), grid=grid)).body.surface.values
    x, y = grid.x - aside[0], grid.y - aside[1]
    wave = 1e-6 * (np.cos(2e4 * np.pi * x) + np.cos(2e4 * np.pi * y))
    there = attrs.evolve(flat, offset=tuple(aside)).heights(grid)
    bowl = -(x**2 + y**2) / 2e-2
    other = -((x + 2 * aside[0]) ** 2 + (y + 2 * aside[1]) ** 2) / 2e-2
    assert min(np.abs(moved - there - wave - each).max() for each in (bowl, other)) < 1e-15


@pytest.mark.parametrize("wrapper", WRAPPERS)
@pytest.mark.parametrize("inner", [
    rc.HeightMap(ROUGH.heights(GRID), 1e-4, periodic=True), ROUGH, rc.WavySurface(1e-8, 1e-4), rc.SphereSurface(1e-3)
])  # fmt: skip
def test_a_surface_of_ones_own_is_shifted_with_its_parts(wrapper, inner):
    moved = wrapper(inner).shift_half_cell(GRID, periodic=True).heights(GRID)
    shifted = shift_half_cell(make_problem(wrapper(inner), boundary="periodic")).body
    np.testing.assert_array_equal(shifted.heights(GRID), moved)


def test_the_page_gives_the_thresholds_as_they_are():
    """The table that tests/pages/test_doc_tables.py holds the page to is that of the checks."""
    sys.path.insert(0, str(PAGE.parents[1] / "studies"))
    stored = __import__("doc_tables").read("stability-checks")
    assert stored == __import__("stability_checks").list_rules()
    assert {name for row in stored[1:] for name in row[0].split("; ")} == set(RULES)


def test_without_a_contact_there_is_nothing_to_be_judged():
    """As after a solve that has failed."""
    problem = rough(32)
    solution = problem.solve(pressure=1e8)
    none = np.zeros(solution.pressure.shape)
    apart = attrs.evolve(solution, pressure=none, displacement=none)
    solved = SolvedProblem(problem, apart, Load("pressure", 1e8))
    checks = {check.name: check for check in (*check_area(apart), *check_model(solved), *check_kernel(solved))}
    without = {name for name, check in checks.items() if "no contact" in check.finding}
    assert {"area: uncertainty", "cells per wavelength", "convolution: digits lost", "slope", "edge contact"} <= without
    assert all(checks[name].verdict is SKIPPED for name in without)
    assert checks["area: warnings"].verdict is PASS
    assert checks["units"].verdict is PASS


def test_the_displacement_at_single_cells_is_that_of_the_convolution():
    for boundary in ("free", "periodic", "wrapped"):
        problem = rough(32, boundary=boundary)
        solution = problem.solve(pressure=1e8)
        chosen = np.array([0, 31, 500, 1023])
        found = sum_displacement(problem, solution.pressure, chosen)
        np.testing.assert_allclose(found, solution.displacement.ravel()[chosen], rtol=1e-9)
