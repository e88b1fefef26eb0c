"""The maps of eigenstrain and pressure: their symmetry, closed forms, orders of convergence and other invariances."""

import doctest
import importlib
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest
import roughcontact as rc
from roughcontact.typing import HalfSpaceStress

from roughcontact_volume import VolumeOperators, love, spectra, tables
from roughcontact_volume.images import FreePlane
from roughcontact_volume.love import mean_stress_below_cell
from roughcontact_volume.spectra import Period

YOUNG, POISSON = 210e9, 0.3
MODULUS = YOUNG / (2.0 * (1.0 + POISSON))
# Double products of tensors weigh shears twice.
WEIGHTS = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
# Components after an exchange of the axes.
EXCHANGED = [1, 0, 2, 4, 3, 5]
BOUNDARIES = ("periodic", "free", "free-periodic", "periodic-free")
SHAPES = [
    ((12, 16), (1e-6, 1e-6)),
    ((9, 15), (1e-6, 3e-6)),
    ((32, 4), (1e-6, 1e-6)),
    ((5, 8), (6e-6, 1e-6)),
    ((1, 7), (1e-6, 1e-6)),
]
UNEVEN = np.array([0.5, 0.7, 1.0, 3.0, 0.2]) * 1e-6


def make(boundary, shape, sides=(1e-6, 1e-6), thicknesses=UNEVEN, young=YOUNG, poisson=POISSON, **others):
    grid = rc.Grid(shape, (shape[0] * sides[0], shape[1] * sides[1]))
    return VolumeOperators(grid, boundary, thicknesses, young, poisson, **others)


def draw(operators, seed):
    return np.random.default_rng(seed).normal(size=operators.shape)


def product(first, second, thicknesses):
    return np.einsum("i,j,ijxy,ijxy->", WEIGHTS, thicknesses, first, second)


def largest(values):
    return np.abs(values).max()


def strain_of(stress, young, poisson):
    """Return the elastic strain, tensor shears."""
    strain = stress * ((1.0 + poisson) / young)
    strain[:3] -= poisson / young * stress[:3].sum(axis=0)
    return strain


def stress_of(strain, young, poisson):
    modulus = young / (1.0 + poisson)
    stress = modulus * strain
    stress[:3] += modulus * poisson / (1.0 - 2.0 * poisson) * strain[:3].sum(axis=0)
    return stress


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize(("shape", "sides"), SHAPES)
def test_residual_stress_is_symmetric_and_negative(boundary, shape, sides):
    operators = make(boundary, shape, sides)
    first, second = draw(operators, 1), draw(operators, 2)
    one, other = operators.find_stress(first), operators.find_stress(second)
    scale = np.sqrt(product(first, first, UNEVEN) * product(other, other, UNEVEN))
    assert abs(product(first, other, UNEVEN) - product(second, one, UNEVEN)) < 1e-14 * scale
    # The elastic energy is positive, and at most that of a strain that is held everywhere.
    held = product(first, stress_of(first, YOUNG, POISSON), UNEVEN)
    assert 0.0 < -product(first, one, UNEVEN) < held


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize(("shape", "sides"), SHAPES)
def test_displacement_is_the_transpose_of_the_stress_by_pressure(boundary, shape, sides):
    operators = make(boundary, shape, sides)
    strain, pressure = draw(operators, 1), np.random.default_rng(2).normal(size=shape)
    stress, displacement = operators.press(pressure), operators.displace(strain)
    scale = np.sqrt(product(strain, strain, UNEVEN) * product(stress, stress, UNEVEN))
    assert abs(product(strain, stress, UNEVEN) - (displacement * pressure).sum()) < 1e-14 * scale


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_layers_may_be_split(boundary):
    operators = make(boundary, (10, 9), (1e-6, 2e-6))
    pieces = np.array([4, 1, 2, 7, 1])
    finer = make(boundary, (10, 9), (1e-6, 2e-6), np.repeat(UNEVEN / pieces, pieces))
    strain, pressure = draw(operators, 1), np.random.default_rng(2).normal(size=(10, 9))
    repeated = np.repeat(strain, pieces, axis=1)
    starts = np.cumsum(pieces) - pieces
    # The integrals of Love's terms grow with the distance, of which the thickness of a layer is a small part.
    within = {"periodic": 1e-14, "free": 1e-13}.get(boundary, 2e-12)
    for whole, split in (
        (operators.find_stress(strain), finer.find_stress(repeated)),
        (operators.press(pressure), finer.press(pressure)),
    ):
        means = np.add.reduceat(split, starts, axis=1) / pieces[:, np.newaxis, np.newaxis]
        assert largest(means - whole) < within * largest(whole)
    displacement = operators.displace(strain)
    assert largest(finer.displace(repeated) - displacement) < within * largest(displacement)


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize(("shape", "sides"), SHAPES)
def test_axes_may_be_exchanged(boundary, shape, sides):
    operators = make(boundary, shape, sides)
    other_boundary = "-".join(boundary.split("-")[::-1])
    turned = make(other_boundary, shape[::-1], sides[::-1])
    strain, pressure = draw(operators, 1), np.random.default_rng(2).normal(size=shape)
    exchanged = strain[EXCHANGED].transpose(0, 1, 3, 2)
    for one, other in (
        (operators.find_stress(strain), turned.find_stress(exchanged)),
        (operators.press(pressure), turned.press(pressure.T)),
    ):
        assert largest(one - other[EXCHANGED].transpose(0, 1, 3, 2)) < 1e-13 * largest(one)
    displacement = operators.displace(strain)
    assert largest(displacement - turned.displace(exchanged).T) < 1e-13 * largest(displacement)


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("mirrored", [0, 1])
def test_axes_may_be_mirrored(boundary, mirrored):
    # With an even number of cells, too, of which the shortest wave has no sign.
    operators = make(boundary, (8, 6), (1e-6, 2e-6))
    strain = draw(operators, 1)
    signs = np.array([[1, 1, 1, 1, -1, -1], [1, 1, 1, -1, 1, -1]])[mirrored].reshape(6, 1, 1, 1)
    stress = operators.find_stress(strain)
    back = signs * np.flip(operators.find_stress(signs * np.flip(strain, 2 + mirrored)), 2 + mirrored)
    assert largest(stress - back) < 1e-13 * largest(stress)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_units_change_no_bit(boundary):
    operators = make(boundary, (10, 9), (1e-6, 2e-6))
    scaled = make(boundary, (10, 9), (2.0**-13 * 1e-6, 2.0**-13 * 2e-6), 2.0**-13 * UNEVEN, 2.0**20 * YOUNG)
    strain, pressure = draw(operators, 1), np.random.default_rng(2).normal(size=(10, 9))
    np.testing.assert_array_equal(2.0**20 * operators.find_stress(strain), scaled.find_stress(strain))
    np.testing.assert_array_equal(2.0**20 * operators.press(pressure), scaled.press(2.0**20 * pressure))
    np.testing.assert_array_equal(2.0**-13 * operators.displace(strain), scaled.displace(strain))


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_single_precision_inside_is_bounded(boundary):
    operators, single = make(boundary, (24, 20)), make(boundary, (24, 20), precision="float32")
    strain = draw(operators, 1)
    stress = operators.find_stress(strain)
    error = largest(single.find_stress(strain) - stress) / largest(stress)
    assert 1e-9 < error < 2e-6


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_threads_change_no_bit(boundary, monkeypatch):
    operators = make(boundary, (70, 72), thicknesses=UNEVEN[:2])
    strain, pressure = draw(operators, 1), np.random.default_rng(2).normal(size=(70, 72))
    alone = operators.find_stress(strain), operators.press(pressure), operators.displace(strain)
    asked = []

    def map_backwards(work, tiles):
        asked.append(len(tiles))
        with ThreadPoolExecutor(3) as pool:
            return list(pool.map(work, tiles[::-1]))[::-1]

    for module in (spectra, tables):
        monkeypatch.setattr(module, "map_tiles", map_backwards)
    operators = make(boundary, (70, 72), thicknesses=UNEVEN[:2])
    shared = operators.find_stress(strain), operators.press(pressure), operators.displace(strain)
    for one, other in zip(alone, shared, strict=True):
        np.testing.assert_array_equal(one, other)
    assert max(asked) >= 4


def _wave(operators, number):
    nx, ny = operators.grid.shape
    phase = 2.0 * np.pi * (number[0] * np.arange(nx)[:, np.newaxis] / nx + number[1] * np.arange(ny) / ny)
    size_x, size_y = operators.grid.size
    return np.cos(phase + 0.4), 2.0 * np.pi * np.hypot(number[0] / size_x, number[1] / size_y)


def _answer_to_elastic_strain(layers):
    """Return errors of the maps of the strain by a pressure, which is compatible: no stress, and its displacement."""
    thicknesses = np.full(layers, 30e-6 / layers)
    operators = make("periodic", (8, 12), (1e-6, 1.5e-6), thicknesses)
    pressure, q = _wave(operators, (1, 1))
    stress = operators.press(1e6 * pressure)
    strain = strain_of(stress, YOUNG, POISSON)
    displacement = 2e6 * (1.0 - POISSON**2) / (YOUNG * q) * pressure
    return (
        largest(operators.find_stress(strain)) / largest(stress),
        largest(operators.displace(strain) - displacement) / largest(displacement),
    )


def test_strain_of_a_pressure_leaves_no_stress_and_its_own_displacement():
    coarse, middle, fine = (_answer_to_elastic_strain(layers) for layers in (60, 120, 240))
    # Of second order: the quotients fall towards a quarter.
    for first, second, third in zip(coarse, middle, fine, strict=True):
        assert 0.24 < third / second < second / first < 0.33
        assert third / second < 0.29
    assert max(fine) < 2e-3


def _smooth_strain(operators):
    z = operators.depths / 6e-6
    shape = np.exp(-((z - 0.8) ** 2) / 0.1)
    waves = [_wave(operators, number)[0] for number in ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2))]
    return np.array([shape[:, np.newaxis, np.newaxis] * wave for wave in waves]) * 1e-3


def _miss_of_equilibrium(layers):
    operators = make("periodic", (12, 15), thicknesses=np.full(layers, 12e-6 / layers))
    stress = operators.find_stress(_smooth_strain(operators))
    step = 12e-6 / layers
    qx, qy = (2j * np.pi * np.fft.fftfreq(n, 1e-6) for n in operators.grid.shape)

    def along(field, axis):
        slope = qx[:, np.newaxis] if axis == 0 else qy
        return np.fft.ifft2(np.fft.fft2(field) * slope).real

    xx, yy, zz, yz, xz, xy = stress
    downwards = [(one[2:] - one[:-2]) / (2.0 * step) for one in (xz, yz, zz)]
    sums = [
        along(xx, 0)[1:-1] + along(xy, 1)[1:-1] + downwards[0],
        along(xy, 0)[1:-1] + along(yy, 1)[1:-1] + downwards[1],
        along(xz, 0)[1:-1] + along(yz, 1)[1:-1] + downwards[2],
    ]
    surface = largest(stress[2:5, 0]) / largest(stress)
    return max(map(largest, sums)) * 1e-6 / largest(stress), surface


def test_stress_is_in_equilibrium_and_leaves_the_surface_free():
    misses = [_miss_of_equilibrium(layers) for layers in (40, 80, 160)]
    (first, near), (second, nearer), (third, nearest) = misses
    assert second / first == pytest.approx(0.25, rel=0.15)
    assert third / second == pytest.approx(0.25, rel=0.1)
    # The components with z vanish at the surface: their mean over the uppermost layer with its thickness.
    assert nearer / near < 0.6
    assert nearest / nearer < 0.55


def _ball(cells, layers, radius, depth):
    """Return the fractions of cells inside a ball, shape (nz, n, n), by 4 x 4 x 4 points each, sides 1."""
    points = (np.arange(4) + 0.5) / 4.0
    x = (np.arange(cells)[:, np.newaxis] + points).ravel() - 0.5 * cells
    z = (np.arange(layers)[:, np.newaxis] + points).ravel() - depth
    inside = z[:, np.newaxis, np.newaxis] ** 2 + x[:, np.newaxis] ** 2 + x**2 < radius**2
    return inside.reshape(layers, 4, cells, 4, cells, 4).mean(axis=(1, 3, 5))


@pytest.mark.parametrize(("radius", "cells"), [(4, 24), (8, 32)])
def test_a_ball_that_swells_lifts_the_surface(radius, cells):
    depth = 1.5 * radius
    ball = _ball(cells, int(3 * radius), radius, depth)
    operators = make("free", (cells, cells), (1.0, 1.0), np.ones(len(ball)))
    strain = np.zeros(operators.shape)
    strain[:3] = 1e-3 * ball
    distance = np.sqrt(operators.grid.x**2 + operators.grid.y**2 + depth**2)
    lift = (1.0 + POISSON) / np.pi * 1e-3 * (4.0 / 3.0 * np.pi * radius**3) * depth / distance**3
    assert largest(operators.displace(strain) + lift) < (8e-3 if radius == 4 else 2e-3) * largest(lift)


@pytest.mark.parametrize(
    ("boundary", "component"),
    [
        *(("free", component) for component in ("xx", "zz", "yz", "xz", "xy", "dilatation")),
        *(("periodic", component) for component in ("yy", "xz")),
    ],
)
def test_a_ball_in_the_deep_has_the_stress_of_eshelby(boundary, component):
    # Eshelby, Proc. R. Soc. A 241 (1957) 376-396, https://doi.org/10.1098/rspa.1957.0133.
    radius, cells, depth = (4, 33, 30) if boundary == "free" else (4, 63, 40)
    operators, ball = _deep_ball(boundary, radius, cells, depth)
    unit = np.zeros(6)
    places = ("xx", "yy", "zz", "yz", "xz", "xy")
    if component == "dilatation":
        unit[:3] = 1.0
    else:
        unit[places.index(component)] = 1.0
    stress = operators.find_stress(1e-3 * unit.reshape(6, 1, 1, 1) * ball)
    mean = np.array([1, 1, 1, 0, 0, 0]) * unit[:3].sum() / 3.0
    alpha = (1.0 + POISSON) / (3.0 * (1.0 - POISSON))
    beta = (8.0 - 10.0 * POISSON) / (15.0 * (1.0 - POISSON))
    bulk = YOUNG / (3.0 * (1.0 - 2.0 * POISSON))
    expected = 1e-3 * (3.0 * bulk * (alpha - 1.0) * mean + 2.0 * MODULUS * (beta - 1.0) * (unit - mean))
    core = _ball(cells, len(ball), radius - 1.5, depth) == 1.0
    inside = stress[:, core]
    assert largest(inside.mean(axis=1) - expected) < 0.005 * largest(expected)
    assert largest(inside - expected[:, np.newaxis]) < 0.016 * largest(expected)


@cache
def _deep_ball(boundary, radius, cells, depth):
    ball = _ball(cells, 2 * depth, radius, depth)
    return make(boundary, (cells, cells), (1.0, 1.0), np.ones(len(ball))), ball


def _zone(shape, sides, layers):
    """Return a smooth plastic strain whose half width is 1 / 1.6 of that of the domain, without volume."""
    x, y = (np.arange(n) - 0.5 * (n - 1) for n in shape)
    half_x, half_y = (0.5 * n / 1.6 for n in shape)
    z = (np.arange(layers) + 0.5) / (0.75 * layers) - 0.6
    rest = 1.0 - (x / half_x)[:, np.newaxis] ** 2 - (y / half_y) ** 2 - z[:, np.newaxis, np.newaxis] ** 2
    amount = np.maximum(rest, 0.0)
    strain = np.array([0.5 * amount, 0.5 * amount, -amount, 0.0 * amount, 0.0 * amount, 0.1 * amount])
    strain[3] = 0.3 * amount * (y / half_y)
    strain[4] = 0.3 * amount * (x / half_x)[:, np.newaxis]
    return strain


@pytest.mark.parametrize(
    ("shape", "sides", "layers"),
    [
        ((26, 26), (1.0, 1.0), 12),
        ((23, 24), (1.0, 3.0), 8),
        ((48, 6), (1.0, 1.0), 6),
        ((6, 48), (1.0, 1.0), 6),
        ((11, 12), (6.0, 1.0), 6),
    ],
)
def test_residual_stress_on_a_free_boundary_has_no_images(shape, sides, layers):
    thicknesses = np.ones(layers)
    strain = _zone(shape, sides, layers)
    plane = FreePlane(shape, sides, thicknesses, POISSON)
    # Far images fall with the third power of the period, so that two periods tell the stress without any.
    longest = max(n * side for n, side in zip(shape, sides, strict=True))
    short, long = (
        Period(
            (2 * int(ratio * longest / sides[0]) + 1, 2 * int(ratio * longest / sides[1]) + 1),
            sides,
            thicknesses,
            POISSON,
        ).find_stress(strain)
        for ratio in (2.5, 5.0)
    )
    expected = long + (long - short) / 7.0
    scale = largest(expected)
    error = largest(plane.find_stress(strain) - expected) / scale
    with_images = largest(plane.period.find_stress(strain) - expected) / scale
    assert error < 1e-3
    assert error < 0.2 * with_images


@pytest.mark.parametrize(
    ("shape", "sides", "layers"), [((26, 9), (1.0, 1.0), 8), ((9, 40), (1.0, 1.0), 6), ((12, 12), (1.0, 6.0), 6)]
)
def test_residual_stress_free_along_one_axis_has_no_images(shape, sides, layers):
    thicknesses = np.ones(layers)
    strain = _zone(shape, sides, layers)
    plane = FreePlane(shape, sides, thicknesses, POISSON, repeats=(False, True))
    # Far images of rows fall with the square of the period.
    longest = max(shape[0], shape[1] * sides[1] / sides[0])
    short, long = (
        Period((2 * int(ratio * longest) + 1, shape[1]), sides, thicknesses, POISSON).find_stress(strain)
        for ratio in (5.0, 10.0)
    )
    expected = long + (long - short) / 3.0
    error = largest(plane.find_stress(strain) - expected) / largest(expected)
    assert error < 1e-3
    assert error < 0.1 * largest(plane.period.find_stress(strain) - expected) / largest(expected)


@pytest.mark.parametrize("ny", [7, 8])
def test_stress_by_rows_is_the_sum_over_all_images(ny):
    thicknesses = np.array([0.5, 1.0, 2.0])
    pressure = np.random.default_rng(1).normal(size=(9, ny))
    found = make("free-periodic", (9, ny), (1.0, 1.0), thicknesses).press(pressure)

    def add_images(copies):
        free = make("free", (9, copies * ny), (1.0, 1.0), thicknesses)
        middle = copies // 2 * ny
        return free.press(np.tile(pressure, (1, copies)))[..., middle : middle + ny]

    # What is missing falls with the distance of the farthest image.
    few, many = add_images(41), add_images(123)
    expected = many + (many - few) / 2.0
    assert largest(found - expected) < 1e-5 * largest(expected)


def test_strip_stands_for_the_images_beyond(monkeypatch):
    few = love.mean_stress_below_row(0.0, 0.5, POISSON, (9, 8), (1.0, 1.0))
    monkeypatch.setattr(love, "_IMAGES", 20)
    many = love.mean_stress_below_row(0.0, 0.5, POISSON, (9, 8), (1.0, 1.0))
    # Without the slope at its end the strip is off by 2e-6.
    assert largest(few - many) < 1e-7


def test_table_is_the_mean_of_the_stress_over_a_layer():
    x, weights = np.polynomial.legendre.leggauss(10)
    kernel = HalfSpaceStress(0.25)
    # Of depths from where the core has it in float64.
    for top, bottom in ((40.0, 42.0), (60.0, 90.0)):
        depths = 0.5 * (top + bottom) + 0.5 * (bottom - top) * x
        expected = sum(
            0.5 * weight * kernel.stress_coefficients("z", (6, 9), (1.0, 3.0), depth)
            for weight, depth in zip(weights, depths, strict=True)
        )
        table = mean_stress_below_cell(top, bottom, 0.25, (6, 9), (1.0, 3.0))
        assert largest(table - expected) < 1e-9 * largest(expected)


def test_table_near_the_surface():
    kernel = HalfSpaceStress(0.25)
    # Nearly a point of depth: the core's float32.
    for depth in (0.0, 0.3, 2.0):
        table = mean_stress_below_cell(depth, depth + 1e-5, 0.25, (6, 9), (1.0, 3.0))
        expected = kernel.stress_coefficients("z", (6, 9), (1.0, 3.0), depth + 5e-6)
        assert largest(table - expected) < 2e-6


def test_maps_of_a_free_boundary_are_plain_sums_of_the_table():
    operators = make("free", (7, 5), (1.0, 2.0), np.array([0.5, 1.5]))
    pressure, strain = np.random.default_rng(1).normal(size=(7, 5)), draw(operators, 2)
    dense = np.empty((6, 2, 7, 5, 7, 5))
    x, y = np.arange(7), np.arange(5)
    signs_x = np.sign(x[:, np.newaxis] - x)[:, np.newaxis, :, np.newaxis]
    signs_y = np.sign(y[:, np.newaxis] - y)[np.newaxis, :, np.newaxis, :]
    for layer, (top, bottom) in enumerate(((0.0, 0.5), (0.5, 2.0))):
        table = mean_stress_below_cell(top, bottom, POISSON, (7, 5), (1.0, 2.0))
        table = table[
            :,
            np.abs(x[:, np.newaxis] - x)[:, np.newaxis, :, np.newaxis],
            np.abs(y[:, np.newaxis] - y)[np.newaxis, :, np.newaxis, :],
        ]
        table[3] *= signs_y
        table[4] *= signs_x
        table[5] *= signs_x * signs_y
        dense[:, layer] = table
    stress = np.einsum("clxyij,ij->clxy", dense, pressure)
    assert largest(operators.press(pressure) - stress) < 1e-14 * largest(stress)
    displacement = np.einsum("c,l,clxyij,clxy->ij", WEIGHTS, operators.thicknesses, dense, strain)
    assert largest(operators.displace(strain) - displacement) < 1e-12 * largest(displacement)


def test_memory_is_what_is_said():
    for boundary in BOUNDARIES:
        operators = make(boundary, (48, 64), thicknesses=np.full(12, 1e-6))
        strain = draw(operators, 1)
        tracemalloc.start()
        try:
            operators.find_stress(strain)
            operators.press(strain[0, 0])
            operators.displace(strain)
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        assert 0.2 * operators.bytes_needed < peak < operators.bytes_needed


def test_a_wide_field_takes_two_fields_and_a_tile():
    # 256 x 256 x 32, periodic: 700 MB with the strain that is given.
    operators = make("periodic", (256, 256), thicknesses=np.ones(32))
    assert operators.bytes_needed + 8 * np.prod(operators.shape) < 400e6


def test_zeros_stay_zero():
    for boundary in BOUNDARIES:
        operators = make(boundary, (6, 5))
        nothing = np.zeros(operators.shape)
        assert not operators.find_stress(nothing).any()
        assert not operators.displace(nothing).any()
        assert not operators.press(nothing[0, 0]).any()


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"boundary": "wrapped"}, "nearest ones alone"),
        ({"boundary": "open"}, "The boundary must be free"),
        ({"thicknesses": []}, "thicknesses"),
        ({"thicknesses": [1e-6, 0.0]}, "thicknesses"),
        ({"thicknesses": [1e-6, np.nan]}, "thicknesses"),
        ({"thicknesses": "deep"}, "thicknesses"),
        ({"thicknesses": [[1e-6]]}, "thicknesses"),
        ({"young": 0.0}, "Young"),
        ({"young": np.inf}, "Young"),
        ({"young": "stiff"}, "Young"),
        ({"poisson": 0.5}, "Poisson"),
        ({"poisson": -1.0}, "Poisson"),
        ({"precision": "float16"}, "precision"),
        ({"grid": (8, 8)}, "grid"),
    ],
)
def test_bad_bodies_are_refused(changes, sentence):
    given = {
        "grid": rc.Grid((4, 4), 1e-6),
        "boundary": "free",
        "thicknesses": [1e-6],
        "young": 1e9,
        "poisson": 0.3,
    } | changes
    with pytest.raises(rc.InputError, match=sentence):
        VolumeOperators(**given)


def test_bad_fields_are_refused():
    operators = make("free", (6, 5))
    for values in (np.zeros((6, 5)), np.zeros((6, 5, 5, 6)), "strain", np.full(operators.shape, np.nan), None):
        for call in (operators.find_stress, operators.displace):
            with pytest.raises(rc.InputError, match="The strain must be"):
                call(values)
    for values in (np.zeros((5, 6)), np.full((6, 5), np.inf), 1.0):
        with pytest.raises(rc.InputError, match="The pressure must be"):
            operators.press(values)


def test_too_many_layers_are_refused():
    operators = make("free", (512, 512), thicknesses=np.full(2**18, 1e-6))
    with pytest.raises(rc.InputError, match=r"of memory.*fewer layers"):
        operators.press(np.zeros((512, 512)))


def test_the_examples_of_the_docstrings_give_what_they_say():
    results = doctest.testmod(importlib.import_module("roughcontact_volume.operators"))
    assert results.attempted > 0
    assert results.failed == 0
