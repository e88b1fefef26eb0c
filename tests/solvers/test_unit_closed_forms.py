"""Small functions of areas, solvers, sweeps and files beside closed forms, on oblong cells and on several tiles."""

from __future__ import annotations

import math
import os
import time
from types import SimpleNamespace

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import reference
from roughcontact._answers.areas import summits
from roughcontact._answers.areas.cells import count_sides, find_straight_rows
from roughcontact._answers.areas.contour import measure_polygons
from roughcontact._answers.areas.dual_cells import find_kinds
from roughcontact._answers.linear.stiffness import _find_rows, _shift
from roughcontact._base.archive import remove_stale
from roughcontact._parts.files.points import put_on_grid
from roughcontact._parts.files.text import require_heights
from roughcontact._parts.grid import grow
from roughcontact._solve.problem.sweep import predict_pressure
from roughcontact._solve.solvers.conjugate.descent import Descent
from roughcontact._solve.solvers.projection import ApproachControl, LoadControl, ReleasedCells, project_to_weighted_load
from roughcontact.results import Sweep
from roughcontact.solving import Whole
from roughcontact.typing import Load
from scenes import each_once

CORNERS = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])


@pytest.mark.parametrize("ratio", [1.0, 0.7, 0.2, 0.02])
def test_ellipses_are_those_of_hertz(ratio):
    force, modulus, radius = 3.0, 2e9, 1e-3
    radii = (radius, radius / ratio)
    elliptic = reference.hertz_elliptic(force, radii, modulus)
    mean = 2.0 / (1.0 / radii[0] + 1.0 / radii[1])
    circular = reference.hertz_sphere(force, mean, modulus)
    assert summits.find_area_factor(ratio) == pytest.approx(elliptic.area / circular.area, rel=1e-3)
    axes = summits.find_axes_ratio(ratio)
    semi_axis = np.sqrt(elliptic.area / np.pi * axes)
    assert 1.5 * summits.find_depth(force, semi_axis, axes, modulus) == pytest.approx(elliptic.approach, rel=2e-3)


@pytest.mark.parametrize(
    ("points", "power"), [(summits.points_of_hertz(), 0.5), (summits.points_of_punch(), -0.5)], ids=["hertz", "punch"]
)
def test_points_in_the_circle_give_the_means_by_its_pressure(points, power):
    """The pressure is (1 - r^2)^power; the moments of even degree are beta functions."""
    x, y, weight = points
    assert weight.sum() == pytest.approx(1.0, rel=1e-14)
    square = 1.0 / (power + 2.0)
    fourth = 2.0 / ((power + 2.0) * (power + 3.0))
    assert weight @ x**2 == pytest.approx(0.5 * square, rel=1e-13)
    assert weight @ y**2 == pytest.approx(0.5 * square, rel=1e-13)
    assert weight @ x**4 == pytest.approx(0.375 * fourth, rel=1e-13)
    assert weight @ (x**2 * y**2) == pytest.approx(0.125 * fourth, rel=1e-13)
    for odd in (x, y, x * y, x**3, x**2 * y, x**3 * y):
        assert weight @ odd == pytest.approx(0.0, abs=1e-15)


def clip(distance, size):
    """Return area and chord of the part of a cell where a plane through the corners is positive."""
    polygon, cuts = [], []
    for k in range(4):
        one, other = distance[k], distance[(k + 1) % 4]
        if one > 0.0:
            polygon.append(CORNERS[k])
        if (one > 0.0) != (other > 0.0):
            cuts.append(CORNERS[k] + one / (one - other) * (CORNERS[(k + 1) % 4] - CORNERS[k]))
            polygon.append(cuts[-1])
    x, y = (np.array(polygon) * size).T if polygon else np.zeros((2, 1))
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    return area, math.dist(cuts[0] * size, cuts[1] * size) if cuts else 0.0


@pytest.mark.parametrize("size", [(1.0, 3.0), (3.0, 1.0), (0.5, 0.5)])
def test_a_straight_edge_through_a_cell(size):
    rng = np.random.default_rng(3)
    slopes, level = rng.normal(size=(400, 2)), rng.normal(size=400)
    distance = np.ascontiguousarray((level[:, np.newaxis] + slopes @ CORNERS.T).T)
    contact = distance > 0.0
    area, chord, euler = measure_polygons(distance, contact, find_kinds(contact), size)
    expected = np.array([clip(one, size) for one in distance.T])
    cut = contact.any(axis=0) & ~contact.all(axis=0)
    np.testing.assert_allclose(area[cut], expected[cut, 0], rtol=1e-12)
    np.testing.assert_allclose(chord[cut], expected[cut, 1], rtol=1e-12)
    inside = contact.sum(axis=0)
    np.testing.assert_array_equal(euler, np.select([inside == 1, inside == 3], [0.25, -0.25], 0.0))


@pytest.mark.parametrize(("inside", "connected"), [(3.0, True), (1.0, False)])
@pytest.mark.parametrize("first", [0, 1])
def test_opposite_corners_in_contact(inside, connected, first):
    """Each of the two triangles has legs of a part of the sides; of connected corners the open ones lose theirs."""
    size = (2.0, 3.0)
    distance = np.full((4, 1), -2.0)
    distance[first::2] = inside
    contact = distance > 0.0
    area, chord, euler = measure_polygons(distance, contact, find_kinds(contact), size)
    part = (2.0 if connected else inside) / (inside + 2.0)
    triangles = part**2 * size[0] * size[1]
    assert area[0] == pytest.approx(size[0] * size[1] - triangles if connected else triangles)
    assert chord[0] == pytest.approx(2.0 * part * math.hypot(*size))
    assert euler[0] == -0.5


def test_rows_of_sides_across_the_border_are_one():
    contact = np.zeros((6, 8), dtype=bool)
    contact[2:4, [0, 1, 6, 7]] = True
    free, periodic = rc.Boundary.FREE, rc.Boundary.PERIODIC
    on_periodic, on_free = (
        SimpleNamespace(contact=contact, boundary=one, parts=Whole(), _keep=lambda _, find: find())
        for one in (periodic, free)
    )
    assert sorted(find_straight_rows(on_periodic)) == [2, 2, 4, 4]
    assert sorted(find_straight_rows(on_free)) == [2, 2, 2, 2, 2, 2]
    assert count_sides(on_periodic) == count_sides(on_free) == 12
    assert count_sides(on_free, np.indices(contact.shape)[1] < 4) == 6
    i, j = np.nonzero(contact & ~np.roll(contact, 1, axis=0))
    starts, lengths = _find_rows(i, j, 0)
    assert (starts.tolist(), lengths.tolist()) == ([0, 2], [2, 2])
    starts, lengths = _find_rows(i, j, 8)
    assert (starts.tolist(), lengths.tolist()) == ([2], [4])
    whole = _find_rows(np.repeat([1, 4], 8), np.tile(np.arange(8), 2), 8)
    assert (whole[0].tolist(), whole[1].tolist()) == ([0, 8], [8, 8])


@pytest.mark.parametrize("step", [1, -1])
def test_neighbours_along_x_end_at_a_free_border(step):
    mask = np.zeros((4, 3), dtype=bool)
    mask[[0, -1]] = True
    np.testing.assert_array_equal(_shift(mask, step, 0, free=False), np.roll(mask, step, axis=0))
    inner = np.zeros((4, 3), dtype=bool)
    inner[1 if step == 1 else 2] = True
    np.testing.assert_array_equal(_shift(mask, step, 0, free=True), inner)


@pytest.mark.parametrize("width", [1, 2])
def test_a_mask_grows_by_squares_around_its_cells(width):
    mask = np.zeros((7, 9), dtype=bool)
    mask[0, 4] = True
    rows, columns = np.indices(mask.shape)
    beside = abs(columns - 4) <= width
    np.testing.assert_array_equal(grow(mask, width, rc.Boundary.FREE), beside & (rows <= width))
    around = np.minimum(rows, 7 - rows) <= width
    np.testing.assert_array_equal(grow(mask, width, rc.Boundary.PERIODIC), beside & around)


class Springs:
    """Cells on springs of their own: what K p is by, and its exact inverse."""

    def __init__(self, compliance):
        self.compliance = compliance

    def apply(self, *arguments):
        if len(arguments) == 1:
            return arguments[0] * self.compliance.reshape(arguments[0].shape)
        active, _, residual = arguments
        return residual * active.gather(1.0 / self.compliance)

    def weights(self, active):
        return active.gather(1.0 / self.compliance)

    def levels(self, *_):
        return None


@each_once(
    {
        "limit": [math.inf, 1.2, "varied"],
        "given": ["approach", "load"],
    }
)
def test_the_descent_of_cells_on_springs_has_a_closed_form(limit, given):
    """p = clip((level - h) / k, 0, limit) on three tiles; the error of any pressure is that of its parts."""
    shape = (3, 2**16 + 7)
    rng = np.random.default_rng(11)
    compliance = rng.uniform(0.5, 2.0, np.prod(shape)).astype(np.float32)
    height = rng.normal(size=compliance.size)
    bound = rng.uniform(0.5, 1.5, compliance.size) if limit == "varied" else np.array([limit])
    level = 0.0 if given == "approach" else 0.37
    exact = np.clip((level - height) / compliance, 0.0, bound)
    control = ApproachControl() if given == "approach" else LoadControl(float(exact.sum()))
    springs = Springs(compliance)
    descent = Descent(springs.apply, shape, springs, control, bound)
    pressure = np.minimum(np.full(compliance.size, exact.mean()), bound)
    pressure *= exact.sum() / pressure.sum()
    pressure = np.minimum(pressure, bound)
    descent.start(pressure.copy(), (height + compliance * pressure).astype(np.float32))
    first = descent.find_error()
    for _ in range(60):
        if not descent.iterate() or descent.find_error() < 1e-6 * first:
            break
    assert descent.find_error() < 1e-4 * first
    tolerance = 1e-3 if given == "approach" or limit == math.inf else 5e-2
    np.testing.assert_allclose(descent.pressure, exact, rtol=0.0, atol=tolerance)


def test_the_error_of_the_descent_sees_every_tile():
    """A single cell, in any tile, that overlaps by 0.5."""
    n = 2**16
    for place in (3, n + 5, 2 * n + 7):
        pressure, gap = np.zeros(3 * n), np.full(3 * n, 1.0, dtype=np.float32)
        pressure[::1000], gap[::1000] = 1.0, 0.0
        gap[place] = -0.5
        springs = Springs(np.ones(3 * n, dtype=np.float32))
        descent = Descent(springs.apply, (3, n), springs, ApproachControl(), np.array([math.inf]))
        descent.start(pressure, gap)
        assert descent.find_error() == pytest.approx(0.5)


@pytest.mark.parametrize("limit", [math.inf, 0.8])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 30.0])
def test_the_projection_to_a_load_is_that_of_bisection(limit, scale):
    rng = np.random.default_rng(5)
    values, weights = scale * rng.normal(size=501), rng.uniform(0.2, 3.0, 501)
    load, bound = 120.0, np.array([limit])
    low, high = -1e6, 1e6
    for _ in range(200):
        middle = 0.5 * (low + high)
        more = np.clip(values - middle * weights, 0.0, limit).sum() > load
        low, high = (middle, high) if more else (low, middle)
    found = project_to_weighted_load(values.copy(), weights, load, bound, 0.0)
    np.testing.assert_allclose(found, np.clip(values - low * weights, 0.0, limit), rtol=0.0, atol=1e-9 * scale + 1e-12)


def test_an_admissible_direction_keeps_the_load_and_moves_no_cell_outward():
    rng = np.random.default_rng(6)
    direction, weights = rng.normal(size=(2, 80)).astype(np.float32)
    weights = np.abs(weights) + np.float32(0.1)
    released = ReleasedCells(np.arange(0, 20), np.arange(20, 50))
    found = LoadControl(1.0).admissible(direction, weights, released)
    assert found.sum() == pytest.approx(0.0, abs=1e-5)
    assert found[:20].min() >= 0.0
    assert found[20:50].max() <= 0.0
    shift = (direction - found)[50:] / weights[50:]
    np.testing.assert_allclose(shift, shift[0], rtol=1e-4, atol=1e-6)
    expected = direction - shift[0] * weights
    np.testing.assert_allclose(found[:20], np.maximum(expected[:20], 0.0), rtol=0.0, atol=1e-5)
    np.testing.assert_allclose(found[20:50], np.minimum(expected[20:50], 0.0), rtol=0.0, atol=1e-5)


def test_secant_stiffness_in_any_order_of_loads():
    """F = d^2 at approaches 1, 2, 4, in another order and one of them twice: chords by hand."""
    approaches = [4.0, 1.0, 2.0, 1.0]
    sweep = Sweep(tuple(SimpleNamespace(force=one**2, approach=one) for one in approaches))
    np.testing.assert_allclose(sweep.secant_stiffness, [12.0 / 2.0, 3.0 / 1.0, 15.0 / 3.0, 3.0 / 1.0])
    alone = Sweep((SimpleNamespace(force=1.0, approach=1.0),))
    assert np.isnan(alone.secant_stiffness).all()


def solved(mean, pressure, *, limit=math.inf, gap=None):
    pressure = np.asarray(pressure, dtype=np.float64)
    saturated = pressure >= limit
    gap = np.zeros_like(pressure) if gap is None else np.asarray(gap)
    return SimpleNamespace(
        tension=None,
        mean_pressure=mean,
        pressure=pressure,
        contact=pressure > 0.0,
        saturated=saturated,
        pressure_limit=limit,
        gap=gap,
    )


def test_a_predicted_pressure_follows_powers_of_the_load():
    one, two = np.array([[1.0, 0.5, 0.0]]), np.array([[2.0, 1.0, 0.25]])
    load = Load("pressure", 4.0)
    assert predict_pressure([], load) is None
    np.testing.assert_allclose(predict_pressure([solved(2.0, two)], load), 2.0 * two)
    np.testing.assert_allclose(predict_pressure([solved(2.0, two), solved(2.0, two)], load), 2.0 * two)
    # Loads of equal ratios: the power 7/4 of the pressure changes by as much again.
    expected = (2.0 * two**1.75 - one**1.75) ** (1.0 / 1.75)
    np.testing.assert_allclose(predict_pressure([solved(1.0, one), solved(2.0, two)], load), expected, rtol=1e-5)
    assert predict_pressure([solved(2.0, two)], Load("pressure", 4.1)) is None
    assert predict_pressure([solved(2.0, two)], Load("pressure", 0.99)) is None
    capped = predict_pressure([solved(1.0, one, limit=2.5), solved(2.0, two, limit=2.5)], load)
    np.testing.assert_allclose(capped, np.minimum(expected, 0.97 * 2.5), rtol=1e-5)


def test_a_saturated_cell_stays_so_while_it_will_overlap():
    limit, load = 2.0, Load("pressure", 4.0)
    before = solved(1.0, [[2.0, 2.0, 0.5]], limit=limit, gap=[[-1.0, -1.0, 0.0]])
    last = solved(2.0, [[2.0, 2.0, 1.0]], limit=limit, gap=[[-2.0, -0.1, 0.0]])
    assert predict_pressure([last], load) is None
    found = predict_pressure([before, last], load)
    assert found[0, 0] == limit
    assert found[0, 1] == pytest.approx(0.97 * limit, rel=1e-6)


def test_only_old_unfinished_files_of_other_machines_go(tmp_path):
    """A link is nobody's unfinished file, however old what it names is."""
    old, new, link = (f".map.npz.{machine}-1.0123456789ab.partial" for machine in ("00000001", "00000002", "00000003"))
    for name in (old, new, "kept"):
        (tmp_path / name).write_text("")
    (tmp_path / link).symlink_to(tmp_path / "kept")
    week = 7 * 24 * 3600
    for name, age in ((old, week + 60), (new, week - 60), ("kept", 2 * week)):
        os.utime(tmp_path / name, (time.time() - age,) * 2)
    remove_stale(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([new, link, "kept"])


def points_of(shape, step, chosen=slice(None)):
    i, j = (one.ravel() for one in np.indices(shape))
    return np.stack((i * step[0], j * step[1], 10.0 * i + j), axis=1)[chosen]


def test_points_are_placed_from_half_of_a_grid_on():
    shape, step = (6, 8), (1.0, 3.0)
    rng = np.random.default_rng(2)
    i, j = np.indices(shape)
    # Even ones of a chessboard are exactly half, and show each row and column.
    half = np.flatnonzero((i + j).ravel() % 2 == 0)
    found = put_on_grid(rng.permutation(points_of(shape, step, half))).heights
    np.testing.assert_array_equal(found, np.where((i + j) % 2 == 0, 10.0 * i + j, np.nan))
    with pytest.raises(rc.InputError, match="do not lie on a regular grid"):
        put_on_grid(points_of(shape, step, half[1:]))
    twice = points_of(shape, step)
    twice[5] = twice[6]
    with pytest.raises(rc.InputError, match="two of them or more stand at one place"):
        put_on_grid(twice)


@pytest.mark.parametrize(("side", "unit"), [(0.01, "metre"), (0.0125, "micrometre")])
def test_the_unit_of_points_is_guessed_from_their_longer_side(side, unit):
    """Eight points at 0.0125 are 0.1 long: no longer taken for metres."""
    hint = put_on_grid(points_of((8, 4), (side, 0.5 * side))).hint
    length, factor = 8 * side, 1.0 if unit == "metre" else 1e-6
    assert f"that is the {unit}, size=({factor * length:.6g}, {factor * length / 4:.6g})" in hint


@pytest.mark.parametrize(("off", "accepted"), [(0.04, True), (0.06, False)])
def test_places_may_be_rounded_by_a_twentieth_of_a_step(off, accepted):
    points = points_of((5, 4), (1.0, 2.0))
    points[points[:, 0] == 2.0, 0] += off
    if accepted:
        np.testing.assert_array_equal(put_on_grid(points).heights, points[:, 2].reshape(5, 4))
        return
    with pytest.raises(rc.InputError, match="do not lie on a regular grid"):
        put_on_grid(points)


def test_margins_are_told_from_eight_numbers_on():
    rng = np.random.default_rng(4)
    for count in (7, 8):
        by_row = np.vstack((np.arange(count) * 0.5, rng.normal(size=(9, count))))
        for table, words in ((by_row, "its first row rise in equal steps"), (by_row.T, "its first column rise")):
            if count == 7:
                require_heights(table)
                continue
            with pytest.raises(rc.InputError, match=words):
                require_heights(table)
    both = np.zeros((10, 10))
    both[1:, 1:] = rng.normal(size=(9, 9))
    both[0, 1:] = both[1:, 0] = np.arange(9)
    with pytest.raises(rc.InputError, match="its first row and its first column count"):
        require_heights(both)
    require_heights(np.add.outer(np.arange(9.0), np.arange(9.0)))
