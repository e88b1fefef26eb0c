"""What figures draw: edges, profiles, correlation and spectrum."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import pyplot

import roughcontact as rc
from roughcontact._answers.areas.estimators import edge_law
from roughcontact._faces.panels.solution import find_surfaces
from roughcontact._faces.panels.surfaces import correlate, spectral_density
from test_plotting import PLANE, ball


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    pyplot.close("all")


class TestEdges:
    def test_the_law_of_the_edge_is_that_of_hertz(self):
        solution = ball()
        theory = rc.reference.hertz_sphere(solution.force, 1e-3, solution.modulus)
        slope = 2.0 * np.pi * theory.semi_axes[0] ** 2 / theory.p_max**2 / solution.grid.area
        assert edge_law(solution) == pytest.approx(slope, rel=0.03)


class TestProfile:
    def test_the_softer_body_is_flattened(self):
        lower, upper = find_surfaces(ball(hardness=1e9))
        assert np.ptp(upper) == pytest.approx(0.0, abs=1e-6 * np.ptp(lower))


class TestSurfaces:
    def test_the_spectrum_holds_the_mean_square_height(self):
        heights = 1e-6 * np.random.default_rng(3).standard_normal(PLANE.shape)
        density = spectral_density(rc.plotting.SampledSurface(heights, PLANE, True))[2]
        cell = (2 * np.pi) ** 2 / PLANE.area
        assert density.sum() * cell / (4 * np.pi**2) == pytest.approx(heights.var(), rel=1e-12)
        windowed = spectral_density(rc.plotting.SampledSurface(heights, PLANE, False))[2]
        assert windowed.sum() * cell / (4 * np.pi**2) == pytest.approx(heights.var(), rel=0.2)

    def test_the_autocorrelation_of_a_wave_is_a_cosine(self):
        x = np.arange(64)
        heights = np.broadcast_to(np.cos(2 * np.pi * x / 8)[:, np.newaxis], (64, 48))
        expected = np.cos(2 * np.pi * np.arange(33) / 8)
        np.testing.assert_allclose(correlate(heights, True)[:, 0], expected, atol=1e-12)
        gappy = np.where(np.random.default_rng(0).random((64, 48)) < 0.1, np.nan, heights)
        np.testing.assert_allclose(correlate(gappy, False)[:9, 0], expected[:9], atol=0.1)
