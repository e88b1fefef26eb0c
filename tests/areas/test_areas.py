from __future__ import annotations

import functools

import numpy as np
import pytest
from hypothesis import given, settings

import roughcontact as rc
from roughcontact import reference
from scenes import each_once
from strategies import problems


@settings(max_examples=25)
@given(problems())
def test_areas_are_between_zero_and_the_nominal_area(case):
    problem, mean = case
    solution = problem.solve(pressure=mean)
    count, corrected = solution.area("cell-count"), solution.area("perimeter")
    assert 0 < count.fraction <= 1
    assert corrected.value <= count.value
    assert corrected.value > 0
    for area in (count, corrected):
        assert area.fraction == pytest.approx(area.value / solution.grid.area)
        assert area.uncertainty >= 0


def test_full_contact_is_the_nominal_area_exactly():
    problem = rc.ContactProblem(
        rc.Body(rc.WavySurface(1e-6, 1e-4), rc.Elastic(1e9, 0.3)), grid=rc.Grid((16, 16), 1e-4), boundary="periodic"
    )
    solution = problem.solve(pressure=1e9)
    for name in ("cell-count", "perimeter"):
        area = solution.area(name)
        assert area.fraction == 1.0
        assert area.uncertainty == 0.0


def hertz(cells_across, offset):
    """A sphere whose contact radius is so many cells, its summit anywhere in a cell."""
    n, modulus, radius = 64, 1e11, 1e-2
    grid = rc.Grid((n, n), 1e-3)
    a = cells_across * grid.spacing[0]
    centre = np.asarray(offset) * grid.spacing[0]
    problem = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(radius, center=centre), rc.Elastic(modulus, 0.0)), grid=grid
    )
    force = 4 * modulus * a**3 / (3 * radius)
    return problem.solve(force=force), reference.hertz_sphere(force, radius, modulus).area


def errors(cells_across, name):
    rng = np.random.default_rng(int(10 * cells_across))
    found = []
    for _ in range(12):
        solution, exact = hertz(cells_across, rng.random(2) - 0.5)
        area = solution.area(name)
        found.append((area.value / exact - 1, area.uncertainty / exact))
    return np.array(found).T


@pytest.mark.slow
@pytest.mark.parametrize("cells_across", [2.5, 4.0, 6.5, 11.0, 20.0])
def test_two_uncertainties_hold_the_area_of_a_sphere(cells_across):
    for name in ("cell-count", "perimeter"):
        error, std = errors(cells_across, name)
        assert np.mean(np.abs(error) <= 2 * std) >= 0.9


@pytest.mark.slow
def test_the_counted_area_is_too_large_and_the_perimeter_corrects_most_of_it():
    for cells_across in (4.0, 8.0, 16.0):
        counted, _ = errors(cells_across, "cell-count")
        corrected, _ = errors(cells_across, "perimeter")
        assert counted.mean() > 0
        assert abs(corrected.mean()) < 0.5 * counted.mean()


def test_the_excess_of_the_count_is_of_first_order():
    coarse, fine = (errors(size, "cell-count")[0].mean() for size in (5.0, 20.0))
    assert np.log(coarse / fine) / np.log(4) == pytest.approx(1.0, abs=0.4)


def test_an_estimator_that_fails_is_named():
    class Lost(rc.AreaEstimator):
        def estimate(self, solution):
            return rc.Area(np.nan, np.nan, 0.0, "lost")

    solution, _ = hertz(4.0, (0, 0))
    with pytest.raises(rc.InputError, match="not an Area of finite numbers"):
        solution.area(Lost())


def test_an_area_reads_well():
    assert str(rc.Area(2e-9, 0.012, 1e-10, "count")) == "(2000 +- 100) µm2, (1.200 +- 0.060) % of nominal [count]"
    assert str(rc.Area(0.0, 0.0, 1e-12, "count")) == "(0.0 +- 1.0) µm2 [count]"
    warned = rc.Area(2e-9, 0.012, 1e-10, "count", warnings=("it is late",))
    assert str(warned).endswith("[count]; uncertain: it is late")


def test_the_length_of_the_edge():
    """A strip of known length; the sides of cells around a sphere are longer than its edge by 4 / pi."""
    body = rc.Body(rc.WavySurface((1e-6, 0.0), 1e-4), rc.Elastic(1e11, 0.0))
    problem = rc.ContactProblem(body, grid=rc.Grid((64, 32), (1e-4, 5e-5)), boundary="periodic")
    solution = problem.solve(pressure=5e8)
    sphere, exact = hertz(16.0, (0.2, 0.1))
    for name in ("cell-count", "perimeter", "level-set", "blend"):
        assert solution.area(name).perimeter == pytest.approx(1e-4, rel=1e-9)
        around = 2 * np.sqrt(np.pi * exact) * (4 / np.pi if name in ("cell-count", "perimeter") else 1.0)
        assert sphere.area(name).perimeter == pytest.approx(around, rel=0.02)


@pytest.mark.parametrize("fraction", [0.01, 0.3, 0.9])
def test_the_area_carries_the_load_at_the_pressure_limit(fraction):
    surface = rc.HeightMap(np.random.default_rng(0).standard_normal((32, 32)), size=100.0)
    problem = rc.ContactProblem(rc.Body(surface, rc.ElasticPerfectlyPlastic(1e9, 0.3, 1e6)))
    solution = problem.solve(pressure=fraction * 1e6)
    assert solution.area("perimeter").fraction >= fraction * (1 - 1e-12)


def test_the_uncertainty_of_the_perimeter_holds_a_round_punch():
    grid = rc.Grid((96, 96), 1e-3)
    punch = rc.HeightMap(np.where(np.hypot(grid.x, grid.y) < 3e-4, 0.0, -1e-4), size=1e-3)
    area = rc.ContactProblem(rc.Body(punch, rc.Elastic(1e11, 0.3))).solve(force=1.0).area("perimeter")
    assert abs(area.value - np.pi * 9e-8) <= 2 * area.uncertainty


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize(("shape", "size"), [((24, 24), (1.0, 1.0)), ((136, 17), (8.0, 1.0)), ((21, 43), (1.0, 2.0))])
def test_sharp_edges_of_small_patches_have_their_length(shape, size, boundary):
    """Pillars of 30 to 90 cells, round and turned: nothing of their edge is traced."""
    grid = rc.Grid(shape, size)
    x, y = grid.x - 0.031, grid.y + 0.017
    along, across = 0.8 * x + 0.6 * y, 0.8 * y - 0.6 * x
    for radius, inside, length in (
        (0.21, np.hypot(x, y), 2.0 * np.pi * 0.21),
        (0.17, np.maximum(np.abs(along), np.abs(across)), 8.0 * 0.17),
    ):
        tops = rc.HeightMap(np.where(inside < radius, 0.0, -0.1), size=size, periodic=boundary == "periodic")
        found = rc.ContactProblem(rc.Body(tops, rc.Elastic(1e9, 0.3)), boundary=boundary).solve(pressure=1e3)
        perimeter = found.response("perimeter", uncertainty="model")
        assert abs(perimeter.value - length) <= min(2.0 * perimeter.uncertainty, 0.12 * length)
        assert perimeter.uncertainty < 0.16 * length


def test_the_edge_of_a_narrow_wall_is_counted():
    """One cell across, too few cells stand in line inwards to tell that the edge is sharp."""
    grid = rc.Grid((41, 41), 1.0)
    inside = np.abs(np.hypot(grid.x - 0.01, grid.y + 0.013) - 0.3) < 0.012
    wall = rc.HeightMap(np.where(inside, 0.0, -0.1), size=1.0)
    solution = rc.ContactProblem(rc.Body(wall, rc.Elastic(1e9, 0.3))).solve(force=1e3)
    perimeter = solution.response("perimeter", uncertainty="model")
    assert perimeter.value == pytest.approx(4.0 * np.pi * 0.3, rel=0.03)
    assert perimeter.uncertainty < 0.12 * perimeter.value


def test_the_uncertainty_of_the_perimeter_holds_strips():
    strip = reference.Westergaard(1e-6, 1e-4, 1e11)
    mean = 0.3 * strip.full_contact_pressure
    for shape in ((256, 1), (256, 4)):
        body = rc.Body(rc.WavySurface((1e-6, 0.0), 1e-4), rc.Elastic(1e11, 0.0))
        problem = rc.ContactProblem(body, grid=rc.Grid(shape, 1e-4), boundary="periodic")
        area = problem.solve(pressure=mean).area("perimeter")
        assert abs(area.fraction * 1e-4 - 2 * strip.half_width(mean)) <= 2e-4 * area.uncertainty / 1e-8


@functools.cache
def press_strips(rows):
    """Return contacts of a wave at random places and loads, and the fractions of the domain that they cover."""
    strip, rng, found = reference.Westergaard(1e-6, 1e-4, 1e11), np.random.default_rng(rows), []
    for phase, fraction in rng.uniform((0.0, 0.1), (2 * np.pi, 0.7), size=(24, 2)):
        mean = fraction * strip.full_contact_pressure
        body = rc.Body(rc.WavySurface((1e-6, 0.0), 1e-4, phase=(phase, 0.0)), rc.Elastic(1e11, 0.0))
        grid = rc.Grid((96, rows), (1e-4, 1e-4 * rows / 96))
        solution = rc.ContactProblem(body, grid=grid, boundary="periodic").solve(pressure=mean)
        found.append((solution, 2e4 * strip.half_width(mean)))
    return found


@each_once(
    {
        "rows": [1, 4],
        "name": ["perimeter", "level-set", "level-set-richardson", "blend"],
    }
)
def test_the_uncertainties_hold_strips_along_the_grid(name, rows):
    """Westergaard: the position of both edges of a strip errs alike."""
    held = []
    for solution, true in press_strips(rows):
        area = solution.area(name)
        held.append(abs(area.fraction - true) <= 2 * area.uncertainty / solution.grid.area)
    assert np.mean(held) >= 0.9
