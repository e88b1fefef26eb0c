"""The closed forms, proved by equilibrium, by quadrature and by each other; then the operators beside them."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import roughcontact as rc

from closed_forms import (
    apply_hooke,
    as_components,
    as_tensor,
    find_boussinesq_stress,
    find_cuboid_displacement,
    find_cuboid_strain,
    find_cuboid_stress,
    find_dilating_sphere,
    find_eshelby,
    find_half_space_stress,
    find_inhomogeneity_strain,
    find_sphere_heave,
)
from roughcontact_volume.operators import VolumeOperators
from roughcontact_volume.shapes import Ellipsoid, Sphere, find_fractions

NU = 0.28
STRAIN = as_tensor([1.0, -0.4, 0.7, 0.3, -0.6, 0.5])
BOX = np.array([[-0.5, 0.7], [-0.3, 0.4], [0.6, 1.5]])


def _gradient(field, point, step):
    """Central differences of fourth order of a field of one point, the derivative last."""
    rows = []
    for axis in range(3):
        shift = np.eye(3)[axis] * step
        near = field(point + shift) - field(point - shift)
        far = field(point + 2 * shift) - field(point - 2 * shift)
        rows.append((8.0 * near - far) / (12.0 * step))
    return np.stack(rows, axis=-1)


def _stress_at(point):
    return find_cuboid_stress(BOX, STRAIN, 2.0, NU, point[:, np.newaxis])[..., 0]


@pytest.mark.parametrize("point", [(0.1, 0.05, 1.0), (0.9, 0.2, 0.4), (-0.8, -0.7, 1.9), (0.1, 0.1, 3.0)])
def test_the_cuboid_is_in_equilibrium(point):
    divergence = np.einsum("ijj", _gradient(_stress_at, np.array(point), 1e-3))
    assert np.abs(divergence).max() < 1e-8


def test_the_cuboid_is_the_integral_of_kelvins_force():
    point = np.array([1.4, 0.9, -0.2])

    def green(x):
        r = math.sqrt(float(x @ x))
        return ((3.0 - 4.0 * NU) * np.eye(3) / r + np.outer(x, x) / r**3) / (16.0 * math.pi * (1.0 - NU))

    # u_i = -G_ij,l s_jl over the cuboid, per shear modulus, s the stress of the eigenstrain.
    source = apply_hooke(STRAIN, 2.0 * (1.0 + NU), NU)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    half = 0.5 * (BOX[:, 1] - BOX[:, 0])

    def displacement(at):
        total = np.zeros(3)
        for places in itertools.product(range(6), repeat=3):
            where = BOX.mean(axis=1) + half * nodes[list(places)]
            slope = _gradient(green, at - where, 1e-2)
            total -= np.prod(weights[list(places)] * half) * np.einsum("ijl,jl", slope, source)
        return total

    gradient = _gradient(displacement, point, 1e-2)
    strain = find_cuboid_strain(BOX, STRAIN, NU, point[:, np.newaxis])[..., 0]
    assert strain == pytest.approx(0.5 * (gradient + gradient.T), abs=2e-6)


def test_tractions_pass_through_the_faces_of_a_cuboid():
    for axis in range(3):
        at = BOX.mean(axis=1) + np.array([0.1, 0.05, -0.1])
        at[axis] = BOX[axis, 1]
        normal = np.eye(3)[axis] * 1e-9
        jump = _stress_at(at + normal) - _stress_at(at - normal)
        assert np.abs(jump[axis]).max() < 1e-7
        assert np.abs(jump).max() > 0.1


def test_a_cube_strains_like_a_sphere_in_its_middle():
    # By its symmetry the dilatation of a cube is that of a sphere: (1 + nu) / (1 - nu) e.
    cube = np.array([[-1.0, 1.0]] * 3)
    strain = find_cuboid_strain(cube, np.eye(3), NU, np.zeros((3, 1)))[..., 0]
    assert strain == pytest.approx((1.0 + NU) / (3.0 * (1.0 - NU)) * np.eye(3), abs=1e-12)


def test_eshelbys_sphere():
    tensor = find_eshelby((1.0, 1.0, 1.0), NU)
    assert tensor[0, 0, 0, 0] == pytest.approx((7.0 - 5.0 * NU) / (15.0 * (1.0 - NU)), rel=1e-10)
    assert tensor[0, 0, 1, 1] == pytest.approx((5.0 * NU - 1.0) / (15.0 * (1.0 - NU)), rel=1e-10)
    assert tensor[0, 1, 0, 1] == pytest.approx((4.0 - 5.0 * NU) / (15.0 * (1.0 - NU)), rel=1e-10)


@pytest.mark.parametrize("axes", [(1.0, 1.0, 1.0), (2.0, 1.0, 0.5), (0.4, 0.4, 1.3)])
def test_eshelbys_tensor_is_the_mean_over_all_directions(axes):
    # Each direction of the wave vector gives the strain of a plane wave; an ellipsoid weights them by its axes.
    cosines, weights = np.polynomial.legendre.leggauss(60)
    angles = 2.0 * math.pi * np.arange(120) / 120.0
    stress = apply_hooke(STRAIN, 2.0 * (1.0 + NU), NU)
    total = np.zeros((3, 3))
    for cosine, weight in zip(cosines, weights, strict=True):
        sine = math.sqrt(1.0 - cosine**2)
        for angle in angles:
            n = np.array([sine * math.cos(angle), sine * math.sin(angle), cosine]) / axes
            n /= np.linalg.norm(n)
            pull = stress @ n
            moved = pull - n * (n @ pull) / (2.0 * (1.0 - NU))
            total += weight / 240.0 * 0.5 * (np.outer(moved, n) + np.outer(n, moved))
    assert np.einsum("ijkl,kl", find_eshelby(axes, NU), STRAIN) == pytest.approx(total, abs=1e-8)


def test_an_inhomogeneity_of_the_same_moduli_is_none():
    assert find_inhomogeneity_strain((2.0, 1.0, 0.5), (3.0, NU), (3.0, NU), STRAIN) == pytest.approx(STRAIN)


def test_a_stiff_sphere_under_pressure():
    # Goodier: the dilatation inside is 3 (1 - nu) K / (2 (1 - 2 nu) K + (1 + nu) K_i) of that far away.
    inside = find_inhomogeneity_strain((1.0, 1.0, 1.0), (5.0, NU), (1.0, NU), np.eye(3))
    expected = 3.0 * (1.0 - NU) / (2.0 * (1.0 - 2.0 * NU) + 5.0 * (1.0 + NU))
    assert inside == pytest.approx(expected * np.eye(3), abs=1e-9)


def test_the_dilating_sphere_leaves_the_surface_free():
    def strain(point):
        gradient = _gradient(lambda at: find_dilating_sphere(0.5, 1.0, 1.0, NU, at), point, 1e-3)
        return 0.5 * (gradient + gradient.T)

    def stress(point):
        return apply_hooke(strain(point), 1.0, NU)

    for x, y in ((0.0, 0.0), (0.7, -0.3), (2.0, 1.0)):
        assert np.abs(stress(np.array([x, y, 0.0]))[2]).max() < 1e-9
    divergence = np.einsum("ijj", _gradient(stress, np.array([0.8, 0.3, 0.5]), 1e-2))
    assert np.abs(divergence).max() < 1e-5
    x, y = np.array([0.0, 0.4]), np.array([0.1, 0.9])
    surface = find_dilating_sphere(0.5, 1.0, 1.0, NU, np.array([x, y, 0.0 * x]))[2]
    assert surface == pytest.approx(find_sphere_heave(0.5, 1.0, 1.0, NU, x, y), rel=1e-12)


def test_the_surface_above_a_small_cuboid_moves_as_above_a_sphere():
    edge = 0.02
    radius = edge * (3.0 / (4.0 * math.pi)) ** (1.0 / 3.0)
    box = np.array([[-edge / 2, edge / 2]] * 2 + [[1.0 - edge / 2, 1.0 + edge / 2]])
    x, y = np.array([0.0, 0.8]), np.array([0.0, 0.3])
    found = find_cuboid_displacement(box, np.eye(3), NU, x, y)
    assert found == pytest.approx(find_sphere_heave(radius, 1.0, 1.0, NU, x, y), rel=1e-4)


@pytest.mark.parametrize("point", [(0.3, 0.2, 0.2), (0.9, -0.4, 0.3)])
def test_the_half_space_with_a_cuboid(point):
    point = np.array(point)
    found = find_half_space_stress(BOX, STRAIN, 2.0, NU, point)
    assert found == pytest.approx(find_half_space_stress(BOX, STRAIN, 2.0, NU, point, nodes=220), abs=1e-5)
    # The traction grows with depth from zero.
    near = find_half_space_stress(BOX, STRAIN, 2.0, NU, point * (1.0, 1.0, 0.25), nodes=300)
    assert np.abs(near[2]).max() < 0.4 * np.abs(found[2]).max()


def test_a_cuboid_below_a_free_surface_that_dilates():
    # The field of Mindlin and Cheng, for a small cuboid as for a sphere of its volume.
    edge = 0.05
    radius = edge * (3.0 / (4.0 * math.pi)) ** (1.0 / 3.0)
    box = np.array([[-edge / 2, edge / 2]] * 2 + [[1.0 - edge / 2, 1.0 + edge / 2]])
    at = np.array([0.6, 0.2, 0.5])
    gradient = _gradient(lambda x: find_dilating_sphere(radius, 1.0, 1.0, NU, x), at, 1e-3)
    expected = apply_hooke(0.5 * (gradient + gradient.T), 2.0, NU)
    found = find_half_space_stress(box, np.eye(3), 2.0, NU, at)
    assert found == pytest.approx(expected, abs=3e-3 * np.abs(expected).max())


def test_boussinesq_carries_the_force():
    angle = np.linspace(0.0, 2.0 * math.pi, 7)
    x = np.array([0.3 * np.cos(angle), 0.3 * np.sin(angle), 0.4 + 0.0 * angle])
    # Through any plane the force passes: the stress of a ray is along the ray.
    stress = find_boussinesq_stress(x, NU)
    assert stress[2, 2] == pytest.approx(-3.0 * 0.4**3 / (2.0 * math.pi * 0.5**5))
    assert stress[0, 2] == pytest.approx(stress[2, 2] * x[0] / x[2])


# Operators beside the closed forms: a cuboid of whole cells, 1 to 2 below the surface.
PLACES = ((0.0, 0.0, 1.5), (1.5, 0.9, 0.5), (0.0, 0.0, 2.6))


class _CuboidInCells:
    def __init__(self, cells, ratio, boundary, width):
        sides = (1.0 / cells, ratio / cells)
        shape = tuple(2 * round(0.5 * width / side) + 1 for side in sides)
        inside = [2 * (round(length / side) // 2) + 1 for length, side in zip((1.0, 2.0), sides, strict=True)]
        grid = rc.Grid(shape, tuple(n * side for n, side in zip(shape, sides, strict=True)))
        self.x, self.y = grid.x.ravel(), grid.y.ravel()
        halves = [0.5 * n * side for n, side in zip(inside, sides, strict=True)]
        self.box = np.array([[-halves[0], halves[0]], [-halves[1], halves[1]], [1.0, 2.0]])
        self.operators = VolumeOperators(grid, boundary, np.full(3 * cells, 1.0 / cells), 2.0, NU)
        self.strain = np.zeros(self.operators.shape)
        i, j = ((whole - part) // 2 for whole, part in zip(shape, inside, strict=True))
        within = (slice(None), slice(cells, 2 * cells), slice(i, i + inside[0]), slice(j, j + inside[1]))
        self.strain[within] = as_components(STRAIN)[:, None, None, None]

    def find_stress_errors(self):
        stress = self.operators.find_stress(self.strain)
        errors = []
        for x, y, z in PLACES:
            i, j = np.argmin(np.abs(self.x - x)), np.argmin(np.abs(self.y - y))
            layer = int(np.argmin(np.abs(self.operators.depths - z)))
            point = np.array([self.x[i], self.y[j], self.operators.depths[layer]])
            exact = as_components(find_half_space_stress(self.box, STRAIN, 2.0, NU, point))
            errors.append(np.abs(stress[:, layer, i, j] - exact).max())
        return np.array(errors)

    def find_displacement_error(self):
        x, y = np.meshgrid(self.x, self.y, indexing="ij")
        near = (np.abs(x) < 3.0) & (np.abs(y) < 3.0)
        exact = find_cuboid_displacement(self.box, STRAIN, NU, x[near], y[near])
        return np.abs(self.operators.displace(self.strain)[near] - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize(("ratio", "width", "cells"), [(1.0, 6.0, 3), (3.0, 12.0, 3)])
def test_the_free_surface_moves_as_over_a_cuboid(ratio, width, cells):
    assert _CuboidInCells(cells, ratio, "free", width).find_displacement_error() < 5e-6


def test_the_periodic_surface_moves_as_over_a_cuboid_far_from_its_images():
    coarse, fine = (_CuboidInCells(cells, 1.0, "periodic", 20.0).find_displacement_error() for cells in (2, 4))
    assert fine < 0.5 * coarse < 0.01


@pytest.mark.parametrize(
    ("ratio", "width", "boundary", "cells"),
    [(1.0, 6.0, "free", 2), (3.0, 12.0, "free", 3), (1.0, 24.0, "periodic", 2)],
)
def test_the_stress_of_a_cuboid_is_of_second_order(ratio, width, boundary, cells):
    coarse, fine = (_CuboidInCells(n, ratio, boundary, width).find_stress_errors() for n in (cells, 2 * cells))
    assert fine.max() < 0.015
    assert fine.sum() < 0.4 * coarse.sum()


def test_the_stress_around_a_dilating_sphere():
    side = 0.125
    grid = rc.Grid((40, 40), 40 * side)
    operators = VolumeOperators(grid, "free", np.full(16, side), 2.0, NU)
    fractions = find_fractions(Sphere(0.5), (0.0, 0.0, 1.0), grid, rc.Boundary.FREE, side * np.arange(17))
    strain = np.zeros(operators.shape)
    strain[:3] = fractions
    heave = find_sphere_heave(0.5, 1.0, 1.0, NU, grid.x, grid.y)
    assert operators.displace(strain) == pytest.approx(heave, abs=0.01 * np.abs(heave).max())
    stress = operators.find_stress(strain)
    inside = fractions == 1.0
    # Eshelby's sphere, and what the free surface adds to it: below a fifth of it at two radii.
    deep = apply_hooke(((1.0 + NU) / (3.0 * (1.0 - NU)) - 1.0) * np.eye(3), 2.0, NU)[0, 0]
    assert stress[0][inside].mean() == pytest.approx(deep, rel=0.2)
    point = np.array([grid.x[27, 0], grid.y[0, 20], operators.depths[5]])
    gradient = _gradient(lambda at: find_dilating_sphere(0.5, 1.0, 1.0, NU, at), point, 1e-3)
    exact = as_components(apply_hooke(0.5 * (gradient + gradient.T), 2.0, NU))
    assert stress[:, 5, 27, 20] == pytest.approx(exact, abs=0.02 * abs(deep))


@pytest.mark.parametrize("axes", [(0.5, 0.5, 0.5), (0.75, 0.5, 0.375)])
def test_eshelbys_ellipsoid_in_the_deep(axes):
    side = 0.125
    grid = rc.Grid((45, 45), 45 * side)
    thicknesses = np.array([3.0, *np.full(8, side)])
    operators = VolumeOperators(grid, "free", thicknesses, 2.0, NU)
    interfaces = np.concatenate(([0.0], np.cumsum(thicknesses)))
    fractions = find_fractions(Ellipsoid(axes), (0.0, 0.0, 3.5), grid, rc.Boundary.FREE, interfaces)
    strain = fractions * as_components(STRAIN)[:, None, None, None]
    spread = np.einsum("ijkl,kl", find_eshelby(axes, NU), STRAIN)
    exact = as_components(apply_hooke(spread - STRAIN, 2.0, NU))
    middle = operators.find_stress(strain)[:, fractions == 1.0].mean(axis=1)
    assert middle == pytest.approx(exact, abs=0.03 * np.abs(exact).max())
