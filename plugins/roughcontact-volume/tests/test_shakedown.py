"""Passes of a ball along a track."""

from itertools import pairwise

import numpy as np
import pytest
import roughcontact as rc

from roughcontact_volume import judge_passes
from roughcontact_volume.shakedown import _judge
from test_process import FIRST_FORCE, FIRST_RADIUS, make_ball, read

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
    assert _judge(np.array(new), np.cumsum(new)) == verdict


@pytest.mark.parametrize("places", [0, 2, 5, True, 1.5])
def test_numbers_of_places_that_are_none(places):
    path = roll(0.5 * FIRST_FORCE, passes=1)
    with pytest.raises(rc.InputError, match="number of places of a pass"):
        judge_passes(path, places)
