"""Persson's theory and spectral moments: limits, closed forms, sampling errors, and the theory beside a solution."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.fft
from scipy import integrate, special

import roughcontact as rc
from roughcontact import reference
from scenes import make_problem

GRID = rc.Grid((96, 64), (3e-3, 1e-3))
MODULUS = 2e9


def wave(grid, amplitude, nx, ny, phase=0.3):
    lx, ly = grid.size
    return amplitude * np.cos(2 * np.pi * (nx * grid.x / lx + ny * grid.y / ly) + phase)


def gaussian(rng, grid, hurst=0.8, low=3, high=20):
    """Heights with Gaussian amplitudes: the spectrum is that of the class, not of each surface."""
    noise = scipy.fft.fft2(rng.standard_normal(grid.shape))
    kx, ky = (np.fft.fftfreq(n) * n for n in grid.shape)
    q = np.hypot(kx[:, None] / grid.size[0], ky / grid.size[1]) * max(grid.size)
    power = np.where((q >= 1) & (q <= high), np.maximum(q, low) ** (-1 - hurst), 0.0)
    return scipy.fft.ifft2(noise * power).real


def draw_surface(seed=1, cells=256, **options):
    options = {"hurst": 0.8, "rms_slope": 0.1, "shortest": 1 / 32, "longest": 0.5, "rolloff": 0.25} | options
    return rc.SelfAffineSurface(seed=seed, **options), rc.Grid((cells, cells), 1.0)


def solve(surface, grid, load, **options):
    problem = make_problem(surface, rc.Elastic(1e9, 0.0), **{"grid": grid, "boundary": "periodic", **options})
    return problem.solve(pressure=load * 1e9 * 0.1)


class TestMoments:
    @pytest.mark.parametrize("waves", [(4, 0), (0, 3), (7, 5), (20, 2)])
    def test_of_one_wave(self, waves):
        """m0 = a^2/2; the mean square gradient is q^2 a^2/2, twice m2; the mean square laplacian is 8/3 m4."""
        q = 2 * np.pi * math.hypot(waves[0] / GRID.size[0], waves[1] / GRID.size[1])
        found = reference.roughness(5.0 + wave(GRID, 2e-6, *waves), GRID)
        assert found.m0.value == pytest.approx(2e-12, rel=1e-9)
        assert 2 * found.m2.value == pytest.approx(q**2 * 2e-12, rel=1e-9)
        assert 8 / 3 * found.m4.value == pytest.approx(q**4 * 2e-12, rel=1e-9)
        assert found.nayak.value == pytest.approx(1.5, rel=1e-9)
        assert found.rms_slope.value == pytest.approx(q * math.sqrt(2) * 1e-6, rel=1e-9)

    def test_summits_of_a_gaussian_surface_are_where_the_moments_say(self):
        """Counted: cells above all eight neighbours, 12 cells a shortest wave; density, mean height, deviation."""
        counts, heights, expected = [], [], []
        for seed in range(6):
            surface, grid = draw_surface(seed, 384)
            z = surface.heights(grid)
            around = [np.roll(z, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
            summits = z > np.max(around, axis=0)
            counts.append(summits.sum())
            heights += list(z[summits] / z.std())
            found = reference.roughness(z, grid)
            rms = found.rms_height.value
            expected.append(
                [found.summit_density.value, found.summit_height.value / rms, found.summit_deviation.value / rms]
            )
        density, height, deviation = np.mean(expected, axis=0)
        assert np.mean(counts) == pytest.approx(density, rel=0.04)
        assert np.mean(heights) == pytest.approx(height, abs=0.06)
        assert np.std(heights) == pytest.approx(deviation, rel=0.06)

    @pytest.mark.slow
    @pytest.mark.parametrize(("periodic", "within"), [(True, 0.12), (False, 0.25)])
    def test_sampling_errors_are_the_scatter_over_surfaces(self, periodic, within):
        rng = np.random.default_rng(3)
        found = [reference.roughness(gaussian(rng, GRID), GRID, periodic=periodic) for _ in range(300)]
        for name in ("m0", "m2", "m4", "rms_height", "nayak", "summit_density", "summit_height", "summit_radius"):
            values = np.array([getattr(one, name).value for one in found])
            stated = np.array([getattr(one, name).uncertainty for one in found])
            assert math.sqrt(np.mean(stated**2)) == pytest.approx(values.std(), rel=2 * within), name

    def test_units_change_nothing_but_the_unit(self):
        heights = gaussian(np.random.default_rng(0), GRID)
        one = reference.roughness(heights, GRID)
        other = reference.roughness(
            heights * 2.0**-30, rc.Grid(GRID.shape, tuple(side * 2.0**-10 for side in GRID.size))
        )
        assert other.m4.value * 2.0**20 == one.m4.value
        assert other.nayak == one.nayak
        assert other.summit_deviation.value * 2.0**30 == one.summit_deviation.value

    def test_it_prints_its_numbers(self):
        text = str(reference.roughness(gaussian(np.random.default_rng(0), GRID) * 1e-6, GRID))
        assert "summit density" in text
        assert "1/m2 +-" in text
        assert "m0" in text


class TestBearingArea:
    def test_of_a_gaussian_surface_is_the_normal_distribution(self):
        rng = np.random.default_rng(8)
        curve = rc.reference.bearing_area(
            rng.standard_normal((400, 300)) * 1e-6 + 5e-3, [-2e-6, -1e-6, 0.0, 1e-6, 2e-6]
        )
        exact = np.array([0.97725, 0.84134, 0.5, 0.15866, 0.02275])
        assert np.abs(curve.fractions - exact).max() < 5e-3
        # Independent heights: the binomial deviation.
        np.testing.assert_allclose(curve.uncertainties, np.sqrt(exact * (1 - exact) / 120_000), rtol=0.6)

    def test_falls_from_one_to_zero_and_its_integral_is_the_mean(self):
        surface, grid = draw_surface(seed=4, cells=64)
        heights = surface.heights(grid)
        curve = rc.reference.bearing_area(heights)
        assert np.all(np.diff(curve.fractions) <= 0.0)
        assert curve.fractions[0] == 1.0 - 1.0 / heights.size
        assert curve.fractions[-1] == 0.0
        mean = curve.levels[0] + np.trapezoid(curve.fractions, curve.levels)
        assert abs(mean) < 1e-2 * np.ptp(heights)

    def test_elastic_bodies_touch_on_less_at_the_same_mean_gap(self):
        surface, grid = draw_surface(seed=2, cells=128)
        solution = solve(surface, grid, 0.02)
        heights = surface.heights(grid)
        levels = np.linspace(heights.min() - heights.mean(), heights.max() - heights.mean(), 400)
        curve = rc.reference.bearing_area(heights, levels)
        gaps = np.array([np.maximum(level - heights + heights.mean(), 0.0).mean() for level in levels])
        overlap = np.interp(solution.gap.mean(), gaps, curve.fractions)
        assert solution.area().fraction < 0.8 * overlap

    @pytest.mark.parametrize("levels", [[np.nan], [[0.0, 1.0]], "high", 0.0])
    def test_bad_levels_get_a_sentence(self, levels):
        with pytest.raises(rc.InputError, match="finite numbers"):
            rc.reference.bearing_area(np.eye(4), levels)


class TestPersson:
    def test_of_one_wave_is_the_integral(self):
        """Of a single wave number the sums have one term: the gap is an integral over the pressure."""
        heights = wave(GRID, 1e-6, 0, 5)
        q, mean_square = 2 * np.pi * 5 / GRID.size[1], 0.5e-12
        rms = math.sqrt(0.25 * MODULUS**2 * q**2 * mean_square)

        def slope(p):
            s = special.erf(p / math.sqrt(2) / rms)
            density = math.sqrt(2 / math.pi) / rms * math.exp(-0.5 * (p / rms) ** 2)
            return 0.25 * MODULUS * q * mean_square * (0.45 + 1.65 * s**2) * density

        for p in np.array([1e-6, 0.01, 0.3, 1.0, 2.5]) * rms:
            found = reference.persson(heights, GRID, MODULUS, float(p))
            gap = integrate.quad(lambda t: slope(math.exp(t)), math.log(p), math.log(9 * rms), epsabs=0, epsrel=1e-10)[
                0
            ]
            assert found.area_fraction == pytest.approx(special.erf(p / math.sqrt(2) / rms), rel=1e-9)
            assert found.mean_gap == pytest.approx(gap, abs=1e-4 * 0.7e-6)
            assert found.stiffness == pytest.approx(p / slope(p), rel=1e-9)

    def test_stiffness_is_the_slope_of_the_gap(self):
        surface, grid = draw_surface()
        pressures = 1e8 * np.geomspace(1e-4, 0.5, 9)
        above, at, below = (
            reference.persson(surface.heights(grid), grid, 1e9, pressures * factor) for factor in (1.05, 1.0, 1 / 1.05)
        )
        slope = (above.pressure - below.pressure) / (below.mean_gap - above.mean_gap)
        assert slope == pytest.approx(at.stiffness, rel=5e-3)

    def test_light_load_and_full_contact(self):
        surface, grid = draw_surface()
        heights, unit = surface.heights(grid), 1e9 * 0.1
        light = reference.persson(heights, grid, 1e9, [1e-12 * unit, 1e-6 * unit])
        assert light.area_fraction / light.pressure * unit == pytest.approx(4 / math.sqrt(2 * math.pi), rel=1e-6)
        # The gap falls with the logarithm of the load, and the stiffness is in proportion to it.
        decades = (light.mean_gap[0] - light.mean_gap[1]) / math.log(1e6)
        assert light.pressure / light.stiffness == pytest.approx(decades, rel=1e-6)
        full = reference.persson(heights, grid, 1e9, [10 * unit, 100 * unit])
        assert full.area_fraction == pytest.approx(1.0)
        assert (full.mean_gap < 1e-9 * heights.std()).all()
        assert full.stiffness[1] == math.inf

    def test_units_and_rectangles_change_nothing(self):
        """The same surface on another rectangle of cells, and in other units, has the same contact."""
        square, other = rc.Grid((64, 64), 1.0), rc.Grid((128, 80), 1.0)
        waves = [(3, 1), (5, -4), (9, 6), (1, 12)]
        one, two = (sum(wave(grid, 1e-2 / (i + 1), *k) for i, k in enumerate(waves)) for grid in (square, other))
        pressures = 1e9 * np.array([0.003, 0.03, 0.3])
        first, second = reference.persson(one, square, 1e9, pressures), reference.persson(two, other, 1e9, pressures)
        for name in ("area_fraction", "mean_gap", "stiffness"):
            assert getattr(first, name) == pytest.approx(getattr(second, name), rel=1e-9), name
        small = reference.persson(one * 2.0**-40, rc.Grid((64, 64), 2.0**-30), 1e9 * 2.0**20, pressures * 2.0**10)
        assert (small.area_fraction == first.area_fraction).all()
        assert (small.mean_gap * 2.0**40 == first.mean_gap).all()

    def test_a_windowed_map_gives_about_the_same(self):
        surface, grid = draw_surface(cells=384)
        heights = surface.heights(grid)
        whole = reference.persson(heights, grid, 1e9, 5e6)
        cut = rc.Grid((256, 288), (256 / 384, 288 / 384))
        part = reference.persson(heights[:256, :288], cut, 1e9, 5e6, periodic=False)
        assert part.area_fraction == pytest.approx(whole.area_fraction, rel=0.1)
        assert part.mean_gap == pytest.approx(whole.mean_gap, rel=0.3)

    def test_one_pressure_gives_numbers_and_several_a_table(self):
        surface, grid = draw_surface()
        heights = surface.heights(grid)
        assert reference.persson(heights, grid, 1e9, 5e6).mean_gap.shape == ()
        assert len(str(reference.persson(heights, grid, 1e9, [5e6, 6e6])).splitlines()) == 3

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            ({"heights": np.zeros((64, 64))}, "there is no roughness"),
            ({"heights": np.full((64, 64), 1e3)}, "there is no roughness"),
            ({"heights": np.zeros((64, 32))}, "shape of the grid"),
            ({"grid": 5}, r"Grid\(shape, size\)"),
            ({"pressure": 0.0}, "above 0"),
            ({"pressure": [1.0, math.nan]}, "above 0"),
            ({"pressure": []}, "above 0"),
            ({"modulus": -1.0}, "contact modulus"),
            ({"periodic": "no"}, "True or False"),
        ],
    )
    def test_bad_input_gets_a_sentence(self, change, words):
        grid = rc.Grid((64, 64), 1.0)
        good = {"heights": wave(grid, 1e-3, 3, 4), "grid": grid, "modulus": 1e9, "pressure": 1e6}
        with pytest.raises(rc.InputError, match=words):
            reference.persson(**(good | change))


class TestBeside:
    @pytest.mark.parametrize("hurst", [0.3, 0.8])
    def test_theory_and_solution_agree_as_is_known(self, hurst):
        """The area is low by a fifth to a third, the mean gap right to a few per cent of the rms height."""
        surface, grid = draw_surface(5, hurst=hurst, longest=1.0, rolloff=0.125)
        for load, low, high in ((0.01, 0.65, 0.74), (0.1, 0.74, 0.81), (0.2, 0.79, 0.86)):
            solution = solve(surface, grid, load)
            theory = solution.theory
            assert low < theory.area_ratio < high
            assert theory.departure == 0.0
            departure = float(theory.contact.mean_gap) - solution.gap.mean()
            assert abs(departure) < (0.25 if load < 0.1 else 0.05) * solution.initial_gap.std()
            assert f"({theory.area_ratio:.2f} of the solved)" in str(solution)
            # Only that the domain is 1 m long.
            assert [text for text in solution.warnings if "1 m long" not in text] == []

    @pytest.mark.parametrize("shape", [(384, 128), (128, 384)])
    def test_the_longer_sides_of_the_cells_resolve_the_waves_or_not(self, shape):
        """Waves of 2.5 such sides are not resolved, those of 6 are, whichever axis has them."""
        for cells, known in ((2.5, False), (6.0, True)):
            surface, _ = draw_surface(hurst=0.5, shortest=cells / 128, longest=0.12, rolloff=0.12, seed=5)
            assert (solve(surface, rc.Grid(shape, 1.0), 0.1).theory is not None) == known

    @pytest.mark.parametrize(
        "make",
        [
            lambda: solve(*draw_surface(cells=128), 0.05, boundary="free"),
            lambda: solve(*draw_surface(), 0.05, boundary="wrapped"),
            lambda: solve(*draw_surface(peklenik=3.0), 0.05),
            lambda: solve(rc.WavySurface(1e-3, 0.25), rc.Grid((64, 64), 1.0), 0.05),
            lambda: solve(rc.SphereSurface(5.0), rc.Grid((64, 64), 1.0), 0.001),
        ],
        ids=["free", "wrapped", "a lay", "a wave", "form"],
    )
    def test_nothing_is_said_where_it_does_not_hold(self, make):
        solution = make()
        assert solution.theory is None
        assert "Persson" not in str(solution)

    def test_a_limited_contact_has_no_theory(self):
        surface, grid = draw_surface()
        body = rc.Body(surface, rc.ElasticPerfectlyPlastic(1e9, 0.0, 5e7))
        assert rc.ContactProblem(body, grid=grid, boundary="periodic").solve(pressure=1e7).theory is None

    def test_a_worn_surface_gets_a_warning(self):
        """Short waves in the valleys alone: near-Gaussian heights, but a contact that they do not roughen."""
        (surface, grid), (shorter, _) = (
            draw_surface(2, rolloff=0.5, shortest=1 / 8),
            draw_surface(3, longest=1 / 12, rolloff=1 / 12),
        )
        long, short = (one.heights(grid) / one.heights(grid).std() for one in (surface, shorter))
        heights = 0.02 * (long + 0.3 * short * (long < 0.5))
        solution = solve(rc.HeightMap(heights, size=1.0, periodic=True), grid, 0.1)
        assert solution.theory.departure > 3.0
        (warning,) = (text for text in solution.warnings if "Persson" in text)
        assert "differs where it touches" in warning
