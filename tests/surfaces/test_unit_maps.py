"""Parts of surfaces: filling, continuation, spectra, forms."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._parts.surfaces.continuation import Continuation, find_maps
from roughcontact._parts.surfaces.filling import fill
from roughcontact._parts.surfaces.statistics import fit_power_law, polynomial
from test_maps import GRID, ROUGH, crop


def test_filling_makes_no_summit_and_continues_planes():
    rng = np.random.default_rng(1)
    incomplete = rng.random((20, 30))
    incomplete[5:12, 8:20] = np.nan
    incomplete[rng.random(incomplete.shape) < 0.3] = np.nan
    complete = fill(incomplete)
    assert np.nanmin(incomplete) <= complete.min()
    assert complete.max() <= np.nanmax(incomplete)
    plane = 3.0 * np.arange(20)[:, None] - np.arange(30)
    plane_with_gap = plane.astype(float)
    plane_with_gap[5:12, 8:20] = np.nan
    np.testing.assert_allclose(fill(plane_with_gap), plane, atol=1e-12)


def test_many_points_are_filled_as_few_are(monkeypatch):
    """Iterations with a multigrid cycle, in memory in proportion to the points, against the direct solution."""
    rng = np.random.default_rng(2)
    heights = 1e-3 + 1e-7 * (rng.random((200, 230)) + np.cos(np.arange(230) / 20))
    heights[4:-3, 5:-2] = np.nan
    heights[rng.random(heights.shape) < 0.3] = np.nan
    heights[90, 100] = heights[20:180, 60] = 1e-3
    iterated = fill(heights)
    monkeypatch.setattr("roughcontact._parts.surfaces.filling._MAX_DIRECT_POINTS", heights.size)
    # The direct solution loses digits to the mean height.
    np.testing.assert_allclose(iterated - 1e-3, fill(heights - 1e-3), atol=1e-11 * 1e-7, rtol=0)
    known = np.isfinite(heights)
    np.testing.assert_array_equal(iterated[known], heights[known])
    assert heights[known].min() <= iterated.min()
    assert iterated.max() <= heights[known].max()


class TestSpectrum:
    @pytest.mark.parametrize("hurst", [0.3, 0.8])
    def test_the_power_law_of_self_affine_maps(self, hurst):
        """Exponents scatter about the true one by the standard error that is stated; sampling moves them by 0.2."""
        deviations = []
        for seed in range(8):
            surface = rc.SelfAffineSurface(
                hurst=hurst, rms_slope=0.1, shortest=2.0, longest=160.0, rolloff=60.0, seed=seed
            )
            heights = surface.heights(rc.Grid((160, 160), 160.0))[:128, :128]
            law = fit_power_law(heights, rc.Grid((128, 128), 128.0), 4.0)
            deviations.append((law.exponent - 2.0 - 2.0 * hurst) / law.exponent_std)
        assert abs(np.mean(deviations)) < 1.0
        assert np.sqrt(np.mean(np.square(deviations))) < 1.6

    def test_a_law_has_the_power_and_the_direction_of_the_map(self):
        surface = rc.SelfAffineSurface(
            hurst=0.8, rms_slope=0.1, shortest=2.0, longest=128.0, peklenik=4.0, lay=0.5, seed=1
        )
        grid = rc.Grid((128, 128), 128.0)
        heights = surface.heights(grid)
        law = fit_power_law(heights, grid, 4.0)
        q = 2.0 * np.pi * np.fft.fftfreq(128)
        qx, qy = q[:, np.newaxis], q[np.newaxis, :]
        power, radius = np.abs(np.fft.fft2(heights, norm="forward")) ** 2, np.hypot(qx, qy)
        band = (radius > np.pi / 4) & (radius < np.pi / 2)
        across = np.abs(np.cos(np.arctan2(qy, qx) - 0.5)) < 0.3
        for part, ratio in ((band, 0.2), (band & across, 0.2), (band & ~across, 0.8)):
            assert law.evaluate(qx, qy)[part].sum() == pytest.approx(power[part].sum(), rel=ratio)
        assert law.evaluate(qx, qy)[0, 0] == 0.0


def continued(surface, shortest, index=0, finest=0.5e-6):
    return Continuation(shortest, finest, None, (0, index), 0.0).extend(surface)


class TestBeyondResolution:
    @pytest.mark.parametrize("periodic", [True, False])
    def test_long_waves_are_kept(self, periodic):
        surface = attrs.evolve(ROUGH, shortest=5e-6, longest=64e-6, rolloff=32e-6)
        grid = rc.Grid((64, 64), 64e-6)
        tilt = 0.0 if periodic else 0.01 * grid.x - 0.02 * grid.y + 50.0 * grid.x**2
        source = rc.HeightMap(surface.heights(grid) + tilt, size=64e-6, periodic=periodic)
        fine = continued(source, 1e-6)
        assert fine.grid.shape == (256, 256)
        x, y = fine.grid.x, fine.grid.y
        true = surface.heights(fine.grid) + (0.0 if periodic else 0.01 * x - 0.02 * y + 50.0 * x**2)
        added = fine.values - true
        inside = slice(None) if periodic else slice(16, -16)
        spectrum = np.fft.fft2(added[inside, inside], norm="forward")
        k = np.abs(np.fft.fftfreq(len(spectrum), 0.25e-6))
        long = np.hypot(k[:, np.newaxis], k) < 1 / 8e-6
        rms = np.std(surface.heights(grid))
        if periodic:
            assert np.abs(spectrum[long]).max() < 1e-12 * rms
        # The waves between 5 and 4 um are drawn, and those below; they are small.
        assert np.sqrt(np.mean(added[inside, inside] ** 2)) < 0.1 * rms

    def test_shorter_waves_only_add(self):
        source = rc.HeightMap(ROUGH.heights(GRID), size=GRID.size, periodic=True)
        coarse, fine = (continued(source, shortest) for shortest in (1e-6, 0.5e-6))
        spectra = [np.fft.fft2(one.values, norm="forward") for one in (coarse, fine)]
        # By the centre of the domain, in waves that both hold.
        k = np.arange(-120, 121)
        waves = [one[np.ix_(k, k)] * np.exp(-1j * np.pi * (k[:, None] + k) * (1.0 / len(one) - 1.0)) for one in spectra]
        inside = np.hypot(k[:, None], k) < 120
        np.testing.assert_allclose(waves[1][inside], waves[0][inside], atol=1e-12 * np.abs(waves[0]).max())
        assert np.std(fine.values - continued(source, 0.5e-6, 1).values) > 0.0

    def test_maps_are_found_wherever_they_are(self):
        one, two = crop(64), crop(96)
        total = rc.SphereSurface(1e-3) + one + rc.PlacedMap(two)
        assert find_maps(total) == (one, two)
        extended = continued(total, 1e-6)
        assert [found.grid.shape for found in find_maps(extended)] == [(256, 256), (384, 384)]
        assert extended.parts[0] == rc.SphereSurface(1e-3)


@pytest.mark.parametrize("shape", [(12, 9), (24, 18), (36, 9), (30, 7)])
@pytest.mark.parametrize("holes", [False, True])
def test_a_form_is_the_same_polynomial_on_other_cells(shape, holes):
    """Through the centres of 12 x 9 cells, at those of others on the same domain."""

    def exact(nx, ny):
        x, y = ((np.arange(n) + 0.5) / n for n in (nx, ny))
        return 3.0 + 2.0 * x[:, np.newaxis] - 5.0 * x[:, np.newaxis] ** 2 * y + 4.0 * y**2

    heights = exact(12, 9)
    missing = None
    if holes:
        missing = np.random.default_rng(1).random(heights.shape) < 0.2
        heights = np.where(missing, 1e3, heights)
    np.testing.assert_allclose(polynomial(heights, 3, missing, shape), exact(*shape), rtol=1e-10)
    if shape == (12, 9):
        np.testing.assert_allclose(polynomial(heights, 3, missing), exact(12, 9), rtol=1e-10)
