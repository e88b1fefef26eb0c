"""Areas of exact fields below the size of a cell, by the functions of the estimators."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact import reference
from roughcontact._answers.areas.cells import find_sharp_edges
from roughcontact._answers.areas.contour import trace_contour
from roughcontact._answers.areas.summits import find_area_factor
from scenes import each_once, rather_slow
from test_subgrid import ESTIMATORS, RADIUS, YOUNG, Summit


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


@pytest.mark.parametrize("fraction", rather_slow([1.2, 0.9, 0.75, 0.6, 0.5, 0.4, 0.25], [0.9, 0.6, 0.25]))
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


@each_once(
    {
        "angle": [0.0, 0.3, np.pi / 4, 1.1],
        "step": [1.0, 50.0],
        "round_": [False, True],
    }
)
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
