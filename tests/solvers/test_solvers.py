from __future__ import annotations

import itertools

import attrs
import numpy as np
import pytest
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

import roughcontact as rc
from extended_precision import violations
from roughcontact.solving import make_task, nearest_pressure, project_to_load, rescale_to_load, starting_pressure
from roughcontact.typing import BoundKernel, Load, PreparedConvolution, Task
from strategies import problems, seeds

SOLVERS = [rc.PolonskyKeer(), rc.SpectralGradient(), rc.ProjectedConjugateGradient()]


@settings(max_examples=50)
@given(problems())
def test_random_problems_satisfy_the_conditions_of_contact(case):
    problem, mean = case
    solution = problem.solve(pressure=mean)
    found = violations(problem, {"pressure": mean}, solution)
    assert found.holds, found
    assert solution.mean_pressure == pytest.approx(mean, rel=1e-13)
    assert solution.pressure.min() >= 0
    assert solution.pressure.max() <= solution.pressure_limit


@settings(max_examples=25)
@given(problems(limited=False, solver="polonsky-keer"))
def test_two_solvers_find_one_solution(case):
    problem, mean = case
    by_conjugate_gradients = problem.solve(pressure=mean, tolerance=1e-8)
    other = rc.ContactProblem(problem.body, boundary=problem.boundary, solver="spectral-gradient")
    by_projected_gradients = other.solve(pressure=mean, tolerance=1e-8)
    size = by_conjugate_gradients.pressure.max()
    # The error in the gap is 1e-8 of the scale; the stiffest wave turns it into pressure.
    stiffest = solution_stiffness(by_conjugate_gradients)
    np.testing.assert_allclose(
        by_projected_gradients.pressure, by_conjugate_gradients.pressure, rtol=0, atol=1e-7 * size + 4e-8 * stiffest
    )


def solution_stiffness(solution):
    """Pressure that moves a single cell by the scale of the residuals."""
    return solution.residuals.scale * solution.modulus / min(solution.grid.spacing) * 4


@given(seeds, st.integers(2, 8))
def test_small_problems_agree_with_a_dense_solver(seed, n):
    """Non-negative least squares on the dense matrix: an active set method without any transform."""
    rng = np.random.default_rng(seed)
    heights = rng.standard_normal((n, n + 1))
    surface = rc.HeightMap(heights, size=(n, n + 1.0))
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), solver=rc.SpectralGradient(tolerance=1e-13))
    solution = problem.solve(pressure=rng.uniform(0.01, 1.0))
    cells = heights.size
    table = rc.Love().coefficients(heights.shape, (1.0, 1.0), 1.0)
    i, j = np.divmod(np.arange(cells), n + 1)
    matrix = table[np.abs(i[:, None] - i), np.abs(j[:, None] - j)]
    # At the approach found: min p.Kp/2 + (h - approach).p over p >= 0.
    root = np.linalg.cholesky(matrix)
    target = np.linalg.solve(root, (solution.approach - problem.initial_gap).ravel())
    dense, _ = scipy.optimize.nnls(root.T, target)
    np.testing.assert_allclose(solution.pressure.ravel(), dense, atol=1e-9 * dense.max())


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_more_load_more_contact(solver, boundary):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8.0, longest=64.0, seed=3)
    body = rc.Body(surface, rc.Elastic(1e9, 0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((64, 64), 64.0), boundary=boundary, solver=solver)
    solutions = [problem.solve(pressure=p) for p in (1e5, 1e6, 1e7, 5e7)]
    for light, heavy in itertools.pairwise(solutions):
        assert heavy.approach > light.approach
        assert heavy.contact.sum() > light.contact.sum()
        # On a periodic surface a cell may lose pressure to its neighbours, but not contact as a whole.
        assert (light.contact & ~heavy.contact).sum() <= 0.02 * light.contact.sum()


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_history_ends_below_the_tolerance(solver):
    problem = rc.ContactProblem(
        rc.Body(rc.WavySurface(1e-6, 1e-4), rc.Elastic(1e11, 0.3)), grid=rc.Grid((32, 32), 1e-4), solver=solver
    )
    solution = problem.solve(pressure=1e7)
    assert len(solution.errors) == solution.iterations + 1
    assert solution.errors[-1] <= solver.tolerance < min(solution.errors[:-1])


@pytest.mark.parametrize("solver", [attrs.evolve(solver, max_iterations=2) for solver in SOLVERS])
def test_giving_up_is_reported(solver):
    problem = rc.ContactProblem(
        rc.Body(rc.WavySurface(1e-6, 1e-4), rc.Elastic(1e11, 0.3)), grid=rc.Grid((32, 32), 1e-4), solver=solver
    )
    with pytest.raises(rc.NotConverged, match="maximum number of iterations") as caught:
        problem.solve(pressure=1e7)
    assert caught.value.solution.status is rc.Status.MAXIMUM_ITERATIONS
    assert not caught.value.solution.status.success
    returned = problem.solve(pressure=1e7, throw=False)
    np.testing.assert_array_equal(returned.pressure, caught.value.solution.pressure)
    assert returned.residuals.error > solver.tolerance


class Exploding(PreparedConvolution):
    """A convolution that turns to infinity after a few calls."""

    def __init__(self, convolution):
        self.convolution, self.calls = convolution, 0

    @property
    def setup(self):
        return self.convolution.setup

    def apply(self, pressure):
        self.calls += 1
        return self.convolution.apply(pressure) * (np.inf if self.calls > 4 else 1.0)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_value_that_is_not_finite_stops_the_solver_at_once(solver):
    grid = rc.Grid((16, 16), 16.0)
    convolution = Exploding(rc.DCFFT().prepare(BoundKernel(rc.Love()), grid, rc.Boundary.FREE))
    initial_gap = (grid.x**2 + grid.y**2) / (grid.x**2 + grid.y**2).max()
    with np.errstate(invalid="ignore"):
        outcome = solver.solve(convolution, Task(initial_gap=initial_gap, mean_pressure=0.1))
    assert outcome.status in (rc.Status.NOT_FINITE, rc.Status.STALLED)
    assert convolution.calls <= 6


class TestLimit:
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8.0, longest=64.0, seed=3)
    grid = rc.Grid((64, 64), 64.0)

    def solve(self, hardness, pressure, boundary="periodic", tolerance=1e-10):
        material = rc.ElasticPerfectlyPlastic(1e9, 0.3, hardness)
        problem = rc.ContactProblem(
            rc.Body(self.surface, material),
            grid=self.grid,
            boundary=boundary,
            solver=rc.SpectralGradient(tolerance=tolerance),
        )
        return problem.solve(pressure=pressure)

    @pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
    @pytest.mark.parametrize("share", [1e-6, 1e-3, 0.1, 0.5, 0.9, 0.999, 1.0])
    def test_any_share_of_the_limit_is_carried(self, share, boundary):
        solution = self.solve(3e7, share * 3e7, boundary)
        assert solution.mean_pressure == pytest.approx(share * 3e7, rel=1e-13)
        assert solution.pressure.max() <= 3e7
        # Saturated cells may overlap, all others may not.
        assert solution.gap[~solution.saturated].min(initial=0.0) >= -1e-9 * np.ptp(solution.initial_gap)

    def test_a_limit_that_is_not_reached_changes_no_bit(self):
        elastic = rc.ContactProblem(
            rc.Body(self.surface, rc.Elastic(1e9, 0.3)),
            grid=self.grid,
            boundary="periodic",
            solver=rc.SpectralGradient(tolerance=1e-10),
        ).solve(pressure=1e6)
        capped = self.solve(1e12, 1e6)
        np.testing.assert_array_equal(capped.pressure, elastic.pressure)
        assert not capped.saturated.any()

    def test_a_vanishing_limit_gives_the_bearing_area(self):
        """What is softer than any elastic force is cut off flat: the highest cells carry the load."""
        hardness, cells = 1.0, 400
        solution = self.solve(hardness, hardness * cells / self.grid.cells)
        highest = np.sort(solution.initial_gap, axis=None)[cells]
        assert solution.saturated.sum() >= cells - 1
        assert solution.initial_gap[solution.contact].max() <= highest

    def test_the_softer_body_counts(self):
        hard, soft = (rc.ElasticPerfectlyPlastic(1e9, 0.3, h) for h in (1e9, 3e7))
        flat = rc.Body(rc.FlatSurface(), hard)
        one = rc.ContactProblem(rc.Body(self.surface, soft), flat, grid=self.grid).solve(pressure=1e6)
        assert one.pressure.max() == 3e7

    def test_the_paper_solver_refuses_a_limit(self):
        material = rc.ElasticPerfectlyPlastic(1e9, 0.3, 1e8)
        with pytest.raises(rc.InputError, match="has no pressure limit"):
            rc.ContactProblem(rc.Body(self.surface, material), grid=self.grid, solver="polonsky-keer")
        problem = rc.ContactProblem(rc.Body(self.surface, material), grid=self.grid)
        task = make_task(problem.plan, problem.initial_gap, Load.of(pressure=1e6))
        with pytest.raises(rc.InputError, match="has no pressure limit"):
            rc.PolonskyKeer().solve(problem.convolution, task)

    def test_the_paper_solver_refuses_an_approach_before_it_solves(self):
        problem = rc.ContactProblem(rc.Body(self.surface, rc.Elastic(1e9, 0.3)), grid=self.grid, solver="polonsky-keer")
        for ask in (problem.require_load, problem.solve):
            with pytest.raises(rc.InputError, match="not an approach"):
                ask(approach=1e-7)
        with pytest.raises(rc.InputError, match="not an approach"):
            rc.Study(problems=problem, approach=[1e-7])


@given(seeds, st.integers(1, 300), st.floats(1e-6, 10.0), st.floats(1.0, 1e3))
def test_projection_onto_the_load_is_the_nearest_point(seed, cells, mean, room):
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((cells, 1)) * 10 ** rng.uniform(-3, 3)
    limit = mean * room
    projected = project_to_load(values, mean, limit)
    assert projected.min() >= 0
    assert projected.max() <= limit
    assert projected.mean() == pytest.approx(mean, rel=1e-12)
    # The nearest point: no other of equal load lies at an angle below 90 degrees from the way back.
    for _ in range(5):
        other = rng.random(values.shape)
        other *= mean / other.mean()
        if other.max() <= limit:
            product = np.sum((values - projected) * (other - projected))
            assert product <= 1e-9 * np.sum(np.abs(values - projected)) * limit


@given(seeds, st.integers(1, 300), st.floats(1e-6, 0.999), st.booleans())
def test_rescaling_meets_the_load_and_leaves_saturated_cells(seed, cells, fraction, uniform):
    rng = np.random.default_rng(seed)
    limit = np.asarray(1.0) if uniform else rng.uniform(0.5, 2.0, cells)
    pressure = np.clip(rng.standard_normal(cells) * rng.uniform(0.0, 3.0), 0.0, limit)
    load = fraction * float(np.broadcast_to(limit, cells).sum())
    before = pressure.copy()
    rescaled = rescale_to_load(pressure, load, limit)
    assert rescaled.sum() == pytest.approx(load, rel=1e-12)
    assert rescaled.min() >= 0
    assert (rescaled <= limit).all()
    inside = (before > 0) & (before < limit)
    if inside.any() and (rescaled[inside] < np.broadcast_to(limit, cells)[inside]).all() and load > before.sum():
        np.testing.assert_array_equal(rescaled[before >= limit], before[before >= limit])


@given(seeds, st.floats(0.01, 1.0), st.booleans())
def test_the_nearest_pressure_of_a_task_keeps_bounds_and_load(seed, fraction, uniform):
    rng = np.random.default_rng(seed)
    limit = 0.5 if uniform else rng.uniform(0.1, 0.9, (6, 7))
    gap, values = rng.random((6, 7)), 3 * rng.standard_normal((6, 7))
    by_load = Task(initial_gap=gap, mean_pressure=fraction * float(np.mean(limit)), pressure_limit=limit)
    for pressure in (nearest_pressure(values, by_load), starting_pressure(by_load)):
        assert pressure.min() >= 0
        assert (pressure <= limit).all()
    assert nearest_pressure(values, by_load).mean() == pytest.approx(by_load.mean_pressure, rel=1e-12)
    by_approach = Task(initial_gap=gap, approach=0.5, pressure_limit=limit)
    np.testing.assert_array_equal(nearest_pressure(values, by_approach), np.clip(values, 0.0, limit))
    assert not starting_pressure(by_approach).any()


@pytest.mark.slow
@given(seeds, st.floats(-1e-3, 1e-3))
def test_saturated_cells_stay_so_where_the_others_can_take_the_difference(seed, change):
    """The rounding of a sum of a million pressures does not shift the saturated ones."""
    rng = np.random.default_rng(seed)
    pressure = np.minimum(rng.exponential(1.0, 2**20), 0.3) * (rng.random(2**20) < 0.9)
    saturated, load = pressure >= 0.3, (1.0 + change) * float(pressure.sum())
    rescaled = rescale_to_load(pressure, load, 0.3)
    assert (rescaled[saturated] == 0.3).all()
    assert abs(rescaled.sum() / load - 1.0) <= 1e-13
