"""The smooth extension of the residual, for kernels that are much stiffer for short waves."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact._solve.convolvers.base import approximate_inverse
from roughcontact._solve.solvers.conjugate.preconditioner import ExtendedInverse, half_space_inverse, is_steep
from roughcontact._solve.solvers.driver import Work
from roughcontact._solve.solvers.passes import active_cells
from roughcontact.typing import InverseConvolution
from test_convolvers import KERNEL


def plate(shape, bending):
    """Return the inverse of a half-space under a plate: stiffness q (1 + (bending q)^3)."""
    qx, qy = 2 * np.pi * np.fft.fftfreq(shape[0]), 2 * np.pi * np.fft.rfftfreq(shape[1])
    q = np.hypot(qx[:, None], qy[None, :])
    return InverseConvolution((q * (1 + (bending * q) ** 3)).astype(np.float32), shape, exact=True)


def columns(function, count):
    return np.stack([function(unit) for unit in np.eye(count, dtype=np.float32)], axis=1)


shapes = st.sampled_from([(12, 10), (9, 12), (11, 7), (8, 8)])


@pytest.mark.slow
@given(shapes, st.floats(0.2, 3.0), st.floats(0.1, 0.9), st.integers(0, 99))
def test_the_extended_inverse_is_symmetric_and_never_falls_below_the_energy_of_the_solution(shape, bending, part, seed):
    """By the principle of minimum energy: outside the contact the true displacement has the minimum energy."""
    inverse = plate(shape, bending)
    mask = np.random.default_rng(seed).random(shape[0] * shape[1]) < part
    mask[:2] = True, False
    active = active_cells(mask, mask.__getitem__)
    cells = np.flatnonzero(mask)
    extended = ExtendedInverse(inverse, shape, Work())
    extended.update(active)
    image = columns(lambda unit: extended.apply(active, active.gather(unit)), mask.size)
    image = image[cells] if image.shape[0] == mask.size else image
    image = image[:, cells].astype(np.float64)
    full = columns(lambda unit: inverse.apply(unit.reshape(shape)).ravel(), mask.size).astype(np.float64)
    inside, across, outside = full[np.ix_(mask, mask)], full[np.ix_(mask, ~mask)], full[np.ix_(~mask, ~mask)]
    exact = inside - across @ np.linalg.pinv(outside, rcond=1e-6) @ across.T
    scale = np.abs(image).max()
    assert np.allclose(image, image.T, atol=1e-5 * scale)
    assert np.linalg.eigvalsh(image - exact)[0] > -1e-4 * scale


def test_a_uniform_displacement_of_a_dense_contact_needs_hardly_any_pressure():
    shape = (32, 32)
    inverse = plate(shape, 2.0)
    mask = np.random.default_rng(1).random(32 * 32) < 0.5
    active = active_cells(mask, mask.__getitem__)
    extended = ExtendedInverse(inverse, shape, Work())
    extended.update(active)
    largest = float(np.abs(inverse.apply(mask.astype(np.float32).reshape(shape))).max())
    assert float(np.abs(extended.apply(active, active.ones)).max()) < 0.1 * largest


@pytest.mark.parametrize("shape", [(32, 32), (64, 33), (17, 128)])
@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_no_half_space_is_steep_and_its_weights_are_above_zero(boundary, shape):
    grid = rc.Grid(shape, (1.0, 2.0))
    problem = rc.ContactProblem(rc.Body(rc.WavySurface(0.01, 0.5), rc.Elastic(1.0, 0.3)), grid=grid, boundary=boundary)
    inverse = approximate_inverse(problem.convolution.setup)
    assert not is_steep(inverse)
    weights = half_space_inverse(inverse, grid.spacing)
    assert weights.stiffness[0, 1] == pytest.approx(inverse.stiffness[0, 1])
    assert weights.coefficients(0).item() > 0.0


@pytest.mark.parametrize("bending", [0.0, 0.3, 1.0, 4.0])
def test_steep_is_what_a_plate_stiffens_for_waves_of_a_some_cells(bending):
    assert is_steep(plate((64, 48), bending)) == (bending >= 1.0)


def test_the_convolution_and_its_inverse_share_one_spectrum(monkeypatch):
    calls = []
    monkeypatch.setattr(
        rc.Love, "spectrum", lambda self, *given, _spectrum=rc.Love.spectrum: calls.append(1) or _spectrum(self, *given)
    )
    convolution = rc.CircularFFT().prepare(KERNEL, rc.Grid((24, 20), (24.0, 20.0)), rc.Boundary.PERIODIC)
    inverse = approximate_inverse(convolution.setup)
    assert len(calls) == 1
    wave = np.cos(2 * np.pi * np.arange(24) / 8)[:, np.newaxis] * np.ones(20)
    np.testing.assert_allclose(inverse.apply(convolution.apply(wave)), wave, atol=1e-12)
    again = pickle.loads(pickle.dumps(convolution))
    np.testing.assert_array_equal(again.apply(wave), convolution.apply(wave))
