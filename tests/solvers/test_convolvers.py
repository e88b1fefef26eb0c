from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.typing import BoundKernel, ConvolutionSetup, PreparedConvolution
from strategies import grids, pressures, seeds

KERNEL = BoundKernel(rc.Love())
PAIRS = [
    (rc.DCFFT(), rc.Boundary.FREE),
    (rc.CircularFFT(), rc.Boundary.PERIODIC),
    (rc.CircularFFT(), rc.Boundary.WRAPPED),
    (rc.Direct(), rc.Boundary.FREE),
    (rc.Direct(), rc.Boundary.WRAPPED),
]


@given(st.data(), grids())
def test_fft_and_direct_sum_agree_on_a_free_boundary(data, grid):
    pressure = data.draw(pressures(grid.shape))
    direct = rc.Direct().prepare(KERNEL, grid, rc.Boundary.FREE).apply(pressure)
    fast = rc.DCFFT().prepare(KERNEL, grid, rc.Boundary.FREE).apply(pressure)
    np.testing.assert_allclose(fast, direct, rtol=0, atol=1e-13 * max(direct.max(), 1e-300))


@given(st.data(), grids())
def test_fft_and_direct_sum_agree_on_a_wrapped_boundary(data, grid):
    pressure = data.draw(pressures(grid.shape))
    direct = rc.Direct().prepare(KERNEL, grid, rc.Boundary.WRAPPED).apply(pressure)
    fast = rc.CircularFFT().prepare(KERNEL, grid, rc.Boundary.WRAPPED).apply(pressure)
    np.testing.assert_allclose(fast, direct, rtol=0, atol=1e-13 * max(direct.max(), 1e-300))


def test_more_columns_than_one_block():
    grid = rc.Grid((21, 150), (21.0, 150.0))
    pressure = np.random.default_rng(0).random(grid.shape)
    direct = rc.Direct().prepare(KERNEL, grid, rc.Boundary.FREE).apply(pressure)
    fast = rc.DCFFT().prepare(KERNEL, grid, rc.Boundary.FREE).apply(pressure)
    np.testing.assert_allclose(fast, direct, rtol=1e-13)


@pytest.mark.parametrize(("convolver", "boundary"), PAIRS)
@given(grid=grids(12), seed=seeds)
def test_linear(convolver, boundary, grid, seed):
    one, other = np.random.default_rng(seed).standard_normal((2, *grid.shape))
    convolution = convolver.prepare(KERNEL, grid, boundary)
    apart = 2.5 * convolution.apply(one) - 0.3 * convolution.apply(other)
    together = convolution.apply(2.5 * one - 0.3 * other)
    np.testing.assert_allclose(together, apart, rtol=0, atol=1e-13 * (np.abs(apart).max() + 1e-300))


@pytest.mark.parametrize(("convolver", "boundary"), PAIRS)
@given(grid=grids(12), seed=seeds)
def test_reciprocal(convolver, boundary, grid, seed):
    """The work of one pressure on the displacement of another is mutual (Betti)."""
    one, other = np.random.default_rng(seed).random((2, *grid.shape))
    convolution = convolver.prepare(KERNEL, grid, boundary)
    there, back = convolution.dot(one, convolution.apply(other)), convolution.dot(other, convolution.apply(one))
    scale = np.abs(convolution.apply(one)).sum()
    assert abs(there - back) <= 1e-13 * scale


@pytest.mark.parametrize(("convolver", "boundary"), PAIRS)
@given(grid=grids(12), seed=seeds)
def test_pressure_does_positive_work(convolver, boundary, grid, seed):
    pressure = np.random.default_rng(seed).standard_normal(grid.shape)
    # Wrapping loses the positivity of waves that are longer than the domain.
    if boundary is rc.Boundary.WRAPPED:
        pressure = np.abs(pressure)
    convolution = convolver.prepare(KERNEL, grid, boundary)
    displacement = convolution.apply(pressure)
    assert convolution.dot(pressure, displacement) >= -1e-13 * np.abs(displacement).max() * np.abs(pressure).sum()


@given(st.data(), grids(16))
def test_free_displacement_is_positive_under_positive_pressure(data, grid):
    pressure = data.draw(pressures(grid.shape))
    pressure.flat[0] = 1.0
    assert rc.DCFFT().prepare(KERNEL, grid, rc.Boundary.FREE).apply(pressure).min() > 0


@pytest.mark.parametrize("boundary", [rc.Boundary.PERIODIC, rc.Boundary.WRAPPED])
@given(grid=grids(16), seed=seeds, shift=st.tuples(st.integers(0, 15), st.integers(0, 15)))
def test_circular_convolution_moves_with_the_pressure(boundary, grid, seed, shift):
    pressure = np.random.default_rng(seed).random(grid.shape)
    convolution = rc.CircularFFT().prepare(KERNEL, grid, boundary)
    here = np.roll(convolution.apply(pressure), shift, axis=(0, 1))
    there = convolution.apply(np.roll(pressure, shift, axis=(0, 1)))
    np.testing.assert_allclose(there, here, rtol=0, atol=1e-13 * np.abs(here).max() + 1e-300)


def test_free_convolution_moves_with_the_pressure():
    grid = rc.Grid((20, 24), (1.0, 1.0))
    convolution = rc.DCFFT().prepare(KERNEL, grid, rc.Boundary.FREE)
    one, other = np.zeros((2, *grid.shape))
    one[3:6, 4:9] = other[10:13, 12:17] = 1.0
    np.testing.assert_allclose(convolution.apply(one)[:13, :16], convolution.apply(other)[7:, 8:], rtol=1e-13)


@pytest.mark.parametrize(("convolver", "boundary"), PAIRS)
def test_the_pressure_is_left_as_it_was(convolver, boundary):
    grid = rc.Grid((9, 8), (1.0, 1.0))
    pressure = np.random.default_rng(0).random(grid.shape)
    kept = pressure.copy()
    convolver.prepare(KERNEL, grid, boundary).apply(pressure)
    np.testing.assert_array_equal(pressure, kept)


def test_padding_is_at_least_twice_less_one_and_fast():
    for n in (2, 3, 17, 64, 100, 1021):
        mx, my = rc.DCFFT().transform_shape(rc.Grid((n, 2), 1.0), rc.Boundary.FREE)
        assert mx >= 2 * n - 1
        assert my >= 3
        assert max(p for p in range(2, mx + 1) if mx % p == 0 and all(p % d for d in range(2, p))) <= 5


@pytest.mark.parametrize(
    ("convolver", "boundary"), [("dc-fft", "periodic"), ("circular-fft", "free"), ("direct", "periodic")]
)
def test_a_convolver_that_does_not_serve_the_boundary_is_refused(convolver, boundary):
    body = rc.Body(rc.WavySurface(1e-6, 1e-3), rc.Elastic(1e9, 0.3))
    with pytest.raises(rc.InputError, match="serves the boundary"):
        rc.ContactProblem(body, grid=rc.Grid((8, 8), 1e-3), boundary=boundary, convolver=convolver)


@pytest.mark.parametrize(("convolver", "boundary"), PAIRS)
@given(grid=grids(8), seed=seeds)
def test_a_convolution_is_the_sum_of_responses_at_all_offsets(convolver, boundary, grid, seed):
    pressure, table = np.random.default_rng(seed).random(grid.shape), KERNEL.responses(grid, boundary)
    i, j = (np.abs(np.arange(n)[:, None] - np.arange(n)) for n in grid.shape)
    if boundary is not rc.Boundary.FREE:
        i, j = (np.minimum(offset, len(offset) - offset) for offset in (i, j))
    exact = np.einsum("ikjl,kl->ij", table[i[:, :, None, None], j[None, None, :, :]], pressure)
    displacement = convolver.prepare(KERNEL, grid, boundary).apply(pressure)
    np.testing.assert_allclose(displacement, exact, rtol=0, atol=1e-13 * np.abs(table).sum() * pressure.max())


@pytest.mark.parametrize("convolver", [rc.DCFFT(), rc.CircularFFT(), rc.Direct()])
@pytest.mark.parametrize("boundary", list(rc.Boundary))
def test_the_setup_refuses_a_boundary_that_is_not_served(convolver, boundary):
    grid = rc.Grid((4, 6), 1.0)
    if boundary in convolver.boundaries:
        setup = convolver.prepare(KERNEL, grid, boundary).setup
        assert setup == ConvolutionSetup(convolver, KERNEL, grid, boundary)
        assert min(convolver.transform_shape(grid, boundary)) >= 4
    else:
        with pytest.raises(rc.InputError, match="serves the boundary"):
            convolver.prepare(KERNEL, grid, boundary)


def test_a_convolver_needs_its_boundaries_and_how_it_prepares_and_a_convolution_how_it_is_applied():
    assert rc.Convolver.__abstractmethods__ == {"boundaries", "prepare"}
    assert PreparedConvolution.__abstractmethods__ == {"setup", "apply"}
