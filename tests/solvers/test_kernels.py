from __future__ import annotations

import re

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc
from extended_precision import love_by_mpmath
from roughcontact.typing import BoundKernel
from strategies import aspects


@pytest.mark.parametrize("spacing", [(2e-6, 2e-6), (1e-6, 1e-3), (1e-3, 1e-6), (1.0, 1e-8), (1e-8, 1.0)])
def test_coefficients_are_loves_solution_in_si(spacing):
    compliance = 3e-12
    values = rc.Love().coefficients((5, 7), spacing, compliance)
    for i, j in np.ndindex(5, 7):
        exact = love_by_mpmath(i, j, *spacing) * compliance / mp.pi
        assert abs(values[i, j] / exact - 1) < 1e-13


class Halved(rc.InfluenceKernel):
    """A kernel that gives its coefficients from the first row on alone."""

    def coefficients(self, shape, spacing, compliance):
        return 0.5 * rc.Love().coefficients(shape, spacing, compliance)


@pytest.mark.parametrize("spacing", [(1.0, 1.0), (1.0, 3.0), (3.0, 1.0), (1e3, 1.0), (1.0, 1e3)])
@pytest.mark.parametrize("first", [1, 10, 110, 200])
def test_coefficients_from_a_row_on_are_those_of_the_whole(spacing, first):
    for kernel in (rc.Love(), Halved()):
        bound = BoundKernel(kernel)
        whole = bound.coefficients((260, 130), spacing)
        np.testing.assert_array_equal(bound.coefficients((60, 130), spacing, first), whole[first : first + 60])


def test_far_from_the_cell_its_load_acts_like_a_point():
    values = rc.Love().coefficients((2001, 1), (1e-6, 1e-6), 1.0)
    distance = 2000e-6
    assert values[2000, 0] == pytest.approx(1e-12 / (np.pi * distance), rel=1e-6)


@given(aspects, st.integers(2, 40))
def test_coefficients_are_positive_and_fall_with_distance(aspect, count):
    values = rc.Love().coefficients((count, count), (1.0, aspect), 1.0)
    assert values.min() > 0
    assert np.diff(values, axis=0).max() < 0
    assert np.diff(values, axis=1).max() < 0


@given(aspects, st.integers(2, 12), st.integers(2, 12))
def test_turning_the_cells_turns_the_coefficients(aspect, nx, ny):
    upright = rc.Love().coefficients((nx, ny), (1.0, aspect), 1.0)
    turned = rc.Love().coefficients((ny, nx), (aspect, 1.0), 1.0)
    np.testing.assert_allclose(upright, turned.T, rtol=1e-14)


@pytest.mark.parametrize("aspect", [2e8, 1e-9, 1e30])
@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_longer_cells_are_refused(aspect, boundary):
    surface = rc.HeightMap(np.eye(4), size=(1.0, aspect))
    with pytest.raises(rc.InputError, match="at most 1e\\+08 times as long as wide"):
        rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.3)), boundary=boundary)


def plain_alias_sum(theta_x, theta_y, dx, dy, count):
    """The defining sum, summed over squares of 2 count + 1 aliases a side, smoothed by averaging squares."""
    orders = np.arange(-count, count + 1)
    x, y = (t + 2 * np.pi * orders for t in (theta_x, theta_y))
    terms = np.sinc(x / 2 / np.pi)[:, None] * np.sinc(y / 2 / np.pi)[None, :]
    terms = terms / np.hypot(x[:, None] / dx, y[None, :] / dy)
    taper = np.clip((count + 1 - np.abs(orders)) / (count / 2), 0, 1)
    smooth = taper**2 * (3 - 2 * taper)
    return 2 * np.sum(terms * smooth[:, None] * smooth[None, :])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("aspect", "count"), [(1e-8, 600), (0.01, 400), (0.5, 400), (1.0, 400), (1.3, 400), (40.0, 400), (1e12, 600)]
)
def test_spectrum_is_the_alias_sum(aspect, count):
    theta = np.array([0.02, 0.7, 2.0, 3.0, np.pi])
    dx, dy = aspect, 1.0
    values = rc.Love().spectrum(theta[:, None] / dx, theta[None, :] / dy, (dx, dy), 1.0)
    for i, j in np.ndindex(5, 5):
        assert values[i, j] == pytest.approx(plain_alias_sum(theta[i], theta[j], dx, dy, count), rel=1e-12)


def test_periodised_love_is_the_sum_over_all_images():
    """Tiles of the domain around it, convolved freely, become the periodic surface as they grow in number."""
    shape, spacing = (6, 4), (1.0, 1.4)
    pressure = np.random.default_rng(0).random(shape)
    # Without mean and first moments the distant images decay fast enough.
    pressure += pressure[::-1] + pressure[:, ::-1] + pressure[::-1, ::-1]
    pressure -= pressure.mean()
    kernel = BoundKernel(rc.Love())

    def tiled(images):
        count = 2 * images + 1
        cells = (count * shape[0], count * shape[1])
        grid = rc.Grid(cells, (cells[0] * spacing[0], cells[1] * spacing[1]))
        free = rc.DCFFT().prepare(kernel, grid, rc.Boundary.FREE).apply(np.tile(pressure, (count, count)))
        middle = free[images * shape[0] :, images * shape[1] :][: shape[0], : shape[1]]
        return middle - middle.mean()

    grid = rc.Grid(shape, (shape[0] * spacing[0], shape[1] * spacing[1]))
    periodic = rc.CircularFFT().prepare(kernel, grid, rc.Boundary.PERIODIC).apply(pressure)
    coarse, fine = tiled(20), tiled(40)
    far = (40.5 / 20.5) ** 3
    np.testing.assert_allclose(fine + (fine - coarse) / (far - 1), periodic, rtol=0, atol=1e-8 * np.abs(periodic).max())
    assert np.abs(fine - periodic).max() > 1e-8 * np.abs(periodic).max()


@given(aspects)
def test_both_kernels_agree_on_long_waves(aspect):
    q = np.array([[1e-3]])
    love = rc.Love().spectrum(q, 0.5 * q, (1.0, aspect), 1.0)
    fourier = rc.FourierHalfSpace().spectrum(q, 0.5 * q, (1.0, aspect), 1.0)
    np.testing.assert_allclose(love, fourier, rtol=1e-5)


@given(aspects, st.integers(2, 30), st.integers(2, 30))
def test_loves_spectrum_is_positive_on_nearly_square_cells(aspect, nx, ny):
    qx, qy = np.pi * np.linspace(0.01, 1, nx)[:, None], np.pi / aspect * np.linspace(0.01, 1, ny)[None, :]
    assert rc.Love().spectrum(qx, qy, (1.0, aspect), 1.0).min() > 0


def test_the_mean_pressure_moves_no_periodic_surface():
    grid = rc.Grid((8, 6), (1.0, 1.0))
    for kernel in (rc.Love(), rc.FourierHalfSpace()):
        convolution = rc.CircularFFT().prepare(BoundKernel(kernel), grid, rc.Boundary.PERIODIC)
        assert np.abs(convolution.apply(np.ones(grid.shape))).max() < 1e-15


class Neither(rc.InfluenceKernel):
    pass


class Broken(rc.InfluenceKernel):
    def __init__(self, values):
        self.values = values

    def coefficients(self, shape, spacing, compliance):
        return self.values(shape)


@pytest.mark.parametrize(
    ("kernel", "boundary", "sentence"),
    [
        (Neither(), "free", "has no real-space coefficients"),
        (Neither(), "periodic", "has no spectrum"),
        (rc.FourierHalfSpace(), "free", "use boundary='periodic'"),
        (Broken(lambda shape: np.full(shape, np.nan)), "free", "not finite"),
        (Broken(lambda shape: np.ones((2, 2))), "free", "shape (2, 2)"),
        (Broken(lambda shape: np.ones(shape, dtype=int)), "wrapped", "real numbers"),
    ],
)
def test_unfit_kernels_are_refused_in_words(kernel, boundary, sentence):
    wave = rc.WavySurface(1e-6, 1e-3)
    body, grid = rc.Body(wave, rc.Elastic(1e9, 0.3)), rc.Grid((8, 9), 1e-3)
    with pytest.raises(rc.InputError, match=re.escape(sentence)):
        rc.ContactProblem(body, grid=grid, boundary=boundary, kernel=kernel).solve(pressure=1e3)


@pytest.mark.parametrize(
    ("kernel", "boundary"), [(rc.FourierHalfSpace(), "free"), ("fourier", "wrapped"), (Broken(np.ones), "periodic")]
)
def test_a_plan_that_cannot_run_is_refused_at_construction(kernel, boundary):
    body = rc.Body(rc.WavySurface(1e-6, 1e-3), rc.Elastic(1e9, 0.3))
    with pytest.raises(rc.InputError, match="or another kernel"):
        rc.ContactProblem(body, grid=rc.Grid((8, 9), 1e-3), boundary=boundary, kernel=kernel)
