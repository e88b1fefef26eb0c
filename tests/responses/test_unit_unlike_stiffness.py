"""The compliance of unlike bodies beside a dense system."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._answers.linear.stiffness import find_normal_answer
from roughcontact._answers.linear.tangential import find_energy_ratio
from test_unlike_stiffness import displace_cells, move_rigidly


@pytest.mark.parametrize("axis", [0, 1])
def test_the_compliance_is_that_of_a_dense_system(axis):
    ball = rc.Body(rc.ParaboloidSurface((1000.0, 400.0)), rc.Elastic(1.0, 0.1))
    problem = rc.ContactProblem(ball, grid=rc.Grid((17, 16), (17.0, 16.0)))
    solution = problem.solve(approach=0.03)
    answer = find_normal_answer(solution, "test").field
    trial = np.zeros((2, *solution.grid.shape))
    trial[axis] = answer
    energy = np.sum(trial * problem.shear_convolution.apply(trial)) / answer.sum() ** 2
    exact = move_rigidly(displace_cells(problem, solution.contact), axis, 3)
    assert find_energy_ratio(solution, answer, axis, coupled=True) * energy == pytest.approx(exact, rel=1e-6)
