"""Residual stress by depth, and regions that strain by themselves."""

from __future__ import annotations

import math

import numpy as np
import pytest
import roughcontact as rc
from roughcontact.responses import FirstYield, StressBelow
from scipy import optimize

from closed_forms import find_sphere_heave
from roughcontact_volume import Cuboid, ResidualStress, Sphere, StrainedRegion

STEEL = rc.Elastic("210GPa", 0.3)
BALL = rc.Body(rc.ParaboloidSurface("5mm"), STEEL)
GRID = rc.Grid((64, 64), "300um")


@pytest.fixture(scope="module")
def pressed():
    return rc.ContactProblem(BALL, grid=GRID).solve(force="10N")


def _find_hertz_yield(residual, strength):
    """The force at which the axis below a ball yields, whose residual stress is the same at all depths."""
    modulus = 210e9 / (1.0 - 0.3**2)
    z = np.linspace(0.01, 3.0, 2001)

    def excess(force):
        a = (0.75 * force * 5e-3 / modulus) ** (1.0 / 3.0)
        radial = -((1.0 + 0.3) * (1.0 - z * np.arctan(1.0 / z)) - 0.5 / (1.0 + z**2))
        difference = 1.5 * force / (math.pi * a**2) * (radial + 1.0 / (1.0 + z**2)) + residual
        return float(np.abs(difference).max()) - strength

    return optimize.brentq(excess, 0.5, 1e3)


@pytest.mark.parametrize("residual", [-4e8, -2e8, 2e8, 4e8])
def test_first_yield_of_a_ball_with_a_uniform_residual_stress(pressed, residual):
    found = pressed.response(FirstYield("1GPa", residual=ResidualStress([0.0], [residual])))
    exact = _find_hertz_yield(residual, 1e9)
    assert abs(found.force.value - exact) < 2.0 * found.force.uncertainty
    assert found.force.uncertainty < 0.01 * exact


def test_residual_stress_adds_to_that_of_the_contact(pressed):
    depths = [0.0, 20e-6, 45e-6]
    peened = ResidualStress(["0um", "30um", "60um"], ["-400MPa", "-600MPa", "0MPa"])
    plain, both = (pressed.response(StressBelow(depths, residual=one)) for one in (None, peened))
    added = both.components - plain.components
    expected = peened.find_stress(depths).T[:, :, None, None] * np.ones(GRID.shape)
    assert added == pytest.approx(expected, abs=1e3)
    assert expected[:, 0, 0, 0] == pytest.approx([-4e8, -5.0e8 - 1e8 / 3.0, -3e8])


def test_a_point_rolls_in_from_its_residual_stress(pressed):
    # The amplitude is that of the contact alone, the hydrostatic stress has two thirds of the residual one.
    depths = [20e-6]
    plain, both = (pressed.response(StressBelow(depths, residual=one)) for one in (None, ResidualStress([0.0], [-3e8])))
    assert both.crossland(0.0) == pytest.approx(plain.crossland(0.0), rel=1e-4)
    assert both.crossland(0.4) == pytest.approx(plain.crossland(0.4) - 0.4 * 2e8, rel=1e-3)


def test_a_residual_stress_that_yields_by_itself_is_refused(pressed):
    with pytest.raises(rc.InputError, match="The residual stress alone makes the body yield"):
        pressed.response(FirstYield("300MPa", residual=ResidualStress([0.0, 1e-5], [0.0, -5e8])))


def test_means_over_layers_are_exact():
    stress = ResidualStress([1.0, 2.0, 4.0], [3.0, -1.0, 2.0])
    means = stress.find_mean_stress([0.5, 2.0, 5.0])
    # From 0.5 to 2.5: 0.5 * 3 + 1 + 0.5 * (-0.625); from 2.5 to 7.5: 1.5 * 0.875 + 3.5 * 2.
    assert means[0] == pytest.approx([3.0, (1.5 + 1.0 - 0.3125) / 2.0, (1.3125 + 7.0) / 5.0])
    assert np.array_equal(means[0], means[1])
    assert not means[2:].any()
    fine = stress.find_mean_stress(np.full(700, 0.01))[0]
    assert means[0][:2] == pytest.approx([fine[:50].mean(), fine[50:250].mean()], rel=1e-12)


@pytest.mark.parametrize(
    ("depth", "stress", "message"),
    [
        ([0.0, 0.0], [1.0, 2.0], "ascending"),
        ([-1.0], [1.0], "ascending"),
        ([0.0, 1.0], [1.0], "2 depths and 1 stresses"),
        ([0.0], ["1m"], "a list of finite numbers"),
        ([], [], "a list of finite numbers"),
        ([0.0], [float("nan")], "a list of finite numbers"),
    ],
)
def test_wrong_residual_stress_is_refused(depth, stress, message):
    with pytest.raises(rc.InputError, match=message):
        ResidualStress(depth, stress)


@pytest.mark.parametrize("side", ["body", "counterbody"])
def test_a_sphere_that_swells_lifts_the_surface(side):
    region = StrainedRegion(Sphere("60um"), 1e-3, centre=(0.0, "20um", "100um"), side=side)
    problem = rc.ContactProblem(BALL, rc.Body(rc.FlatSurface(), STEEL), grid=GRID, laws=region)
    moved = region.change_gap(problem, None, {})
    exact = find_sphere_heave(60e-6, 100e-6, 1e-3, 0.3, GRID.x, GRID.y - 20e-6)
    assert moved == pytest.approx(exact, abs=5e-3 * np.abs(exact).max())
    state = problem.solve(force="10N")
    plain = rc.ContactProblem(problem.body, problem.counterbody, grid=GRID).solve(force="10N")
    assert state.certificate.error < 1e-5
    # The ball touches the rise first, about where it is highest.
    assert state.pressure.max() > 1.02 * plain.pressure.max()
    assert problem.sweep(force=["10N"]).table().columns["rise_by_strain"][0] == pytest.approx(-exact.min(), rel=5e-3)


def test_a_swelling_sphere_leaves_the_stress_of_eshelby():
    region = StrainedRegion(Sphere("40um"), 1e-3, centre=(0.0, 0.0, "130um"))
    problem = rc.ContactProblem(BALL, grid=GRID, laws=region)
    interfaces, stress = region.find_stress(problem)
    middle = int(np.searchsorted(interfaces, 130e-6)) - 1
    exact = (1.3 / (3.0 * 0.7) - 1.0) * 210e9 / 0.4 * 1e-3
    assert stress[:3, middle, 32, 32] == pytest.approx([exact] * 3, rel=0.05)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"centre": (0.0, 0.0, "30um")}, "reaches the surface"),
        ({"centre": ("130um", 0.0, "100um")}, "over the border of the domain along x"),
        ({"strain": 0.2}, "The strain of a region"),
        ({"strain": [1e-3, 1e-3]}, "The strain of a region"),
        ({"side": "both"}, "'body' or 'counterbody'"),
        ({"shape": "sphere"}, "a Sphere, an Ellipsoid or a Cuboid"),
        ({"shape": Cuboid(["0.1um", "0.1um", "0.1um"]), "centre": (0.0, 0.0, "100um")}, "smaller than a cell"),
    ],
)
def test_wrong_regions_are_refused(given, message):
    def solve():
        region = StrainedRegion(**{"shape": Sphere("40um"), "strain": 1e-3, "centre": (0.0, 0.0, "100um")} | given)
        rc.ContactProblem(BALL, grid=GRID, laws=region).solve(force="10N")

    with pytest.raises(rc.InputError, match=message):
        solve()


def test_a_body_with_a_hardness_is_refused():
    soft = rc.Body(rc.ParaboloidSurface("5mm"), rc.ElasticPerfectlyPlastic("210GPa", 0.3, hardness="2GPa"))
    region = StrainedRegion(Sphere("40um"), 1e-3, centre=(0.0, 0.0, "100um"))
    with pytest.raises(rc.InputError, match="lies in an Elastic body"):
        rc.ContactProblem(soft, grid=GRID, laws=region).solve(force="10N")
