"""Parts of the projected conjugate gradient: weights of a punch, nested grids, other methods after a stall."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact._solve.convolvers.base import approximate_inverse
from roughcontact._solve.problem.sweep import predict_pressure
from roughcontact._solve.solvers.conjugate.descent import Descent
from roughcontact._solve.solvers.conjugate.nested_iteration import PressureOnGrid
from roughcontact._solve.solvers.conjugate.preconditioner import PunchWeights
from roughcontact._solve.solvers.conjugate.refinement import Openings
from roughcontact._solve.solvers.driver import Work
from roughcontact._solve.solvers.grids import climb
from roughcontact._solve.solvers.passes import active_cells
from roughcontact.typing import Load, Task
from test_conjugate import SLOPE, YOUNG, rough


@pytest.mark.usefixtures("as_on_large_grids")
def test_where_the_openings_do_not_settle_the_pressure_is_sought(monkeypatch):
    monkeypatch.setattr(Openings, "_descend", lambda self, goal: self._closing.astype(np.float32))
    solution = rough(128).solve(pressure=SLOPE * YOUNG)
    assert solution.status is rc.Status.CONVERGED
    assert solution.levels[-1].single > 0


def test_weights_are_exact_while_cells_join_and_leave():
    """But for the cells beyond the stencil, which act by a few per cent."""
    rng = np.random.default_rng(0)
    for boundary in ("free", "periodic"):
        convolution = rough(64, boundary=boundary).convolution
        inverse = approximate_inverse(convolution.setup, np.float32)
        mask = rng.random(64 * 64) < 0.2
        work = Work()
        weights = PunchWeights(inverse, (64, 64), work)
        weights.update(active_cells(mask, mask.__getitem__))
        for _ in range(5):
            mask = mask.copy()
            mask[rng.integers(0, mask.size, 20)] ^= True
            found = weights.update(active_cells(mask, mask.__getitem__))
        assert work.inverse == 1
        exact = PunchWeights(inverse, (64, 64), Work()).update(active_cells(mask, mask.__getitem__))
        np.testing.assert_allclose(found, exact, atol=0.03 * exact.max())


@pytest.mark.usefixtures("as_on_large_grids")
def test_nested_iteration_starts_near_the_solution():
    problem = rough(128)
    task = Task(
        initial_gap=problem.initial_gap / problem.plan.peak_to_valley, mean_pressure=5e-3 / problem.plan.peak_to_valley
    )
    start = climb(PressureOnGrid(problem.convolution, task))
    assert start.pressure.min() >= 0
    fine = problem.solve(pressure=5e-3).pressure / problem.plan.peak_to_valley
    assert np.abs(start.pressure - fine).sum() < 0.5 * fine.sum()


@pytest.mark.usefixtures("as_on_large_grids")
def test_after_a_stall_another_method_continues(monkeypatch):
    monkeypatch.setattr(Descent, "iterate", lambda self: False)
    solution = rough(64).solve(pressure=5e-3)
    assert solution.status is rc.Status.RESCUED
    assert solution.residuals.error <= 2e-8


class TestSweep:
    @pytest.mark.slow
    @settings(max_examples=30, deadline=None)
    @given(st.integers(0, 99), st.floats(0.05, 0.9), st.floats(0.4, 1.2), st.sampled_from([None, 0.2 * SLOPE * YOUNG]))
    def test_a_start_is_within_the_bounds(self, seed, load, ratio, hardness):
        problem, load = rough(64, hardness=hardness, seed=seed), 0.15 * load * SLOPE * YOUNG
        found = [problem.solve(pressure=p, throw=False) for p in (load, 0.8 * load)]
        start = predict_pressure(found, Load("pressure", 0.8 * ratio * load))
        if start is not None:
            assert (start >= 0.0).all()
            assert (start <= found[0].pressure_limit).all()
            assert not start[~found[1].contact].any()
