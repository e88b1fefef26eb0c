"""Small functions of area estimators beside closed forms: saddles, figures' lines, excesses, shares and warnings."""

from __future__ import annotations

import math
from types import SimpleNamespace

import attrs
import numpy as np
import pytest

import roughcontact as rc
from exact_contacts import MODULUS, ball, distances, edge, with_fields
from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.cells import count_saturated, count_sides, find_straight_rows
from roughcontact._answers.areas.contour import (
    _count_alike,
    _find_bracketed_root,
    _find_root,
    find_modulus_change,
    trace_contour,
)
from roughcontact._answers.areas.edges import (
    _count_equal_errors,
    _measure_rims,
    _measure_roundness,
    _measure_width,
    _saturated_weight,
    is_diagonal,
    list_warnings,
    total_area,
    trace_edges,
)
from roughcontact._answers.areas.estimators import _chain, _extrapolate, _smallest_areas, contours, trace_pieces
from roughcontact._answers.areas.hertz import (
    _find_hidden,
    _find_low_cells,
    _raise_to_three_halves,
    hertz_areas,
)
from roughcontact._answers.areas.initial_gap import Spline, lay_ratio
from roughcontact._answers.areas.peak import _find_cut, _find_summits, _gather
from roughcontact._answers.areas.summits import find_lowest
from roughcontact.solving import Whole


@pytest.mark.parametrize("value", [1.0, 0.5])
def test_roots_of_cubics_that_rise_and_of_those_that_fall_between(value):
    """a w^3 + b w^2 + c w reaches a value at a root that is known; b is negative where both fields vary."""
    rng = np.random.default_rng(1)
    root = rng.uniform(0.2, 3.0, 300)
    cubic, linear = rng.uniform(0.1, 2.0, (2, 300))
    square = rng.uniform(0.0, 2.0, 300)
    scale = value / (((cubic * root + square) * root + linear) * root)
    found = _find_root(cubic * scale, square * scale, linear * scale, np.full(300, 50.0), value)
    np.testing.assert_allclose(found, root, rtol=1e-9)
    # Still rising, for the square of the middle term is below three times the product of the others.
    square = -0.7 * np.sqrt(3.0 * cubic * linear)
    scale = value / (((cubic * root + square) * root + linear) * root)
    terms = cubic * scale, square * scale, linear * scale, np.full(300, 4.0)
    np.testing.assert_allclose(_find_root(*terms, value), root, rtol=1e-4)
    np.testing.assert_allclose(_find_bracketed_root(*terms, value), root, rtol=1e-4)


def test_the_modulus_change_of_a_layer_is_that_over_two_octaves():
    """E* as a power of the wave number: four times the wave number at both sides of half a cell."""
    grid = rc.Grid((6, 8), (6.0, 18.0))
    lengths = np.geomspace(1e-3, 1e3, 40)
    layered = with_fields(grid, 1.0, 0.0, moduli=(tuple(lengths.tolist()), tuple((1e9 * lengths**-0.3).tolist())))
    assert find_modulus_change(layered) == pytest.approx(0.3 * math.log(4.0))
    assert trace_edges(layered).shift == pytest.approx(
        trace_edges(with_fields(grid, 1.0, 0.0)).shift + 0.1 * 0.3 * math.log(4.0)
    )
    assert find_modulus_change(with_fields(grid, 1.0, 0.0)) == 0.0
    # One power below half a cell, by the mean side of the cells, and another above.
    half = 0.5 * math.sqrt(grid.cell_area)
    moduli = (1e9 * (half / 1e-3) ** 0.5, 1e9, 1e9 * (half / 1e3) ** 0.1)
    kinked = attrs.evolve(layered, moduli=((1e-3, half, 1e3), moduli))
    assert find_modulus_change(kinked) == pytest.approx((0.5 + 0.1) * math.log(2.0))


def test_edges_that_are_the_same_are_counted():
    """Four equal patches, each at the same place in its cells: each part of an edge is there four times."""
    grid = rc.Grid((40, 40), (40.0, 40.0))
    x, y = distances(rc.Grid((20, 20), 20.0), (0.31, -0.17), "periodic")
    depth = np.tile(5.3 - np.hypot(x, y), (2, 2))
    alone = trace_contour(
        edge(rc.Grid((20, 20), 20.0), depth[:20, :20], boundary="periodic"), np.zeros((20, 20), dtype=bool)
    )
    found = trace_contour(edge(grid, depth, boundary="periodic"), np.zeros((40, 40), dtype=bool))
    np.testing.assert_allclose(found.alike[1:], 4.0 * alone.alike[1])
    assert alone.alike[1] == pytest.approx(1.0, abs=0.3)
    np.testing.assert_allclose(found.area[1:], alone.area[1])
    assert found.area.size == 5
    same = _count_alike(
        Whole(), np.array([0.5, 0.5, 0.2, 0.5]), np.array([1.0, 1.0, 1.0, 0.7]), np.tile([[1.0], [-1.0]], (1, 4))
    )
    assert same.tolist() == [2.0, 2.0, 1.0, 1.0]
    assert _count_equal_errors(np.array([1.0, 3.0])).tolist() == [1.0, 1.0 + 2.0 * calibration.ALIKE_PARTS_FACTOR]


@pytest.mark.parametrize(("apart", "pieces"), [(5.0, 1.0), (7.5, 2.0)])
def test_pieces_are_counted_by_the_euler_number(apart, pieces):
    """Two discs of a radius of 5 cells, apart or as one."""
    grid = rc.Grid((28, 34), 28.0)
    one, other = (np.hypot(*distances(grid, (0.3, s * apart))) for s in (1.0, -1.0))
    scale = 28.0 / 34.0
    found = trace_contour(edge(grid, 5.0 * scale - np.minimum(one, other) * scale), np.zeros(grid.shape, dtype=bool))
    assert found.euler.sum() == pytest.approx(pieces)


def test_a_ring_has_a_hole_and_lines_around_it():
    """Euler number zero; two closed lines, with the contact on their left, of the lengths of both circles."""
    for boundary in ("free", "periodic"):
        grid = rc.Grid((40, 52), (40.0, 78.0))
        centre = (2.3, 1.1) if boundary == "free" else (18.0, 37.0)
        radius = np.hypot(*distances(grid, centre, boundary))
        solution = edge(grid, 4.2 - np.abs(radius - 11.0), boundary=boundary)
        found = trace_contour(solution, np.zeros(grid.shape, dtype=bool))
        assert found.euler[1] == pytest.approx(0.0, abs=1e-9)
        assert found.area[1] == pytest.approx(np.pi * (15.2**2 - 6.8**2), rel=5e-3)
        lines = contours(solution)
        assert len(lines) == 2
        areas = []
        for line in lines:
            np.testing.assert_allclose(line[0], line[-1], atol=1e-9)
            x, y = line.T
            areas.append(0.5 * float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])))
        np.testing.assert_allclose(sorted(areas), [-np.pi * 6.8**2, np.pi * 15.2**2], rtol=0.02)
        pieces, _, _ = trace_pieces(solution)
        total = float(np.sum(np.hypot(*(pieces[:, 1] - pieces[:, 0]).T))) if boundary == "free" else None
        if total is not None:
            assert total == pytest.approx(2.0 * np.pi * 22.0, rel=0.02)


@pytest.mark.parametrize("axis", [0, 1])
def test_lines_of_a_band_end_at_a_free_border_and_run_around_a_periodic_domain(axis):
    grid = rc.Grid((16, 21), (16.0, 42.0))
    across = (grid.x, grid.y)[axis] + np.zeros(grid.shape)
    half = 3.3 * grid.spacing[axis]
    for boundary in ("free", "periodic"):
        lines = contours(edge(grid, half - np.abs(across), boundary=boundary))
        assert len(lines) == 2
        along = 1 - axis
        for line in lines:
            np.testing.assert_allclose(np.abs(line[:, axis]), half, rtol=1e-6)
            assert abs(line[-1, along] - line[0, along]) == pytest.approx(grid.size[along])
            # The contact lies on the left of each line.
            direction = np.sign(line[-1, along] - line[0, along])
            side = np.sign(line[0, axis])
            assert direction * side == (1.0 if axis == 0 else -1.0)
        if boundary == "free":
            assert all(np.abs(line[[0, -1], along]).min() == pytest.approx(0.5 * grid.size[along]) for line in lines)


def test_pieces_are_chained_from_their_open_ends_and_around():
    chains = _chain(np.array([2, 0, -1, 4, 3, 5]))
    found = [(chain.tolist(), closed) for chain, closed in chains]
    assert found == [([1, 0, 2], False), ([3, 4], True), ([5], True)]


def test_discs_and_strips_have_a_width_and_a_roundness():
    """4 A / L of a disc is its diameter; a strip of width b is as wide as a disc of radius b."""
    width = _measure_width(
        np.array([np.pi * 9.0, 2.0 * 100.0, 5.0]),
        np.array([6.0 * np.pi, 200.0, 0.0]),
        1.0,
        np.array([28.0, 200.0, 5.0]),
    )
    np.testing.assert_allclose(width, [28.0, np.pi * 4.0, 5.0], rtol=0.02)
    assert _measure_roundness(np.array([28.0]), np.array([28.0])).tolist() == [1.0]
    assert _measure_roundness(np.array([10.0]), np.array([20.0])).tolist() == [1.0]
    narrow = _measure_roundness(np.array([10.0]), np.array([60.0]))
    assert narrow[0] == pytest.approx(1.0 / (1.0 + 2.0 / (1.0 + 0.04)))


def test_the_excess_grows_with_the_resolution_ratio_up_to_a_part_of_the_area():
    grid = rc.Grid((48, 48), 12.0)
    x, y = distances(grid, (0.1, 0.2), "periodic")
    heights = 0.01 * (np.cos(2.0 * np.pi * x / 2.0) + np.cos(2.0 * np.pi * y / 1.5))
    body = rc.Body(rc.HeightMap(heights, size=grid.size, periodic=True), rc.Elastic(1.0, 0.0))
    edges = trace_edges(rc.ContactProblem(body, boundary="periodic").solve(pressure=2e-3))
    ratio = edges.curvature_resolution
    first, second = calibration.EXCESS
    assert ratio > 0.2
    expected = np.minimum((first * ratio + second * ratio**2) * edges.strip, 0.3 * edges.area)
    np.testing.assert_allclose(edges.excess, expected)


def test_the_standard_deviation_of_an_excess_falls_with_the_pieces_of_the_edge():
    """The other parts are those of all edges together; cells of 1 by 4 double them, and the excess once more."""
    grid = rc.Grid((30, 30), 15.0)
    edges = trace_edges(ball(grid, 9.0, 100.0))
    given = {"shift": 0.1, "slender": 0.2, "saturated": 3.0}
    given = {name: np.full(2, value) for name, value in given.items()}
    edges = attrs.evolve(edges, **given, strip=np.array([0.0, 50.0]), topology=2.0, pieces=16.0, oblong=2.0)
    fraction = np.array([0.0, 0.5])
    excess_std = edges.average_excess(np.array([0.0, 6.0]))
    assert excess_std == pytest.approx(calibration.EXCESS_STD * 6.0 / 4.0)
    parts = (2.0 * excess_std, 2.0, 0.1 * 25.0, 0.2 * 25.0, 1.5)
    assert edges.common_std(excess_std, fraction) == pytest.approx(2.0 * math.hypot(*parts))


def test_standard_deviations_of_single_edges_and_of_those_beside_hertz_areas():
    grid = rc.Grid((30, 30), 15.0)
    edges = trace_edges(ball(grid, 9.0, 100.0))
    alone = 1.6 * edges.std[1] * math.sqrt(edges.alike[1])
    assert edges.alone_std[1] == pytest.approx(alone)
    blended = edges.std[1] * math.sqrt(calibration.BLENDED_STD_FACTOR**2 - 1.0 + edges.alike[1])
    assert edges.blended_std[1] == pytest.approx(blended)


@pytest.mark.parametrize("sides", [(1.0, 1.0), (0.5, 3.0)])
@pytest.mark.parametrize("turn", [0.0, 0.3, 0.25 * math.pi, 2.0])
def test_the_lay_ratio_of_a_quadratic_surface_is_that_of_its_curvatures(turn, sides):
    grid = rc.Grid((40, 41), (40.0 * sides[0], 41.0 * sides[1]))
    u, v = math.cos(turn) * grid.x + math.sin(turn) * grid.y, math.cos(turn) * grid.y - math.sin(turn) * grid.x
    body = rc.Body(rc.HeightMap(-1e-3 * (u**2 + 0.25 * v**2), size=grid.size), rc.Elastic(1.0, 0.0))
    solution = rc.ContactProblem(body).solve(force=0.1)
    assert lay_ratio(solution) == pytest.approx(0.25, rel=1e-6)


def test_narrow_patches_are_not_extrapolated_and_wide_ones_are():
    grid = rc.Grid((30, 30), 15.0)
    edges = trace_edges(ball(grid, 9.0, 100.0))
    middle = math.sqrt(6.0 * 60.0)
    cases = {1.0: 0.0, 1.5: 0.0, 3.0: 0.5, 6.0: 0.5, middle: 0.75, 60.0: 1.0, 500.0: 1.0}
    for width, expected in cases.items():
        found = _extrapolate(attrs.evolve(edges, width=np.full(2, width), roundness=np.ones(2)))
        np.testing.assert_allclose(found, expected)
    slender = _extrapolate(attrs.evolve(edges, width=np.full(2, 60.0), roundness=np.full(2, 0.1)))
    np.testing.assert_allclose(slender, 0.5)


def test_saturated_patches_weigh_from_half_of_their_cells_and_carry_their_load():
    grid = rc.Grid((12, 12), (12.0, 24.0))
    pressure = np.zeros(grid.shape)
    pressure[1, 1:9] = 1.0
    pressure[1, 1:3] = 2.0
    pressure[5, 1:5] = 2.0
    pressure[9, 1:3] = 1.5
    solution = with_fields(grid, pressure, pressure == 0.0, limit=2.0)
    assert _saturated_weight(solution).tolist() == [0.0, 0.5, 1.0, 0.0]
    assert count_saturated(solution).tolist() == [0, 2, 4, 0]
    np.testing.assert_allclose(_smallest_areas(solution), [0.0, (6.0 + 4.0) * 0.5 * 2.0, 4.0 * 2.0, 3.0 * 0.5 * 2.0])
    free = with_fields(grid, pressure, pressure == 0.0)
    assert not _saturated_weight(free).any()
    assert not _smallest_areas(free).any()


def test_rims_count_from_a_third_more_curvature_on():
    first, highest, std = calibration.RIM_POSITION_TERMS
    grid = rc.Grid((31, 31), 31.0)
    square = grid.x**2 + grid.y**2
    contact = square < 11.0**2
    cap = with_fields(grid, contact, ~contact, initial_gap=square)
    quartic = with_fields(grid, contact, ~contact, initial_gap=square**2)
    eighth = with_fields(grid, contact, ~contact, initial_gap=square**6)
    from roughcontact._answers.areas.initial_gap import rim_ratio

    assert not _measure_rims(cap).any()
    np.testing.assert_allclose(_measure_rims(quartic), std * (rim_ratio(quartic) - first))
    np.testing.assert_allclose(_measure_rims(eighth), std * highest)


def test_depths_grow_to_loads_by_three_halves():
    np.testing.assert_allclose(_raise_to_three_halves(np.array([-1.0, 0.0, 4.0, 9.0])), [0.0, 0.0, 8.0, 27.0])


@pytest.mark.parametrize("cell", [(1.0, 1.0), (1.0, 2.0)])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_summits_between_open_cells_have_the_area_of_hertz(cell, boundary):
    """A paraboloid whose summit lies in the corner of four open cells overlaps by a known depth."""
    grid = rc.Grid((20, 24), (20 * cell[0], 24 * cell[1]))
    centre = (0.1 * cell[0], -0.2 * cell[1]) if boundary == "free" else (-10.0 * cell[0], 12.0 * cell[1])
    x, y = distances(grid, centre, boundary)
    radius = 50.0
    gap = (x**2 + y**2) / (2.0 * radius)
    approach = 0.4 * float(gap.min())
    tilt = 1e-6
    solution = with_fields(grid, 0.0, gap - approach, initial_gap=gap, approach=approach, boundary=boundary)
    overlap, unit_depth, unit_area = _find_hidden(solution, Spline.through_gap(solution), 1.0 / radius)
    assert overlap == pytest.approx([approach], rel=8e-3)
    # Hertz: a^3 = 3 F R / 4 E*, depth a^2 / R.
    a = (0.75 * radius / MODULUS) ** (1.0 / 3.0)
    assert unit_depth == pytest.approx([a**2 / radius], rel=2e-3)
    assert unit_area == pytest.approx([np.pi * a**2], rel=2e-3)
    # A tilt of the displacement moves the summit: by its slope times the radius, deeper by half of that.
    tilted = with_fields(grid, 0.0, gap + tilt * x - approach, initial_gap=gap, approach=approach, boundary=boundary)
    if boundary == "free":
        overlap = _find_hidden(tilted, Spline.through_gap(tilted), 1.0 / radius)[0]
        assert overlap == pytest.approx([approach + 0.5 * radius * tilt**2], rel=1e-3)


def test_low_open_cells_are_looked_at_once():
    grid = rc.Grid((12, 12), (6.0, 6.0))
    gap = np.full(grid.shape, 5.0)
    gap[3, 3] = gap[3, 4] = 0.1
    gap[8, 8] = 0.2
    gap[0, 6] = 0.1
    gap[6, 1] = 0.1
    pressure = np.zeros(grid.shape)
    pressure[8, 9] = 1.0
    gap[8, 9] = 0.0
    for boundary, expected in (("free", [(3, 3)]), ("periodic", [(0, 6), (3, 3), (6, 1)])):
        found = _find_low_cells(with_fields(grid, pressure, gap, boundary=boundary), 1.0)
        places = list(zip(*(at.tolist() for at in np.divmod(found, 12)), strict=True))
        assert len(places) == len(expected)
        assert {place if place != (3, 4) else (3, 3) for place in places} == set(expected)
    assert _find_low_cells(with_fields(grid, pressure, gap), 0.1).size == 0
    hole = np.zeros(grid.shape, dtype=bool)
    hole[5, 5] = True
    near = with_fields(grid, pressure, gap, boundary="periodic", non_measured=hole)
    assert (3, 3) not in list(zip(*(at.tolist() for at in np.divmod(_find_low_cells(near, 1.0), 12)), strict=True))


def test_the_highest_cells_of_patches_and_whether_the_border_cuts_them():
    grid = rc.Grid((8, 9), 1.0)
    pressure = np.zeros(grid.shape)
    pressure[0, 1:4] = 1.0, 3.0, 2.0
    pressure[4, 4:7] = 1.0, 2.0, 1.0
    pressure[7, 8] = 1.0
    free = with_fields(grid, pressure, 1.0)
    highest = find_lowest(free, -free.pressure)
    assert sorted(np.transpose(np.divmod(highest, 9)).tolist()) == [[0, 2], [4, 5], [7, 8]]
    assert sorted(_find_cut(free, highest).tolist()) == [False, True, True]
    assert not _find_cut(with_fields(grid, pressure, 1.0, boundary="periodic"), highest).any()
    periodic = SimpleNamespace(boundary=rc.Boundary.PERIODIC, parts=Whole())
    near = _gather(periodic, np.arange(72.0).reshape(8, 9), np.array([13]), 1)
    np.testing.assert_array_equal(near[:, :, 0], [[3, 4, 5], [12, 13, 14], [21, 22, 23]])


@pytest.mark.parametrize("cell", [(1.0, 1.0), (1.0, 2.0)])
@pytest.mark.parametrize("quartic", [0.0, 0.15, -0.1])
def test_the_maximum_pressure_of_a_summit_of_fourth_order(cell, quartic):
    """3 F / 2 A times 1 - 32/45 c4 a^2 / c2 for a profile c2 r^2 + c4 r^4."""
    grid = rc.Grid((40, 44), (40 * cell[0], 44 * cell[1]))
    square = grid.x**2 + grid.y**2
    a, c2 = 9.0, 1.0 / 200.0
    plain = ball(grid, a, 100.0)
    c4 = quartic * c2 / a**2
    solution = with_fields(grid, plain.pressure, plain.gap, initial_gap=c2 * square + c4 * square**2)
    value, error = _find_summits(solution, solution.area("hertz"), find_lowest(solution, -solution.pressure))
    found = hertz_areas(solution)
    hertz = 1.5 * solution.force / found.area[1]
    if quartic == 0.0:
        assert value[0] == pytest.approx(2.0 * MODULUS * a / (np.pi * 100.0), rel=0.01)
    mean = found.summits.curvature[0] / 2.0
    expected = hertz * (1.0 - 32.0 / 45.0 * c4 * found.area[1] / np.pi / mean)
    assert value[0] == pytest.approx(expected, rel=2e-3)
    wanted = calibration.MIN_SUMMIT_ERROR + found.error[1]
    assert error[0] == pytest.approx(wanted, rel=1e-6)


def test_long_edges_along_a_diagonal_of_the_grid_are_told():
    grid = rc.Grid((40, 40), 20.0)
    i, j = np.indices(grid.shape)
    diagonal = (i + j) % 40 < 20
    straight = np.broadcast_to(i < 20, grid.shape)
    steep = (3 * i + j) % 40 < 20
    for contact, lay, expected in (
        (diagonal, 1.0, True), (straight, 1.0, False), (steep, 1.0, False), (steep, 0.0, True), (straight, 0.0, False)
    ):  # fmt: skip
        assert is_diagonal(with_fields(grid, contact, ~contact, boundary="periodic"), lay) == expected
    small = np.hypot(i - 20, j - 20) < 3
    assert not is_diagonal(with_fields(grid, small, ~small, boundary="periodic"), 1.0)


def test_warnings_of_areas_come_where_the_grid_fails():
    """Below 5.5 cells a wave; a fifth of the area in small patches of a grid that hardly resolves them; on a layer."""
    grid = rc.Grid((20, 20), 10.0)
    contact = np.zeros(grid.shape, dtype=bool)
    contact[2:8, 2:8] = True
    contact[12, 12] = contact[15, 15] = contact[18, 18] = True
    few = with_fields(grid, contact, ~contact, boundary="periodic")
    assert list_warnings(few, 0.0) == ()
    assert list_warnings(few, (2.0 * math.pi / 5.6) ** 2) == ()
    (words,) = list_warnings(few, (2.0 * math.pi / 5.4) ** 2)
    assert "about 5.4 cells" in words
    contact[[12, 15, 18, 12, 15, 18], [1, 1, 1, 5, 5, 5]] = True
    contact[12, 8] = True
    many = with_fields(grid, contact, ~contact, boundary="periodic")
    assert list_warnings(many, 0.39) == ()
    (words,) = list_warnings(many, 0.41)
    assert "21.7 % of the counted area" in words
    layers = [
        (tuple(np.geomspace(0.01, 100.0, 30)), tuple(1e9 * np.geomspace(0.01, 100.0, 30) ** -power))
        for power in (0.2, 0.25)
    ]
    assert [len(list_warnings(attrs.evolve(few, moduli=one), 0.0)) for one in layers] == [0, 1]
    stopped = attrs.evolve(few, status=rc.Status.STALLED)
    assert list_warnings(stopped, 0.0) == ("the solution is not converged",)


def test_an_area_is_that_of_its_patches_and_at_most_nominal():
    grid = rc.Grid((20, 30), (20.0, 60.0))
    solution = ball(grid, 8.0, 100.0)
    edges = attrs.evolve(trace_edges(solution), border=3.0)
    found = total_area(solution, np.array([1.0, 200.0]), np.array([2.0, 6.0]), 1.5, edges, "mine")
    assert (found.value, found.estimator) == (201.0, "mine")
    assert found.fraction == pytest.approx(201.0 / 1200.0)
    assert found.uncertainty == pytest.approx(math.sqrt(4.0 + 36.0 + 2.25 + 9.0))
    np.testing.assert_allclose(found.patches, [200.0])
    assert found.perimeter == pytest.approx(edges.length.sum())
    more = total_area(solution, np.array([100.0, 1400.0]), np.zeros(2), 0.0, edges, "mine")
    assert more.value == 1200.0
    np.testing.assert_allclose(more.patches, [1400.0 * 1200.0 / 1500.0])
    edges = attrs.evolve(edges, border=0.0)
    sure = total_area(solution, np.array([0.0, 200.0]), np.zeros(2), 13.9, edges, "")
    unsure = total_area(solution, np.array([0.0, 200.0]), np.zeros(2), 14.1, edges, "")
    assert (len(sure.warnings), len(unsure.warnings)) == (0, 1)


def touching(contact, boundary):
    """What the counts of sides read of a solution."""
    return SimpleNamespace(contact=contact, boundary=boundary, parts=Whole(), _keep=lambda _, find: find())


@pytest.mark.parametrize(
    ("boundary", "sides"), [(rc.Boundary.FREE, 4), (rc.Boundary.PERIODIC, 6), (rc.Boundary.WRAPPED, 6)]
)
def test_sides_are_counted_across_a_periodic_border(boundary, sides):
    mask = np.zeros((5, 6), dtype=bool)
    mask[0, 2:4] = True
    assert count_sides(touching(mask, boundary)) == sides


def test_a_row_of_cells_is_not_its_own_neighbour():
    assert count_sides(touching(np.array([[True, False, False, True]]), rc.Boundary.PERIODIC)) == 2


def test_straight_rows():
    mask = np.zeros((6, 6), dtype=bool)
    mask[1:3, 1:5] = True
    assert sorted(find_straight_rows(touching(mask, rc.Boundary.FREE))) == [2, 2, 4, 4]
    for shift in range(6):
        moved = np.roll(mask, (shift, -shift), (0, 1))
        assert sorted(find_straight_rows(touching(moved, rc.Boundary.PERIODIC))) == [2, 2, 4, 4]
