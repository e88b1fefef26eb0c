"""Signs of interpolation, steps, filled points and noise in maps, of heights of which they are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import ndimage

import roughcontact as rc
from roughcontact._parts.surfaces import quality
from roughcontact._parts.surfaces.quality import (
    _count_waves,
    _find_filled,
    _levels,
    _middle,
    _shows_in_differences,
    _take_middle,
    find_period,
    list_map_warnings,
)

RNG = np.random.default_rng(5)


def make_rough(shape, shortest=4.0, seed=3):
    """Return periodic heights with a spectrum that falls as q^-3.2 up to waves of some cells."""
    spectrum = np.fft.fft2(np.random.default_rng(seed).normal(size=shape))
    q = np.hypot(np.fft.fftfreq(shape[0])[:, np.newaxis], np.fft.fftfreq(shape[1]))
    power = np.where((q > 0.0) & (q < 1.0 / shortest), np.maximum(q, 1.0 / max(shape)) ** -1.6, 0.0)
    return np.fft.ifft2(spectrum * power).real


@pytest.mark.parametrize("shape", [(300, 40), (513, 512), (100, 1000)])
def test_the_middle_is_examined(shape):
    heights = np.arange(float(shape[0] * shape[1])).reshape(shape)
    found = _middle(heights)
    most = quality._EXAMINED_CELLS
    assert found.shape == tuple(min(n, most) for n in shape)
    first = tuple((n - m) // 2 for n, m in zip(shape, found.shape, strict=True))
    assert found[0, 0] == heights[first]
    assert found[-1, -1] == heights[first[0] + found.shape[0] - 1, first[1] + found.shape[1] - 1]
    part, unit = _take_middle(heights, None)
    assert np.ptp(part) == pytest.approx(1.0)
    assert unit == pytest.approx(np.ptp(found))


def test_points_without_a_measurement_are_smoothed_over_up_to_half():
    heights = make_rough((40, 50))
    holes = np.zeros(heights.shape, dtype=bool)
    holes[10:14, 20:25] = True
    wild = np.where(holes, 1e9, heights)
    part, unit = _take_middle(wild, holes)
    assert unit == pytest.approx(np.ptp(heights), rel=0.3)
    np.testing.assert_allclose((part * unit)[~holes], heights[~holes])
    most = np.indices(heights.shape)[0] < 21
    assert _take_middle(heights, most)[0].size == 0
    assert _take_middle(heights, np.indices(heights.shape)[0] < 20)[0].shape == heights.shape


def test_points_that_are_the_mean_of_their_neighbours_are_filled():
    heights = RNG.normal(size=(30, 41))
    expected = np.zeros(heights.shape, dtype=bool)
    # None beside another one, and none at the border.
    expected[2:28:5, 3:38:4] = RNG.random((6, 9)) < 0.5
    around = sum(np.roll(heights, step, axis) for axis in (0, 1) for step in (-1, 1))
    np.testing.assert_array_equal(_find_filled(np.where(expected, 0.25 * around, heights)), expected)
    tilted = heights + 1e3 * np.arange(30.0)[:, np.newaxis]
    assert not _find_filled(tilted).any()
    assert _find_filled(np.add.outer(np.arange(8.0), np.arange(9.0)))[1:-1, 1:-1].all()


def test_steps_are_told_from_third_differences_whatever_the_form():
    steps = np.rint(3.0 * RNG.normal(size=(60, 40)))
    x = np.arange(60.0)[:, np.newaxis]
    levels = _levels(steps + 0.5 * x**2 - 7.0 * x + np.arange(40.0))
    sizes = np.diff(levels) / np.median(np.diff(levels))
    np.testing.assert_allclose(sizes, np.rint(sizes), atol=1e-6)
    rms = np.sqrt(np.mean(np.diff(steps, 3, axis=0) ** 2))
    assert np.median(np.diff(levels)) == pytest.approx(1.0 / rms)
    assert _levels(x**2 + np.zeros((60, 40))).tolist() == [0.0, 1.0]
    assert _levels(RNG.normal(size=(60, 40))).size > 2000


@pytest.mark.parametrize("factor", [2, 3, 4])
@pytest.mark.parametrize("axis", [0, 1])
def test_the_period_of_interpolated_maps_is_their_factor(factor, axis):
    rough = make_rough((64, 96) if axis else (96, 64), 2.0)
    n = rough.shape[axis]
    place = np.arange(n * factor) / factor % n
    before = np.floor(place).astype(int)
    part = (place - before).reshape([-1 if k == axis else 1 for k in (0, 1)])
    low, high = (np.take(rough, (before + step) % n, axis) for step in (0, 1))
    found = find_period((1.0 - part) * low + part * high)
    assert found == pytest.approx(factor, rel=0.02) or found == pytest.approx(factor / 2.0, rel=0.02)
    assert find_period(rough) == 0.0
    assert find_period(rough[:5]) == 0.0


@pytest.mark.parametrize("count", [1, 3, 8])
def test_waves_are_counted_by_their_part_in_the_curvature(count):
    """Of cosines of the same curvature along both axes: as many as there are, but for the window."""
    x, y = np.indices((128, 128))
    heights = np.zeros((128, 128))
    rng = np.random.default_rng(7)
    for k in range(count):
        m = 12 + 3 * k
        heights += np.cos(2.0 * np.pi * m * (x + y) / 128 + rng.uniform(0, 6.28)) / m**2
    found = _count_waves(heights)
    assert 0.7 * count < found < 6.0 * count


def test_noise_shows_in_second_differences_by_six_times_its_variance():
    x = np.arange(400.0)[:, np.newaxis] + np.zeros(30)
    wave = np.cos(0.3 * x)
    flat = wave + np.cos(0.5 * np.arange(30.0))
    squares = min(float(np.mean(np.diff(flat, 2, axis=axis) ** 2)) for axis in (0, 1))
    floor = quality._MIN_NOISE_FRACTION**2 * squares / (6.0 * flat.size)
    assert _shows_in_differences(flat, 1.01 * floor)
    assert not _shows_in_differences(flat, 0.99 * floor)


@pytest.mark.parametrize("scale", [1e-9, 1e-6])
def test_each_sign_has_its_sentence_and_other_maps_none(scale):
    grid = rc.Grid((160, 150), (160e-6, 150e-6))
    quiet = scale * make_rough(grid.shape, 2.0)
    assert list_map_warnings(quiet, grid) == ()
    assert list_map_warnings(quiet[:5], rc.Grid((5, 150), 1e-4)) == ()
    assert list_map_warnings(0.0 * quiet, grid) == ()
    smooth = ndimage.gaussian_filter(quiet, 1.2, mode="wrap")
    # Without any noise nothing has measured it.
    assert list_map_warnings(smooth, grid) == ()
    (blurred,) = list_map_warnings(smooth + 1e-4 * quiet.std() * np.random.default_rng(1).normal(size=grid.shape), grid)
    assert blurred.rule == "blurred map"
    # A blur by s cells adds -2 (s q)^2 to the slope of -3.2: it is below -5.5 from waves of 2 pi / 0.9 cells on.
    assert 3.0e-6 < blurred.value < 11.0e-6
    assert f"({blurred.value / 1e-6:.2g} cells)" in blurred
    # Also where the noise hides all waves of less than 16 cells, which then have no slope.
    for part in (0.5, 1.0, 10.0):
        noisy = quiet + part * quiet.std() * np.random.default_rng(1).normal(size=grid.shape)
        assert {text.rule for text in list_map_warnings(noisy, grid)} == {quality._NOISE_RULE}
    size = 0.02 * np.ptp(quiet)
    assert [text.rule for text in list_map_warnings(size * np.rint(quiet / size), grid)] == ["stepped map"]
    filled = quiet.copy()
    places = np.zeros(grid.shape, dtype=bool)
    places[2:-2:4, 2:-2:4] = True
    around = sum(np.roll(quiet, step, axis) for axis in (0, 1) for step in (-1, 1))
    filled[places] = 0.25 * around[places]
    share = float(places.mean())
    found = {text.rule: text for text in list_map_warnings(filled, grid)}
    assert found["filled points"].value == pytest.approx(share, rel=0.05)
    assert f"about {100.0 * share:.2g} % of the points of the map look filled in" in found["filled points"]
    known = {text.rule: text for text in list_map_warnings(filled, grid, was_filled=True)}
    assert "the contact is a guess" in known["filled points"]
    assert math.isclose(known["filled points"].value, found["filled points"].value)
