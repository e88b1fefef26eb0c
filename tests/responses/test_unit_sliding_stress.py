"""Stress below a contact that slides: Cerruti's cells, Hamilton's ball, the surface, first yield, and fatigue."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy import optimize

import roughcontact as rc
from roughcontact._answers.subsurface.field import find_crossland, find_dang_van, find_spheres, list_paths, von_mises
from roughcontact._parts.kernels.stress_cells import cell_stress
from roughcontact.reference import SlidingCylinder, SlidingSphere
from scenes import each_once
from test_sliding_reference import tangential_point_force
from test_stress import NU, RADIUS, STEEL, XX, XY, XZ, YY, YZ, ZZ, convolve, press_ball
from test_stress import press_rough as rough
from test_unit_stress import superpose

EXCHANGED = [YY, XX, ZZ, XZ, YZ, XY]


def turn(stress, degrees):
    """Return stresses, shape (6, ...), after a turn of the body from x towards y."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    xx, yy, zz, yz, xz, xy = stress
    return np.array(
        [
            c * c * xx + s * s * yy - 2 * c * s * xy,
            s * s * xx + c * c * yy + 2 * c * s * xy,
            zz,
            s * xz + c * yz,
            c * xz - s * yz,
            c * s * (xx - yy) + (c * c - s * s) * xy,
        ]
    )


def below_ball(solution, hertz, place, z, mu, degrees=0.0):
    """Return Hamilton's stress at the cells of a solution over the maximum pressure."""
    grid, spacing = solution.grid, 4e-6
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y = grid.x - place[0] * spacing, grid.y - place[1] * spacing
    sphere = SlidingSphere(hertz.semi_axes[0], 1.0, mu, NU)
    return turn(sphere.stress(c * x + s * y, c * y - s * x, z), degrees)


def largest_on_sphere(mu):
    """Return the maximum von Mises stress below a sliding sphere over the maximum pressure, and its depth."""
    sphere = SlidingSphere(1.0, 1.0, mu, NU)

    def negative(place):
        return -float(von_mises(sphere.stress(place[0], 0.0, abs(place[1]))))

    found = optimize.minimize(negative, (mu, 0.45), method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-12})
    edge = float(von_mises(sphere.stress(-1.0, 0.0, 0.0)))
    return (-found.fun, abs(found.x[1])) if -found.fun > edge else (edge, 0.0)


@pytest.mark.parametrize(("nu", "z", "sides"), [(0.3, 0.4, (1.0, 0.7)), (0.0, 2.0, (1.0, 1.0)), (0.5, 1.0, (0.3, 2.0))])
def test_a_cell_is_the_integral_of_tangential_point_forces(nu, z, sides):
    nodes, weights = np.polynomial.legendre.leggauss(80)
    along_x, along_y = (cell_stress(z, nu, (4, 3), sides, np.float64, load) for load in "xy")
    for i, j in ((0, 0), (1, 0), (0, 2), (3, 1)):
        x = (i - 0.5 * nodes[:, np.newaxis]) * sides[0]
        y = (j - 0.5 * nodes[np.newaxis, :]) * sides[1]
        area = sides[0] * sides[1] / 4.0
        for table, points in (
            (along_x, tangential_point_force(x, y, z, nu)),
            (along_y, tangential_point_force(y, x, z, nu)[EXCHANGED]),
        ):
            whole = np.einsum("aij,i,j->a", points, weights, weights) * area
            np.testing.assert_allclose(table[:, i, j], whole, atol=1e-9)


@pytest.mark.slow
@each_once(
    {
        "sides": [(1.0, 1.0), (1.0, 3.0)],
        "z": [0.0, 0.3, 2.5, 11.0],
    }
)
def test_transforms_are_the_sums_over_cells(sides, z):
    traction = np.random.default_rng(5).standard_normal((2, 24, 15)).astype(np.float32)

    def add(loads, images):
        return sum(superpose(load, z, NU, sides, images, letter) for load, letter in zip(loads, "xy", strict=True))

    free = convolve(traction, z, "free", sides, "xy", common=(4, 1))
    np.testing.assert_allclose(free, add(traction, 0), atol=1e-5)
    # Without a mean the error of the sum over images falls with their number.
    traction -= traction.mean(axis=(1, 2), keepdims=True, dtype=np.float64).astype(np.float32)
    periodic = convolve(traction, z, "periodic", sides, "xy")
    np.testing.assert_allclose(periodic, 2.0 * add(traction, 24) - add(traction, 12), atol=4e-5)


@each_once(
    {
        "mu": [0.1, 0.25, 0.5],
        "shape sides degrees": [
            ((48, 45), (1.0, 1.0), 0.0),
            ((45, 90), (1.0, 1.0), 90.0),
            ((17, 49), (3.0, 1.0), 35.0),
        ],
    }
)
def test_hamiltons_ball_at_all_points(mu, shape, sides, degrees):
    place = (0.31, -0.17)
    solution, hertz, _ = press_ball(16.0, shape, sides=sides, place=place)
    # Depth in cells, and the error that uniform loads on cells leave, over the maximum pressure.
    for cells, error in ((4, 3e-3), (8, 1e-3), (16, 4e-4)):
        z = cells * max(solution.grid.spacing)
        found = solution.stress([z], friction=mu, direction=degrees).components[0] / hertz.p_max
        assert np.abs(found - below_ball(solution, hertz, place, z, mu, degrees)).max() < error


@each_once(
    {
        "mu": [0.1, 0.25, 0.5],
        "boundary": ["free", "periodic"],
    }
)
def test_a_slide_to_the_other_side_mirrors_the_stress_and_an_exchange_of_axes_transposes_it(mu, boundary):
    solution, _, _ = press_ball(6.0, (25, 31), sides=(3.0, 1.0), boundary=boundary, tolerance=1e-8)
    depths = [cells * solution.grid.spacing[1] for cells in (0.5, 2.0, 5.0)]
    found = solution.stress(depths, friction=mu).components
    peak = solution.pressure.max()
    signs = np.array([1, 1, 1, 1, -1, -1])[:, np.newaxis, np.newaxis]
    other = solution.stress(depths, friction=mu, direction=180.0).components
    np.testing.assert_allclose(other, signs * found[:, :, ::-1], atol=2e-5 * peak)
    exchanged, _, _ = press_ball(6.0, (31, 25), sides=(1.0, 3.0), boundary=boundary, tolerance=1e-8)
    along_y = exchanged.stress(depths, friction=mu, direction=90.0).components
    np.testing.assert_allclose(along_y[:, EXCHANGED].transpose(0, 1, 3, 2), found, atol=2e-5 * peak)


@pytest.mark.parametrize("direction", [0.0, 180.0])
@pytest.mark.parametrize("mu", [0.1, 0.25, 0.5])
def test_hamiltons_ball_near_the_surface_on_and_off_the_axis(mu, direction):
    # With an odd number of cells along each axis of the grid the axis of the ball passes through points.
    solution, hertz, _ = press_ball(16.0, (49, 51))
    middle = solution.grid.shape[0] // 2, solution.grid.shape[1] // 2
    # Depth in cells, and the largest error over the maximum pressure: at the edge of the contact.
    for cells, anywhere in ((0.5, 3.2e-2), (1, 1.35e-2), (2, 3.4e-3), (4, 9e-4)):
        z = cells * solution.grid.spacing[0]
        found = solution.stress([z], friction=mu, direction=direction).components[0] / hertz.p_max
        error = np.abs(found - below_ball(solution, hertz, (0.0, 0.0), z, mu, direction))
        assert error[:, *middle].max() < 2.5e-4
        assert error.max() < anywhere


def test_a_periodic_ball_tends_to_a_free_one():
    errors = []
    for cells in (48, 96):
        free, hertz, _ = press_ball(6.0, (cells, cells))
        periodic, _, _ = press_ball(6.0, (cells, cells), boundary="periodic")
        middle = slice(cells // 2 - 8, cells // 2 + 8)
        z = 4.0 * free.grid.spacing[0]
        one, other = (solution.stress(z, friction=0.5).components[0] for solution in (free, periodic))
        errors.append(np.abs(one - other)[:, middle, middle].max() / hertz.p_max)
    # With the square of the distance of the images.
    assert errors[1] < 0.3 * errors[0]
    assert errors[1] < 0.03


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_surface_carries_the_traction(boundary):
    solution, _ = rough(45, 3, boundary)
    rng = np.random.default_rng(4)
    traction = rng.standard_normal((2, *solution.grid.shape)) * solution.pressure
    peak = solution.pressure.max()
    stress = solution.stress(0.0, traction=traction).components[0]
    np.testing.assert_allclose(stress[ZZ], -solution.pressure, atol=3e-6 * peak)
    np.testing.assert_allclose(stress[[XZ, YZ]], -traction, atol=5e-6 * peak)


def test_a_plane_carries_the_force():
    periodic, _ = rough(48, 3)
    for z in (0.0, 1e-5, 3e-4):
        stress = periodic.stress(z, friction=0.4, direction=60.0).components[0]
        mean = stress.mean(axis=(1, 2)) / periodic.mean_pressure
        assert mean[ZZ] == pytest.approx(-1.0, abs=1e-4)
        assert mean[[XZ, YZ]] == pytest.approx([-0.2, -0.4 * math.sin(math.pi / 3.0)], abs=1e-4)
    free, _, _ = press_ball(4.0, (96, 96))
    # What passes beyond the border grows with the depth.
    stress = free.stress(0.05 * free.grid.spacing[0], friction=0.4).components[0]
    cell = free.grid.area / free.grid.shape[0] ** 2
    assert stress[XZ].sum() * cell == pytest.approx(-0.4 * free.force, rel=2e-3)


def test_a_friction_is_a_traction():
    solution, _ = rough(32, 2, "free")
    h, shape = solution.grid.spacing[0], solution.grid.shape
    friction = np.random.default_rng(1).uniform(0.0, 0.5, shape)
    found = solution.stress(h, friction=friction, direction=-90.0).components
    traction = np.array([np.zeros(shape), -friction * solution.pressure])
    np.testing.assert_array_equal(found, solution.stress(h, traction=traction).components)
    none = solution.stress(h, friction=0.0)
    np.testing.assert_array_equal(none.components, solution.stress(h).components)
    with_pressure = solution.stress(h, friction=0.2).components - none.components
    double = solution.stress(h, friction=0.4).components - none.components
    np.testing.assert_allclose(double, 2.0 * with_pressure, atol=1e-6 * solution.pressure.max())


def test_the_counterbody_is_pulled_at_the_other_side():
    ball = rc.ParaboloidSurface(RADIUS)
    problem = rc.ContactProblem(
        rc.Body(ball, STEEL), rc.Body(rc.FlatSurface(), STEEL), grid=rc.Grid((32, 32), 3e-4), threads=1
    )
    solution = problem.solve(force=20.0)
    one, other = (solution.stress(friction=0.3, body=body) for body in ("body", "counterbody"))
    assert one.maximum_principal.x < -6e-5
    assert other.maximum_principal.x > 6e-5
    opposite = solution.stress(friction=0.3, direction=180.0)
    np.testing.assert_array_equal(other[3].components, opposite[3].components)


def test_adhesion_does_not_pull_sideways():
    problem = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(RADIUS), STEEL),
        grid=rc.Grid((48, 48), 2e-4),
        adhesion=rc.Exponential(work=0.5, range=2e-8),
        threads=1,
    )
    solution = problem.solve(force=2.0)
    assert solution.tension.max() > 0.01 * solution.pressure.max()
    stress = solution.stress(0.0, friction=0.5).components[0]
    peak = solution.pressure.max()
    np.testing.assert_allclose(stress[XZ], -0.5 * solution.contact_pressure, atol=1e-5 * peak)
    np.testing.assert_allclose(stress[ZZ], -solution.pressure, atol=1e-5 * peak)


@pytest.mark.slow
def test_the_maximum_moves_to_the_surface_near_a_friction_of_three_tenths():
    assert largest_on_sphere(0.29)[1] > 0.4
    assert largest_on_sphere(0.31)[1] == 0.0
    solution, hertz, _ = press_ball(24.0, (72, 72), place=(0.3, -0.2))
    for mu in (0.1, 0.25):
        value, depth = largest_on_sphere(mu)
        found = solution.stress(friction=mu).maximum
        assert found.value == pytest.approx(value * hertz.p_max, rel=1e-3)
        assert found.depth == pytest.approx(depth * hertz.semi_axes[0], rel=0.02)
        assert found.warnings == ()
    for mu in (0.35, 0.5):
        value, _ = largest_on_sphere(mu)
        found = solution.stress(friction=mu).maximum
        assert found.depth == 0.0
        assert abs(found.value - value * hertz.p_max) < 3.0 * found.uncertainty
        assert found.value == pytest.approx(value * hertz.p_max, rel=0.015)
        assert found.uncertainty < 0.05 * found.value
        assert found.warnings == ()


@each_once(
    {
        "cells": [4.0, 16.0],
        "mu degrees": [(0.0, 0.0), (0.1, 90.0), (0.5, 35.0)],
    }
)
def test_the_tension_behind_a_ball(cells, mu, degrees):
    count = int(2.8 * cells) + 7
    solution, hertz, _ = press_ball(cells, (count, count), place=(0.2, 0.3))
    found = solution.stress(friction=mu, direction=degrees).maximum_principal
    tension = ((1.0 - 2.0 * NU) / 3.0 + math.pi * (4.0 + NU) / 8.0 * mu) * hertz.p_max
    assert abs(found.value - tension) < 3.0 * found.uncertainty
    assert found.value == pytest.approx(tension, rel=0.06 if cells < 10.0 else 0.02)
    assert found.depth == 0.0
    if mu > 0.1:
        # Behind the contact, against the traction on the body.
        angle = math.degrees(math.atan2(-found.y, -found.x))
        assert angle == pytest.approx(degrees, abs=20.0)
        assert math.hypot(found.x, found.y) == pytest.approx(hertz.semi_axes[0], rel=0.3)


def test_the_principal_stress_of_a_plane_is_the_largest():
    solution, _ = rough(32, 5)
    field = solution.stress([3e-5], friction=0.3)[0]
    xx, yy, zz, yz, xz, xy = field.components
    tensors = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 3, 0, 1)
    expected = np.linalg.eigvalsh(tensors)[..., -1]
    np.testing.assert_allclose(field.principal, expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.slow
@each_once(
    {
        "boundary": ["free", "periodic", ("periodic", "free")],
        "place": [(0.2, -0.3), (21.6, 0.4), (-21.6, 19.1)],
    }
)
def test_the_tension_does_not_depend_on_the_place(boundary, place):
    solution, hertz, _ = press_ball(5.0, (56, 52), place=place, boundary=boundary)
    for mu in (0.2, 0.6):
        found = solution.stress([0.0], friction=mu, direction=40.0).maximum_principal
        tension = ((1.0 - 2.0 * NU) / 3.0 + math.pi * (4.0 + NU) / 8.0 * mu) * hertz.p_max
        assert found.value == pytest.approx(tension, rel=0.05)
        assert abs(found.value - tension) < 2.0 * found.uncertainty


def test_the_tension_turns_with_the_axes():
    solution, _, _ = press_ball(6.0, (24, 22), place=(0.2, -0.3))
    along = np.zeros((2, 24, 22))
    along[0] = 0.4 * solution.pressure
    one = solution.stress([0.0], traction=along).maximum_principal
    turned, _, _ = press_ball(6.0, (22, 24), place=(-0.3, 0.2))
    other = turned.stress([0.0], friction=0.4, direction=90.0).maximum_principal
    assert other.value == pytest.approx(one.value, rel=1e-3)
    assert (other.y, other.x) == pytest.approx((one.x, one.y), abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("mu", "degrees"), [(0.1, 0.0), (0.25, 90.0)])
def test_the_load_of_first_yield_of_a_sliding_ball(mu, degrees):
    _, hertz, problem = press_ball(16.0, (44, 46), place=(0.2, 0.4))
    strength = largest_on_sphere(mu)[0] * hertz.p_max
    force = math.pi**3 * RADIUS**2 * hertz.p_max**3 * STEEL.compliance**2 / 6.0
    found = problem.solve(force=0.4 * force).first_yield(strength, friction=mu, direction=degrees)
    assert found.force.value == pytest.approx(force, rel=3e-3)
    assert found.maximum.value == pytest.approx(strength, rel=2e-4)


def test_long_cells_are_a_cylinder():
    cells, a = 120, 40.0
    x = np.arange(cells) - 0.5 * (cells - 1)
    edges = np.clip(np.array([x - 0.5, x + 0.5]) / a, -1.0, 1.0)
    area = 0.5 * (edges * np.sqrt(1.0 - edges**2) + np.arcsin(edges))
    pressure = (a * (area[1] - area[0])).astype(np.float32)[:, np.newaxis]
    loads = np.array([pressure, 0.4 * pressure])
    for z in (4.0, 15.0):
        found = convolve(loads, z, "free", (1.0, 1e5), "zx")[:, :, 0]
        np.testing.assert_allclose(found, SlidingCylinder(a, 1.0, 0.4, NU).stress(x, z), atol=2e-3)


def test_what_has_no_traction_gets_a_sentence():
    solution, _, _ = press_ball(4.0, (16, 18))
    zeros = np.zeros((2, 16, 18))
    for traction in (zeros[0], zeros[:, 1:], "much", zeros + math.nan, zeros + 1e30, zeros + 1j):
        with pytest.raises(rc.InputError, match="traction"):
            solution.stress(traction=traction)
    for friction in (-0.1, math.nan, 1e300, True, "some", np.ones(3), np.ones((18, 16)), -np.ones((16, 18))):
        with pytest.raises(rc.InputError, match="friction"):
            solution.stress(friction=friction)
        with pytest.raises(rc.InputError, match="friction"):
            solution.first_yield(1e9, friction=friction)
    with pytest.raises(rc.InputError, match="one of them"):
        solution.stress(traction=zeros, friction=0.1)
    with pytest.raises(rc.InputError, match="direction"):
        solution.stress(friction=0.1, direction="up")
    stress = solution.stress([1e-6])
    for number in (stress.crossland, stress.dang_van):
        for alpha, axis in ((-1.0, 0), (math.nan, 0), ("x", 0), (0.3, 2), (0.3, True), (0.3, "x")):
            with pytest.raises(rc.InputError):
                number(alpha, axis)


@pytest.mark.slow
@given(hnp.arrays(np.float64, (3, 9, 6), elements=st.integers(-3, 3).map(float)))
def test_a_smallest_sphere_holds_all_points_and_no_smaller_one_does(points):
    points[..., 2] = -points[..., 0] - points[..., 1]
    centres, radii = find_spheres(points)
    for centre, radius, cloud in zip(centres, radii, points, strict=True):
        distance = np.linalg.norm(cloud - centre, axis=1)
        assert distance.max() <= radius * (1.0 + 1e-12)
        # The centre lies between the points on the sphere: no direction leads away from none of them.
        held = (cloud - centre)[distance > radius * (1.0 - 1e-5)]
        if radius > 0.0:
            sums = np.vstack((held.T, np.ones(len(held))))
            _, rest = optimize.nnls(sums, np.append(np.zeros(6), 1.0))
            assert rest < 1e-4 * max(radius, 1.0)


def test_fatigue_numbers_of_known_paths():
    phase = np.linspace(0.0, 2.0 * np.pi, 25)
    none = np.zeros_like(phase)
    # Torsion between two opposite stresses, and pulsating tension.
    torsion = np.array([none, none, none, none, none, np.cos(phase)])[:, np.newaxis]
    assert find_crossland(torsion, 0.3) == pytest.approx(1.0)
    assert find_dang_van(torsion, 0.3) == pytest.approx(1.0)
    tension = np.array([1.0 - np.cos(phase), none, none, none, none, none])[:, np.newaxis]
    assert find_crossland(tension, 0.3) == pytest.approx(1.0 / math.sqrt(3.0) + 0.3 * 2.0 / 3.0)
    assert find_dang_van(tension, 0.3) == pytest.approx(0.5 + 0.3 * 2.0 / 3.0)
    # Torsion and tension out of phase, on a circle: the amplitude is its radius.
    circle = np.array([math.sqrt(3.0) * np.sin(phase), none, none, none, none, np.cos(phase)])[:, np.newaxis]
    assert find_crossland(circle, 0.0) == pytest.approx(1.0)
    # A pressure that swings, on two lines: the largest of either counts.
    swing = np.zeros((6, 2, 2))
    swing[:3] = [[-1.0, 2.0], [-3.0, 1.0]]
    assert find_crossland(swing, 0.3) == pytest.approx(0.6)
    assert find_dang_van(swing, 0.3) == pytest.approx(0.6)


def test_fatigue_below_a_rolling_cylinder():
    x = np.linspace(-6.0, 6.0, 601)
    for z in (0.5, 0.8):
        path = SlidingCylinder(1.0, 1.0, 0.0, NU).stress(x, z)
        found = find_crossland(list_paths(path[:, :, np.newaxis], 0, starts_unloaded=True), 0.0)
        deviators = path[:3] - path[:3].mean(axis=0)
        deviators = np.append(deviators, np.zeros((3, 1)), axis=1)
        shear = np.append(path[XZ], 0.0)

        def farthest(centre, deviators=deviators, shear=shear):
            shift = np.array([centre[0], centre[1], -centre[0] - centre[1]])[:, np.newaxis]
            return float((0.5 * ((deviators - shift) ** 2).sum(axis=0) + shear**2).max())

        best = optimize.minimize(farthest, (0.0, 0.0), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12})
        assert found == pytest.approx(math.sqrt(best.fun), rel=1e-5)
    # The orthogonal shear stress has the amplitude p0/4 at the depth a/2.
    assert np.abs(SlidingCylinder(1.0, 1.0, 0.0, NU).stress(x, 0.5)[XZ]).max() == pytest.approx(0.25, rel=1e-3)


def test_fatigue_follows_the_axis_of_rolling():
    heights = 1e-6 * np.random.default_rng(4).standard_normal((24, 20))
    size = (4.8e-4, 4e-4)
    one, other = (
        rc.ContactProblem(rc.Body(rc.HeightMap(h, size=s, periodic=True), STEEL), boundary="periodic", threads=1).solve(
            pressure=1e8
        )
        for h, s in ((heights, size), (np.ascontiguousarray(heights.T), size[::-1]))
    )
    depths = np.array([0.0, 2e-5, 9e-5])
    along, across = one.stress(depths, friction=0.2), other.stress(depths, friction=0.2, direction=90.0)
    for number in ("crossland", "dang_van"):
        found = getattr(along, number)(0.3)
        assert found.shape == depths.shape
        np.testing.assert_allclose(found, getattr(across, number)(0.3, axis=1), rtol=1e-3)
        assert np.abs(found / getattr(along, number)(0.3, axis=1) - 1.0).max() > 1e-3
