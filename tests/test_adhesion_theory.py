from __future__ import annotations

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.reference import JKR, JohnsonWave, MaugisDugdale, full_contact_energies

R, E, W = 1e-6, 1e9, 0.05


def test_the_gap_at_the_end_of_the_tension_is_the_work_over_the_strength():
    # The gaps outside a contact of a ball and by a tension on a ring around it, in closed form.
    ball = MaugisDugdale(R, E, W, 3e7)
    a = 1.2 * ball.radius_at_zero_load
    m = ball.tension_radius(a) / a
    angle = math.acos(1.0 / m)
    root = math.sqrt(m * m - 1.0)
    punch = a * a * (root + (m * m - 2.0) * angle) / (math.pi * R)
    pull = 4.0 * ball.strength * a * (root * angle - m + 1.0) / (math.pi * E)
    assert (punch + pull) * ball.strength == pytest.approx(W, rel=1e-9)


def test_the_energy_that_the_edge_of_a_soft_ball_releases_is_the_work_of_adhesion():
    # The force below that of Hertz acts as on a flat punch, of the compliance 1/(2 E* a).
    ball = JKR(R, E, W)
    a = ball.radius_at_zero_load
    step = 1e-6 * a
    missing = 4.0 * E * a**3 / (3.0 * R) - ball.force(a)
    softening = 1.0 / (2.0 * E * a) - 1.0 / (2.0 * E * (a + step))
    assert missing**2 / 2.0 * softening / (2.0 * math.pi * a * step) == pytest.approx(W, rel=1e-5)


def test_pull_off_of_the_wave_is_its_lowest_pressure():
    wave = JohnsonWave(amplitude=1e-6, wavelength=1e-4, modulus=1e6, work=2e-3)
    pressures = [wave.mean_pressure(width * 1e-4) for width in np.linspace(1e-6, 0.25, 20001)]
    assert min(pressures) == pytest.approx(wave.pull_off, rel=1e-7)


def test_energy_of_full_contact_of_one_wave():
    grid = rc.Grid((64, 32), (64e-6, 32e-6))
    heights = 1e-7 * np.cos(2.0 * np.pi * grid.x / 32e-6) + 0.0 * grid.y
    # The pressure of a wave is E* q D / 2, over the displacement D; half of their mean product.
    expected = 0.5 * 0.5 * E * (2.0 * np.pi / 32e-6) / 2.0 * 1e-14
    found = full_contact_energies(heights, grid, work=1.0, modulus=E)
    assert found.elastic == pytest.approx(expected, rel=1e-12)
    assert found.released == pytest.approx(1.0 - expected, rel=1e-12)
    assert full_contact_energies(heights, grid, work=0.5 * expected, modulus=E).released < 0.0
