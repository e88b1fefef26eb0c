"""How far other places differ: windows, strips, tiles."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from scipy import special

import roughcontact as rc
from roughcontact._solve.solution import list_answers, sampling
from roughcontact._solve.solution import place as places
from roughcontact.reference.roughness import transform_waves
from test_sampling import STEEL, draw, press, relative


@pytest.fixture(scope="module")
def rough():
    return press(draw((64, 64), 64e-6, 1, 16e-6, 4e-6), 64e-6)


def vary_across(rough, direction, slopes):
    """Return the variance told by strips, at a pressure that is alike everywhere, of a lay across a direction."""
    x, y = rough.grid.x / rough.grid.size[0], rough.grid.y / rough.grid.size[1]
    lay = transform_waves(np.cos(6.0 * np.pi * (direction[0] * x + direction[1] * y)), rough.grid)
    even = places.Place.of(attrs.evolve(rough, pressure=np.ones(rough.grid.shape)))
    window = places.find_window(even)
    return places._vary_across_lay(even, window, lay, slopes, np.ones(slopes.shape, dtype=bool), 0.0)


@pytest.mark.parametrize("steps", [np.arange(1.0, 9.0), np.array([1.0, 8.0, 2.0, 7.0, 1.0, 9.0, 1.0, 8.0])])
def test_slopes_of_strips_along_a_lay_tell_the_variance_across_it(rough, steps):
    means = [steps.reshape(count, -1).mean(axis=1) for count in (2, 4, 8)]
    expected = max(np.var(one, ddof=1) / one.size for one in means) / steps.mean() ** 2
    slopes = np.broadcast_to(np.repeat(steps, 8)[:, None], (64, 64))
    assert vary_across(rough, (1, 0), slopes) == pytest.approx(expected, rel=1e-6)
    assert vary_across(rough, (0, 1), slopes.T) == pytest.approx(expected, rel=1e-6)
    assert vary_across(rough, (0, 1), slopes) == pytest.approx(0.0, abs=1e-12)


def test_strips_follow_an_oblique_lay(rough):
    i, j = np.indices((64, 64))
    slopes = 1.0 + (i + j) // 16
    assert vary_across(rough, (1, 1), slopes) > 20.0 * vary_across(rough, (1, -1), slopes)


def test_the_slopes_of_places_of_a_gaussian_surface_vary_by_chance():
    found, expected = [], []
    for seed in range(40):
        place = places.Place.of(press(draw((32, 32), 32e-6, seed, 16e-6, 4e-6), 32e-6))
        window = places.find_window(place)
        waves = places._find_long_waves(place, window)
        square = float(places._sample_slopes(place, window, np.ones(window.shape, dtype=bool))[1].mean())
        found.append(square)
        expected.append(places._find_chance(place, window, waves, square))
    assert np.mean(expected) == pytest.approx(np.var(found, ddof=1) / np.mean(found) ** 2, rel=0.5)


def test_below_a_ball_it_is_that_of_the_part_in_contact():
    size = (96e-6, 64e-6)
    heights = draw((96, 64), size, 1, 16e-6, 4e-6)

    def press_ball(heights, size, force):
        body = rc.Body(rc.HeightMap(heights, size=size), STEEL)
        ball = rc.Body(rc.SphereSurface(100e-6), rc.Rigid())
        return rc.ContactProblem(body, ball).solve(force=force)

    light = press_ball(heights, size, 0.1)
    heavy = press_ball(heights, size, 1.0)
    assert max(places.find_window(places.Place.of(heavy)).shape) < 50
    assert 0.0 < relative(heavy)[0] < relative(light)[0]
    assert relative(heavy) == pytest.approx(relative(press_ball(heights.T, size[::-1], 1.0)), rel=1e-4)


def test_a_contact_too_small_to_tell_has_none():
    heights = draw((32, 32), 32e-6, 1, 16e-6, 8e-6)
    ball = rc.Body(rc.SphereSurface(60e-6), STEEL)
    tiny = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=32e-6), STEEL), ball).solve(force=1e-4)
    assert max(places.find_window(places.Place.of(tiny)).shape) < 4
    assert tiny.area().sampling is None


def test_tiles_that_carry_in_proportion_to_their_area_do_not_differ(rough):
    even = places.Place.of(attrs.evolve(rough, pressure=np.where(rough.contact, 1e9, 0.0)))
    whole = places.find_window(even)
    usual = 0.3 / math.sqrt(even.count)
    assert 0.0 < places._compare_tiles(even, whole, 1.0) < usual
    # Half of the tiles carry twice the pressure of the others.
    left = np.arange(64)[:, None] < 32
    uneven = attrs.evolve(even, pressure=np.where(rough.contact, np.where(left, 2e9, 1e9), 0.0))
    assert places._compare_tiles(uneven, whole, 1.0) > 2.0 * places._compare_tiles(even, whole, 1.0)


@pytest.mark.parametrize("fraction", [0.01, 0.3, 0.9])
def test_the_elasticity_is_the_derivative_of_the_area_of_persson(fraction):
    ratio = special.erfinv(fraction)
    step = 1e-5
    derivative = (math.log(special.erf(ratio / (1 + step))) - math.log(special.erf(ratio / (1 - step)))) / (2 * step)
    assert places._find_elasticity(fraction) == pytest.approx(-derivative, rel=1e-6)


def test_a_flat_punch_of_the_domain_has_its_stiffness():
    # A square punch: 1.152 E* times its side (Borodich, Galanov 2002).
    found = sampling._find_punch_stiffness((1e-3, 1e-3), 1e9)
    assert found == pytest.approx(1.152 * 1e9 * 1e-3, rel=2e-3)


def test_the_print_and_the_report_tell_it(rough):
    percent = 100.0 * rough.area().sampling / rough.area().value
    # The report has the rows of this list.
    told = list_answers(rough)["other places"]
    assert f"contact area +- {percent:.2g} %" in told
    assert f"other places {told}" in " ".join(str(rough).split())


def test_no_more_is_stated_than_the_number_itself(rough):
    uneven = places.PlaceStatistics(tiles=0.1, elasticity=1.0, height=0.1, lay=1.0, unevenness=1.2)
    place = places.Place.of(rough)
    object.__setattr__(place, "statistics", uneven)
    for defer in (sampling.defer_area_sampling, sampling.defer_peak_sampling):
        solution = attrs.evolve(rough)
        object.__setattr__(solution, "_place", place)
        assert defer(solution).read() is None
