"""Sub-grid areas against closed forms and converged answers."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import given, settings

import roughcontact as rc
from roughcontact import reference
from roughcontact._answers.areas.cells import find_sharp_edges
from roughcontact._answers.areas.contour import trace_contour
from roughcontact._answers.areas.summits import find_area_factor
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


def pressed(radius, rng, *, hardness=None, ratio=1.0, cells=None):
    """A summit whose elastic contact has the area of a circle of so many cells radius."""
    summit = Summit((1 / RADIUS, ratio / RADIUS), rng.uniform(0, np.pi), tuple(rng.random(2) - 0.5))
    material = rc.Elastic(YOUNG, 0.0) if hardness is None else rc.ElasticPerfectlyPlastic(YOUNG, 0.0, hardness)
    n = cells or 2 * int(1.3 * radius * max(1.0, ratio**-0.5) + 6)
    mean = 0.5 * (1 + ratio) / RADIUS
    force = 4 / 3 * YOUNG * mean * (radius**2 / float(find_area_factor(np.array([ratio]))[0])) ** 1.5
    return rc.ContactProblem(rc.Body(summit, material), grid=rc.Grid((n, n), float(n))).solve(force=force)


def spread(radii, count, name, **options):
    """Relative errors of the areas of summits, and their uncertainties."""
    rng, found = np.random.default_rng(int(10 * radii[0])), []
    for radius in rng.uniform(*radii, size=count):
        ratio = options.get("ratios") and rng.uniform(*options["ratios"])
        solution = pressed(radius, rng, ratio=ratio or 1.0)
        area = solution.area(name)
        found.append((area.value / (np.pi * radius**2) - 1, area.uncertainty / area.value))
    return np.array(found).T


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radii", "most"), [((3, 5), 1.5), ((5, 8), 0.8), ((8, 14), 0.7), ((14, 25), 0.2), ((25, 50), 0.1)]
)
def test_level_set_on_spheres(radii, most):
    error, std = spread(radii, 80 if radii[1] < 20 else 30, "level-set")
    assert np.percentile(np.abs(error), 95) <= most / 100
    assert np.mean(np.abs(error) <= 2 * std) >= 0.9


@pytest.mark.slow
@pytest.mark.parametrize("radii", [(0.8, 1.5), (1.5, 3), (3, 6), (6, 12)])
def test_blend_on_ellipses(radii):
    error, std = spread(radii, 24, "blend", ratios=(0.15, 1.0))
    assert np.percentile(np.abs(error), 95) <= 0.006
    assert np.mean(np.abs(error) <= 2 * std) >= 0.9


@pytest.mark.parametrize("fraction", [1.2, 0.9, 0.75, 0.6, 0.5, 0.4, 0.25])
def test_blend_on_spheres_at_a_pressure_limit(fraction):
    rng, found = np.random.default_rng(3), []

    def area(radius):
        solution = pressed(
            radius, rng, hardness=fraction * 2 * radius / np.pi / RADIUS, cells=2 * int(2.6 * radius) + 8
        )
        return solution.area()

    exact = area(60.0).value / 60.0**2
    for radius in rng.uniform(4, 12, size=12):
        guess = area(radius)
        found.append((guess.value / radius**2 / exact - 1, guess.uncertainty / guess.value))
    error, std = np.array(found).T
    assert np.abs(error).max() <= 0.012
    assert np.mean(np.abs(error) <= 2 * std) >= 0.9


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


@pytest.mark.parametrize("load", [0.002, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1])
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


def rough(cells, per_wave, *, hurst, seed, kernel="love"):
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
    exact = rough(1024, 32, hurst=hurst, seed=seed).solve(pressure=0.1 * fraction).area().fraction
    light = fraction < 0.01
    for per_wave, most in ((8, 0.5 if light else 0.3), (4, 3.5 if light else 1.5), (2, np.inf)):
        for kernel in ("love", "fourier"):
            problem = rough(32 * per_wave, per_wave, hurst=hurst, seed=seed, kernel=kernel)
            area = problem.solve(pressure=0.1 * fraction).area()
            assert abs(area.fraction / exact - 1) <= most / 100
            assert abs(area.fraction - exact) * 32.0**2 <= 2 * area.uncertainty
            assert bool(area.warnings) == (per_wave == 2)


@pytest.mark.slow
@pytest.mark.parametrize(("hurst", "seed"), [(0.8, 31), (0.5, 32), (0.8, 33)])
@pytest.mark.parametrize("fraction", [0.005, 0.025])
def test_a_finer_grid_where_the_grid_hardly_resolves_the_waves(fraction, hurst, seed):
    problem = rough(64, 2, hurst=hurst, seed=seed)
    exact = rough(1024, 32, hurst=hurst, seed=seed).solve(pressure=0.1 * fraction).area().fraction
    area = rc.on_grid(problem, (512, 512)).solve(pressure=0.1 * fraction).area()
    assert area.fraction == pytest.approx(exact, rel=0.005)


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 4, 1.1])
@pytest.mark.parametrize("step", [1.0, 50.0])
@pytest.mark.parametrize("round_", [False, True])
def test_flat_punches(angle, step, round_):
    """The edge of a punch is sharp: its cells are its area."""
    grid = rc.Grid((64, 64), 64.0)
    c, s = np.cos(angle), np.sin(angle)
    u, v = c * grid.x + s * grid.y, c * grid.y - s * grid.x
    inside = (np.hypot(u, v) if round_ else np.maximum(np.abs(u), np.abs(v))) < 15.3
    punch = rc.HeightMap(np.where(inside, 0.0, -step), size=64.0)
    for boundary in ("free", "periodic"):
        solution = rc.ContactProblem(rc.Body(punch, rc.Elastic(1.0, 0.0)), boundary=boundary).solve(force=1.0)
        assert solution.area().value == pytest.approx(inside.sum(), rel=1e-3)
        assert find_sharp_edges(solution).sum() > 0


def test_no_edge_of_a_sphere_is_sharp():
    rng = np.random.default_rng(0)
    assert not any(find_sharp_edges(pressed(radius, rng)).any() for radius in rng.uniform(1, 20, size=30))


@pytest.mark.parametrize("name", ESTIMATORS)
def test_no_contact_has_exactly_no_area(name):
    solution = pressed(5.0, np.random.default_rng(0))
    lifted = attrs.evolve(solution, pressure=np.zeros_like(solution.pressure))
    assert lifted.area(name).value == 0.0


@pytest.mark.slow
@settings(max_examples=60)
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


def test_the_edge_of_exact_fields():
    """With the fields of a long smooth edge, p = K sqrt(d) and g = 4 K / 3 E* d^(3/2), the edge is exact."""
    solution = pressed(20.0, np.random.default_rng(0), cells=64)
    distance = 20.0 - np.hypot(solution.grid.x, solution.grid.y)
    strength = 0.03
    pressure = strength * np.sqrt(np.maximum(distance, 0.0))
    gap = 4 * strength / 3 * np.maximum(-distance, 0.0) ** 1.5
    exact = attrs.evolve(solution, pressure=pressure, initial_gap=gap - solution.displacement + solution.approach)
    edge = trace_contour(exact, np.zeros(exact.grid.shape, dtype=bool))
    assert edge.area.sum() + 0.5 * edge.euler.sum() == pytest.approx(np.pi * 400.0, rel=2e-4)
    assert edge.length.sum() == pytest.approx(2 * np.pi * 20.0, rel=1e-3)
    assert edge.euler.sum() == pytest.approx(1.0)


def test_the_order_of_the_level_set():
    """The mean excess over a sphere's area falls faster than the cell."""
    coarse, fine = (np.sqrt(np.mean(spread(radii, 24, "level-set")[0] ** 2)) for radii in ((4.0, 5.0), (16.0, 20.0)))
    assert np.log(coarse / fine) / np.log(4.0) > 1.2


def test_hertz_alone_is_exact_for_any_ellipse():
    error, _ = spread((1.0, 6.0), 16, "hertz", ratios=(0.1, 1.0))
    assert np.abs(error).max() <= 2e-4


def test_the_factor_of_an_ellipse_is_hertz():
    """Against the closed form of the reference, by way of a sphere and of a mild ellipse."""
    assert find_area_factor(np.array([1.0]))[0] == 1.0
    sphere = reference.hertz_sphere(1.0, RADIUS, YOUNG)
    radius = (0.75 * RADIUS / YOUNG) ** (1 / 3)
    assert sphere.area == pytest.approx(np.pi * radius**2)
    # To first order in the ratio's logarithm the area depends on the mean curvature alone.
    assert find_area_factor(np.array([0.98]))[0] == pytest.approx(1.0, abs=1e-4)


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
    problem = rough(64, 2, hurst=0.8, seed=1)
    solution = problem.solve(pressure=0.06)
    for name in ("hertz", "blend", "level-set"):
        area = solution.area(name)
        assert area.patches.sum() == pytest.approx(area.value, rel=1e-12)
