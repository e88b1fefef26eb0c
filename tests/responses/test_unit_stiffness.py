"""Stiffness beside the tangent of the discrete contact."""

from __future__ import annotations

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._answers.linear.tangent import Tangent
from roughcontact._parts.surfaces.statistics import rms_slope
from test_stiffness import punch_of


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_rough_contact_converges_within_its_uncertainty(boundary):
    size, found = 1e-3, {}
    for n in (64, 128, 384):
        surface = rc.SelfAffineSurface(hurst=0.6, rms_height=1e-6, longest=size / 2, shortest=size / 12, seed=4)
        problem = rc.ContactProblem(
            rc.Body(surface, rc.Elastic(2e11, 0.3)), grid=rc.Grid((n, n), size), boundary=boundary, threads=1
        )
        scale = problem.plan.modulus * rms_slope(problem.initial_gap, problem.plan.grid)
        found[n] = problem.solve(pressure=0.05 * scale).stiffness()
    fine = found.pop(384)
    assert fine.uncertainty < 2e-3 * fine.value
    for estimate in found.values():
        assert abs(estimate.value - fine.value) <= 2.5 * math.hypot(estimate.uncertainty, fine.uncertainty)
    assert abs(found[128].value / fine.value - 1) < 8e-3


def test_saturated_cells_follow():
    rng = np.random.default_rng(0)
    surface = rc.HeightMap(1e-7 * rng.standard_normal((32, 32)), 32e-6)
    problem = rc.ContactProblem(
        rc.Body(surface, rc.ElasticPerfectlyPlastic(2e11, 0.3, 1e9)), boundary="periodic", threads=1
    )
    solution = problem.solve(pressure=3e8)
    assert solution.saturated.any()
    ones = np.ones(solution.grid.shape)
    loading, unloading = (Tangent(solution, saturated=part).solve(ones).values.sum() for part in (False, True))
    assert loading < unloading
    found = solution.stiffness()
    assert 0.0 < found.value < unloading * solution.grid.cell_area
    with pytest.raises(rc.InputError, match="limit"):
        solution.response("tangential-stiffness")


def test_one_cell_in_contact():
    heights = np.zeros((7, 5))
    heights[3, 2] = 1.0
    solution = punch_of(heights > 0, size=(7.0, 5.0))
    # Love's coefficient of a square on itself, (4 / pi) ln(1 + sqrt 2).
    raw = 1 / (4 / math.pi * math.log(1 + math.sqrt(2)))
    answer = Tangent(solution).solve(np.ones(solution.grid.shape))
    assert answer.values.sum() == pytest.approx(raw, rel=1e-10)
    assert solution.stiffness().value == pytest.approx(raw, rel=0.3)
