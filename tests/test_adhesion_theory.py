from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import integrate, optimize

import roughcontact as rc
from roughcontact.reference import (
    DmtSphere,
    JkrSphere,
    JohnsonWave,
    MaugisSphere,
    full_contact_energies,
    hertz_sphere,
    stickiness,
    tabor_parameter,
)

R, W, E = 1e-6, 0.05, 1e9


def maugis(parameter):
    strength = 0.5 * parameter * (math.pi * W * (4 * E / 3) ** 2 / R) ** (1 / 3)
    return MaugisSphere(R, W, E, strength)


class TestBall:
    @pytest.mark.parametrize(
        ("parameter", "pull_off"),
        [(0.1, 1.9506), (0.25, 1.8468), (0.5, 1.7182), (1, 1.6007), (2, 1.5346), (3, 1.5168), (5, 1.5063)],
    )
    def test_pull_off_of_maugis_goes_from_dmt_to_jkr(self, parameter, pull_off):
        ball = maugis(parameter)
        assert ball.parameter == pytest.approx(parameter, rel=1e-12)
        assert -ball.pull_off / (math.pi * W * R) == pytest.approx(pull_off, abs=5e-5)

    def test_maugis_satisfies_his_equations(self):
        # The gap at the end of the tension, by the integral of Sneddon's solution, is the work over the strength.
        ball = maugis(1.0)
        a = 1.2 * (0.75 * math.pi * W * R**2 / E) ** (1 / 3)
        m = float(ball.tension_radius(np.array(a))) / a
        punch = a * a * (math.sqrt(m * m - 1) + (m * m - 2) * math.acos(1 / m)) / (math.pi * R)
        pull = 4 * ball.strength * a * (math.sqrt(m * m - 1) * math.acos(1 / m) - m + 1) / (math.pi * E)
        assert (punch + pull) * ball.strength == pytest.approx(W, rel=1e-9)

    def test_limits(self):
        jkr, dmt = JkrSphere(R, W, E), DmtSphere(R, W, E)
        soft, hard = maugis(300.0), maugis(1e-3)
        assert soft.pull_off == pytest.approx(jkr.pull_off, rel=1e-3)
        assert soft.zero_load_radius == pytest.approx(jkr.zero_load_radius, rel=1e-3)
        assert hard.pull_off == pytest.approx(dmt.pull_off, rel=1e-3)
        assert hard.zero_load_radius == pytest.approx(dmt.zero_load_radius, rel=1e-3)
        a = np.array([0.7, 1.0, 1.5]) * jkr.zero_load_radius
        np.testing.assert_allclose(soft.force(a), jkr.force(a), atol=5e-3 * abs(jkr.pull_off))
        np.testing.assert_allclose(hard.approach(a), dmt.approach(a), rtol=4e-2)

    def test_radius_without_load_carries_none(self):
        for ball in (JkrSphere(R, W, E), DmtSphere(R, W, E), maugis(0.3), maugis(3.0)):
            force = float(ball.force(np.array(ball.zero_load_radius)))
            assert abs(force) < 1e-8 * abs(ball.pull_off)

    def test_pull_off_is_the_lowest_force(self):
        ball = JkrSphere(R, W, E)
        a = np.linspace(0.01, 2.0, 20001) * ball.zero_load_radius
        assert ball.force(a).min() == pytest.approx(ball.pull_off, rel=1e-6)

    def test_the_energy_that_the_edge_of_jkr_releases_is_the_work_of_adhesion(self):
        # The force below Hertz's acts as on a flat punch, of the compliance 1/(2 E* a).
        ball = JkrSphere(R, W, E)
        a = ball.zero_load_radius
        step = 1e-6 * a
        missing = 4 * E * a**3 / (3 * R) - float(ball.force(np.array(a)))
        softening = 1.0 / (2.0 * E * a) - 1.0 / (2.0 * E * (a + step))
        assert missing**2 / 2 * softening / (2 * math.pi * a * step) == pytest.approx(W, rel=1e-5)

    def test_without_attraction_it_is_hertz(self):
        ball = JkrSphere(R, 1e-12, E)
        a = np.array([1e-7])
        force = float(ball.force(a)[0])
        hertz = hertz_sphere(force, R, E)
        assert hertz.semi_axes[0] == pytest.approx(1e-7, rel=1e-4)
        assert hertz.approach == pytest.approx(float(ball.approach(a)[0]), rel=1e-4)

    def test_tabor_and_maugis_differ_by_a_factor(self):
        ball = maugis(1.0)
        assert tabor_parameter(R, W, W / ball.strength, E) * 2 / (math.pi * 16 / 9) ** (1 / 3) == pytest.approx(
            1.0, rel=1e-12
        )

    def test_wrong_arguments(self):
        for cls in (JkrSphere, DmtSphere):
            with pytest.raises(rc.InputError):
                cls(R, 0.0, E)
        with pytest.raises(rc.InputError):
            MaugisSphere(R, W, E, -1.0)


class TestWave:
    def wave(self, alpha):
        amplitude, wavelength = 1e-6, 1e-4
        work = alpha**2 * math.pi**2 * E * amplitude**2 / (2 * wavelength)
        return JohnsonWave(amplitude, wavelength, work, E)

    @pytest.mark.parametrize(
        ("alpha", "pull_off", "half"), [(0.1, 0.0220, 0.0697), (0.2, 0.0556, 0.1136), (0.3, 0.0959, 0.1546)]
    )
    def test_values(self, alpha, pull_off, half):
        wave = self.wave(alpha)
        assert wave.parameter == pytest.approx(alpha, rel=1e-12)
        assert -wave.pull_off / wave.full_pressure == pytest.approx(pull_off, abs=6e-5)
        assert wave.zero_load_fraction / 2 == pytest.approx(half, abs=6e-5)

    def test_pull_off_is_the_lowest_pressure_of_small_contacts(self):
        wave = self.wave(0.2)
        fractions = np.linspace(1e-6, 0.5, 100001)
        assert wave.pressure(fractions).min() == pytest.approx(wave.pull_off, rel=1e-8)

    def test_full_contact_without_load(self):
        assert not self.wave(0.569).snaps_into_full_contact
        assert self.wave(0.571).snaps_into_full_contact
        assert self.wave(0.571).zero_load_fraction == 1.0
        assert self.wave(0.569).zero_load_fraction == pytest.approx(2 / 3, abs=0.05)

    def test_without_attraction_it_is_the_wave_of_westergaard(self):
        wave = self.wave(1e-6)
        found = optimize.brentq(
            lambda fraction: float(wave.pressure(np.array(fraction))) - 0.3 * wave.full_pressure, 0.01, 0.99
        )
        assert np.sin(np.pi * found / 2) ** 2 == pytest.approx(0.3, rel=1e-4)


def test_energy_of_full_contact_of_one_wave():
    grid = rc.Grid((64, 32), (64e-6, 32e-6))
    heights = 1e-7 * np.cos(2 * np.pi * grid.x / 32e-6) + 0.0 * grid.y
    # The pressure of a wave is E* q D / 2, over the displacement D; half of their mean product.
    expected = 0.5 * 0.5 * E * (2 * np.pi / 32e-6) / 2 * 1e-14
    found = full_contact_energies(heights, grid, work=1.0, modulus=E)
    assert found.elastic == pytest.approx(expected, rel=1e-12)
    assert found.released == pytest.approx(1.0 - expected, rel=1e-12)


def test_stickiness_follows_from_the_gap_at_the_edge_of_a_cylinder():
    # A long contact of half width a = d/2 of a body of the radius R = d/(2 h'): the gap's slope is sqrt(s(d+s))/R.
    slope, curvature, work, reach = 0.1, 1e5, 0.05, 1e-11
    width = 4 * slope / curvature
    radius = 2 / curvature
    distance = optimize.brentq(
        lambda s: integrate.quad(lambda x: math.sqrt(x * width) / radius, 0, s)[0] - reach, 1e-15, width, xtol=1e-20
    )
    # Attraction w/rho on a strip of that width around patches of circumference over area pi/d, over repulsion h'E*/2.
    expected = work / reach * math.pi * distance / width / (slope * E / 2)
    assert stickiness(slope, curvature, work, reach, E) == pytest.approx(expected, rel=1e-4)
