from __future__ import annotations

import itertools

import attrs
import numpy as np
import pytest
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.kernels import BoundKernel
from roughcontact.solvers.projection import onto_load
from strategies import problems, seeds

SOLVERS = [rc.PolonskyKeer(), rc.SpectralGradient(), rc.ProjectedConjugateGradient()]


def violations(solution, problem):
    """The conditions of contact by an independent path: direct sums where there are, own arithmetic."""
    bound = BoundKernel(problem.plan.kernel, 1 / solution.modulus)
    convolver = problem.plan.convolver if problem.boundary is rc.Boundary.PERIODIC else rc.Direct()
    plan = convolver.plan(bound, solution.grid, problem.boundary)
    p, limit = solution.pressure, solution.limit
    level = plan.apply(p) + problem.undeformed
    free = (p > 0) & (p < limit)
    datum = np.average(level[free], weights=p[free]) if free.any() else level[p >= limit].max()
    gap = (level - datum) / solution.residuals.scale
    opened = np.sum(p * np.where(p >= limit, np.maximum(gap, 0), np.abs(gap))) / p.sum()
    return opened, max(0.0, -gap[p < limit].min(initial=np.inf))


@settings(max_examples=150)
@given(problems())
def test_random_problems_satisfy_the_conditions_of_contact(case):
    problem, mean = case
    solution = problem.solve(pressure=mean)
    tolerance = 2 * max(
        1e-8, 1e-15 * np.ptp(solution.undeformed + np.abs(solution.displacement)) / solution.residuals.scale
    )
    opened, penetration = violations(solution, problem)
    assert opened <= tolerance + 1e-10
    assert penetration <= tolerance + 1e-10
    assert solution.mean_pressure == pytest.approx(mean, rel=1e-13)
    assert solution.pressure.min() >= 0
    assert solution.pressure.max() <= solution.limit


@settings(max_examples=60)
@given(problems(limited=False, solver="polonsky-keer"))
def test_two_solvers_find_one_solution(case):
    problem, mean = case
    by_conjugate_gradients = problem.solve(pressure=mean)
    other = rc.ContactProblem(problem.body, boundary=problem.boundary, solver="spectral-gradient")
    by_projected_gradients = other.solve(pressure=mean)
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
    target = np.linalg.solve(root, (solution.approach - problem.undeformed).ravel())
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
    assert len(solution.history) == solution.iterations + 1
    assert solution.history[-1] <= solver.tolerance < min(solution.history[:-1])


@pytest.mark.parametrize("solver", [attrs.evolve(solver, max_iterations=2) for solver in SOLVERS])
def test_giving_up_is_said(solver):
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


class Exploding(rc.PlannedConvolution):
    """A convolution that turns to infinity after a few calls."""

    def __init__(self, plan):
        self.plan, self.calls = plan, 0

    @property
    def scene(self):
        return self.plan.scene

    def apply(self, pressure):
        self.calls += 1
        return self.plan.apply(pressure) * (np.inf if self.calls > 4 else 1.0)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_value_that_is_not_finite_stops_the_solver_at_once(solver):
    grid = rc.Grid((16, 16), 16.0)
    plan = Exploding(rc.DCFFT().plan(BoundKernel(rc.Love()), grid, rc.Boundary.FREE))
    undeformed = (grid.x**2 + grid.y**2) / (grid.x**2 + grid.y**2).max()
    with np.errstate(invalid="ignore"):
        outcome = solver.solve(plan, rc.Task(undeformed=undeformed, mean_pressure=0.1))
    assert outcome.status in (rc.Status.NOT_FINITE, rc.Status.STALLED)
    assert plan.calls <= 6


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
        assert solution.gap[~solution.saturated].min(initial=0.0) >= -1e-9 * np.ptp(solution.undeformed)

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
        highest = np.sort(solution.undeformed, axis=None)[cells]
        assert solution.saturated.sum() >= cells - 1
        assert solution.undeformed[solution.contact].max() <= highest

    def test_the_softer_body_counts(self):
        hard, soft = (rc.ElasticPerfectlyPlastic(1e9, 0.3, h) for h in (1e9, 3e7))
        flat = rc.Body(rc.FlatSurface(), hard)
        one = rc.ContactProblem(rc.Body(self.surface, soft), flat, grid=self.grid).solve(pressure=1e6)
        assert one.pressure.max() == 3e7

    def test_the_paper_solver_refuses_a_limit(self):
        material = rc.ElasticPerfectlyPlastic(1e9, 0.3, 1e8)
        problem = rc.ContactProblem(rc.Body(self.surface, material), grid=self.grid, solver="polonsky-keer")
        with pytest.raises(rc.InputError, match="has no pressure limit"):
            problem.solve(pressure=1e6)


@given(seeds, st.integers(1, 300), st.floats(1e-6, 10.0), st.floats(1.0, 1e3))
def test_projection_onto_the_load_is_the_nearest_point(seed, cells, mean, room):
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((cells, 1)) * 10 ** rng.uniform(-3, 3)
    limit = mean * room
    projected = onto_load(values, mean, limit)
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
