"""Sub-grid areas against closed forms and converged answers."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import given, settings

import roughcontact as rc
from roughcontact import reference
from scenes import rather_slow
from strategies import problems

YOUNG, RADIUS = 1.0, 1e4
ESTIMATORS = sorted(rc.areas)
TRUE_WAVY = {50e6: 0.71689e-2, 100e6: 1.14192e-2, 200e6: 1.82266e-2}


@attrs.frozen
class Summit(rc.Surface):
    """An elliptic paraboloid, turned and anywhere in a cell."""

    curvatures: tuple[float, float] = (1 / RADIUS, 1 / RADIUS)
    angle: float = 0.0
    centre: tuple[float, float] = (0.0, 0.0)

    def heights(self, grid):
        x, y = grid.x - self.centre[0], grid.y - self.centre[1]
        c, s = np.cos(self.angle), np.sin(self.angle)
        return -0.5 * (self.curvatures[0] * (c * x + s * y) ** 2 + self.curvatures[1] * (c * y - s * x) ** 2)


@pytest.mark.parametrize(("cells", "most"), [(256, 0.25), (512, 0.10)])
@pytest.mark.parametrize("load", TRUE_WAVY)
def test_the_paper_on_one_grid(cells, most, load):
    rng = np.random.default_rng(cells)
    body = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6, phase=tuple(rng.uniform(0, 2 * np.pi, 2))), rc.Elastic(200e9, 0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((cells, cells), 250e-6), boundary="periodic")
    area = problem.solve(pressure=load).area()
    assert area.fraction == pytest.approx(TRUE_WAVY[load], rel=most / 100)
    assert abs(area.fraction - TRUE_WAVY[load]) <= 2 * area.uncertainty / problem.plan.grid.area


def bisinusoid(cells, waves, load, phase):
    body = rc.Body(rc.WavySurface(0.04, 1.0, phase=phase), rc.Elastic(1.0, 0.0))
    return rc.ContactProblem(body, grid=rc.Grid((cells, cells), float(waves)), boundary="periodic").solve(pressure=load)


@pytest.mark.parametrize("load", rather_slow([0.002, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1], [0.002, 0.03, 0.07]))
def test_blend_on_the_bisinusoid(load):
    """3 to 65 % contact; contacts merge above 40 %."""
    rng = np.random.default_rng(0)
    exact = bisinusoid(512, 1, load, (0.3, 0.7)).area("level-set-richardson").fraction
    for cells, waves, most in ((64, 5, 0.6), (128, 5, 0.25), (256, 5, 0.15)):
        area = bisinusoid(cells, waves, load, tuple(rng.uniform(0, 2 * np.pi, 2))).area()
        assert area.fraction == pytest.approx(exact, rel=most / 100)
        assert abs(area.fraction - exact) * waves**2 <= 2 * area.uncertainty


@pytest.mark.parametrize("load", [0.0575, 0.06, 0.0625])
def test_the_uncertainty_holds_where_contacts_merge(load):
    """The topology of the coarse contact is uncertain there; the area misses by up to 1.7 %."""
    exact = bisinusoid(512, 1, load, (0.3, 0.7)).area("level-set-richardson").fraction
    area = bisinusoid(64, 5, load, (1.0, 2.0)).area()
    assert abs(area.fraction - exact) * 25.0 <= 2 * area.uncertainty
    assert area.fraction == pytest.approx(exact, rel=0.02)


def make_resampled(cells, per_wave, *, hurst, seed, kernel="love"):
    """32 shortest waves a side."""
    surface = rc.SelfAffineSurface(hurst=hurst, rms_slope=0.1, shortest=1.0, longest=16.0, rolloff=8.0, seed=seed)
    heights = surface.heights(rc.Grid((128, 128), 32.0))
    whole = rc.HeightMap(heights, size=32.0, periodic=True).resample((cells, cells), "fourier")
    return rc.ContactProblem(rc.Body(whole, rc.Elastic(1.0, 0.0)), boundary="periodic", kernel=kernel)


ROUGH = [(0.8, 21), *(pytest.param(h, s, marks=pytest.mark.slow) for h, s in ((0.8, 22), (0.4, 23), (0.5, 24)))]


@pytest.mark.slow
@pytest.mark.parametrize(("hurst", "seed"), ROUGH)
@pytest.mark.parametrize("fraction", [0.005, 0.025, 0.08, 0.25])
def test_blend_on_rough_surfaces(fraction, hurst, seed):
    """About 1, 5, 16 and 45 % contact; the uncertainties hold down to two cells a wave."""
    exact = make_resampled(1024, 32, hurst=hurst, seed=seed).solve(pressure=0.1 * fraction).area().fraction
    light = fraction < 0.01
    for per_wave, most in ((8, 0.5 if light else 0.3), (4, 3.5 if light else 1.5), (2, np.inf)):
        for kernel in ("love", "fourier"):
            problem = make_resampled(32 * per_wave, per_wave, hurst=hurst, seed=seed, kernel=kernel)
            area = problem.solve(pressure=0.1 * fraction).area()
            assert abs(area.fraction / exact - 1) <= most / 100
            assert abs(area.fraction - exact) * 32.0**2 <= 2 * area.uncertainty
            assert bool(area.warnings) == (per_wave == 2)


@pytest.mark.slow
@pytest.mark.parametrize(("hurst", "seed"), [(0.8, 31), (0.5, 32), (0.8, 33)])
@pytest.mark.parametrize("fraction", [0.005, 0.025])
def test_a_finer_grid_where_the_grid_hardly_resolves_the_waves(fraction, hurst, seed):
    problem = make_resampled(64, 2, hurst=hurst, seed=seed)
    exact = make_resampled(1024, 32, hurst=hurst, seed=seed).solve(pressure=0.1 * fraction).area().fraction
    area = rc.on_grid(problem, (512, 512)).solve(pressure=0.1 * fraction).area()
    assert area.fraction == pytest.approx(exact, rel=0.005)


@pytest.mark.slow
@settings(max_examples=25)
@given(problems())
def test_every_estimator_gives_a_possible_area(case):
    problem, mean = case
    solution = problem.solve(pressure=mean)
    for name in ESTIMATORS:
        area = solution.area(name)
        assert 0.0 < area.value <= solution.grid.area * (1 + 1e-12)
        assert 0.0 <= area.uncertainty < np.inf
        if area.patches is not None and not solution.contact.all():
            assert area.patches.shape == (solution.patches.count,)
            # Contacts at summits between the cells have no patch.
            assert area.patches.sum() <= area.value * (1.0 + 1e-12)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_areas_scale_with_the_problem(name):
    """Powers of two change no bit of the fraction."""

    def fraction(length, modulus):
        surface = rc.HeightMap(np.random.default_rng(5).standard_normal((40, 40)) * 0.01 * length, size=40.0 * length)
        problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(modulus, 0.0)))
        return problem.solve(pressure=0.002 * modulus).area(name).fraction

    assert fraction(2.0**-20, 2.0**37) == pytest.approx(fraction(1.0, 1.0), rel=1e-12)


@pytest.mark.parametrize("stretch", [0.6, 1.7])
def test_rectangular_cells(stretch):
    errors = []
    for k in range(8):
        n, centre = 64, tuple(np.random.default_rng(k).random(2))
        grid = rc.Grid((n, n), (float(n), n * stretch))
        body = rc.Body(Summit(centre=centre), rc.Elastic(YOUNG, 0.0))
        solution = rc.ContactProblem(body, grid=grid).solve(force=4 * 10.0**3 / (3 * RADIUS))
        errors.append(solution.area("level-set").value / (np.pi * 100.0) - 1)
    assert np.abs(errors).max() <= 0.02


@pytest.mark.parametrize("cells", [32, 33])
@pytest.mark.parametrize("force", [0.1, 10.0, 1000.0])
def test_a_contact_far_smaller_than_a_cell(force, cells):
    ball = rc.Body(rc.ParaboloidSurface(1.0), rc.Elastic(1e9, 0.0))
    area = rc.ContactProblem(ball, grid=rc.Grid((cells, cells), 1.0)).solve(force=force).area()
    assert area.value == pytest.approx(reference.hertz_sphere(force, 1.0, 1e9).area, rel=1e-3)


@pytest.mark.parametrize("centre", [0.5, 0.45, 0.4])
def test_a_contact_that_a_free_border_cuts(centre):
    def area(cells):
        ball = rc.Body(rc.ParaboloidSurface(1.0, center=(centre, 0.1)), rc.Elastic(1e9, 0.3))
        return rc.ContactProblem(ball, grid=rc.Grid((cells, cells), 1.0)).solve(force=3e6).area()

    coarse, fine = area(128), area(512)
    assert coarse.value == pytest.approx(fine.value, rel=0.01)
    assert abs(coarse.value - fine.value) <= 2 * coarse.uncertainty


@pytest.mark.parametrize("cells", [64, 128])
def test_summits_between_cells_of_equal_height_are_counted_once(cells):
    """Whole and halved cells in a wave at phase zero; the second solver keeps the symmetry to the last bit."""
    wave = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6), rc.Elastic(200e9, 0.3))
    solutions = [
        rc.ContactProblem(wave, grid=rc.Grid((cells, cells), 250e-6), boundary="periodic", solver=solver).solve(
            pressure=100e6
        )
        for solver in ("projected-cg", "polonsky-keer")
    ]
    one, other = (solution.area() for solution in solutions)
    assert other.value == pytest.approx(one.value, rel=1e-6)
    assert abs(one.fraction - 0.011419) < 2 * one.uncertainty / solutions[0].grid.area


@pytest.mark.parametrize("turn", [np.transpose, lambda h: h[::-1], lambda h: np.roll(h, (32, 21), (0, 1))])
def test_areas_of_mirrored_and_shifted_heights_agree(turn):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=2.0, longest=64.0, rolloff=16.0, seed=1)
    heights = surface.heights(rc.Grid((64, 64), 64.0))

    def areas(values):
        problem = rc.ContactProblem(
            rc.Body(rc.HeightMap(values.copy(), size=64.0), rc.Elastic(1.0, 0.0)), boundary="periodic"
        )
        solution = problem.solve(pressure=5e-3)
        return [(solution.area(name).value, solution.area(name).uncertainty) for name in ESTIMATORS]

    np.testing.assert_allclose(areas(turn(heights)), areas(heights), rtol=1e-5)


def test_the_uncertainty_of_full_contact_holds_gaps_between_the_cells():
    """Two waves on 64 cells, so close to full contact that each gap is narrower than a cell and hidden."""
    strip = reference.Westergaard(1e-2, 32.0, 1.0)
    body = rc.Body(rc.WavySurface((1e-2, 0.0), 32.0, phase=(np.pi / 32, 0.0)), rc.Elastic(1.0, 0.0))
    problem = rc.ContactProblem(body, grid=rc.Grid((64, 64), 64.0), boundary="periodic")
    mean = 0.9995 * strip.full_contact_pressure
    area = problem.solve(pressure=mean).area()
    assert abs(area.fraction - 2 * strip.half_width(mean) / 32.0) * 64.0**2 <= 2 * area.uncertainty
    assert problem.solve(pressure=1.1 * strip.full_contact_pressure).area().uncertainty == 0.0


def test_areas_of_patches_sum_to_the_area():
    problem = make_resampled(64, 2, hurst=0.8, seed=1)
    solution = problem.solve(pressure=0.06)
    for name in ("hertz", "blend", "level-set"):
        area = solution.area(name)
        assert area.patches.sum() == pytest.approx(area.value, rel=1e-12)
