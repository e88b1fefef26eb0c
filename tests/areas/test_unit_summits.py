"""Far fields, ellipses and shared loads of contacts whose fields are closed forms."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from scipy.special import zeta

import roughcontact as rc
from exact_contacts import MODULUS, distances, with_fields
from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.hertz import _average_cells, _find_low_cells, _pair_cells, hertz_areas
from roughcontact._answers.areas.initial_gap import Spline
from roughcontact._answers.areas.summits import (
    _find_near_border,
    find_area_factor,
    find_axes_ratio,
    find_centroids,
    find_far_field,
    find_summits,
    is_elliptic,
)
from scenes import each_once

CELLS = [(1.0, 1.0), (1.0, 2.5), (3.0, 1.0)]


def points(grid, cells, forces, boundary="free"):
    """A solution with a contact of one cell at each place, that carries a force."""
    pressure = np.zeros(grid.shape)
    for place, force in zip(cells, forces, strict=True):
        pressure[place] = force / grid.cell_area
    return with_fields(grid, pressure, np.where(pressure > 0.0, 0.0, 1.0), boundary=boundary)


def displacement(x, y, place, force):
    return force / (np.pi * MODULUS * math.hypot(x - place[0], y - place[1]))


def test_the_far_field_of_point_loads_is_that_of_boussinesq():
    grid = rc.Grid((40, 50), (40.0, 75.0))
    cells, forces = [(5, 7), (12, 30), (30, 20)], [1e3, 3e3, 2e3]
    solution = points(grid, cells, forces)
    x, y = (np.array([cell[k] for cell in cells]) * grid.spacing[k] for k in (0, 1))
    found, step = find_far_field(solution, x, y, np.zeros_like(x)), 1e-3
    for k in range(3):
        others = [((x[n], y[n]), forces[n]) for n in range(3) if n != k]

        def at(a, b, others=others, k=k):
            return sum(displacement(x[k] + a * step, y[k] + b * step, *one) for one in others)

        slope = (at(1, 0) - at(-1, 0), at(0, 1) - at(0, -1))
        np.testing.assert_allclose(found.slope[:, k], np.array(slope) / (2 * step), rtol=1e-5)
        bend = (at(1, 0) + at(-1, 0) - 2 * at(0, 0), 0.25 * (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)))
        bend = (*bend, at(0, 1) + at(0, -1) - 2 * at(0, 0))
        scale = np.abs(found.curvature[:, k]).max()
        np.testing.assert_allclose(found.curvature[:, k], np.array(bend) / step**2, rtol=0.0, atol=1e-4 * scale)


@pytest.mark.parametrize("width", [0.9, 9.0, 90.0])
@pytest.mark.parametrize("boundary", ["free-periodic", "periodic-free"])
def test_the_far_field_of_a_row_of_loads_on_narrow_and_wide_domains(width, boundary):
    """The images at L, 2 L, 3 L ... on both sides bend the surface along the row by 4 zeta(3) F / (pi E* L^3)."""
    order = slice(None) if boundary == "free-periodic" else slice(None, None, -1)
    grid = rc.Grid((9, 12)[order], (width, 9.0)[order])
    solution = points(grid, [(4, 5)[order]], [5e3], boundary)
    x, y = (np.array([2.0]), np.array([3.0]))
    found = find_far_field(solution, x, y, np.zeros(1))
    load = 5e3 / (np.pi * MODULUS * 9.0**3) * zeta(3)
    across, _, along = found.curvature[order, 0]
    assert along == pytest.approx(4.0 * load, rel=0.01)
    assert across == pytest.approx(-2.0 * load, rel=0.01)


@pytest.mark.parametrize("boundary", ["free", "wrapped", "periodic"])
def test_loads_that_are_no_points_have_an_error_by_their_axes(boundary):
    """Two loads across the border of a wrapped or periodic domain are near each other."""
    grid = rc.Grid((40, 30), (40.0, 90.0))
    solution = points(grid, [(2, 5), (37, 5)], [1e3, 4e3], boundary)
    x, y = np.array([2.0, 37.0]), np.array([15.0, 15.0])
    axes = np.array([0.5, 0.2])
    apart = 35.0 if boundary == "free" else 5.0
    found = find_far_field(solution, x, y, axes)
    factor, most = calibration.FAR_FIELD_ERROR
    expected = np.array([4e3, 1e3]) / (np.pi * MODULUS * apart**3) * min(factor * 0.29 / apart**2, most)
    np.testing.assert_allclose(found.error, expected, rtol=0.02)
    np.testing.assert_array_less(0.0, found.slope[0] * np.array((1.0, -1.0)) * (1.0 if boundary == "free" else -1.0))


@pytest.mark.parametrize("sides", [(10.0, 10.0), (10.0, 15.0), (20.0, 10.0)])
@pytest.mark.parametrize("count", [1, 4])
def test_the_far_field_of_a_lattice_of_loads(sides, count):
    """One contact a cell: the curvature of all its images, 9.0336 / L^3 for the sum of both of a square lattice."""
    repeats = (2, 2) if count == 4 else (1, 1)
    grid = rc.Grid((8 * repeats[0], 9 * repeats[1]), (sides[0] * repeats[0], sides[1] * repeats[1]))
    cells = [(3 + 8 * i, 4 + 9 * j) for i in range(repeats[0]) for j in range(repeats[1])]
    solution = points(grid, cells, [5e3] * count, "periodic")
    x, y = (np.array([cell[k] for cell in cells]) * grid.spacing[k] for k in (0, 1))
    found = find_far_field(solution, x + 0.3, y - 37.0, np.zeros_like(x))
    steps = np.arange(-400, 401)
    a, b = np.meshgrid(steps * sides[0], steps * sides[1], indexing="ij")
    radius = np.hypot(a, b)
    inside = (radius > 0.0) & (radius < 390 * min(sides))
    a, b, radius = a[inside], b[inside], radius[inside]
    beyond = 1.0 / (390 * min(sides)) / (sides[0] * sides[1]) * np.pi
    load = 5e3 / (np.pi * MODULUS)
    xx, yy = (load * (float(np.sum((3 * at**2 / radius**2 - 1) / radius**3)) + beyond) for at in (a, b))
    if sides[0] == sides[1]:
        assert (xx + yy) * sides[0] ** 3 / load == pytest.approx(9.03362, rel=1e-3)
    np.testing.assert_allclose(found.curvature[0], xx, atol=0.06 * (xx + yy))
    np.testing.assert_allclose(found.curvature[2], yy, atol=0.06 * (xx + yy))
    np.testing.assert_allclose(found.curvature[1], 0.0, atol=1e-9 * (xx + yy))
    np.testing.assert_allclose(found.slope, 0.0, atol=1e-9 * load / min(sides) ** 2 * 100)


def ellipsoid(grid, curvatures, angle, centre, force, boundary="periodic", **options):
    """The heights of an elliptic paraboloid, with a force on the cells in its contact."""
    x, y = distances(grid, centre, boundary)
    c, s = math.cos(angle), math.sin(angle)
    gap = 0.5 * (curvatures[0] * (c * x + s * y) ** 2 + curvatures[1] * (c * y - s * x) ** 2)
    mean, ratio = 0.5 * sum(curvatures), min(curvatures) / max(curvatures)
    area = np.pi * (0.75 * force / (MODULUS * mean)) ** (2.0 / 3.0) * float(find_area_factor(ratio))
    axes = float(find_axes_ratio(ratio))
    major = math.sqrt(area * axes / np.pi)
    along, across = (x * -s + y * c, x * c + y * s) if curvatures[0] > curvatures[1] else (x * c + y * s, y * c - x * s)
    pressure = np.sqrt(np.maximum(1.0 - (along / major) ** 2 - (across * axes / major) ** 2, 0.0))
    pressure *= force / (pressure.sum() * grid.cell_area)
    solution = with_fields(grid, pressure, pressure == 0.0, initial_gap=gap, boundary=boundary, **options)
    return solution, area, axes


@each_once(
    {
        "moduli": [None, (MODULUS,) * 128],
        "cell": CELLS,
        "curvatures angle": [((2.0, 1.0), 0.0), ((0.5, 1.5), 0.6), ((1.0, 3.0), 2.5), ((1.0, 1.0), 0.0)],
    }
)
def test_summits_have_the_ellipse_of_hertz(cell, curvatures, angle, moduli):
    """Place, area, axes, angle and extents, anywhere on the grid; also of moduli that are alike in all directions."""
    shape = (36, 45)
    grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
    mean = 0.5 * sum(curvatures)
    size = 5.0 * max(cell)
    force = 4.0 / 3.0 * MODULUS * mean * size**3
    if size * 1.8 > 0.4 * min(grid.size):
        grid = rc.Grid((90, 90), (90 * cell[0], 90 * cell[1]))
    for centre in ((0.3, -0.4), (0.3 * cell[0], 0.1 * cell[1])):
        solution, area, axes = ellipsoid(grid, curvatures, angle, centre, force, directional_moduli=moduli)
        spline = Spline.through_gap(solution)
        found = find_summits(solution, spline)
        assert found.known.tolist() == [True]
        steps, sides = np.concatenate((found.row, found.column)), np.array(grid.spacing)
        place = (steps + 0.5) * sides - 0.5 * np.array(grid.size)
        np.testing.assert_allclose(place, centre, atol=0.02 * max(cell))
        # The far field of the images bends the surface a little more.
        assert found.area[0] == pytest.approx(area, rel=0.02)
        assert found.axes_ratio[0] == pytest.approx(axes, rel=0.02)
        assert found.curvature[0] == pytest.approx(mean, rel=0.02)
        assert found.spread[0] == pytest.approx(0.0, abs=1e-3)
        if axes > 1.0:
            longer = angle if curvatures[0] < curvatures[1] else angle + 0.5 * np.pi
            assert math.sin(found.angle[0] - longer) == pytest.approx(0.0, abs=0.01)
        major = math.sqrt(area * axes / np.pi)
        around = np.linspace(0.0, 2.0 * np.pi, 400)
        x, y = found.place(np.cos(around), np.sin(around))
        assert np.hypot(x, y).max() == pytest.approx(major, rel=0.02)
        np.testing.assert_allclose([x.max(), y.max()], [extent[0] for extent in found.extents], rtol=1e-4)


def test_centres_of_pressure_of_patches_across_the_border():
    grid = rc.Grid((10, 12), 1.0)
    pressure = np.zeros(grid.shape)
    pressure[[9, 0], 5] = 1.0, 3.0
    pressure[4, [11, 0, 1]] = 1.0, 1.0, 2.0
    found = find_centroids(with_fields(grid, pressure, 1.0, boundary="periodic"))
    place = sorted(zip(found[0] % 10.0, found[1] % 12.0, strict=True))
    np.testing.assert_allclose(place, [(4.0, 0.25), (9.75, 5.0)])
    free = find_centroids(with_fields(grid, pressure, 1.0))
    expected = [(0.0, 5.0), (4.0, 2.0 / 3.0), (4.0, 11.0), (9.0, 5.0)]
    np.testing.assert_allclose(sorted(zip(*free, strict=True)), expected)


@pytest.mark.parametrize("axis", [0, 1])
def test_an_ellipse_that_a_free_border_cuts_is_not_known(axis):
    grid = rc.Grid((40, 40), (40.0, 60.0))
    force = 4.0 / 3.0 * MODULUS * 7.5**3
    side = 0.5 * grid.size[axis] - 0.5 * grid.spacing[axis]
    for sign in (-1.0, 1.0):
        for room, near in ((7.8, False), (7.0, True)):
            centre = [0.0, 0.0]
            centre[axis] = sign * (side - room)
            solution, _, _ = ellipsoid(grid, (1.0, 1.0), 0.0, centre, force, "free")
            found = find_summits(solution, Spline.through_gap(solution))
            assert _find_near_border(solution, found).tolist() == [near]
            assert found.known.tolist() == [not near]


def test_which_summits_have_an_elliptic_contact():
    """Longer ones than 1:20 only where the curvature varies by less than the smaller principal one."""
    mean = np.array([1.0, 1.0, 1.0, 1.0, 1.0, -1.0])
    ratio = np.array([0.5, 0.06, 0.04, 0.04, 0.005, 0.5])
    difference = mean * (1.0 - ratio) / (1.0 + ratio)
    spread = np.array([0.9, 0.9, 0.9, 0.05, 0.0, 0.0])
    assert is_elliptic(mean, difference, spread).tolist() == [True, True, False, True, False, False]


def test_a_single_ball_carries_its_load_and_pairs_of_cells_are_all():
    label = np.array([0, 0, 0, 1, 3, 3])
    one, other = _pair_cells(label)
    expected = {(i, j) for i in range(6) for j in range(6) if label[i] == label[j]}
    assert set(zip(one.tolist(), other.tolist(), strict=True)) == expected
    assert one.size == len(expected)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_displacement_by_others_is_what_is_left_of_all(boundary):
    """A patch that lies across a periodic border, on oblong cells; beside its own displacement a uniform one."""
    grid = rc.Grid((12, 15), (12.0, 30.0))
    pressure = np.zeros(grid.shape)
    at = [(11, 6), (0, 6), (0, 7), (1, 7)] if boundary == "periodic" else [(3, 6), (4, 6), (4, 7), (5, 7)]
    values = [1.0, 2.0, 4.0, 3.0]
    for cell, value in zip(at, values, strict=True):
        pressure[cell] = value
    x = [grid.spacing[0] * step for step in (0, 1, 1, 2)]
    y = [grid.spacing[1] * step for step in (0, 0, 1, 1)]
    half = [0.5 * side for side in grid.spacing]

    def influence(a, b):
        corner = lambda u, v: u * np.arcsinh(v / abs(u)) + v * np.arcsinh(u / abs(v))  # noqa: E731
        u, v = (np.array((at - side, at + side)) for at, side in zip((a, b), half, strict=True))
        return (corner(u[1], v[1]) - corner(u[0], v[1]) - corner(u[1], v[0]) + corner(u[0], v[0])) / (np.pi * MODULUS)

    own = [sum(q * influence(x[m] - x[n], y[m] - y[n]) for n, q in enumerate(values)) for m in range(4)]
    displaced = np.zeros(grid.shape)
    for cell, value in zip(at, own, strict=True):
        displaced[cell] = value + 7e-9
    gap = np.where(pressure > 0.0, 0.0, 1.0)
    solution = with_fields(grid, pressure, gap, initial_gap=gap - displaced, boundary=boundary)
    summits = find_summits(solution, Spline.through_gap(solution))
    row, column = find_centroids(solution)
    summits = attrs.evolve(summits, row=row, column=column)
    moments, by_others = _average_cells(solution, summits, np.array([True]))
    weight = np.array(values) / sum(values)
    x, y = x - np.dot(weight, x), y - np.dot(weight, y)
    expected = [np.dot(weight, part) for part in (x, y, x * x, x * y, y * y)]
    np.testing.assert_allclose(moments[:, 0], expected, atol=1e-12)
    assert by_others[0] == pytest.approx(7e-9, rel=1e-6)


@pytest.mark.parametrize("cell", [(1.0, 1.0), (1.0, 2.0)])
def test_equal_balls_at_different_places_in_their_cells_share_the_load(cell):
    """Discrete pressures differ with the place in the cell; the common approach gives each ball its part again."""
    grid = rc.Grid((64, 32), (64 * cell[0], 32 * cell[1]))
    x, y = grid.x, grid.y
    first, second = (-16.0 * cell[0] + 0.5 * cell[0], 0.5 * cell[1]), (16.0 * cell[0] + 0.0, 0.0)
    radius = 400.0
    gap = np.minimum(*((np.subtract.outer(x[:, 0], at[0]) ** 2)[:, None] + (y - at[1]) ** 2 for at in (first, second)))
    heights = rc.HeightMap(-gap / (2.0 * radius), size=grid.size, periodic=True)
    problem = rc.ContactProblem(rc.Body(heights, rc.Elastic(MODULUS, 0.0)), grid=grid, boundary="periodic", threads=1)
    solution = problem.solve(force=2.0 * 4.0 / 3.0 * MODULUS / radius * (1.6 * max(cell)) ** 3, tolerance=1e-10)
    found = hertz_areas(solution)
    forces = solution.patches.forces
    assert forces.size == 2
    shared = forces * found.correction.factor
    assert shared.sum() == pytest.approx(forces.sum(), rel=1e-9)
    assert abs(forces[0] / forces[1] - 1.0) > 4.0 * abs(shared[0] / shared[1] - 1.0)
    np.testing.assert_allclose(shared, 0.5 * forces.sum(), rtol=5e-3)
    assert found.area[1] == pytest.approx(found.area[2], rel=5e-3)


@pytest.mark.parametrize("place", [(1, 5), (5, 1), (8, 5), (5, 10), (0, 6), (9, 3), (4, 0), (4, 11)])
def test_summits_beside_a_free_border_are_not_looked_for(place):
    """Their curvature is not known there; on a periodic boundary any place is like any other."""
    grid = rc.Grid((10, 12), 1.0)
    gap = np.full(grid.shape, 3e-6)
    gap[place], gap[5, 6] = 1e-6, 0.0
    pressure = np.where(gap == 0.0, 1.0, 0.0)
    index = place[0] * 12 + place[1]
    for boundary, found in (("free", False), ("periodic", True)):
        low = _find_low_cells(with_fields(grid, pressure, gap, boundary=boundary), 1.0)
        assert (index in low.tolist()) == found
