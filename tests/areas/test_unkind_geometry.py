"""Areas and estimates where borders are near, cells long, contacts slender, nearly full or checkered."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipe

import roughcontact as rc
from roughcontact.reference import hertz_elliptic, hertz_sphere
from scenes import each_once

ELASTIC = rc.Elastic(1.0, 0.0)


def press(surface, grid, material=ELASTIC, boundary="free", **load):
    return rc.ContactProblem(rc.Body(surface, material), grid=grid, boundary=boundary).solve(**load)


def assert_within_two(found, true):
    assert abs(found.value - true) <= 2 * found.uncertainty


@each_once(
    {
        "turned": [False, True],
        "ratio minor room": [(4.0, 3.3, 1.2), (12.0, 2.1, 1.3), (30.0, 1.7, 1.15), (48.0, 2.6, 1.4)],
    }
)
def test_slender_ellipses_in_domains_of_their_shape(ratio, minor, room, turned):
    radii = (1e5, 1e5 / ratio)
    unit = hertz_elliptic(1e-6, radii, 1.0)
    force = 1e-6 * (minor / min(unit.semi_axes)) ** 3
    exact = hertz_elliptic(force, radii, 1.0)
    long, short = max(exact.semi_axes), min(exact.semi_axes)
    cells = [math.ceil(2 * room * axis + 8) for axis in (long, short)]
    if turned:
        radii, cells = radii[::-1], cells[::-1]
    solution = press(rc.ParaboloidSurface(radii, center=(0.31, -0.17)), rc.Grid(cells, cells), force=force)
    area, length = solution.area(), solution.response("perimeter")
    assert area.value == pytest.approx(math.pi * long * short, rel=2e-3)
    assert_within_two(area, math.pi * long * short)
    assert length.value == pytest.approx(4 * long * ellipe(1 - (short / long) ** 2), rel=2e-3)
    assert solution.peak_pressure().value == pytest.approx(exact.p_max, rel=2e-3)


@each_once(
    {
        "shape": [(6, 21), (9, 9), (40, 7), (12, 31)],
        "sides": [(1.0, 1.0), (3.0, 1.0), (1.0, 3.0)],
    }
)
def test_a_ball_in_a_small_free_domain(shape, sides):
    size = np.multiply(shape, sides)
    radius, blunt = 0.3 * size.min(), 1e3 * size.max()
    force = 4 * radius**3 / (3 * blunt)
    center = tuple(0.3 * np.array(sides) * (1, -1))
    solution = press(rc.ParaboloidSurface(blunt, center=center), rc.Grid(shape, tuple(size)), force=force)
    area = solution.area()
    assert area.value == pytest.approx(math.pi * radius**2, rel=5e-3)
    assert_within_two(area, math.pi * radius**2)
    assert_within_two(solution.peak_pressure(), hertz_sphere(force, blunt, 1.0).p_max)


@pytest.mark.parametrize("center", [(16.0, 0.0), (0.0, -15.0), (12.0, 2.0)])
def test_a_maximum_that_a_free_border_cuts_is_unbounded(center):
    found = [
        press(rc.ParaboloidSurface(100.0, center=center), rc.Grid((cells, cells), 32.0), force=3.0).peak_pressure()
        for cells in (47, 96)
    ]
    assert found[1].value > 1.2 * found[0].value
    for one in found:
        assert one.uncertainty == one.value
        assert any("border" in warning for warning in one.warnings)


@pytest.mark.parametrize("pressure", [0.015, 0.017, 0.0185])
def test_the_mean_gap_near_full_contact(pressure):
    surface = rc.WavySurface(amplitude=0.05, wavelength=16.0, phase=(1.0, 2.0))
    fine, *coarse = (
        press(surface, rc.Grid((cells, cells), 16.0), boundary="periodic", pressure=pressure).response("mean-gap")
        for cells in (192, 48, 33)
    )
    for one in coarse:
        assert one.value == pytest.approx(fine.value, rel=0.03)
        assert_within_two(one, fine.value)


def test_bodies_that_flow_do_not_overlap_in_the_mean_gap():
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=2.0, longest=16.0, seed=5)
    material = rc.ElasticPerfectlyPlastic(1.0, 0.0, 0.02)
    solution = press(surface, rc.Grid((65, 65), 16.0), material, "periodic", pressure=0.018)
    open_gap = float(np.mean(np.where(solution.contact, 0.0, solution.gap)))
    found = solution.response("mean-gap")
    assert open_gap > 0.0
    assert found.value == pytest.approx(open_gap, rel=0.05)
    assert_within_two(found, open_gap)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_no_estimate_is_sure_of_a_checkered_contact(boundary):
    i, j = np.indices((16, 16))
    heights = rc.HeightMap(np.where((i + j) % 2 == 0, 0.01, 0.0), (16.0, 16.0))
    solution = press(heights, rc.Grid((16, 16), 16.0), boundary=boundary, pressure=1e-4)
    counted = solution.area("cell-count").value
    for name in ("blend", "hertz", "level-set"):
        found = solution.area(name)
        assert abs(found.value - counted) <= 2 * found.uncertainty, name
    assert solution.response("perimeter").value > 0.0


@pytest.mark.parametrize("cells", [(64, 64), (65, 33)])
def test_the_saturated_area_of_a_smooth_body_has_no_false_warning(cells):
    radius, blunt = 10.0, 1e4
    force = 4 * radius**3 / (3 * blunt)
    hardness = hertz_sphere(force, blunt, 1.0).p_max / 3.5
    surface = rc.ParaboloidSurface(blunt, center=(0.3, 0.21))
    material = rc.ElasticPerfectlyPlastic(1.0, 0.0, hardness)
    found = press(surface, rc.Grid(cells, 32.0), material, force=force).saturated_area()
    fine = press(surface, rc.Grid((256, 256), 32.0), material, force=force).saturated_area("cell-count")
    assert not found.warnings
    assert found.uncertainty < 0.01 * found.value
    assert found.value == pytest.approx(fine.value, rel=5e-3)


@pytest.mark.parametrize("cells", [(1.0, 3.0), (3.0, 1.0)])
def test_areas_of_rough_contacts_on_long_cells_hold_their_uncertainty(cells):
    """Against grids of six times as many cells along each axis; about one in twenty may miss two deviations."""
    misses = 0
    for seed in range(8):
        shape = (72, 24) if cells[0] < cells[1] else (24, 72)
        surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=18.0, longest=72.0, seed=seed)
        grid = rc.Grid(shape, (shape[0] * cells[0], shape[1] * cells[1]))
        problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), grid=grid, boundary="periodic")
        area = problem.solve(pressure=5e-3).area()
        fine = rc.on_grid(problem, (6 * shape[0], 6 * shape[1])).solve(pressure=5e-3).area()
        misses += abs(area.value - fine.value) > 2.0 * area.uncertainty
        assert area.uncertainty < 0.1 * area.value
    assert misses <= 1


@pytest.mark.parametrize("shape", [(64, 64), (96, 32), (37, 71)])
def test_points_missing_outside_a_contact_cut_by_a_free_border_hardly_change_its_area(shape):
    for seed, fraction in ((0, 0.01), (1, 0.03), (2, 0.03)):
        surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=6.0, longest=float(min(shape)), seed=seed)
        heights = np.array(surface.heights(rc.Grid(shape, (float(shape[0]), float(shape[1])))))
        measured = rc.HeightMap(heights, size=(float(shape[0]), float(shape[1])))
        whole = rc.ContactProblem(rc.Body(measured, rc.Elastic(1.0, 0.0))).solve(pressure=2e-3)
        missing = (np.random.default_rng(seed).random(shape) < fraction) & ~whole.contact
        holed = rc.HeightMap(np.where(missing, np.nan, heights), size=measured.size)
        area = rc.ContactProblem(rc.Body(holed, rc.Elastic(1.0, 0.0))).solve(pressure=2e-3).area()
        assert area.value == pytest.approx(whole.area().value, rel=0.01)
        assert area.uncertainty < 2.0 * whole.area().uncertainty
