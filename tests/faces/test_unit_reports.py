"""The reference solutions of a report of errors."""

from __future__ import annotations

import pytest

import roughcontact as rc
from roughcontact._work.reports.reference import solve_reference
from roughcontact.typing import Load
from test_report import STEEL, ball, rough_map


@pytest.mark.parametrize("cells", [128, 256])
def test_a_reference_solution_is_within_its_error_bound_on_coarse_grids(cells):
    wave = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6), STEEL)
    problem = rc.ContactProblem(wave, grid=rc.Grid((cells, cells), 250e-6), boundary="periodic")
    reference = solve_reference(problem, Load("pressure", 1e8), (cells, cells), None)
    converged = {"area": 1.14192e-2 * 250e-6**2, "p_max": 13.220e9}
    # The approach follows from 1024 x 1024 cells, whose summits are lower than the wave's by a known height.
    converged["approach"] = 6.365e-8
    for quantity, value in converged.items():
        assert abs(value - getattr(reference, quantity)) <= getattr(reference, f"{quantity}_error"), quantity


def test_a_given_approach_is_not_a_result():
    reference = solve_reference(ball(32), Load("approach", 2e-7), (32, 32), None)
    assert reference.quantities == ("area", "p_max")


def test_height_maps_are_interpolated_as_the_user_says():
    problem = rc.ContactProblem(rc.Body(rough_map(False), STEEL))
    load = Load("pressure", 5e8)
    # A map that is linear between its points is solved on no finer grid.
    assert "64 x 48" in solve_reference(problem, load, (32, 24), "bilinear").source
    placed = rc.Body(rc.PlacedMap(rough_map(False), interpolation="bilinear"), STEEL)
    ridged = rc.ContactProblem(placed, grid=rc.Grid((30, 20), (30e-6, 20e-6)))
    assert "30 x 20" in solve_reference(ridged, load, (30, 20), None).source
    smooth = rc.ContactProblem(rc.Body(rough_map(True), STEEL), boundary="periodic")
    assert "128 x 96" in solve_reference(smooth, load, (64, 48), None).source
    report = rc.error_vs_time(problem, pressure=5e8, areas=("blend",), reference={"approach": 1e-6}, repeats=1)
    assert [row.shape for row in report.rows] == [(32, 24), (64, 48)]
    assert all("interpolation='bilinear'" in row.failure for row in report.rows[:1])
    assert not report.rows[1].failure
    with pytest.raises(rc.InputError, match="has no area"):
        report.advice()
