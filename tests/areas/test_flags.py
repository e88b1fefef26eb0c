"""Flags of a contact: where its pressure is unbounded, and where its heights are as rough as its cells."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import stated_uncertainties as judged
from edged_classes import EDGED, SMOOTH

from roughcontact.responses import PeakPressure

ELASTIC = rc.Elastic(1.0, 0.0)


def press(heights, size, boundary="periodic", pressure=1e-3, material=ELASTIC):
    body = rc.Body(rc.HeightMap(heights, size=size, periodic=boundary == "periodic"), material)
    return rc.ContactProblem(body, boundary=boundary).solve(pressure=pressure)


def punch(shape=(48, 40), size=(1.0, 0.8), at=(0.03, -0.02), turn=0.3):
    grid = rc.Grid(shape, size)
    x, y = grid.x - at[0], grid.y - at[1]
    u, v = math.cos(turn) * x + math.sin(turn) * y, math.cos(turn) * y - math.sin(turn) * x
    return np.where(np.maximum(abs(u), abs(v)) < 0.2, 0.0, -0.1)


def ridges(shape=(60, 48), size=(1.0, 0.8), waves=(3, 0), place=0.4):
    """Return the cusps between the grooves of a tool."""
    grid = rc.Grid(shape, size)
    part = (waves[0] * grid.x / size[0] + waves[1] * grid.y / size[1] + place) % 1.0
    return np.broadcast_to(0.01 * (2.0 * part - 1.0) ** 2, shape)


def smooth(shape=(60, 48), size=(1.0, 0.8), waves=(3, 2)):
    grid = rc.Grid(shape, size)
    return 0.01 * np.cos(2 * np.pi * waves[0] * grid.x / size[0]) * np.cos(2 * np.pi * waves[1] * grid.y / size[1])


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize(("shape", "size"), [((48, 40), (1.0, 0.8)), ((45, 63), (1.0, 1.4)), ((96, 32), (1.0, 1.0))])
def test_a_punch_has_sharp_edges_in_any_geometry(shape, size, boundary):
    flags = press(punch(shape, size), size, boundary).response("flags")
    assert flags.unbounded
    assert flags.sharp_edge > 0.5
    turned = press(punch(shape, size).T, size[::-1], boundary).response("flags")
    assert turned.sharp_edge == pytest.approx(flags.sharp_edge, rel=1e-9)


@pytest.mark.parametrize("waves", [(3, 0), (0, 2), (2, 2)])
@pytest.mark.parametrize("place", [0.0, 0.13, 0.5])
def test_a_ridge_under_the_maximum_is_a_crease(waves, place):
    solution = press(ridges(waves=waves, place=place), (1.0, 0.8), pressure=3e-3)
    flags = solution.response("flags")
    assert flags.crease > 0.02
    assert flags.sharp_edge == 0.0
    assert solution.peak_pressure().uncertainty == solution.peak_pressure().value
    assert any("grows with every grid" in text for text in solution.peak_pressure().warnings)


def test_the_jump_at_a_crease_is_that_of_the_slope():
    """Two grooves of depth d and width w meet at slopes 4d/w."""
    solution = press(ridges((96, 8), (1.0, 1.0), (3, 0), 0.5), (1.0, 1.0), pressure=3e-3)
    jump = 2.0 * 4.0 * 0.01 * 3.0
    # Uniform cells see the mean slope over one of them, 1/16 of a groove from the ridge.
    assert solution.response("flags").crease * float(solution.pressure.max()) == pytest.approx(jump, rel=0.1)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_smooth_contacts_have_no_flag(boundary):
    for heights in (smooth(), smooth(waves=(1, 1)), -smooth(waves=(2, 3))):
        flags = press(heights, (1.0, 0.8), boundary).response("flags")
        assert not flags
        assert str(flags).startswith("none")


def test_flags_do_not_depend_on_units_and_shifts():
    flags = press(punch(), (1.0, 0.8)).response("flags")
    steel = rc.Elastic(200e9, 0.3)
    pressure = 1e-3 * 200e9 / (1.0 - 0.3**2)
    small = press(1e-6 * punch(), (1e-6, 0.8e-6), pressure=pressure, material=steel)
    assert small.response("flags").sharp_edge == pytest.approx(flags.sharp_edge, rel=1e-6)
    shifted = press(np.roll(punch(), (17, -9), axis=(0, 1)), (1.0, 0.8)).response("flags")
    assert shifted.sharp_edge == pytest.approx(flags.sharp_edge, rel=1e-6)


def test_valleys_alone_are_no_reason_for_an_unbounded_pressure():
    """Where balls merge there are creases, but none that points at the other surface."""
    grid = rc.Grid((64, 64), 1.0)
    tips = [(-0.2, -0.1), (0.15, 0.2), (0.2, -0.25), (-0.25, 0.25)]
    heights = np.max([-2.0 * ((grid.x - x) ** 2 + (grid.y - y) ** 2) for x, y in tips], axis=0)
    flags = press(heights, (1.0, 1.0), "free", 1e-3).response("flags")
    assert not flags.unbounded
    assert flags.rough_tail


def test_a_limited_pressure_is_not_unbounded():
    soft = rc.ElasticPerfectlyPlastic(1.0, 0.0, hardness=2e-3)
    solution = press(ridges(), (1.0, 0.8), pressure=1e-3, material=soft)
    assert solution.saturated.any()
    assert not solution.response("flags").unbounded
    assert solution.peak_pressure().uncertainty == 0.0


def test_a_punch_at_its_hardness_is_not_unbounded():
    soft = rc.ElasticPerfectlyPlastic(1.0, 0.0, hardness=1.2e-3)
    solution = press(punch(), (1.0, 0.8), pressure=2e-4, material=soft)
    assert solution.saturated.any()
    assert not solution.saturated[solution.contact].all()
    assert not solution.response("flags").unbounded


def test_a_response_of_ones_own_is_not_the_kept_maximum():
    """A maximum pressure is kept by its solution."""

    class Doubled(PeakPressure):
        def find(self, solution, area):
            found = super().find(solution, area)
            return rc.Estimate(2.0 * found.value, found.uncertainty, "Pa")

    solution = press(smooth(), (1.0, 0.8))
    assert solution.response(Doubled()).value == 2.0 * solution.peak_pressure().value


def test_lost_points_of_a_smooth_map_are_no_flag():
    lost = np.zeros((60, 48), dtype=bool)
    lost[20:24, 30:33] = lost[50, 5] = True
    body = rc.Body(rc.HeightMap(smooth(), size=(1.0, 0.8), periodic=True, non_measured=lost), ELASTIC)
    solution = rc.ContactProblem(body, boundary="periodic").solve(pressure=1e-3)
    assert not solution.response("flags")


@pytest.mark.parametrize("scale", [1e-30, 1e30])
def test_flags_of_extreme_heights(scale):
    grid = rc.Grid((48, 40), (scale, 0.8 * scale))
    body = rc.Body(rc.HeightMap(scale * punch(), size=grid.size, periodic=True), ELASTIC)
    flags = rc.ContactProblem(body, boundary="periodic").solve(pressure=1e-3).response("flags")
    assert flags.unbounded
    assert flags.rough_tail == press(punch(), (1.0, 0.8)).response("flags").rough_tail


def test_nothing_in_contact_and_full_contact_have_no_flag():
    full = press(1e-4 * smooth(), (1.0, 0.8), pressure=1.0)
    assert full.contact.all()
    assert not full.response("flags").unbounded


class Tip(rc.Surface):
    """A cone, whose pressure is unbounded at its tip on every grid."""

    def heights(self, grid):
        return -0.05 * np.hypot(grid.x, grid.y)

    @property
    def is_smooth(self):
        return True


def test_a_reference_omits_an_unbounded_maximum():
    """Two grids do not show that it grows: the crease does."""
    problem = rc.ContactProblem(rc.Body(Tip(), ELASTIC), grid=rc.Grid((24, 24), 1.0))
    report = rc.error_vs_time(problem, force=1e-3, cells=[12, 24], repeats=1)
    assert "it grows with every grid" in " ".join(str(report).split())
    assert report.reference.p_max is None


@pytest.mark.slow
def test_most_unbounded_pressures_of_machined_surfaces_are_found_and_no_smooth_one():
    answers = ("area", "approach")
    edged, smooth = (
        [row for rows in judged.judge_kinds(list(kinds), 103, 4, answers, ["two grids"]).values() for row in rows]
        for kinds in (EDGED, SMOOTH)
    )
    grow, found, _, _ = judged.count_unbounded(edged)
    assert found > 0.7 * grow
    assert judged.count_unbounded(smooth)[3] <= 0.03 * len(smooth)
    for rows in (edged, smooth):
        for answer in answers:
            assert judged.cover(rows, answer, "two grids").within >= 0.9


@pytest.mark.parametrize(("power", "sharp"), [(1.0, True), (2.0, False)])
@pytest.mark.parametrize(("shape", "size"), [((63, 75), (1.0, 1.2)), ((48, 96), (1.0, 2.0))])
def test_a_flat_with_a_rounded_border_is_not_sharp_and_one_with_a_bevel_is(shape, size, power, sharp):
    grid = rc.Grid(shape, size)
    outside = np.maximum(np.hypot(grid.x - 0.007, grid.y + 0.003) - 0.25, 0.0)
    for pressure in (2e-3, 8e-3):
        flags = press(-0.02 * (outside / 0.06) ** power, size, pressure=pressure).response("flags")
        assert flags.unbounded is sharp
