"""Stress below the surface: Love's cells, Hertz in Huber's closed form, equilibrium, and the maximum."""

from __future__ import annotations

import math
import tracemalloc

import attrs
import numpy as np
import pytest
from scipy import optimize

import roughcontact as rc
from roughcontact.reference import hertz_sphere
from roughcontact.typing import HalfSpaceStress, StressConvolution
from scenes import make_rough

NU = 0.3
STEEL = rc.Elastic(200e9, NU)
RADIUS = 1e-2
XX, YY, ZZ, YZ, XZ, XY = range(6)


def boussinesq(x, y, z, nu):
    """Return the stress by a unit force on the surface, shape (6, ...); Johnson (1985), sec. 3.2."""
    square, away = x * x + y * y, np.sqrt(x * x + y * y + z * z)
    lateral = 1.0 - 2.0 * nu
    diagonal = lateral / (away * (away + z))
    round_x = lateral * y * y * z / (away**3 * square)
    round_y = lateral * x * x * z / (away**3 * square)
    return np.array(
        [
            diagonal * (x * x - y * y) / square + round_x - 3 * x * x * z / away**5,
            diagonal * (y * y - x * x) / square + round_y - 3 * y * y * z / away**5,
            -3 * z**3 / away**5,
            -3 * y * z * z / away**5,
            -3 * x * z * z / away**5,
            lateral * x * y * (2 * away + z) / (away**3 * (away + z) ** 2) - 3 * x * y * z / away**5,
        ]
    ) / (2.0 * np.pi)


def huber(x, y, z, a, nu):
    """Return the stress below Hertz's contact of radius a over its maximum pressure, shape (6, ...), for z > 0.

    Huber, Ann. Phys. 319 (1904) 153-163, https://doi.org/10.1002/andp.19043190611
    """
    r = np.hypot(x, y)
    half = 0.5 * (r * r + z * z - a * a)
    u = half + np.sqrt(half**2 + a * a * z * z)
    t = z / np.sqrt(u)
    rest = (1 - 2 * nu) / 3 * (a / r) ** 2 * (1 - t**3)
    angle = (1 + nu) * np.sqrt(u) / a * np.arctan(a / np.sqrt(u))
    normal = -(t**3) * a * a * u / (u * u + a * a * z * z)
    radial = rest - normal + t * ((1 - nu) * u / (a * a + u) + angle - 2)
    hoop = -rest - t * (2 * nu + (1 - nu) * u / (a * a + u) - angle)
    shear = -r * z * z / (u * u + a * a * z * z) * a * a * np.sqrt(u) / (a * a + u)
    c, s = x / r, y / r
    return np.array(
        [
            radial * c * c + hoop * s * s,
            radial * s * s + hoop * c * c,
            normal,
            shear * s,
            shear * c,
            (radial - hoop) * c * s,
        ]
    )


def maximum_on_axis(nu):
    """Return the maximum shear on Hertz's axis over the maximum pressure, and its depth over the radius."""

    def negative(z):
        xx, _, zz, *_ = huber(1e-6, 0.0, z, 1.0, nu)
        return 0.5 * (zz - xx)

    found = optimize.minimize_scalar(negative, bounds=(0.1, 1.0), method="bounded", options={"xatol": 1e-9})
    return -found.fun, found.x


def press_ball(cells, shape, *, sides=(1.0, 1.0), place=(0.0, 0.0), boundary="free", material=STEEL, tolerance=None):
    """Return the contact of a ball with a radius of so many cells, and Hertz's solution."""
    spacing = 4e-6
    modulus, radius = 1.0 / material.compliance, cells * spacing
    force = 4.0 * modulus * radius**3 / (3.0 * RADIUS)
    size = tuple(n * side * spacing for n, side in zip(shape, sides, strict=True))
    ball = rc.ParaboloidSurface(RADIUS, center=tuple(spacing * p for p in place))
    problem = rc.ContactProblem(rc.Body(ball, material), grid=rc.Grid(shape, size), boundary=boundary, threads=1)
    return problem.solve(force=force, tolerance=tolerance), hertz_sphere(force, RADIUS, modulus), problem


def press_rough(cells, seed, boundary="periodic", load=2e-3, length=1e-3, young=200e9, aspect=1):
    waves = {"hurst": 0.7, "rms_slope": 0.05, "shortest": length / 8, "longest": length, "rolloff": length / 3}
    material = rc.Elastic(young, NU)
    problem = make_rough((cells, cells * aspect), length, material, boundary=boundary, threads=1, seed=seed, **waves)
    return problem.solve(pressure=load * young), problem


def convolve(loads, z, boundary="free", sides=(1.0, 1.0), of="z", steps=(1, 1), common=None):
    """Return the stress at a depth by loads, shape (nx, ny) or (k, nx, ny), on cells with sides."""
    loads = loads.reshape(-1, *loads.shape[-2:])
    shape = loads.shape[1:]
    grid = rc.Grid(shape, (shape[0] * sides[0], shape[1] * sides[1]))
    convolution = StressConvolution(HalfSpaceStress(NU), grid, rc.Boundary(boundary), common or steps)
    return convolution.apply(convolution.transform(loads, of), z, of, steps)


def test_the_mean_pressure_of_a_periodic_body_is_confined():
    for z in (0.0, 0.5, 30.0):
        stress = convolve(np.full((12, 8), 1.0, np.float32), z, "periodic")
        lateral = -NU / (1.0 - NU)
        expected = np.array([lateral, lateral, -1.0, 0.0, 0.0, 0.0])[:, np.newaxis, np.newaxis]
        np.testing.assert_allclose(stress, np.broadcast_to(expected, stress.shape), atol=1e-6)


def test_stress_of_waves_along_the_line_is_that_of_all_images():
    # Loads whose rows have no mean: images further away than two lengths do not act.
    random = np.random.default_rng(3)
    loads = random.standard_normal((3, 12, 8)).astype(np.float32)
    loads -= loads.mean(axis=2, keepdims=True)
    images = np.tile(loads, (1, 1, 41))
    sides = (1.0, 1.5)
    for depth in (0.5, 2.0, 6.0):
        expected = convolve(images, depth, "free", sides, "zxy")[:, :, 160:168]
        mixed = convolve(loads, depth, "free-periodic", sides, "zxy")
        np.testing.assert_allclose(mixed, expected, atol=5e-5)


@pytest.mark.parametrize("seed", range(3))
def test_the_maximum_shear_below_a_ball_is_hertzs(seed):
    rng = np.random.default_rng(seed)
    sides = (1.0, float(rng.uniform(0.6, 1.0)))
    shape = 40, int(40 / sides[1])
    solution, hertz, _ = press_ball(16.0, shape, sides=sides, place=rng.uniform(-0.5, 0.5, 2))
    value, depth = maximum_on_axis(NU)
    found = solution.stress().maximum_shear
    assert found.value == pytest.approx(value * hertz.p_max, rel=5e-4)
    assert found.depth == pytest.approx(depth * hertz.semi_axes[0], rel=5e-3)
    assert abs(found.value - value * hertz.p_max) < 3.0 * found.uncertainty
    assert found.warnings == ()


@pytest.mark.parametrize(("radius", "sides"), [(0.8, (1.0, 1.0)), (1.6, (1.0, 0.6)), (2.7, (0.5, 1.0))])
def test_below_a_ball_on_a_coarse_grid_the_maximum_is_hertzs(radius, sides):
    """Uniform pressure on its cells has a maximum that is up to 30 % off."""
    solution, hertz, _ = press_ball(radius, (24, 24), sides=sides, place=(0.31, -0.17))
    value, depth = maximum_on_axis(NU)
    found = solution.stress().maximum_shear
    assert found.value == pytest.approx(value * hertz.p_max, rel=1e-3)
    assert abs(found.value - value * hertz.p_max) < 3.0 * found.uncertainty < 0.01 * found.value
    assert found.depth == pytest.approx(depth * hertz.semi_axes[0], rel=0.03)
    assert found.warnings == ()


@pytest.mark.parametrize("radii", [(8.0, 1.0), (1.0, 3.0)])
def test_below_an_ellipse_on_a_coarse_grid_the_maximum_is_that_of_a_fine_one(radii):
    body = rc.Body(rc.ParaboloidSurface(tuple(RADIUS * radius for radius in radii), center=(1e-6, 2e-6)), STEEL)
    coarse, fine = (
        rc.ContactProblem(body, grid=rc.Grid((n, n), 4e-4), threads=1).solve(force=2.0).stress() for n in (20, 160)
    )
    for name in ("maximum", "maximum_shear"):
        found, true = (getattr(stress, name) for stress in (coarse, fine))
        assert found.uncertainty < 0.01 * found.value
        assert abs(found.value - true.value) < 2.0 * math.hypot(found.uncertainty, true.uncertainty)
        assert found.depth == pytest.approx(true.depth, rel=0.05)


def press_wave(cells, half_width, angle, sides=(1.0, 1.0), place=0.0):
    """Return the contact of sinusoidal ridges, half-widths of so many cells, on a domain of so many, and its stress.

    That is the maximum von Mises stress and shear stress by Westergaard's pressure, in waves.
    """
    shape = [round(cells / side) for side in sides]
    waves = (1, 0) if angle == 0 else (2, 1)
    size = tuple(n * side for n, side in zip(shape, sides, strict=True))
    number = math.hypot(waves[0] / size[0], waves[1] / size[1])
    grid = rc.Grid(tuple(shape), size)
    phase = 2.0 * np.pi * (waves[0] * grid.x / size[0] + waves[1] * grid.y / size[1] + place / cells)
    amplitude = 1e-3 / number
    heights = rc.HeightMap(amplitude * np.cos(phase), size=size, periodic=True)
    wanted = np.sin(np.pi * half_width * number) ** 2
    pressure = np.pi * amplitude * number * wanted
    material = rc.Elastic(2.0 * (1.0 - NU * NU), NU)
    problem = rc.ContactProblem(
        rc.Body(heights, material), rc.Body(rc.FlatSurface(), material), boundary="periodic", threads=1
    )
    # p = 2 p_mean cos(pi x) / sin(pi a)^2 sqrt(sin(pi a)^2 - sin(pi x)^2), x and a in waves.
    x = (np.arange(2**12) + 0.5) / 2**12 - 0.5
    profile = np.sqrt(np.maximum(wanted - np.sin(np.pi * x) ** 2, 0.0)) * np.cos(np.pi * x)
    profile *= pressure / profile.mean()
    q = 2.0 * np.pi * number * np.arange(2**11 + 1)
    spectrum = np.fft.rfft(np.fft.ifftshift(profile)).real / x.size
    spectrum[1:] *= 2.0
    largest = np.zeros(2)
    for z in np.linspace(0.5, 1.0, 41) * half_width:
        decay = spectrum * np.exp(-q * z)
        zz, xx = -np.sum(decay * (1.0 + q * z)), -np.sum(decay[1:] * (1.0 - q[1:] * z))
        yy = NU * (xx + zz)
        xx, yy = xx - NU / (1.0 - NU) * pressure, yy - NU / (1.0 - NU) * pressure + NU * pressure
        mises = math.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2))
        largest = np.maximum(largest, (mises, 0.5 * abs(zz - xx)))
    return problem.solve(pressure=pressure), largest


@pytest.mark.parametrize(
    ("half_width", "angle", "sides"),
    [(0.7, 0, (1.0, 1.0)), (1.3, 1, (1.0, 1.0)), (0.8, 1, (1.0, 0.4)), (2.0, 0, (0.4, 1.0))],
)
def test_below_ridges_narrower_than_the_cells_the_maximum_is_westergaards(half_width, angle, sides):
    """The cells lack up to a third of it."""
    solution, true = press_wave(40, half_width, angle, sides, place=0.31)
    stress = solution.stress()
    for found, value in zip((stress.maximum, stress.maximum_shear), true, strict=True):
        assert found.value == pytest.approx(value, rel=0.03)
        assert abs(found.value - value) < 3.0 * found.uncertainty
        assert found.warnings == ()


def test_the_reference_has_the_known_maximum():
    value, depth = maximum_on_axis(0.3)
    assert (round(value, 3), round(depth, 2)) == (0.310, 0.48)


@pytest.mark.parametrize("material", [STEEL, rc.Elastic(200e9, 0.0), rc.Elastic(200e9, 0.5)])
def test_hertz_at_all_points(material):
    place = (0.31, -0.17)
    solution, hertz, _ = press_ball(16.0, (48, 44), place=place, material=material)
    grid, a = solution.grid, hertz.semi_axes[0]
    spacing = grid.spacing[0]
    # Depth in cells, and the error that uniform pressure on cells leaves, over the maximum pressure.
    for cells, error in ((4, 4e-3), (8, 1.2e-3), (16, 4e-4)):
        found = solution.stress([cells * spacing]).components[0] / hertz.p_max
        exact = huber(grid.x - place[0] * spacing, grid.y - place[1] * spacing, cells * spacing, a, material.poisson)
        assert np.abs(found - exact).max() < error


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_at_the_surface_the_normal_stress_is_the_pressure(boundary):
    solution, _ = press_rough(48, 3, boundary)
    xx, yy, zz, yz, xz, _ = solution.stress(0.0).components[0] / solution.pressure.max()
    np.testing.assert_allclose(zz, -solution.pressure / solution.pressure.max(), atol=2e-6)
    assert max(np.abs(yz).max(), np.abs(xz).max()) < 1e-6
    # On a free surface the trace is that of the pressure alone.
    if boundary == "free":
        np.testing.assert_allclose(xx + yy + zz, 2.0 * (1.0 + NU) * zz, atol=5e-6)


def test_far_away_the_contact_is_a_point():
    solution, _, _ = press_ball(4.0, (64, 48), place=(7.3, -3.1))
    grid = solution.grid
    x, y = (float(np.sum(solution.pressure * axis) / np.sum(solution.pressure)) for axis in (grid.x, grid.y))
    for depth in (60.0, 1000.0):
        z = depth * grid.spacing[0]
        found = solution.stress(z).components[0]
        exact = solution.force * boussinesq(grid.x - x, grid.y - y, z, NU)
        # The square of the radius over the depth, and what the transforms leave.
        assert np.abs(found - exact).max() < ((4.0 / depth) ** 2 + 3e-4) * np.abs(exact).max()


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("friction", [None, 0.6])
def test_the_stress_is_in_equilibrium(boundary, friction):
    solution, _ = press_rough(64, 1, boundary, aspect=2)
    dx, dy = solution.grid.spacing
    z, step = 6.0 * dx, 0.25 * dx
    above, here, below = solution.stress([z - step, z, z + step], friction=friction, direction=25.0).components
    inner = (slice(3, -3), slice(3, -3))

    def differ(field, axis, spacing):
        return sum(
            weight * (np.roll(field, -k, axis) - np.roll(field, k, axis)) / spacing
            for k, weight in ((1, 0.75), (2, -0.15), (3, 1.0 / 60.0))
        )[inner]

    for x_part, y_part, z_part in ((XX, XY, XZ), (XY, YY, YZ), (XZ, YZ, ZZ)):
        parts = (
            differ(here[x_part], 0, dx),
            differ(here[y_part], 1, dy),
            ((below - above)[z_part] / (2.0 * step))[inner],
        )
        assert np.abs(sum(parts)).max() < 3e-3 * max(np.abs(part).max() for part in parts)


def test_a_periodic_contact_far_from_its_images_is_a_free_one():
    # The mean pressure, 2 % of the maximum, changes the stress by a part of itself.
    free, hertz, _ = press_ball(8.0, (96, 96))
    periodic, _, _ = press_ball(8.0, (96, 96), boundary="periodic")
    z = 4.0 * free.grid.spacing[0]
    mean = periodic.mean_pressure / hertz.p_max
    one, other = (solution.stress(z).components[0][:, 24:72, 24:72] / hertz.p_max for solution in (free, periodic))
    assert np.abs(one - other).max() < mean
    assert periodic.stress().maximum.value == pytest.approx(free.stress().maximum.value, rel=mean)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize(("length", "stiffness"), [(2.0**-20, 2.0**-30), (2.0**20, 1.0), (1.0, 2.0**30)])
def test_units_change_nothing_but_the_scale(boundary, length, stiffness):
    heights = 1e-6 * np.random.default_rng(4).standard_normal((32, 24))
    one, other = (
        rc.ContactProblem(
            rc.Body(rc.HeightMap(heights * factor, size=(1e-3 * factor, 8e-4 * factor), periodic=True), material),
            boundary=boundary,
            threads=1,
        ).solve(pressure=2e-3 * material.young)
        for factor, material in ((1.0, STEEL), (length, rc.Elastic(200e9 * stiffness, NU)))
    )
    depths = np.array([0.3, 4.0, 12.0]) * one.grid.spacing[0]
    for friction in (None, 0.4):
        found = one.stress(depths, friction=friction).components
        np.testing.assert_array_equal(found * stiffness, other.stress(depths * length, friction=friction).components)
        found = one.stress(friction=friction)
        assert found.maximum.value * stiffness == other.stress(friction=friction).maximum.value
        assert found.maximum_principal.value * stiffness == other.stress(friction=friction).maximum_principal.value


@pytest.mark.slow
@pytest.mark.parametrize(
    ("boundary", "aspect", "seed"), [("periodic", 1, 21), ("periodic", 2, 22), ("periodic", 1, 23)]
)
def test_the_uncertainty_of_the_maximum_holds_on_rough_surfaces(boundary, aspect, seed):
    exact, _ = press_rough(192 // aspect, seed, boundary, aspect=aspect)
    true = exact.stress().maximum
    for cells in (48, 96):
        found = press_rough(cells // aspect, seed, boundary, aspect=aspect)[0].stress().maximum
        assert abs(found.value - true.value) < 3.0 * math.hypot(found.uncertainty, true.uncertainty)
        assert found.uncertainty < 0.15 * found.value


def test_memory_does_not_grow_with_the_depths():
    solution, _ = press_rough(128, 6, "free")
    peaks = []
    for count in (3, 24):
        tracemalloc.start()
        for _ in solution.stress(np.linspace(0.5, 7.5, count) * solution.grid.spacing[0]):
            pass
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.05 * peaks[0]


def test_the_maximum_says_why_it_must_not_be_trusted():
    solution, _, _ = press_ball(3.0, (32, 32))
    shallow = solution.stress().maximum
    assert shallow.warnings == ()
    ends = solution.stress([1.5e-5, 3e-5]).maximum
    assert "smallest of the depths" in " ".join(ends.warnings)
    assert "uncertain" in str(ends)
    # On eight rows finer cells have no room: the stress is as uncertain as the maximum pressure.
    ridges = np.tile(1e-6 * np.cos(6.0 * np.pi * (np.arange(60) + 0.31) / 60), (8, 1))
    body = rc.Body(rc.HeightMap(ridges, size=(8e-5, 6e-4), periodic=True), STEEL)
    coarse = rc.ContactProblem(body, boundary="periodic", threads=1).solve(pressure=2e7)
    found = coarse.stress().maximum
    peak = coarse.peak_pressure()
    assert found.uncertainty / found.value >= 0.7 * peak.uncertainty / peak.value
    assert "cells below the surface, where it depends on the grid" in " ".join(found.warnings)
    bordering, _ = press_rough(48, 1, "free", load=0.02)
    found = bordering.stress().maximum
    assert found.uncertainty == found.value
    assert "border" in " ".join(found.warnings)
    wrapped, _ = press_rough(48, 1, "wrapped")
    assert "wrapped" in " ".join(wrapped.stress().maximum.warnings)


def test_the_edge_of_a_punch_has_no_maximum():
    grid = rc.Grid((40, 40), 1e-3)
    heights = np.where(np.hypot(grid.x, grid.y) < 2.5e-4, 1e-3, 0.0)
    problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, 1e-3), STEEL), threads=1)
    found = problem.solve(force=100.0).stress().maximum
    assert found.uncertainty == found.value
    assert "sharp edge" in " ".join(found.warnings)


def test_both_bodies_carry_the_same_pressure():
    ball = rc.ParaboloidSurface(RADIUS)
    counter = rc.Body(rc.FlatSurface(), rc.Elastic(70e9, 0.0))
    problem = rc.ContactProblem(rc.Body(ball, STEEL), counter, grid=rc.Grid((32, 32), 3e-4), threads=1)
    solution = problem.solve(force=20.0)
    z = 5e-5
    one, other = (solution.stress(z, body=name).components[0] for name in ("body", "counterbody"))
    for same in (ZZ, YZ, XZ):
        np.testing.assert_allclose(one[same], other[same], atol=1e-6 * solution.pressure.max())
    assert np.abs(one[XX] - other[XX]).max() > 0.05 * solution.pressure.max()


@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
@pytest.mark.parametrize("shape", [(1, 24), (24, 1), (2, 3), (3, 50)])
def test_narrow_grids(boundary, shape):
    size = tuple(1e-5 * n for n in shape)
    body = rc.Body(rc.ParaboloidSurface(RADIUS), STEEL)
    problem = rc.ContactProblem(body, grid=rc.Grid(shape, size), boundary=boundary, threads=1)
    stress = problem.solve(pressure=1e8).stress()
    assert np.isfinite(stress.components).all()
    assert math.isfinite(stress.maximum.value)


@attrs.frozen
class Coated(rc.Love):
    def effective_modulus(self, wavenumber, compliance):
        return np.full(wavenumber.shape, 2.0 / compliance)


def test_what_has_no_stress_gets_a_sentence():
    solution, _, _ = press_ball(4.0, (16, 16))
    for depths in (-1e-6, [], "deep", [1e-6, math.nan], [[1e-6]], math.inf, 1.0, True and [None]):
        with pytest.raises(rc.InputError, match=r"depth"):
            solution.stress(depths)
    with pytest.raises(rc.InputError, match="no stress below its surface"):
        solution.stress(body="counterbody")
    with pytest.raises(rc.InputError, match="'counterbody'"):
        solution.stress(body="third")
    for index in (2, -3, 0.0, "x", True):
        with pytest.raises(rc.InputError, match="number of a depth"):
            _ = solution.stress([1e-6, 2e-6])[index]
    coated = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(RADIUS), STEEL), grid=rc.Grid((16, 16), 2e-4), kernel=Coated(), threads=1
    )
    with pytest.raises(rc.InputError, match="homogeneous"):
        coated.solve(force=1.0).stress()
    with pytest.raises(rc.InputError, match="does not say which problem"):
        attrs.evolve(solution, origin=None).stress()


@pytest.mark.parametrize("start", [0.3, 40.0])
def test_the_load_of_first_yield_of_a_ball(start):
    _, hertz, problem = press_ball(12.0, (40, 40), place=(0.2, 0.4))
    strength = 0.55 * hertz.p_max
    # On the axis the von Mises stress is twice the maximum shear.
    pressure = strength / (2.0 * maximum_on_axis(NU)[0])
    modulus = 1.0 / STEEL.compliance
    force = math.pi**3 * RADIUS**2 * pressure**3 / (6.0 * modulus**2)
    found = problem.solve(force=start * force * 0.05).first_yield(strength)
    assert found.force.value == pytest.approx(force, rel=6e-3)
    assert abs(found.force.value - force) < 3.0 * found.force.uncertainty
    assert found.maximum.value == pytest.approx(strength, rel=2e-4)
    assert found.mean_pressure.value == pytest.approx(found.force.value / problem.grid.area)
    assert "first yield" in str(found)


def test_first_yield_that_cannot_be_gets_a_sentence():
    soft = rc.ElasticPerfectlyPlastic(200e9, NU, hardness=1e9)
    problem = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(RADIUS), soft), grid=rc.Grid((16, 16), 3e-4), threads=1)
    solution = problem.solve(force=10.0)
    with pytest.raises(rc.InputError, match="No load was found"):
        solution.first_yield(5e9)
    assert solution.first_yield(0.45e9).maximum.value == pytest.approx(0.45e9, rel=1e-3)
    for strength in (0.0, -1.0, math.nan, "hard"):
        with pytest.raises(rc.InputError, match="yield stress"):
            solution.first_yield(strength)
