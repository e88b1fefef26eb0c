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


@attrs.frozen
class BondedLayer(rc.InfluenceKernel):
    """A layer of this thickness, m, and nu = 0.3, bonded to a rigid base."""

    thickness: float

    def spectrum(self, qx, qy, spacing, compliance):
        q, k = np.hypot(qx, qy), 3.0 - 4.0 * 0.3
        depth = q * self.thickness
        # The hyperbolic functions over cosh(2 depth), which would overflow.
        decay = np.exp(-2.0 * depth)
        sinh, inverse = (1.0 - decay**2) / (1.0 + decay**2), 2.0 * decay / (1.0 + decay**2)
        shape = (2.0 * k * sinh - 4.0 * depth * inverse) / (2.0 * k + (4.0 * depth**2 + 1.0 + k**2) * inverse)
        return 2.0 * compliance / q * shape


class HalfSpaceBySpectrum(rc.InfluenceKernel):
    """A homogeneous half-space that says nothing of its modulus."""

    def spectrum(self, qx, qy, spacing, compliance):
        return rc.Love().spectrum(qx, qy, spacing, compliance)


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


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan, np.inf])
def test_moduli_that_cannot_be_are_refused(factor):
    with pytest.raises(rc.InputError, match="must return moduli above zero"):
        sphere(StifferHalfSpace(factor), 1e9)


def test_moduli_follow_from_the_spectrum():
    layer, q = BondedLayer(1e-3), np.geomspace(1e2, 1e6, 9)
    amplitudes = layer.spectrum(q, 0.0, (1e-9, 1e-9), 0.5)
    np.testing.assert_allclose(layer.effective_modulus(q, 0.5) * q * amplitudes, 2.0)
    assert HalfSpaceBySpectrum().effective_modulus(q, 0.5) is None
    assert layer.effective_modulus(q, 0.5)[0] > 40.0
    assert layer.effective_modulus(q, 0.5)[-1] == pytest.approx(2.0, rel=1e-9)


@pytest.mark.parametrize(("cells", "size"), [((64, 64), (1.0, 1.0)), ((96, 32), (1.5, 0.5)), ((45, 15), (0.5, 1.5))])
def test_area_on_a_bonded_layer_whose_kernel_says_nothing_of_its_modulus(cells, size):
    surface = rc.ParaboloidSurface(radius=50.0, center=(0.013, -0.021))

    def press(finer):
        grid = rc.Grid((finer * cells[0], finer * cells[1]), size)
        problem = rc.ContactProblem(
            rc.Body(surface, rc.Elastic(1.0, 0.0)), grid=grid, boundary="periodic", kernel=BondedLayer(0.02)
        )
        return problem.solve(force=5e-4).area()

    area, fine = press(1), press(6)
    assert 0.01 < fine.fraction < 0.3
    assert abs(area.value - fine.value) <= 2.0 * np.hypot(area.uncertainty, fine.uncertainty)
    assert area.uncertainty < 0.2 * area.value


def test_a_file_keeps_the_moduli(tmp_path):
    solution = sphere(StifferHalfSpace(), 1e9)
    with pytest.warns(UserWarning, match="must be registered"):
        solution.save(tmp_path / "stiffer.npz")
    loaded = rc.ContactSolution.load(tmp_path / "stiffer.npz", verify=False)
    assert loaded.moduli == solution.moduli
    assert loaded.effective_modulus(1e6) == pytest.approx(2e9 / 0.91)


class StifferAlongX(rc.InfluenceKernel):
    """Waves along x meet twice the modulus of those along y; it says nothing of its modulus."""

    def spectrum(self, qx, qy, spacing, compliance):
        return compliance * (2.0 - qx**2 / (qx**2 + qy**2)) / np.hypot(qx, qy)


def test_a_modulus_that_is_not_stated_is_the_mean_over_the_directions():
    q = np.geomspace(1e3, 1e6, 4)
    np.testing.assert_allclose(StifferAlongX().effective_modulus(q, 0.5), 2.0 / (0.5 * 1.5), rtol=1e-12)


def test_moduli_must_be_above_zero():
    with pytest.raises(rc.InputError, match="moduli above zero"):
        sphere(StifferHalfSpace(factor=-1.0), 1e9)


@attrs.frozen
class Orthotropic(rc.InfluenceKernel):
    """A modulus that depends on the direction, 1/E* = c (1 + part cos 2 angle), of waves without aliases."""

    part: float

    def spectrum(self, qx, qy, spacing, compliance):
        angle = np.arctan2(qy, qx)
        return 2.0 * compliance / np.hypot(qx, qy) * (1.0 + self.part * np.cos(2.0 * angle))

    def effective_modulus(self, wavenumber, compliance):
        return np.full(wavenumber.shape, 1.0 / compliance)

    def directional_modulus(self, angle, compliance):
        return 1.0 / (compliance * (1.0 + self.part * np.cos(2.0 * angle)))


@pytest.mark.parametrize("part", [0.1, 0.5])
def test_areas_follow_the_directions(part):
    coarse, fine = (on_waves(Orthotropic(part), cells) for cells in (32, 128))
    assert len(fine.directional_moduli) == 128
    assert abs(coarse.area().value - fine.area().value) < 3.0 * coarse.area().uncertainty


def test_directional_moduli_are_checked():
    class Zero(Orthotropic):
        def directional_modulus(self, angle, compliance):
            return 0.0 * angle

    with pytest.raises(rc.InputError, match="moduli above zero"):
        on_waves(Zero(0.1), 16)


def on_waves(kernel, cells):
    body = rc.Body(rc.WavySurface(1e-8, 1e-6), rc.Elastic(1e9, 0.3))
    grid = rc.Grid((cells, cells), 1e-6)
    return rc.ContactProblem(body, grid=grid, boundary="periodic", kernel=kernel).solve(pressure=2e6)
