"""The heights between the cells, their curvatures and summits, beside closed forms on oblong cells."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import roughcontact as rc
from exact_contacts import distances, with_fields
from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.approach import _bound_rise, find_rise, fit_hyperboloid
from roughcontact._answers.areas.creases import CREASE_REACH, find_creased_tops
from roughcontact._answers.areas.hertz import _find_tip_error
from roughcontact._answers.areas.initial_gap import Spline, average_curvature, curvature_resolution, rim_ratio
from roughcontact._answers.areas.peak import _is_rim
from roughcontact._solve.solution.healing import heal

CELLS = [(1.0, 1.0), (1.0, 2.5), (3.0, 1.0)]


def waves(grid, i, j, turns, degree):
    """Return derivatives, along x and along y, of cos(qx x + qy y + 0.3) at points in cells from the first centre."""
    (dx, dy), q = grid.spacing, [2.0 * np.pi * n / side for n, side in zip(turns, grid.size, strict=True)]
    angle = q[0] * i * dx + q[1] * j * dy + 0.3
    return q[0] ** degree[0] * q[1] ** degree[1] * np.cos(angle + 0.5 * np.pi * sum(degree))


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("shape", [(23, 36), (30, 17)])
def test_a_periodic_spline_through_a_wave_and_its_derivatives_anywhere(shape, cell):
    grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
    turns = (2, 1) if shape[0] < shape[1] else (1, 1)
    nodes = np.indices(shape)
    spline = Spline.through(waves(grid, *nodes, turns, (0, 0)), grid.spacing, rc.Boundary.PERIODIC)
    np.testing.assert_allclose(spline.derivatives(*nodes, 0)[0], waves(grid, *nodes, turns, (0, 0)), atol=1e-13)
    rng = np.random.default_rng(1)
    # More than one chunk of points, and beyond the border too.
    i, j = rng.uniform(-1.5, 2.5, (2, 1300)) * np.array(shape)[:, np.newaxis]
    found = spline.derivatives(i, j, 2, 0, 1)
    shortest = max(2.0 * np.pi * n / m for n, m in zip(turns, shape, strict=True))
    for part, degree in zip(found, [(2, 0), (1, 1), (0, 2), (0, 0), (1, 0), (0, 1)], strict=True):
        scale = np.abs(waves(grid, i, j, turns, degree)).max()
        error = 2.0 * shortest**4 / 720.0 if sum(degree) == 2 else shortest**5 / 500.0
        np.testing.assert_allclose(part, waves(grid, i, j, turns, degree), rtol=0.0, atol=error * scale)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("shape", [(9, 14), (16, 11), (3, 6)])
def test_a_free_spline_continues_a_paraboloid_up_to_the_border(shape, cell):
    """Slope and curvature are continued: those of a paraboloid are right half a cell beyond the centres."""
    terms = (0.4, -0.3, 0.7, 0.05, -0.02, 0.03)

    def exact(x, y):
        a, b, c, d, e, f = terms
        return [a + b * x + c * y + d * x**2 + e * x * y + f * y**2, b + 2 * d * x + e * y, c + e * x + 2 * f * y]

    i, j = np.indices(shape)
    spline = Spline.through(exact(i * cell[0], j * cell[1])[0], cell, rc.Boundary.FREE)
    rng = np.random.default_rng(2)
    i, j = (rng.uniform(-0.5, n - 0.5, 200) for n in shape)
    found = spline.derivatives(i, j, 0, 1, 2)
    reach = max(shape) * max(cell)
    errors = [2e-4 * reach, 3e-3 * max(cell), 3e-3 * max(cell), 0.012, 0.012, 0.012]
    exact_values = [*exact(i * cell[0], j * cell[1]), 0.1, -0.02, 0.06]
    for part, expected, error in zip(found, exact_values, errors, strict=True):
        np.testing.assert_allclose(part, np.broadcast_to(expected, part.shape), rtol=0.0, atol=error)
    middle = spline.derivatives(np.array([0.5 * (shape[0] - 1)]), np.array([0.5 * (shape[1] - 1)]), 2)[:, 0]
    np.testing.assert_allclose(middle, (0.1, -0.02, 0.06), rtol=0.0, atol=2e-3)


def test_a_hole_in_a_plane_is_bridged_by_the_plane():
    """The surface of minimum bending through a plane around holes near the contact is the plane."""
    grid = rc.Grid((14, 17), (14.0, 34.0))
    gap = 50.0 + 0.3 * grid.x - 0.2 * grid.y
    missing = np.zeros(grid.shape, dtype=bool)
    missing[4:6, 5:8] = missing[9, 11] = True
    pressure = np.zeros(grid.shape)
    pressure[7, 8] = 1.0
    for boundary in ("free", "periodic"):
        solution = with_fields(grid, pressure, np.where(missing, 1e3, gap), boundary=boundary, non_measured=missing)
        healed = heal(solution)
        np.testing.assert_allclose(healed.initial_gap, gap, rtol=1e-6)
        assert healed.non_measured is None


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("cell", CELLS)
def test_the_curvature_of_a_quadric_is_exact_to_the_border(cell, boundary):
    """Stencils at a free border are moved inside; half the sum and half the difference of the principal curvatures."""
    shape = (13, 18)
    grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
    xx, xy, yy = 0.3, 0.07, 0.11
    gap = 0.5 * xx * grid.x**2 + xy * grid.x * grid.y + 0.5 * yy * grid.y**2
    contact = np.zeros(shape, dtype=bool)
    contact[5:8, 8:11] = True
    if boundary == "free":
        contact[0, 0] = contact[0, 10] = contact[-1, -4:] = True
    solution = with_fields(grid, contact * 1.0, ~contact, initial_gap=gap, boundary=boundary)
    middle, difference, spread, _ = average_curvature(solution)
    np.testing.assert_allclose(middle[1:], 0.5 * (xx + yy), rtol=1e-9)
    np.testing.assert_allclose(difference[1:], math.hypot(0.5 * (xx - yy), xy), rtol=1e-9)
    np.testing.assert_allclose(spread[1:], 0.0, atol=1e-6)


def test_the_spread_of_the_curvature_is_that_of_all_components():
    """Under x^3 / 6 the curvature is x: its standard deviation over the cells, by their pressure, over its mean."""
    grid = rc.Grid((24, 21), (24.0, 42.0))
    gap = grid.x**3 / 6.0 + grid.x**2 + grid.y**2 + 0.0 * grid.y
    pressure = np.zeros(grid.shape)
    pressure[10:14, 9:13] = np.arange(1.0, 5.0)[:, np.newaxis]
    found = average_curvature(with_fields(grid, pressure, 1.0, initial_gap=gap))
    bend, weight = grid.x[10:14, 0], np.arange(1.0, 5.0)
    mean = np.average(bend, weights=weight)
    std = math.sqrt(np.average((bend - mean) ** 2, weights=weight))
    middle = 2.0 + 0.5 * mean
    assert found[0][1] == pytest.approx(middle)
    assert found[1][1] == pytest.approx(0.5 * abs(mean))
    assert found[2][1] == pytest.approx(std / middle)
    # One cell shows no spread: that of its neighbours is taken, in a circle of as many cells.
    one = np.where(np.indices(grid.shape).sum(axis=0) == 22, 0.0, 0.0)
    one[11, 11] = 1.0
    alone = average_curvature(with_fields(grid, one, 1.0, initial_gap=gap))
    reach = 0.2 / np.pi / (2.0 / 3.0 + 1.0 / (4.0 * np.pi))
    assert alone[2][1] == pytest.approx(math.sqrt(2.0 / 3.0 * reach) / (2.0 + 0.5 * grid.x[11, 0]))


def test_the_spread_of_the_curvature_is_the_same_of_transposed_heights():
    rng = np.random.default_rng(3)
    gap = rng.normal(size=(9, 14))
    pressure = np.zeros(gap.shape)
    pressure[3:6, 4:9] = rng.uniform(1.0, 2.0, (3, 5))
    for power in (2, 3):
        along_x = gap.cumsum(axis=0) * power
        grid, turned = rc.Grid((9, 14), (9.0, 28.0)), rc.Grid((14, 9), (28.0, 9.0))
        plain = with_fields(grid, pressure, 1.0, initial_gap=along_x)
        transposed = with_fields(turned, pressure.T, 1.0, initial_gap=along_x.T)
        found, other = (average_curvature(one) for one in (plain, transposed))
        np.testing.assert_allclose(np.stack(other)[:, 1], np.stack(found)[:, 1], rtol=1e-9)


@pytest.mark.parametrize("radius", [0.01, 0.1, 0.3, 0.6, 2.0, 3.0, 5.0])
def test_the_height_of_rounded_tips(radius):
    """They are hyperboloids, whatever their radius."""
    x, y = np.arange(21.0)[:, np.newaxis] - 9.63, np.arange(19.0) - 9.21
    gap = np.sqrt(x**2 + y**2 + radius**2) - radius
    rise, std = find_rise(gap, rc.Boundary.FREE)
    true = gap.min()
    assert rise == pytest.approx(true, rel=1e-3)
    assert abs(rise - true) <= std < 0.05 * true


@pytest.mark.parametrize("power", [1.25, 1.5, 1.75])
def test_the_height_of_tips_between_a_cone_and_a_paraboloid(power):
    rng = np.random.default_rng(8)
    ratios = []
    for _ in range(40):
        x, y = (
            np.arange(cells)[:, np.newaxis] - middle
            for cells, middle in zip((21, 19), rng.uniform(8, 12, 2), strict=True)
        )
        gap = (x**2 + y.T**2) ** (0.5 * power)
        rise, std = find_rise(gap, rc.Boundary.FREE)
        assert rise == pytest.approx(gap.min(), abs=0.1)
        ratios.append((rise - gap.min()) / max(std, 1e-12))
    assert np.mean(np.abs(ratios) <= 2.0) >= 0.9


def test_waves_and_rough_surfaces_have_no_tips():
    rng = np.random.default_rng(4)
    for along_x, along_y in itertools.product((4, 6, 9, 16, 60, 1e3), repeat=2):
        x, y = np.mgrid[-2:3, -2:3] - rng.uniform(-0.4, 0.4, (2, 1, 1))
        wave = 2.0 - np.cos(2.0 * np.pi * x / along_x) - np.cos(2.0 * np.pi * y / along_y)
        assert fit_hyperboloid(wave) == (None, 0.0)
    heights = rc.SelfAffineSurface(hurst=0.5, rms_height=1.0, shortest=3.0, longest=48.0, seed=2).heights(
        rc.Grid((96, 96), 96.0)
    )
    highest = [
        place for place in np.argwhere(heights > np.quantile(heights, 0.95)) if 2 <= min(place) <= max(place) < 94
    ]
    assert len(highest) > 200
    for i, j in highest:
        assert fit_hyperboloid(-heights[i - 2 : i + 3, j - 2 : j + 3]) == (None, 0.0)


@pytest.mark.parametrize("place", [(0, 11), (23, 11), (9, 0), (9, 20), (0, 0), (23, 20)])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_heights_at_the_opposite_border_count_on_a_periodic_boundary_alone(place, boundary):
    grid = rc.Grid((24, 21), (24.0, 42.0))
    gap = grid.x**3 / 50.0 + grid.x**2 + grid.y**2 - 0.01 * grid.y**3
    pressure = np.zeros(grid.shape)
    pressure[place] = 1.0
    steps = np.hypot(*(index - at for index, at in zip(np.indices(grid.shape), place, strict=True)))
    rough = np.where(steps > 9.0, np.random.default_rng(1).normal(size=grid.shape), 0.0)
    solutions = (
        with_fields(grid, pressure, 1.0, initial_gap=heights, boundary=boundary) for heights in (gap, gap + rough)
    )
    plain, changed = (np.stack(average_curvature(one)) for one in solutions)
    assert np.allclose(plain[:, 1], changed[:, 1]) == (boundary == "free")


@pytest.mark.parametrize("turns", [(3, 0), (0, 5), (4, 2)])
def test_the_resolution_ratio_of_waves(turns):
    """Second and fourth differences of a wave are 2 - 2 cos(q h) times it, and that squared."""
    grid = rc.Grid((24, 30), (24.0, 60.0))
    parts = [
        np.cos(2.0 * np.pi * n * at / side) for n, at, side in zip(turns, (grid.x, grid.y), grid.size, strict=True)
    ]
    gap = sum(part for part, n in zip(parts, turns, strict=True) if n) + np.zeros(grid.shape)
    solution = with_fields(grid, 1.0, 0.0, initial_gap=gap, boundary="periodic")
    squares = [2.0 - 2.0 * math.cos(2.0 * np.pi * n / m) for n, m in zip(turns, grid.shape, strict=True)]
    expected = math.sqrt(sum(one**4 for one in squares) / sum(one**2 for one in squares))
    assert curvature_resolution(solution) == pytest.approx(expected, rel=1e-9)


def test_the_rim_of_a_quartic_is_more_curved_than_its_middle():
    """The laplacian of r^4 is 16 r^2: its mean along the rim over that inside, and one of a paraboloid."""
    grid = rc.Grid((31, 40), (31.0, 60.0))
    square = grid.x**2 + grid.y**2
    contact = square < 11.0**2
    inner = contact.copy()
    for axis in (0, 1):
        for step in (-1, 1):
            inner &= np.roll(contact, step, axis=axis)
    quartic = with_fields(grid, contact, ~contact, initial_gap=square**2)
    laplacian = 16.0 * square + 2.0 + 2.0 * grid.spacing[1] ** 2
    assert rim_ratio(quartic) == pytest.approx(laplacian[contact & ~inner].mean() / laplacian[inner].mean(), rel=1e-9)
    assert rim_ratio(with_fields(grid, contact, ~contact, initial_gap=square)) == pytest.approx(1.0)


@pytest.mark.parametrize(("power", "expected"), [(2.0, 0.0), (1.8, 25.0 * (0.2 * math.log(2.0)) ** 4), (1.0, 0.3)])
def test_tips_are_told_by_the_curvature_over_one_and_two_cells(power, expected):
    """Under r^n the curvature over s cells grows as s^(n - 2)."""
    grid = rc.Grid((12, 15), (12.0, 22.5))
    x, y = grid.x - grid.x[5, 0], grid.y - grid.y[0, 7]
    gap = np.abs(x) ** power + np.abs(y) ** power * 0.8
    pressure = np.zeros(grid.shape)
    pressure[5, 7] = pressure[5, 8] = 1.0
    found = _find_tip_error(with_fields(grid, pressure, 1.0, initial_gap=gap, boundary="periodic"))
    assert calibration.TIP_ERROR == (25.0, 0.3)
    np.testing.assert_allclose(found, [expected], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("cell", CELLS)
def test_the_rise_of_a_paraboloid_above_its_highest_cell(cell, boundary):
    rng = np.random.default_rng(6)
    grid = rc.Grid((14, 11), (14 * cell[0], 11 * cell[1]))
    for _ in range(6):
        centre = rng.uniform(-0.5, 0.5, 2) * grid.spacing
        centre += 0.0 if boundary == "free" else 0.5 * np.array(grid.size)
        x, y = distances(grid, centre, boundary)
        gap = 0.3 * x**2 + 0.05 * x * y + 0.2 * y**2
        rise, error = find_rise(gap - gap.min(), rc.Boundary(boundary))
        assert rise == pytest.approx(gap.min(), rel=1e-9)
        assert error == pytest.approx(0.0, abs=1e-12)


def test_the_rise_of_a_wave_is_of_fourth_order():
    for cells, most in ((12, 3e-3), (24, 2e-4)):
        i, j = np.indices((cells, cells + 6))
        gap = 2.0 - np.cos(2 * np.pi * (i - 3.4) / cells) - np.cos(2 * np.pi * (j - 5.3) / (cells + 6))
        rise, error = find_rise(gap - gap.min(), rc.Boundary.PERIODIC)
        assert rise == pytest.approx(gap.min(), rel=30.0 * most)
        assert 0.2 * abs(rise - gap.min()) < error < 0.1 * gap.min()


@pytest.mark.parametrize("cells", [(60, 60), (88, 44), (75, 128), (90, 45)])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_nothing_rises_above_a_flat_land_with_dimples(cells, boundary):
    """Polynomials swing beside their edges by thirty times the true rise, which is zero."""
    x, y = ((np.arange(n) + 0.5) / n * 4 % 1 - 0.5 for n in cells)
    gap = 5e-6 * np.clip(1.0 - (x[:, np.newaxis] ** 2 + y**2) / 0.32**2, 0.0, None)
    rise, std = find_rise(gap, rc.Boundary(boundary))
    # A free border that cuts dimples of eleven cells leaves wedges.
    assert rise < (1e-8 if boundary == "periodic" or min(cells) > 50 else 3e-7)
    assert rise <= 2.0 * std + 1e-12


@pytest.mark.parametrize("radius", [6.0, 9.3, 14.8])
def test_nothing_rises_above_a_pillar(radius):
    x, y = np.arange(40.0)[:, np.newaxis] - 19.3, np.arange(36.0) - 17.6
    rise, std = find_rise(np.where(np.hypot(x, y) < radius, 0.0, 1.0), rc.Boundary.FREE)
    assert rise <= 2.0 * std + 1e-12


def test_lines_through_two_cells_meet_above_a_summit_between_them():
    """A wedge of 0.3 counts on both diagonals; a pyramid has it on one axis and 0.2 on the other."""
    along, across = np.abs(np.arange(-4.0, 5.0) - 0.3), np.abs(np.arange(-4.0, 5.0) + 0.2)
    wedge = np.broadcast_to(along[:, np.newaxis], (9, 9))
    for one in (wedge, wedge.T):
        assert _bound_rise(one[np.newaxis])[0] == pytest.approx(0.6)
    pyramid = along[:, np.newaxis] + across
    assert 0.5 <= _bound_rise(pyramid[np.newaxis])[0] <= 1.0
    x, y = np.arange(-4.0, 5.0)[:, np.newaxis] - 0.4, np.arange(-4.0, 5.0) - 0.2
    round_summit = 0.1 * (x**2 + 0.5 * x * y + y**2)
    assert _bound_rise(round_summit[np.newaxis])[0] > round_summit[4, 4]


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("shape", [(33, 40), (40, 33)])
@pytest.mark.parametrize("bend", [0.0, 0.03])
def test_the_top_of_a_creased_summit_lies_between_the_cells(shape, boundary, bend):
    """Three faces, plane or hollow as dents of balls, meet in a point: the polynomials found a fifth of its height."""
    rng = np.random.default_rng(3)
    for _ in range(6):
        x, y = (np.arange(n) - n // 2 + rng.uniform(-0.5, 0.5) for n in shape)
        directions = rng.uniform(0.0, 7.0) + np.array((0.0, 2.1, 4.2)) + rng.uniform(-0.3, 0.3, 3)
        faces = [np.cos(angle) * x[:, np.newaxis] + np.sin(angle) * y for angle in directions]
        square = x[:, np.newaxis] ** 2 + y**2
        gap = np.max(faces, axis=0) - 0.5 * bend * np.minimum(square, 100.0)
        rise, std = find_rise(gap - gap.min(), rc.Boundary(boundary))
        assert rise == pytest.approx(gap.min(), rel=0.1, abs=0.03)
        assert abs(rise - gap.min()) < 2.0 * std


def test_round_summits_waves_and_cones_have_no_creases():
    rng = np.random.default_rng(4)
    cells = np.arange(-CREASE_REACH, CREASE_REACH + 1.0)
    for _ in range(20):
        x, y = cells[:, np.newaxis] - rng.uniform(-0.5, 0.5), cells - rng.uniform(-0.5, 0.5)
        length = rng.uniform(4.0, 40.0)
        wave = -np.cos(2.0 * np.pi * x / length) - np.cos(2.0 * np.pi * (y + 0.3 * x) / length)
        summits = np.stack((x**2 + 0.4 * x * y + 0.3 * y**2, np.hypot(x, y), np.hypot(x, y) ** 1.5, wave))
        assert not find_creased_tops(summits)[1].any()


def test_a_ridge_has_a_crest_of_any_direction():
    """Grooves of a turning tool meet in a ridge, level or falling; its top is that of the row across it."""
    cells = np.arange(-CREASE_REACH, CREASE_REACH + 1.0)
    for angle in (0.0, 0.5, 0.25 * np.pi, 1.2):
        across = np.cos(angle) * (cells[:, np.newaxis] - 0.3) + np.sin(angle) * (cells - 0.1)
        ridge = np.abs(across) - 0.02 * across**2
        tops, creased = find_creased_tops(np.stack((ridge, ridge.T, 1e-9 * ridge)))
        assert creased.all()
        np.testing.assert_allclose(tops, [0.0, 0.0, 0.0], atol=0.02)


@pytest.mark.parametrize("angle", [0.0, 0.6, 0.25 * np.pi, 2.0])
def test_the_rim_of_a_land_is_no_tip(angle):
    cells = np.arange(-4.0, 5.0)
    x, y = cells[:, np.newaxis] - 0.3, cells + 0.2
    beyond = np.cos(angle) * x + np.sin(angle) * y
    assert _is_rim(np.maximum(beyond + 0.5, 0.0) ** 2)
    for power in (1.0, 1.5, 2.0):
        assert not _is_rim((beyond**2 + 0.3 * (np.cos(angle) * y - np.sin(angle) * x) ** 2) ** (0.5 * power))
