from __future__ import annotations

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.reference import JKR, JohnsonWave, MaugisDugdale, PastewkaRobbins, full_contact_energies

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


def make_waves(shortest, cells=256, seed=1):
    grid = rc.Grid((cells, cells), cells * 1e-6)
    waves = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.1, shortest=shortest * 1e-6, longest=0.25 * cells * 1e-6, seed=seed
    )
    return waves, grid


class TestPastewkaRobbins:
    @pytest.mark.parametrize("seed", [1, 2, 3])
    def test_the_diameter_of_patches_is_that_of_solved_contacts(self, seed):
        # Of the mean chord of the patches at light load: about two thirds, on grids of four points to the shortest wave
        # up to 1.0, while half the Laplacian for the curvature would make it a third.
        surface, grid = make_waves(4.0, seed=seed)
        problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(0.75e9, 0.5)), grid=grid, boundary="periodic")
        contact = problem.solve(pressure=2e-3 * problem.plan.modulus).contact
        ends = sum(np.count_nonzero(contact & ~np.roll(contact, 1, axis)) for axis in (0, 1))
        chord = 2.0 * np.count_nonzero(contact) / ends * 1e-6
        heights = surface.heights(grid)
        steps = [(np.roll(heights, -1, axis) - heights) / 1e-6 for axis in (0, 1)]
        bends = [(step - np.roll(step, 1, axis)) / 1e-6 for axis, step in enumerate(steps)]
        slope = math.sqrt(sum(np.mean(step**2) for step in steps))
        theory = PastewkaRobbins(slope, float(np.std(sum(bends))), 1e9, 0.05, 1e-9)
        assert 0.55 < chord / theory.patch_diameter < 1.1

    def test_the_sticking_edge_carries_what_the_patches_press(self):
        # The attracted zone of width d (3 range / (4 h' d))^(2/3) around patches of area over perimeter d / pi.
        theory = PastewkaRobbins(0.1, 1e6, 1e8, 0.05, 1e-9)
        d = theory.patch_diameter
        zone = d * (3.0 * theory.range / (4.0 * 0.1 * d)) ** (2.0 / 3.0)
        pulls = theory.work / theory.range * math.pi * zone / d
        presses = theory.modulus * 0.1 / 2.0
        assert theory.ratio == pytest.approx(presses / pulls, rel=1e-12)


class TestStickiness:
    def solve(self, work, **options):
        surface, grid = make_waves(16.0, cells=128)
        law = rc.Exponential(work, math.sqrt(4.0 * np.max(work) * 1e-6 / E))
        options = {"boundary": "periodic", "adhesion": law} | options
        body = rc.Body(surface, rc.Elastic(0.75 * E, 0.5))
        return rc.ContactProblem(body, grid=grid, **options).solve(pressure=2e-3 * E), surface.heights(grid), grid

    @pytest.mark.usefixtures("no_pictures")
    def test_is_that_of_the_heights(self):
        solution, heights, grid = self.solve(1.0)
        found = solution.stickiness
        expected = full_contact_energies(heights, grid, work=1.0, modulus=solution.modulus)
        assert found.full_contact.elastic == pytest.approx(expected.elastic, rel=1e-9)
        statistics = rc.reference.roughness(heights, grid, periodic=True)
        assert found.criterion.rms_slope == pytest.approx(statistics.rms_slope.value, rel=1e-9)
        assert found.criterion.rms_curvature**2 == pytest.approx(8.0 / 3.0 * statistics.m4.value, rel=1e-9)
        assert found.criterion.range == pytest.approx(math.sqrt(4.0 * 1e-6 / E))
        assert "Pastewka, Robbins" in str(solution)
        assert "Persson, Tosatti" in solution.to_html()
        # Full contact is pressed together by its elastic energy and held by the work of adhesion.
        assert ("more than the work" in str(found)) == (expected.released < 0.0)

    def test_stickier_surfaces_have_a_smaller_ratio(self):
        weak, strong = (self.solve(work)[0].stickiness.criterion for work in (0.1, 10.0))
        assert weak.ratio > strong.ratio

    def test_is_not_stated_where_it_does_not_hold(self):
        assert self.solve(1.0, adhesion=None)[0].stickiness is None
        assert self.solve(1.0, boundary="free")[0].stickiness is None
        assert self.solve(np.full((128, 128), 1.0))[0].stickiness is None
        wave = rc.Body(rc.WavySurface(1e-6, 32e-6), rc.Elastic(0.75 * E, 0.5))
        law = rc.Exponential(1.0, math.sqrt(4.0 * 1e-6 / E))
        problem = rc.ContactProblem(wave, grid=rc.Grid((64, 64), 64e-6), boundary="periodic", adhesion=law)
        found = problem.solve(pressure=2e-3 * E).stickiness
        assert found.criterion is None
        assert "Pastewka" not in str(found)
