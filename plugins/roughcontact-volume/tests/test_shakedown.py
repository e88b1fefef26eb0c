"""Passes of a ball along a track, and the load at which they do not shake down any more."""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import roughcontact as rc

from roughcontact_volume import find_shakedown_load, judge_passes
from roughcontact_volume.shakedown import Passes, judge_strains
from test_process import FIRST_FORCE, FIRST_RADIUS, LIMIT, make_ball, read

PLACES = 5


def roll(force, passes=3, **others):
    grid = rc.Grid((24, 12), (9.6 * FIRST_RADIUS, 4.8 * FIRST_RADIUS))
    track = [(cells, 0) for cells in (-4, -2, 0, 2, 4)]
    problem = make_ball(grid=grid, of="body", boundary="periodic", accuracy=1.0, **others)
    return problem.path(force=force, shift=passes * track)


def test_strain_is_that_in_the_middle_of_the_track():
    path = roll(3.0 * FIRST_FORCE, hardening=None)
    found = judge_passes(path, PLACES)
    layers = len(read(path[-1])["accumulated_strain"])
    # The middle half of a track of eight cells are four, or five where a middle lies on its end.
    after = [np.zeros((layers, 24, 12))]
    for number in range(3):
        one = read(path[PLACES * number + PLACES - 1])["accumulated_strain"]
        after.append(np.pad(one, ((0, layers - len(one)), (0, 0), (0, 0))))
    new = [(two - one)[:, 10:14].max() for one, two in pairwise(after)]
    assert found.new_strain == pytest.approx(new, rel=1e-9)
    assert found.accumulated_strain[-1] == after[-1][:, 10:14].max()
    assert new[0] > 3.0 * new[1] > 6.0 * new[2] > 0.0
    assert found.verdict == "undecided"
    assert list(found.table().columns["pass"]) == [1, 2, 3]


def test_loads_below_first_yield_leave_nothing():
    assert judge_passes(roll(0.7 * FIRST_FORCE, passes=2), PLACES).verdict == "stays elastic"


# Strains of passes of a ball on a fine grid: 3 Fy without hardening, and 10 Fy without and with it.
@pytest.mark.parametrize(
    ("new", "verdict"),
    [
        ([4.4e-3, 3.8e-4, 3.7e-5, 8e-6], "undecided"),
        ([4.4e-3, 3.8e-4, 3.7e-5, 8e-6, 2e-6], "shakes down"),
        ([1.9e-2, 2.8e-3, 1.9e-3, 1.6e-3], "flows in every pass"),
        ([1.7e-2, 2.5e-3, 4.0e-4, 1.6e-4], "undecided"),
        ([0.0, 0.0], "stays elastic"),
    ],
)
def test_verdicts(new, verdict):
    assert judge_strains(np.array(new), np.cumsum(new)) == verdict


@pytest.mark.parametrize("places", [0, 2, 5, True, 1.5])
def test_numbers_of_places_that_are_none(places):
    path = roll(0.5 * FIRST_FORCE, passes=1)
    with pytest.raises(rc.InputError, match="number of places of a pass"):
        judge_passes(path, places)


def make_passes(verdict):
    return Passes(np.array([1e-3]), np.array([1e-3]), verdict, 1e9)


class TestLoad:
    """Between shakedown and flow in every pass, with verdicts that are given."""

    @staticmethod
    def find(monkeypatch, shaken, flowing, force=(1.0, 16.0), **others):
        def roll(problem, places, one, most):
            verdict = "shakes down" if one < shaken else "flows in every pass" if one > flowing else "undecided"
            return make_passes(verdict)

        monkeypatch.setattr("roughcontact_volume.shakedown_load._roll", roll)
        return find_shakedown_load(make_ball(of="body", boundary="periodic"), [(0, 0)], force, **others)

    def test_is_enclosed(self, monkeypatch):
        found = self.find(monkeypatch, 5.0, 5.0, within=0.1)
        below, above = found.below[0], found.above[0]
        assert below < 5.0 <= above <= 1.1 * below
        assert found.force.value == 0.5 * (below + above)
        assert found.force.uncertainty == pytest.approx((above - below) / np.sqrt(12.0))
        assert not found.force.warnings
        assert found.table().columns["force"] == sorted(found.table().columns["force"])

    def test_undecided_loads_are_left_between(self, monkeypatch):
        found = self.find(monkeypatch, 4.0, 6.0, within=0.1)
        assert found.below[0] < 4.0 < 6.0 < found.above[0] < 6.0 * 1.1
        assert found.below[0] > 4.0 / 1.1
        assert "undecided" in found.force.warnings[0]

    @pytest.mark.parametrize(
        ("force", "others", "sentence"),
        [
            ((8.0, 16.0), {}, "smaller force, at which they shake down"),
            ((1.0, 4.0), {}, "larger force, at which they flow in every pass"),
            ((4.0, 1.0), {}, "the smaller one first"),
            ((1.0,), {}, "two, the smaller one first"),
            ((1.0, 16.0), {"passes": 3}, "number of passes at a force"),
            ((1.0, 16.0), {"within": 0.0}, "admissible ratio of two forces"),
        ],
    )
    def test_bad_input(self, monkeypatch, force, others, sentence):
        with pytest.raises(rc.InputError, match=sentence):
            self.find(monkeypatch, 5.0, 5.0, force, **others)


@pytest.mark.slow
def test_pressure_of_hertz_that_is_held_shakes_down_up_to_the_limit_of_johnson(monkeypatch):
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parents[1]), *sys.path])
    from measure_shakedown import move_pressure

    # Contact Mechanics (1985), section 9.2: the alternating shear of a circular contact, 0.214 of its pressure, is k at
    # 4.68 k.
    assert move_pressure(0.95 * 4.68)[0] == "shakes down"
    assert move_pressure(1.05 * 4.68, passes=5)[0] == "flows in every pass"


@pytest.mark.slow
def test_load_of_a_ball_that_sinks_into_its_track():
    """On a finer grid it is 8.84 times the load of first yield (`measure_shakedown.py`)."""
    radius = 8.84 ** (1.0 / 3.0) * FIRST_RADIUS
    grid = rc.Grid((28, 20), (7.0 * radius, 5.0 * radius))
    problem = make_ball(grid=grid, of="body", boundary="periodic", accuracy=1.0, hardening=None)
    track = [(cells, 0) for cells in (-6, -4, -2, 0, 2, 4, 6)]
    found = find_shakedown_load(problem, track, (7.4 * FIRST_FORCE, 10.5 * FIRST_FORCE), within=0.5)
    assert found.force.value == pytest.approx(8.95 * FIRST_FORCE)
    # Johnson's limit of a contact that is 1.4 times as wide as long is 4.24 k.
    assert found.peak_pressure.value * np.sqrt(3.0) / LIMIT == pytest.approx(4.33, rel=0.05)
