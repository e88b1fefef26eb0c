"""Kernels whose contact modulus depends on the wave number."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import roughcontact as rc


@attrs.frozen
class StifferHalfSpace(rc.InfluenceKernel):
    """A half-space of twice the modulus of the materials."""

    factor: float = 2.0

    def coefficients(self, shape, spacing, compliance):
        return rc.Love().coefficients(shape, spacing, 0.5 * compliance)

    def effective_modulus(self, wavenumber, compliance):
        return np.full(wavenumber.shape, self.factor / compliance)


@attrs.frozen
class Wavy(rc.InfluenceKernel):
    """A modulus that depends on the wave number, in 1/m."""

    def coefficients(self, shape, spacing, compliance):
        return rc.Love().coefficients(shape, spacing, compliance)

    def effective_modulus(self, wavenumber, compliance):
        return (1.0 + 1e-6 * wavenumber) / compliance


def sphere(kernel, young):
    body = rc.Body(rc.ParaboloidSurface(radius=1e-3), rc.Elastic(young, 0.3))
    return rc.ContactProblem(body, grid=rc.Grid((48, 48), (6e-5, 6e-5)), kernel=kernel).solve(force=0.03)


@pytest.mark.parametrize("estimator", ["blend", "hertz", "level-set"])
def test_estimators_use_the_modulus_of_the_kernel(estimator):
    stiffer, plain = sphere(StifferHalfSpace(), 1e9), sphere("love", 2e9)
    assert stiffer.area(estimator).value == pytest.approx(plain.area(estimator).value, rel=1e-6)
    assert stiffer.area(estimator).uncertainty == pytest.approx(plain.area(estimator).uncertainty, rel=1e-6)


def test_the_solution_has_the_modulus_of_the_kernel_at_each_wave_number():
    q = np.geomspace(2e4, 5e6, 20)
    np.testing.assert_allclose(sphere(Wavy(), 1e9).effective_modulus(q), (1.0 + 1e-6 * q) * 1e9 / 0.91, rtol=1e-3)


def test_a_half_space_has_one_modulus():
    assert rc.Love().effective_modulus(np.ones(3), 1.0) is None
    solution = sphere("love", 1e9)
    assert solution.moduli is None
    np.testing.assert_array_equal(solution.effective_modulus(np.array([1.0, 1e6])), solution.modulus)


def test_a_file_keeps_the_moduli(tmp_path):
    solution = sphere(StifferHalfSpace(), 1e9)
    with pytest.warns(UserWarning, match="must be registered"):
        solution.save(tmp_path / "stiffer.npz")
    loaded = rc.ContactSolution.load(tmp_path / "stiffer.npz", verify=False)
    assert loaded.moduli == solution.moduli
    assert loaded.effective_modulus(1e6) == pytest.approx(2e9 / 0.91)


def test_moduli_must_be_above_zero():
    with pytest.raises(rc.InputError, match="moduli above zero"):
        sphere(StifferHalfSpace(factor=-1.0), 1e9)
