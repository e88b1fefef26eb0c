"""Small functions of partial slip, conductance and the closing of a gap beside closed forms."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import roughcontact as rc
from exact_contacts import MODULUS, ball, with_fields
from roughcontact._answers.areas.approach import find_shift
from roughcontact._answers.areas.initial_gap import curvature_resolution
from roughcontact._answers.flow import percolation
from roughcontact._answers.flow.network import find_paths
from roughcontact._answers.slip import (
    _approach_std,
    _compare_areas,
    _complementary_energy,
    _cut_fraction,
    _displace,
    _dissipate,
)
from roughcontact.responses import Conductance, find_percolation

GRID = rc.Grid((60, 50), (60e-6, 75e-6))
RADIUS = 1e-3


@pytest.mark.parametrize("a", [10e-6, 20e-6])
def test_the_complementary_energy_of_a_ball_is_three_fifths_of_force_times_approach(a):
    """The approach grows as the force to the power 2/3."""
    solution = ball(GRID, a, RADIUS, (0.3e-6, 0.4e-6))
    assert _complementary_energy(solution) == pytest.approx(0.6 * solution.force * solution.approach, rel=2e-3)


def test_the_energy_of_a_cycle_is_the_bend_of_the_approach_over_the_force():
    """Of two balls: 2 [U - U*] - (P - P*) (d + d*) with U = 3/5 P d, and the differences of approach and area."""
    whole, stuck = ball(GRID, 20e-6, RADIUS), ball(GRID, 14e-6, RADIUS)
    force = [4.0 / 3.0 * MODULUS * a**3 / RADIUS for a in (20e-6, 14e-6)]
    approach = [a**2 / RADIUS for a in (20e-6, 14e-6)]
    bend = 2.0 * 0.6 * (force[0] * approach[0] - force[1] * approach[1]) - (force[0] - force[1]) * sum(approach)
    found = _dissipate(whole, stuck, 3.0)
    assert found.value == pytest.approx(3.0 * bend, rel=0.05)
    std = _approach_std(whole, stuck)
    assert found.uncertainty == pytest.approx(3.0 * (whole.force - stuck.force) * std)
    moved = _displace(whole, stuck, 0.7)
    assert moved.value == pytest.approx(0.7 * (approach[0] - approach[1]))
    assert moved.uncertainty == pytest.approx(0.7 * std)
    stick, slip = _compare_areas(whole, stuck)
    assert stick.value == pytest.approx(np.pi * 14e-6**2, rel=1e-3)
    assert slip.value == pytest.approx(np.pi * (20e-6**2 - 14e-6**2), rel=2e-3)
    assert slip.uncertainty == pytest.approx(math.hypot(whole.area().uncertainty, stuck.area().uncertainty))
    unsure, _ = _compare_areas(whole, stuck, 0.5)
    assert unsure.uncertainty == pytest.approx(math.hypot(stick.uncertainty, 0.5 * stick.value))
    alone, none = _compare_areas(whole, whole)
    assert (alone.value, none.value, none.uncertainty) == (whole.area().value, 0.0, 0.0)
    assert _displace(whole, whole, 0.7).value == _dissipate(whole, whole, 3.0).value == 0.0


def test_approaches_close_to_each_other_err_alike():
    """Both errors of edges, faded by how little slides, with oblong cells; at most the difference itself."""
    options = {"edge_shift": 0.018}
    whole, stuck = ball(GRID, 20e-6, RADIUS, **options), ball(GRID, 14e-6, RADIUS, **options)
    assert _approach_std(whole, whole) == 0.0
    both = [find_shift(one)[1] for one in (whole, stuck)]
    found = _approach_std(whole, stuck)
    assert 0.0 < found <= 1.5 * math.hypot(*both)
    near = ball(GRID, 19.8e-6, RADIUS, **options)
    assert _approach_std(whole, near) < 0.3 * found
    # An unsolved gap counts by its residual; and the difference is the most that it can be.
    unsolved = attrs.evolve(stuck, residuals=type(stuck.residuals)(0.1, 0.2, 0.0, 1e-7))
    assert _approach_std(whole, unsolved) == pytest.approx(math.hypot(found, 0.2e-7))
    wild = attrs.evolve(stuck, residuals=type(stuck.residuals)(0.1, 0.2, 0.0, 1.0))
    assert _approach_std(whole, wild) == pytest.approx(whole.approach - stuck.approach)


def test_the_border_cuts_half_of_the_sides_that_lie_on_it():
    contact = np.zeros((8, 10), dtype=bool)
    contact[0, 2:5] = contact[-1, 7] = contact[3:5, 0] = True
    grid = rc.Grid(contact.shape, 1.0)
    assert _cut_fraction(with_fields(grid, contact, ~contact)) == pytest.approx(0.5 * 6 / 80)
    assert _cut_fraction(with_fields(grid, contact, ~contact, boundary="periodic")) == 0.0


def test_a_conductance_reads_well():
    """Two patches of 2 and 4 K/W with films of 1 K/W each, beside what is found for both together."""
    found = Conductance(0.5, 0.01, 5e3, np.array([0.3, 0.2]), np.array([2.0, 4.0]), np.array([1.0, 1.0]))
    text = str(found)
    assert "500 mW/K (mS if the conductivities are in S/m) +- 2 %" in text
    assert "5 kW/(m2 K) (kS/m2) of nominal area, through 2 patches" in text
    assert found.interaction == pytest.approx(1.0 / 0.5 - 1.0 / (1.0 / 3.0 + 1.0 / 5.0))
    one = attrs.evolve(found, patches=np.ones(1), value=0.0, uncertainty=0.0)
    assert str(one).endswith("through 1 patch")
    assert "+- 0 %" in str(one)
    assert one.interaction == 0.0
    assert attrs.evolve(found, value=math.inf).interaction == 0.0


@pytest.mark.parametrize("axis", [0, 1])
def test_the_load_that_closes_a_gap_lies_between_the_last_open_and_the_first_closed_contact(axis, monkeypatch):
    grid = rc.Grid((32, 24), (32.0, 24.0))
    body = rc.Body(rc.HeightMap(sum_waves(grid), size=grid.size, periodic=True), rc.Elastic(1e9, 0.0))
    given = rc.ContactProblem(body, grid=grid, boundary="periodic", threads=1)
    found = find_percolation(given, axis=axis, within=0.02)
    low, high = found.last_open, found.first_closed
    assert found.pressure.value == pytest.approx(math.sqrt(low.mean_pressure * high.mean_pressure))
    assert 1.0 < high.mean_pressure / low.mean_pressure <= 1.02
    for one, joined in ((low, True), (high, False)):
        cells = ~one.contact if axis == 0 else ~one.contact.T
        assert find_paths(cells, periodic=True).any() == joined
    assert found.area_fraction.value == pytest.approx(0.5 * (low.area().fraction + high.area().fraction))
    # Without what the width of paths leaves open, the resolution alone is unsure.
    monkeypatch.setattr(percolation, "_WIDTH_STD", 0.0)
    unresolved = 0.1 * curvature_resolution(low)
    sure = find_percolation(given, axis=axis, within=0.02)
    assert sure.pressure.uncertainty == pytest.approx(unresolved * found.pressure.value)
    own = low.area().uncertainty / grid.area
    assert sure.area_fraction.uncertainty == pytest.approx(math.hypot(unresolved * found.area_fraction.value, own))
    assert found.pressure.uncertainty > sure.pressure.uncertainty
    assert found.area_fraction.uncertainty > sure.area_fraction.uncertainty


def sum_waves(grid):
    """Some waves of random phases and directions."""
    rng = np.random.default_rng(5)
    heights = np.zeros(grid.shape)
    for m in range(-4, 5):
        for n in range(5):
            if 0 < math.hypot(m, n) <= 4.5:
                phase = rng.uniform(0.0, 2.0 * np.pi)
                angle = 2.0 * np.pi * (m * grid.x / grid.size[0] + n * grid.y / grid.size[1])
                heights += 0.05 * np.cos(angle + phase)
    return heights
