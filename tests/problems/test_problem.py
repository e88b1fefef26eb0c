from __future__ import annotations

import pickle

import attrs
import numpy as np
import pytest
from hypothesis import given, settings

import roughcontact as rc
from roughcontact.typing import Outcome
from strategies import powers_of_two, problems, seeds

GRID = rc.Grid((48, 40), (48e-6, 50e-6))
STEEL = rc.Elastic(210e9, 0.3)


def sample_map(seed=0, grid=GRID):
    surface = rc.SelfAffineSurface(hurst=0.7, rms_height=1e-7, shortest=8e-6, longest=40e-6, seed=seed)
    return rc.HeightMap(surface.heights(grid), size=grid.size)


def test_the_contract_of_the_readme():
    wavy = rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6)
    grid = rc.Grid(shape=(64, 64), size=(12.5e-6, 12.5e-6))
    problem = rc.ContactProblem(
        rc.Body(wavy, rc.Elastic(young=200e9, poisson=0.3)),
        rc.RIGID_FLAT,
        grid=grid,
        boundary="periodic",
        kernel="love",
        convolver="auto",
        solver="auto",
    )
    solution = problem.solve(pressure=100e6)
    for field in (solution.pressure, solution.gap, solution.displacement):
        assert field.shape == (64, 64)
        assert field.dtype == np.float64
        assert not field.flags.writeable
    assert solution.force == pytest.approx(100e6 * grid.area, rel=1e-13)
    assert solution.mean_pressure == pytest.approx(100e6, rel=1e-13)
    assert solution.approach > 0
    assert solution.contact.dtype == solution.saturated.dtype == bool
    assert solution.status is rc.Status.CONVERGED
    assert solution.iterations > 0
    assert solution.convolutions > 0
    assert solution.seconds > 0
    assert max(solution.residuals.complementarity, solution.residuals.penetration) <= 2e-5
    assert solution.residuals.load <= 1e-12
    area = solution.area("cell-count")
    assert area.estimator == "cell-count"
    assert area.value == pytest.approx(area.fraction * grid.area)
    assert solution.area().uncertainty > 0


def test_gap_displacement_and_approach_fit_together():
    solution = rc.ContactProblem(rc.Body(sample_map(), STEEL)).solve(pressure=1e8, tolerance=1e-7)
    expected = solution.initial_gap + solution.displacement - solution.approach
    np.testing.assert_array_equal(solution.gap, expected)
    assert np.abs(solution.gap[solution.contact]).max() < 1e-6 * np.ptp(solution.initial_gap)
    assert solution.initial_gap.min() == 0.0


def test_force_and_pressure_are_the_same_load():
    problem = rc.ContactProblem(rc.Body(sample_map(), STEEL))
    by_pressure, by_force = problem.solve(pressure=1e8), problem.solve(force=1e8 * GRID.area)
    np.testing.assert_allclose(by_force.pressure, by_pressure.pressure, rtol=1e-12, atol=1e-12 * 1e8)


@settings(max_examples=25)
@given(problems(), powers_of_two, powers_of_two)
def test_scaling_by_powers_of_two_changes_no_bit(case, length, stress):
    problem, mean = case
    surface, material = problem.body.surface, problem.body.material
    scaled_surface = rc.HeightMap(surface.values * length, size=np.array(surface.size) * length)
    changes = {"young": material.young * stress}
    if isinstance(material, rc.ElasticPerfectlyPlastic):
        changes["hardness"] = material.hardness * stress
    scaled = attrs.evolve(problem, body=rc.Body(scaled_surface, attrs.evolve(material, **changes)))
    plain, large = problem.solve(pressure=mean), scaled.solve(pressure=mean * stress)
    np.testing.assert_array_equal(large.pressure, plain.pressure * stress)
    np.testing.assert_array_equal(large.gap, plain.gap * length)
    assert large.iterations == plain.iterations


@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_scaling_heights_alone_by_a_power_of_two_changes_no_bit(boundary):
    plain = rc.ContactProblem(rc.Body(sample_map(), STEEL), boundary=boundary).solve(pressure=1e8)
    flatter = rc.HeightMap(sample_map().values / 4, size=GRID.size)
    scaled = rc.ContactProblem(rc.Body(flatter, STEEL), boundary=boundary).solve(pressure=1e8 / 4)
    np.testing.assert_array_equal(scaled.pressure, plain.pressure / 4)


@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
@pytest.mark.parametrize(("length", "stress"), [(3.7, 1.0), (1.0, 0.3), (1e-3, 1e5)])
def test_scaling_by_other_factors_changes_rounding_only(boundary, length, stress):
    solver = rc.SpectralGradient(tolerance=1e-14)
    plain = rc.ContactProblem(rc.Body(sample_map(), STEEL), boundary=boundary, solver=solver).solve(pressure=1e8)
    body = rc.Body(
        rc.HeightMap(sample_map().values * length, size=np.array(GRID.size) * length), rc.Elastic(210e9 * stress, 0.3)
    )
    scaled = rc.ContactProblem(body, boundary=boundary, solver=solver).solve(pressure=1e8 * stress)
    np.testing.assert_allclose(scaled.pressure / stress, plain.pressure, rtol=0, atol=1e-13 * plain.pressure.max())


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_swapping_the_bodies_changes_nothing(boundary):
    one, other = rc.Body(sample_map(0), STEEL), rc.Body(sample_map(1), rc.Elastic(70e9, 0.34))
    there = rc.ContactProblem(one, other, boundary=boundary).solve(pressure=1e8)
    back = rc.ContactProblem(other, one, boundary=boundary).solve(pressure=1e8)
    np.testing.assert_array_equal(there.pressure, back.pressure)


def test_roughness_may_be_on_either_body():
    split = rc.ContactProblem(rc.Body(sample_map(0), STEEL), rc.Body(sample_map(1), STEEL)).solve(pressure=1e8)
    half = rc.Elastic(105e9, 0.3)
    joined = rc.ContactProblem(rc.Body(sample_map(0) + sample_map(1), half)).solve(pressure=1e8)
    np.testing.assert_allclose(joined.pressure, split.pressure, atol=1e-7 * split.pressure.max())


@settings(max_examples=20)
@given(seeds)
def test_mirroring_the_surface_mirrors_the_pressure(seed):
    surface = rc.HeightMap(np.random.default_rng(seed).random((9, 12)), size=(1.0, 1.0))
    mirrored = rc.HeightMap(surface.values[::-1], size=(1.0, 1.0))
    solver = rc.SpectralGradient(tolerance=1e-12)
    one, other = (
        rc.ContactProblem(rc.Body(s, rc.Elastic(1.0, 0.3)), solver=solver).solve(pressure=1.0)
        for s in (surface, mirrored)
    )
    np.testing.assert_allclose(other.pressure[::-1], one.pressure, atol=1e-9 * one.pressure.max())


def test_translation_on_a_periodic_boundary_moves_the_pressure():
    moved = rc.HeightMap(np.roll(sample_map().values, (5, 11), axis=(0, 1)), size=GRID.size)
    solver = rc.SpectralGradient(tolerance=1e-12)
    here, there = (
        rc.ContactProblem(rc.Body(s, STEEL), boundary="periodic", solver=solver).solve(pressure=1e8)
        for s in (sample_map(), moved)
    )
    np.testing.assert_allclose(
        there.pressure, np.roll(here.pressure, (5, 11), axis=(0, 1)), atol=1e-9 * here.pressure.max()
    )


def test_a_solve_runs_twice_to_the_same_bits():
    problem = rc.ContactProblem(rc.Body(sample_map(), STEEL))
    np.testing.assert_array_equal(problem.solve(pressure=1e8).pressure, problem.solve(pressure=1e8).pressure)


def test_direct_and_fft_give_one_solution():
    small = sample_map(grid=rc.Grid((20, 18), (40e-6, 36e-6)))
    one, other = (
        rc.ContactProblem(rc.Body(small, STEEL), convolver=c, solver=rc.SpectralGradient(tolerance=1e-12))
        for c in ("direct", "dc-fft")
    )
    np.testing.assert_allclose(one.solve(pressure=1e9).pressure, other.solve(pressure=1e9).pressure, atol=1e-9 * 1e11)


def test_explain_says_what_runs_and_what_is_omitted():
    text = rc.ContactProblem(rc.Body(sample_map(), STEEL), boundary="periodic").explain()
    for words in ("48 x 40 cells", "Love", "Circular FFT", "omitted", "padding", "pressure limit"):
        assert words in text
    limited = rc.ElasticPerfectlyPlastic(210e9, 0.3, 6e9)
    text = rc.ContactProblem(rc.Body(sample_map(), limited), rc.Body(sample_map(1), STEEL)).explain()
    assert "6 GPa" in text
    assert "96 x 80 cells" in text
    assert "pressure limit: neither" not in text
    assert "rigid" not in text
    assert "adhesion: none is given" in text
    law = rc.Exponential(0.05, 1e-7)
    text = rc.ContactProblem(rc.Body(sample_map(), STEEL), boundary="periodic", adhesion=law).explain()
    assert "the repulsive part of the law: the wall is hard" in text
    assert "none is given" not in text


@pytest.mark.parametrize("shape", [(256, 96), (45, 130), (31, 33)])
def test_explain_lists_the_grids_of_the_solve(shape):
    """On a periodic boundary, where no part is omitted."""
    size = (1e-6 * shape[0], 1e-6 * shape[1])
    wave = rc.Body(rc.WavySurface(1e-7, (size[0] / 3, size[1] / 2)), STEEL)
    problem = rc.ContactProblem(wave, grid=rc.Grid(shape, size), boundary="periodic")
    (*coarse, _) = problem.solve(pressure=1e7).levels
    lines = [line for line in problem.explain().splitlines() if line.startswith("solved on")]
    assert len(lines) == min(len(coarse), 1)
    for level in coarse:
        assert "{} x {}".format(*level.shape) in lines[0]
    careful = attrs.evolve(problem, solver="polonsky-keer")
    assert "solved on" not in careful.explain()


def test_explain_says_what_is_done_with_non_measured_points():
    heights = np.array(sample_map().values)
    heights[3, 5:8] = np.nan
    kept = rc.ContactProblem(rc.Body(rc.HeightMap(heights, GRID.size), STEEL)).explain()
    assert "3 of 1920 points were not measured: they carry nothing" in kept
    filled = rc.ContactProblem(rc.Body(rc.HeightMap(heights, GRID.size, non_measured="fill"), STEEL)).explain()
    assert "not measured" not in filled
    assert "3 of 1920 points non-measured and filled from their neighbours" in filled


def test_the_grid_of_a_map_is_used():
    assert rc.ContactProblem(rc.Body(sample_map(), STEEL)).plan.grid == GRID
    assert rc.ContactProblem(rc.Body(rc.WavySurface(1e-6, 1e-5) + sample_map(), STEEL)).plan.grid == GRID


def test_problems_solutions_and_errors_travel_to_other_processes():
    problem = rc.ContactProblem(rc.Body(sample_map(), STEEL), solver=rc.PolonskyKeer(max_iterations=1))
    with pytest.raises(rc.NotConverged) as caught:
        problem.solve(pressure=1e8)
    copy = pickle.loads(pickle.dumps(caught.value))
    assert str(copy) == str(caught.value)
    np.testing.assert_array_equal(copy.solution.pressure, caught.value.solution.pressure)
    assert pickle.loads(pickle.dumps(problem)).plan.grid == GRID


class Optimist(rc.Solver):
    """Claims convergence whatever it returns."""

    tolerance = 1e-8

    def __init__(self, change):
        self.change = change

    def solve(self, convolution, task):
        pressure = self.change(np.full(task.initial_gap.shape, task.mean_pressure))
        return Outcome(pressure=pressure, status=rc.Status.CONVERGED, iterations=0, convolutions=0, errors=(0.0,))


@pytest.mark.parametrize("change", [lambda p: p, lambda p: 2 * p, lambda p: p - 2 * p.mean()])
def test_a_solver_that_lies_is_found_out(change):
    problem = rc.ContactProblem(rc.Body(sample_map(), STEEL), solver=Optimist(change))
    with pytest.raises(rc.NotConverged, match="do not confirm"):
        problem.solve(pressure=1e6)


class Creeping(rc.Material):
    """A material of somebody else, by subclassing."""

    def __init__(self, relaxed):
        self.relaxed = relaxed

    @property
    def compliance(self):
        return 1.0 / self.relaxed

    @property
    def pressure_limit(self):
        return np.inf


def test_a_material_by_subclassing_is_as_good_as_what_ships():
    own = rc.ContactProblem(rc.Body(sample_map(), Creeping(210e9 / (1 - 0.3**2)))).solve(pressure=1e8)
    ours = rc.ContactProblem(rc.Body(sample_map(), STEEL)).solve(pressure=1e8)
    np.testing.assert_allclose(own.pressure, ours.pressure, atol=1e-7 * ours.pressure.max())


def test_what_looks_unlike_what_was_meant_is_noted():
    steep = rc.HeightMap(sample_map().values * 1e3, size=GRID.size)
    assert any("are in m and" in warning for warning in rc.ContactProblem(rc.Body(steep, STEEL)).plan.warnings)
    broken = rc.WavySurface(1e-6, 12.2e-6, phase=1.0)
    jumping = rc.ContactProblem(rc.Body(broken, STEEL), grid=rc.Grid((200, 200), 250e-6), boundary="periodic")
    assert any("jump across the border" in warning for warning in jumping.plan.warnings)
    whole = rc.ContactProblem(
        rc.Body(rc.WavySurface(0.5e-6, 12.5e-6), STEEL), grid=rc.Grid((200, 200), 250e-6), boundary="periodic"
    )
    assert whole.plan.warnings == ()


def test_heights_are_asked_for_once():
    class Moody(rc.Surface):
        def __init__(self):
            self.rng = np.random.default_rng(0)

        def heights(self, grid):
            return self.rng.random(grid.shape)

    problem = rc.ContactProblem(rc.Body(Moody(), rc.Elastic(1.0, 0.0)), grid=rc.Grid((8, 8), 1.0))
    assert problem.plan.peak_to_valley == problem.initial_gap.max()


def test_a_solver_must_return_an_outcome():
    class Silent(rc.Solver):
        tolerance = 1e-8

        def solve(self, convolution, task):
            return None

    with pytest.raises(rc.InputError, match="must return an Outcome"):
        rc.ContactProblem(rc.Body(sample_map(), STEEL), solver=Silent()).solve(pressure=1e6)


def test_a_convolver_must_return_a_prepared_convolution():
    class Wrong(rc.DCFFT):
        def prepare(self, kernel, grid, boundary):
            return kernel

    with pytest.raises(rc.InputError, match="must return a PreparedConvolution"):
        rc.ContactProblem(rc.Body(sample_map(), STEEL), convolver=Wrong()).solve(pressure=1e8)


def test_another_tolerance_samples_no_surface_anew():
    sampled = []

    class Counted(rc.WavySurface):
        def heights(self, grid):
            sampled.append(grid)
            return super().heights(grid)

    body, grid = rc.Body(Counted(1e-6, 1e-3), rc.Elastic(200e9, 0.3)), rc.Grid((15, 21), 1e-3)
    found = rc.ContactProblem(body, grid=grid).solve(force=10.0, tolerance=1e-8)
    assert len(sampled) == 1
    solver = rc.ProjectedConjugateGradient(tolerance=1e-8)
    expected = rc.ContactProblem(body, grid=grid, solver=solver).solve(force=10.0)
    assert (found.pressure == expected.pressure).all()
    assert found.origin.problem["solver"] == solver


def test_the_plan_of_a_periodic_problem_speaks_of_no_border():
    body, grid = rc.Body(rc.WavySurface(1e-6, 1e-3), rc.Elastic(200e9, 0.3)), rc.Grid((8, 8), 1e-3)
    free, periodic = (rc.ContactProblem(body, grid=grid, boundary=one).explain() for one in ("free", "periodic"))
    assert "the borders of the domain" in free
    assert "borders" not in periodic
    assert "free" not in periodic
