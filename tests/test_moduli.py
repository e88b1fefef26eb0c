"""Kernels whose modulus depends on the length of the waves."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import roughcontact as rc


@attrs.frozen
class TwiceAsStiff(rc.InfluenceKernel):
    """A half-space of twice the modulus that the materials tell."""

    told: float = 2.0

    def coefficients(self, shape, spacing, compliance):
        return rc.Love().coefficients(shape, spacing, 0.5 * compliance)

    def modulus_at(self, length, compliance):
        return np.full(length.shape, self.told / compliance)


def sphere(kernel, young):
    body = rc.Body(rc.ParaboloidSurface(radius=1e-3), rc.Elastic(young, 0.3))
    return rc.ContactProblem(body, grid=rc.Grid((48, 48), (6e-5, 6e-5)), kernel=kernel).solve(force=0.03)


@pytest.mark.parametrize("estimator", ["blend", "hertz", "level-set"])
def test_estimators_read_the_modulus_that_the_kernel_tells(estimator):
    told, plain = sphere(TwiceAsStiff(), 1e9), sphere("love", 2e9)
    assert told.area(estimator).value == pytest.approx(plain.area(estimator).value, rel=1e-6)
    assert told.area(estimator).uncertainty == pytest.approx(plain.area(estimator).uncertainty, rel=1e-6)


def test_a_file_keeps_the_moduli(tmp_path):
    solution = sphere(TwiceAsStiff(), 1e9)
    solution.save(tmp_path / "told.npz")
    again = rc.ContactSolution.load(tmp_path / "told.npz")
    assert again.moduli == solution.moduli
    assert again.modulus_at(1e-6) == pytest.approx(2e9 / 0.91)
    assert sphere("love", 1e9).modulus_at(1e-6) == pytest.approx(1e9 / 0.91)


def test_moduli_must_be_above_zero():
    with pytest.raises(rc.InputError, match="moduli above zero"):
        sphere(TwiceAsStiff(told=-1.0), 1e9)
