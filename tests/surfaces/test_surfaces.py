from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import attrs
import numpy as np
import pytest
import scipy.fft
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc
from strategies import seeds

GRID = rc.Grid((40, 30), (2e-4, 3e-4))


def test_wave_is_equation_25():
    wave = rc.WavySurface((1e-6, 2e-6), (5e-5, 1e-4), phase=(0.3, -0.2))
    x, y = (np.arange(40) - 19.5) * 5e-6, (np.arange(30) - 14.5) * 1e-5
    expected = 1e-6 * np.cos(2 * np.pi * x / 5e-5 + 0.3)[:, None] + 2e-6 * np.cos(2 * np.pi * y / 1e-4 - 0.2)
    np.testing.assert_allclose(wave.heights(GRID), expected, rtol=0, atol=1e-20)


def test_a_sphere_is_a_paraboloid_near_its_summit():
    small = rc.Grid((11, 11), 1e-5)
    sphere, paraboloid = rc.SphereSurface(1e-2).heights(small), rc.ParaboloidSurface(1e-2).heights(small)
    np.testing.assert_allclose(sphere, paraboloid, rtol=1e-6)


def test_a_sphere_has_its_radius():
    heights = rc.SphereSurface(2e-4, center=(1e-5, 0)).heights(GRID)
    distance = np.sqrt((GRID.x - 1e-5) ** 2 + GRID.y**2 + (heights + 2e-4) ** 2)
    np.testing.assert_allclose(distance, 2e-4, rtol=1e-14)


def test_surfaces_add():
    wave, ball = rc.WavySurface(1e-6, 1e-4), rc.ParaboloidSurface((1e-2, 3e-2))
    bump = rc.HeightMap(np.random.default_rng(0).random(GRID.shape), size=GRID.size)
    total = wave + ball + bump
    assert total.own_grid == GRID
    np.testing.assert_array_equal(total.heights(GRID), wave.heights(GRID) + ball.heights(GRID) + bump.heights(GRID))


def test_a_map_keeps_a_private_copy():
    values = np.zeros((3, 4))
    surface = rc.HeightMap(values, size=(1.0, 1.0))
    values[0, 0] = 1.0
    assert surface.values[0, 0] == 0.0
    assert not surface.values.flags.writeable


def test_bilinear_is_exact_on_planes_inside():
    plane = rc.HeightMap(GRID.x + 2 * GRID.y, size=GRID.size)
    finer = plane.resample((80, 45))
    expected = finer.grid.x + 2 * finer.grid.y
    np.testing.assert_allclose(finer.values[2:-2, 2:-2], expected[2:-2, 2:-2], atol=1e-17)


def test_bilinear_takes_the_mean_of_two_cells_when_halving():
    values = np.random.default_rng(0).random((8, 6))
    halved = rc.HeightMap(values, size=(1.0, 1.0)).resample((4, 3))
    np.testing.assert_allclose(halved.values, values.reshape(4, 2, 3, 2).mean(axis=(1, 3)), rtol=1e-14)


def test_bilinear_goes_around_on_a_periodic_map():
    values = np.random.default_rng(0).random((8, 6))
    surface = rc.HeightMap(values, size=(1.0, 1.0), periodic=True)
    moved = rc.HeightMap(np.roll(values, 2, axis=0), size=(1.0, 1.0), periodic=True)
    np.testing.assert_allclose(np.roll(surface.resample((12, 6)).values, 3, axis=0), moved.resample((12, 6)).values)


@given(seeds, st.integers(5, 40), st.integers(5, 40))
def test_fourier_is_exact_on_waves(seed, nx, ny):
    rng = np.random.default_rng(seed)
    waves = rc.WavySurface(rng.random(2), (1 / 2, 1 / 2), phase=rng.random(2) * 6)
    coarse, fine = rc.Grid((5, 6), 1.0), rc.Grid((nx, ny), 1.0)
    surface = rc.HeightMap(waves.heights(coarse), size=(1.0, 1.0), periodic=True)
    np.testing.assert_allclose(surface.resample((nx, ny), "fourier").values, waves.heights(fine), atol=1e-13)


def test_fourier_to_the_same_and_threefold_cells_keeps_the_values():
    values = np.random.default_rng(0).random((6, 9))
    surface = rc.HeightMap(values, size=(1.0, 1.0), periodic=True)
    np.testing.assert_allclose(surface.resample((6, 9), "fourier").values, values, atol=1e-15)
    # The centres of threefold finer cells include the old ones.
    np.testing.assert_allclose(surface.resample((18, 27), "fourier").values[1::3, 1::3], values, atol=1e-14)


def test_block_mean_keeps_the_mean():
    values = np.random.default_rng(0).random((12, 10))
    coarse = rc.HeightMap(values, size=(1.0, 1.0)).resample((3, 5), "mean")
    np.testing.assert_allclose(coarse.values, values.reshape(3, 4, 5, 2).mean(axis=(1, 3)))


@pytest.mark.parametrize("degree", [0, 1, 2, 4])
def test_detrending_removes_polynomials_and_nothing_else(degree):
    x, y = np.meshgrid(np.linspace(0, 1, 25), np.linspace(-1, 2, 18), indexing="ij")
    rng = np.random.default_rng(0)
    trend = sum(rng.random() * x**i * y**j for i in range(degree + 1) for j in range(degree + 1 - i))
    rough = rng.standard_normal(x.shape)
    plain = rc.HeightMap(rough, size=(1.0, 3.0)).detrend(degree)
    with_trend = rc.HeightMap(rough + 1e3 * trend, size=(1.0, 3.0)).detrend(degree)
    np.testing.assert_allclose(with_trend.values, plain.values, atol=1e-10)
    for i in range(degree + 1):
        for j in range(degree + 1 - i):
            assert abs(np.sum(plain.values * x**i * y**j)) < 1e-9


class TestSelfAffine:
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8.0, longest=64.0, rolloff=32.0, seed=5)

    def test_has_the_slope_that_was_asked_for(self):
        heights = self.surface.heights(rc.Grid((64, 64), 64.0))
        waves = np.fft.fft2(heights) / heights.size
        q = 2 * np.pi * np.fft.fftfreq(64)
        slope = np.sqrt(np.sum((q[:, None] ** 2 + q**2) * np.abs(waves) ** 2))
        assert slope == pytest.approx(0.1, rel=1e-12)
        assert abs(heights.mean()) < 1e-14

    def test_has_the_height_that_was_asked_for(self):
        surface = rc.SelfAffineSurface(hurst=0.5, rms_height=2e-7, shortest=4e-6, longest=3e-5, seed=1)
        heights = surface.heights(rc.Grid((32, 48), (3.2e-5, 4.8e-5)))
        assert heights.std() == pytest.approx(2e-7, rel=1e-12)

    def test_is_the_same_surface_on_every_grid(self):
        coarse = rc.HeightMap(self.surface.heights(rc.Grid((32, 40), 64.0)), size=(64.0, 64.0), periodic=True)
        fine = self.surface.heights(rc.Grid((96, 120), 64.0))
        np.testing.assert_allclose(coarse.resample((96, 120), "fourier").values, fine, atol=1e-13)

    def test_has_only_the_waves_that_were_asked_for(self):
        waves = np.abs(np.fft.fft2(self.surface.heights(rc.Grid((64, 64), 64.0))))
        q = np.hypot(*np.meshgrid(np.fft.fftfreq(64), np.fft.fftfreq(64)))
        outside = (q > 1.001 / 8) | (q < 0.999 / 64)
        assert waves[outside].max() < 1e-10 * waves.max()

    def test_falls_with_the_hurst_exponent(self):
        grid = rc.Grid((256, 256), 256.0)
        powers = np.zeros(2)
        for seed in range(20):
            surface = rc.SelfAffineSurface(hurst=0.8, rms_height=1.0, shortest=4.0, longest=256.0, seed=seed)
            waves = np.abs(np.fft.fft2(surface.heights(grid))) ** 2
            k = 256 * np.hypot(*np.meshgrid(np.fft.fftfreq(256), np.fft.fftfreq(256)))
            powers += [waves[np.abs(k - 8) < 0.5].mean(), waves[np.abs(k - 32) < 0.5].mean()]
        assert np.log(powers[0] / powers[1]) / np.log(4) == pytest.approx(2 + 2 * 0.8, abs=0.15)


def fourier_coefficients(surface, cells, size, wave):
    """Return the coefficients of the waves of at least `wave`, by the centre of the domain."""
    grid = rc.Grid((cells, cells + 6), size)
    kx, ky = (np.fft.fftfreq(n, 1 / n)[:, None] for n in grid.shape)
    qx, qy = 2 * np.pi * kx / size[0], 2 * np.pi * ky.T / size[1]
    spectrum = np.fft.fft2(surface.heights(grid), norm="forward")
    spectrum *= np.exp(-1j * (qx * grid.x[0, 0] + qy * grid.y[0, 0]))
    kept = np.hypot(qx, qy) * wave <= 2 * np.pi * (1 + 1e-6)
    found = {
        (int(i), int(j)): spectrum[a, b]
        for a, i in enumerate(kx.ravel())
        for b, j in enumerate(ky.ravel())
        if kept[a, b]
    }
    return np.array([found[key] for key in sorted(found)])


@given(
    seeds,
    st.floats(2.0, 9.0),
    st.floats(2.0, 9.0),
    st.floats(2.0, 9.0),
    st.sampled_from(["rms_height", "rms_slope"]),
    st.floats(1.0, 1.6),
)
def test_the_seed_fixes_the_long_waves(seed, one, other, cutoff, rms, aspect):
    """Whatever the shortest wave and the grid: a shorter one only adds waves."""
    size = (24.0, 24.0 * aspect)
    surface = rc.SelfAffineSurface(
        hurst=0.7, shortest=one, longest=24.0, rolloff=12.0, rms_cutoff=cutoff, seed=seed, **{rms: 0.1}
    )
    shorter, longer = sorted((one, other))
    waves = [
        fourier_coefficients(attrs.evolve(surface, shortest=shortest), cells, size, longer)
        for shortest, cells in ((shorter, 40), (longer, 46), (longer, 40))
    ]
    scale = np.abs(waves[0]).max()
    assert scale > 0.0
    for others in waves[1:]:
        np.testing.assert_allclose(others, waves[0], rtol=0, atol=1e-12 * scale)
    # The wave at the cut-off is there: nothing of the band that counts was omitted.
    counted = attrs.evolve(surface, shortest=cutoff)
    default = rc.SelfAffineSurface(hurst=0.7, shortest=cutoff, longest=24.0, rolloff=12.0, seed=seed, **{rms: 0.1})
    grid = rc.Grid((40, 46), size)
    np.testing.assert_array_equal(counted.heights(grid), default.heights(grid))


@pytest.mark.parametrize(
    ("shape", "size", "fields"),
    [
        ((64, 64), (1.0, 1.0), {"shortest": 1 / 32, "longest": 0.5, "rms_height": 0.1, "rolloff": 0.25}),
        (
            (64, 48),
            (2.0, 1.0),
            {"shortest": 1 / 16, "rms_slope": 0.1, "longest": 1.0, "peklenik": 3.0, "lay": 0.4, "rms_cutoff": 1 / 6},
        ),
        ((45, 33), (2.0, 1.0), {"shortest": 1 / 10, "rms_slope": 0.1, "longest": 1.0, "rms_cutoff": 1 / 80}),
        ((64, 4), (16.0, 1.0), {"shortest": 0.5, "rms_slope": 0.1, "longest": 3.0}),
        ((4, 64), (1.0, 16.0), {"shortest": 0.5, "rms_slope": 0.1, "longest": 3.0}),
    ],
)
@pytest.mark.parametrize("count", [1, 3])
def test_columns_of_the_waves_are_those_of_the_heights(shape, size, fields, count):
    """The parts ask each other for a number at the same time: each is a thread that waits for the others."""
    surface = rc.SelfAffineSurface(hurst=0.8, seed=3, **fields)
    grid = rc.Grid(shape, size)
    bounds = [(shape[1] // 2 + 1) * part // count for part in range(count + 1)]
    barrier = threading.Barrier(count, timeout=30)
    numbers = [0.0] * count

    def find(part):
        def across(ufunc, value):
            numbers[part] = value
            barrier.wait()
            found = float(ufunc.reduce(numbers))
            barrier.wait()
            return found

        return surface.half_spectrum(grid, slice(*bounds[part : part + 2]), across)

    with ThreadPoolExecutor(count) as pool:
        waves = np.concatenate(list(pool.map(find, range(count))), axis=1)
    heights = surface.heights(grid)
    np.testing.assert_allclose(
        scipy.fft.irfft2(waves, s=shape, norm="forward"), heights, rtol=0, atol=1e-14 * np.abs(heights).max()
    )


def test_a_cutoff_beyond_the_longest_wave_is_refused():
    with pytest.raises(rc.InputError, match="cut-off of the rms value must be at most the longest wavelength"):
        rc.SelfAffineSurface(hurst=0.7, rms_slope=0.1, shortest=1.0, longest=8.0, rms_cutoff=9.0)


def test_a_printed_map_says_what_it_is_and_where_it_comes_from():
    heights = 1e-7 * np.random.default_rng(0).standard_normal((48, 40))
    mask = np.zeros(heights.shape, dtype=bool)
    mask[3, 4] = mask[5, 6] = True
    surface = rc.HeightMap(heights, size=(48e-6, 40e-6), non_measured=mask, history=("read from a.csv",)).detrend(
        "plane"
    )
    lines = str(surface).splitlines()
    measured = surface.values[~mask]
    assert lines[0] == "grid          48 x 40 cells on 48 µm x 40 µm, cells of 1 µm x 1 µm"
    assert lines[2] == f"Sq            {1e9 * measured.std():.4g} nm about the mean"
    assert lines[3] == "history       read from a.csv"
    assert "plane" in lines[4]
    assert lines[5] == "non-measured  2 of 1920 points (0.1 %)"
    assert all(len(line) <= 80 for line in lines)
    assert "periodic" in str(rc.HeightMap(heights, size=(48e-6, 40e-6), periodic=True))


@given(seeds, st.integers(4, 24), st.integers(4, 24), st.booleans(), st.booleans())
def test_rearranged_maps_are_the_same_surface(seed, nx, ny, periodic, holed):
    rng = np.random.default_rng(seed)
    mask = rng.random((nx, ny)) < 0.2 if holed else None
    surface = rc.HeightMap(rng.random((nx, ny)), (3e-6, 5e-6), periodic=periodic, non_measured=mask)
    for again in (surface.mirrored().mirrored(), surface.transposed().transposed()):
        np.testing.assert_array_equal(again.values, surface.values)
        assert (again.size, again.periodic) == (surface.size, periodic)
    turned = surface.transposed()
    assert turned.size == (5e-6, 3e-6)
    np.testing.assert_array_equal(turned.values, surface.values.T)
    np.testing.assert_array_equal(surface.mirrored().values[0], surface.values[-1])
    if surface.non_measured is not None:
        np.testing.assert_array_equal(turned.non_measured, surface.non_measured.T)
        np.testing.assert_array_equal(surface.mirrored().non_measured, surface.non_measured[::-1])


def test_a_part_of_a_map_stands_where_it_was():
    grid = rc.Grid((40, 30), (40e-6, 60e-6))
    values = grid.x + 1000 * grid.y
    mask = np.zeros(grid.shape, bool)
    mask[22, 17] = True
    part = rc.HeightMap(values, grid.size, periodic=True, non_measured=mask).crop((8e-6, 12e-6), centre=(4e-6, 6e-6))
    assert part.grid.matches(rc.Grid((8, 6), (8e-6, 12e-6)))
    np.testing.assert_allclose(part.values, part.grid.x + 4e-6 + 1000 * (part.grid.y + 6e-6), atol=1e-15)
    assert not part.periodic
    assert part.non_measured.sum() == 1
    assert "cut to 8 x 6 of its cells, 20 to 27 x 15 to 20" in part.history[-1]
    with pytest.raises(
        rc.InputError, match=r"A part of 8 µm x 12 µm around \(18 µm, 0 m\) is not inside the map, 40 µm"
    ):
        rc.HeightMap(values, grid.size).crop((8e-6, 12e-6), centre=(18e-6, 0))


def test_filled_points_count_as_measured():
    values = np.random.default_rng(1).random((9, 8))
    holed = np.where(values > 0.8, np.nan, values)
    filled = rc.HeightMap(holed, (9e-6, 8e-6)).fill()
    assert filled.non_measured is None
    assert filled.values.max() <= 0.8
    np.testing.assert_array_equal(filled.values[values <= 0.8], values[values <= 0.8])
    assert filled.fill() is filled
    # Heights given at non-measured points are not trusted.
    given_heights = rc.HeightMap(values, (9e-6, 8e-6), non_measured=values > 0.8)
    np.testing.assert_array_equal(given_heights.fill().values, filled.values)


class TestGaussianFilter:
    @given(st.integers(1, 6), st.integers(0, 6), st.floats(0.06, 0.9))
    def test_waves_lose_what_the_standard_says(self, kx, ky, cutoff):
        """Transmission 2^-(cut-off / wavelength)^2 of a wave in any direction."""
        grid = rc.Grid((36, 48), (1e-6, 2e-6))
        phase = 2 * np.pi * (kx * grid.x / 1e-6 + ky * grid.y / 2e-6)
        surface = rc.HeightMap(np.cos(phase + 0.3), grid.size, periodic=True)
        wavelength = 1.0 / np.hypot(kx / 1e-6, ky / 2e-6)
        kept = 2.0 ** -((cutoff * 1e-6 / wavelength) ** 2)
        if cutoff * 1e-6 < 2 * max(grid.spacing):
            with pytest.raises(rc.InputError, match="at least two cells"):
                surface.filtered(cutoff * 1e-6)
            return
        np.testing.assert_allclose(surface.filtered(cutoff * 1e-6).values, kept * surface.values, atol=1e-13)
        np.testing.assert_allclose(
            surface.filtered(longest=cutoff * 1e-6).values, (1 - kept) * surface.values, atol=1e-13
        )

    @given(seeds, st.booleans())
    def test_constant_maps_stay_and_the_border_and_holes_have_no_weight(self, seed, transposed):
        rng = np.random.default_rng(seed)
        mask = rng.random((20, 60)) < 0.3
        mask[8:12, 20:30] = True
        flat = rc.HeightMap(np.where(mask, 7.0, 3.0), (20e-6, 60e-6), non_measured=mask)
        flat = flat.transposed() if transposed else flat
        smooth = flat.filtered(5e-6)
        np.testing.assert_allclose(smooth.values[~flat.non_measured], 3.0, rtol=1e-12)
        np.testing.assert_array_equal(smooth.non_measured, flat.non_measured)

    def test_weights_are_those_of_the_standard_inside_a_map_that_does_not_repeat(self):
        values = np.random.default_rng(3).random((60, 40))
        found = rc.HeightMap(values, (60e-6, 80e-6)).filtered(20e-6).values
        # The mean under the weights of ISO 16610-61 at one point, summed directly.
        x, y = np.arange(60) * 1e-6, np.arange(40) * 2e-6
        alpha = np.sqrt(np.log(2) / np.pi)
        square = np.add.outer((x - x[25]) ** 2, (y - y[4]) ** 2)
        weights = np.exp(-np.pi * square / (alpha * 20e-6) ** 2)
        assert found[25, 4] == pytest.approx(np.sum(weights * values) / weights.sum(), rel=2e-6)

    def test_both_ends_and_what_is_refused(self):
        surface = rc.HeightMap(np.random.default_rng(1).random((32, 32)), 32e-6, periodic=True)
        both = surface.filtered(4e-6, longest=16e-6)
        np.testing.assert_allclose(both.values, surface.filtered(4e-6).filtered(longest=16e-6).values)
        assert both.history[-2:] == (
            "waves below 4 µm removed by a Gaussian filter",
            "waves above 16 µm removed by a Gaussian filter",
        )
        with pytest.raises(rc.InputError, match="Give the cut-off of the short waves"):
            surface.filtered()
        with pytest.raises(rc.InputError, match="must be above the shortest"):
            surface.filtered(8e-6, 4e-6)


@pytest.mark.parametrize("interpolation", ["cubic", "bilinear"])
@pytest.mark.parametrize("shape", [(64, 45), (20, 90)])
def test_resampled_waves_stand_where_they_stood(interpolation, shape):
    def wave(nx, ny):
        x, y = ((np.arange(n) + 0.5) / n for n in (nx, ny))
        return np.cos(2.0 * np.pi * x[:, np.newaxis] + 0.4) + np.sin(2.0 * np.pi * y)

    found = rc.HeightMap(wave(40, 36), size=(2.0, 3.0), periodic=True).resample(shape, interpolation)
    error = 1e-3 if interpolation == "cubic" else 8e-3
    np.testing.assert_allclose(found.values, wave(*shape), atol=error)
