"""Maximum pressure, perimeter, patches, approach and mean gap below the cell, with uncertainties that hold."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.reference import hertz_elliptic, hertz_sphere
from scenes import each_once

ELASTIC = rc.Elastic(1.0, 0.0)
NAMES = ("peak-pressure", "perimeter", "patches", "approach", "mean-gap")


def press_ball(radius, cells=32, center=(0.0, 0.0), material=ELASTIC):
    """Return a ball of this radius of contact, in cells, and Hertz's solution."""
    blunt, force = 1e3 * radius, 4e-3 * radius**2 / 3
    surface = rc.ParaboloidSurface(blunt, center=center)
    problem = rc.ContactProblem(rc.Body(surface, material), grid=rc.Grid((cells, cells), float(cells)))
    return problem.solve(force=force), hertz_sphere(force, blunt, 1.0)


def press_wave(cells, phase, waves=20, pressure=100e6):
    surface = rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6, phase=phase)
    body = rc.Body(surface, rc.Elastic(200e9, 0.3))
    grid = rc.Grid((cells, cells), waves * 12.5e-6)
    return rc.ContactProblem(body, grid=grid, boundary="periodic").solve(pressure=pressure)


@each_once(
    {
        "radius": [0.6, 0.9, 1.4, 2.3, 3.7, 6.0, 9.0],
        "center": [(0.0, 0.0), (0.31, -0.17)],
    }
)
def test_hertz_below_the_cell(radius, center):
    solution, exact = press_ball(radius, center=center)
    true = {"peak-pressure": exact.p_max, "perimeter": 2 * np.pi * radius, "approach": exact.approach, "patches": 1.0}
    for name, value in true.items():
        found = solution.response(name)
        assert abs(found.value - value) <= 2 * found.uncertainty + 1e-12 * value, name
    assert solution.peak_pressure().value == pytest.approx(exact.p_max, rel=0.004)
    assert solution.response("perimeter").value == pytest.approx(2 * np.pi * radius, rel=0.01)
    if radius > 1:
        # The highest cell is up to 0.7 cells from the summit.
        assert solution.response("approach").value == pytest.approx(exact.approach, rel=0.06)


def test_ellipse_along_the_grid():
    exact = hertz_elliptic(0.05, (12e3, 3e3), 1.0)
    body = rc.Body(rc.ParaboloidSurface((12e3, 3e3)), ELASTIC)
    solution = rc.ContactProblem(body, grid=rc.Grid((64, 64), 64.0)).solve(force=0.05)
    assert solution.peak_pressure().value == pytest.approx(exact.p_max, rel=0.005)


@pytest.mark.parametrize("cells", [256, 320, 500])
def test_maximum_pressure_of_the_papers_wave(cells):
    # 13.220 GPa by solves of one wave on up to 4096 x 4096 cells.
    found = press_wave(cells, (1.0, 2.0)).peak_pressure()
    assert found.value == pytest.approx(13.220e9, rel=0.01)
    assert found.unit == "Pa"
    assert abs(found.value - 13.220e9) <= 2 * found.uncertainty


def test_grids_agree_within_their_uncertainties():
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=1.05, longest=16.0, rolloff=8.0, seed=77)

    def press(cells):
        grid = rc.Grid((cells, cells), 16.0)
        return rc.ContactProblem(rc.Body(surface, ELASTIC), grid=grid, boundary="periodic").solve(pressure=3e-3)

    fine, coarse = press(512), press(128)
    for name in NAMES:
        one, other = coarse.response(name), fine.response(name)
        assert abs(one.value - other.value) <= 2 * np.hypot(one.uncertainty, other.uncertainty), name
    # Mean gap and approach of one surface are complementary: the corrections must not break that.
    assert coarse.response("mean-gap").value == pytest.approx(fine.response("mean-gap").value, rel=3e-3)


def test_limited_pressure_has_the_limit_as_its_maximum():
    solution, exact = press_ball(5.0, material=rc.ElasticPerfectlyPlastic(1.0, 0.0, 4e-4))
    assert exact.p_max > 4e-4
    found = solution.peak_pressure()
    assert (found.value, found.uncertainty) == (4e-4, 0.0)


def test_sharp_edge_has_no_maximum():
    grid = rc.Grid((48, 48), 48.0)
    heights = np.where(np.hypot(grid.x, grid.y) < 12.0, 0.0, -1.0)
    solution = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=48.0), ELASTIC)).solve(force=1e-3)
    found = solution.peak_pressure()
    assert found.uncertainty == found.value
    assert any("unbounded" in warning for warning in found.warnings)


@pytest.mark.parametrize(("sides", "sharp"), [((2, 4), False), ((1, 8), False), ((3, 3), True), ((3, 4), True)])
def test_patches_of_fewer_than_nine_cells_may_be_summits_instead_of_punches(sides, sharp):
    heights = np.full((20, 22), -1.0)
    heights[6 : 6 + sides[0], 7 : 7 + sides[1]] = 0.0
    solution = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=(20.0, 22.0)), ELASTIC)).solve(force=1e-3)
    found = solution.peak_pressure()
    assert any("unbounded" in warning for warning in found.warnings) == sharp
    assert (found.uncertainty == found.value) == sharp
    assert found.uncertainty > 0.5 * found.value


def test_a_limit_between_the_cells_cuts_the_maximum():
    """The summit lies between four cells: a limit above their pressure and below that of the summit is reached."""
    free, exact = press_ball(6.0)
    highest = free.pressure.max()
    assert highest < exact.p_max
    for limit in (0.5 * (highest + exact.p_max), 2.0 * exact.p_max):
        solution, _ = press_ball(6.0, material=rc.ElasticPerfectlyPlastic(1.0, 0.0, limit))
        assert not solution.saturated.any()
        found = solution.peak_pressure()
        assert found.value == pytest.approx(min(limit, exact.p_max), rel=2e-3)
        assert found.value <= limit
        assert 0.0 < found.uncertainty < 0.02 * found.value


def test_area_estimators_without_patches_serve():
    solution, exact = press_ball(6.0)
    for name in NAMES:
        found = solution.response(rc.responses.create(name, "cell-count"))
        assert np.isfinite((found.value, found.uncertainty)).all()
    assert solution.response(rc.responses.create("peak-pressure", estimator="cell-count")).value == pytest.approx(
        exact.p_max, rel=0.01
    )


def test_no_contact_and_full_contact():
    wave = rc.Body(rc.WavySurface(amplitude=1e-3, wavelength=8.0), ELASTIC)
    full = rc.ContactProblem(wave, grid=rc.Grid((8, 8), 8.0), boundary="periodic").solve(pressure=0.1)
    none = attrs.evolve(full, pressure=np.zeros((8, 8)), displacement=np.ones((8, 8)))
    for solution in (full, none):
        for name in NAMES:
            found = solution.response(name)
            assert np.isfinite((found.value, found.uncertainty)).all()
    assert full.peak_pressure().value == pytest.approx(0.1 + 0.5 * 2 * np.pi / 8e3 * 2, rel=1e-3)
    assert none.peak_pressure().value == none.response("patches").value == 0.0


def test_estimates_are_printed_and_checked():
    solution, _ = press_ball(3.0)
    assert str(solution.peak_pressure()).startswith(f"{1e6 * solution.peak_pressure().value:.5g} µPa +- ")
    assert str(solution.response("patches")).startswith("1 +- 0")
    with pytest.raises(rc.InputError, match="peak-pressure"):
        solution.response("peak-presure")

    class Wrong(rc.Response):
        def respond(self, solution):
            return rc.Estimate(math.nan, 0.0, "m")

    with pytest.raises(rc.InputError, match="has no value"):
        solution.response(Wrong())


@pytest.mark.parametrize("pressure", [50e6, 100e6])
def test_summits_between_the_cells_are_patches_with_an_edge(pressure):
    """On 7.5 cells a wave a quarter of the summits lie where four cells meet, and no cell touches there."""
    coarse, fine = (press_wave(cells, (0.0, 0.0), waves, pressure) for cells, waves in ((30, 4), (200, 1)))
    assert coarse.patches.count == 12
    assert coarse.response("patches").value == 16.0
    length = 16.0 * fine.response("perimeter").value
    assert coarse.response("perimeter").value == pytest.approx(length, rel=0.02)


def test_areas_of_balls_that_end_just_before_a_free_border():
    within = []
    for number in range(24):
        a = 1.5 + 0.15 * number
        shape = (9 + 2 * number, 24)
        center = (0.5 * shape[0] - (1.02 + 0.01 * (number % 4)) * a, 0.3 * np.sin(number))
        body = rc.Body(rc.ParaboloidSurface(1e4, center=center), rc.Elastic(1.0, 0.0))
        problem = rc.ContactProblem(body, grid=rc.Grid(shape, (float(shape[0]), float(shape[1]))))
        area = problem.solve(force=4.0 * a**3 / 3e4).area()
        within.append(abs(area.value - np.pi * a**2) <= 2.0 * area.uncertainty)
    assert np.mean(within) >= 0.93
