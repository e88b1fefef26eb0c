"""The algorithm of the paper with its own stopping rule and a limit within the iteration."""

from __future__ import annotations

import numpy as np
import pytest
import roughcontact as rc

from roughcontact_paper.printed_solver import PrintedPolonskyKeer
from roughcontact_paper.wave import wave_problem

BALL = rc.ParaboloidSurface(5e-3)


def ball(solver, hardness):
    steel = rc.ElasticPerfectlyPlastic(210e9, 0.3, hardness)
    return rc.ContactProblem(rc.Body(BALL, steel), grid=rc.Grid((64, 64), 6e-4), solver=solver)


def test_it_is_registered():
    assert rc.solvers.create("paper-as-printed") == PrintedPolonskyKeer()


def test_without_a_limit_it_finds_the_certified_pressure():
    exact = wave_problem(128).solve(pressure=100e6, tolerance=1e-8)
    problem = rc.ContactProblem(
        wave_problem(128).body, boundary="wrapped", solver=PrintedPolonskyKeer(change=1e-9, tolerance=1e-7)
    )
    found = problem.solve(pressure=100e6)
    assert found.status.success
    np.testing.assert_allclose(found.pressure, exact.pressure, atol=1e-6 * exact.pressure.max())


def test_a_small_change_is_not_taken_for_the_solution():
    problem = rc.ContactProblem(wave_problem(128).body, boundary="wrapped", solver=PrintedPolonskyKeer(change=1e-2))
    with pytest.raises(rc.NotConverged) as caught:
        problem.solve(pressure=100e6)
    found = caught.value.solution
    assert found.errors[-1] <= 1e-2 < found.errors[-2]
    assert found.residuals.complementarity > 1e-5


def test_with_a_limit_the_load_is_lost_and_the_certificate_says_so():
    exact = ball("auto", 0.8e9).solve(force=10.0)
    assert exact.saturated.any()
    found = ball(PrintedPolonskyKeer(), 0.8e9).solve(force=10.0, throw=False)
    assert not found.status.success
    assert found.force < 0.9 * exact.force
    assert found.pressure.max() <= 0.8e9


def test_released_saturated_cells_keep_the_load_under_a_mild_limit():
    exact = ball("auto", 0.8e9).solve(force=10.0)
    found = ball(PrintedPolonskyKeer(change=1e-7, release_saturated=True), 0.8e9).solve(force=10.0, throw=False)
    assert found.force == pytest.approx(exact.force, rel=1e-4)
    np.testing.assert_array_equal(found.saturated, exact.saturated)


def test_an_approach_is_refused():
    with pytest.raises(rc.InputError, match="'paper-as-printed' needs a load"):
        ball(PrintedPolonskyKeer(), 1e9).solve(approach=1e-7)
