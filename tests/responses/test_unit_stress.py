"""Stresses beneath single cells, their sums and invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import roughcontact as rc
from roughcontact._answers.subsurface.field import find_steps, maximum_shear
from roughcontact._answers.subsurface.near import find_near_maxima
from roughcontact._base import machine
from roughcontact._parts.kernels.stress_cells import STRESS_COMPONENTS, cell_stress
from roughcontact.responses import StressField
from scenes import each_once
from test_stress import (
    NU,
    XX,
    XY,
    XZ,
    YY,
    YZ,
    ZZ,
    boussinesq,
    convolve,
    maximum_on_axis,
    press_ball,
    press_rough,
)


def is_odd(axis, component, load):
    return (component + load).count(axis) % 2 == 1


def superpose(load, z, nu, sides, images, letter="z"):
    """Return the stress by all cells and so many rings of images of the domain, summed one by one, float64."""
    nx, ny = load.shape
    reach_x, reach_y = max(nx * images, nx - 1), max(ny * images, ny - 1)
    table = cell_stress(z, nu, (reach_x + 1, reach_y + 1), sides, np.float64, letter)
    x, y = np.arange(-reach_x, reach_x + 1), np.arange(-reach_y, reach_y + 1)
    # The outermost image lies half on each side.
    ends = [np.where(images * (np.abs(o) == n * images), 0.5, 1.0) for o, n in ((x, nx), (y, ny))]
    stress = np.empty((6, nx, ny))
    for place, component in enumerate(STRESS_COMPONENTS):
        kernel = table[place][np.abs(x)][:, np.abs(y)] * ends[0][:, np.newaxis] * ends[1]
        kernel *= np.sign(x)[:, np.newaxis] if is_odd("x", component, letter) else 1.0
        kernel *= np.sign(y) if is_odd("y", component, letter) else 1.0
        mx, my = (nx, ny) if images else (2 * nx, 2 * ny)
        folded = np.zeros((mx, my))
        np.add.at(folded, ((x % mx)[:, np.newaxis], y % my), kernel)
        whole = np.fft.ifft2(np.fft.fft2(folded) * np.fft.fft2(load, (mx, my))).real
        stress[place] = whole[:nx, :ny]
    return stress


@pytest.mark.parametrize(("nu", "z", "sides"), [(0.3, 0.4, (1.0, 0.7)), (0.0, 2.0, (1.0, 1.0)), (0.5, 1.0, (0.3, 2.0))])
def test_a_cell_is_the_integral_of_point_forces(nu, z, sides):
    nodes, weights = np.polynomial.legendre.leggauss(80)
    table = cell_stress(z, nu, (4, 3), sides, np.float64)
    for i, j in ((0, 0), (1, 0), (0, 2), (3, 1)):
        x = (i - 0.5 * nodes[:, np.newaxis]) * sides[0]
        y = (j - 0.5 * nodes[np.newaxis, :]) * sides[1]
        points = boussinesq(x, y, z, nu)
        whole = np.einsum("aij,i,j->a", points, weights, weights) * sides[0] * sides[1] / 4.0
        np.testing.assert_allclose(table[:, i, j], whole, atol=1e-9)


@each_once(
    {
        "sides": [(1.0, 1.0), (1.0, 1.7)],
        "z": [0.0, 0.3, 2.5, 11.0],
    }
)
def test_transforms_are_the_sums_over_cells(sides, z):
    pressure = np.random.default_rng(5).random((24, 15)).astype(np.float32)
    free = convolve(pressure, z, "free", sides, common=(4, 1))
    np.testing.assert_allclose(free, superpose(pressure, z, NU, sides, 0), atol=2e-6)
    # Only without a mean does the sum over images converge.
    even = pressure - np.float32(pressure.mean(dtype=np.float64))
    periodic = convolve(even, z, "periodic", sides)
    np.testing.assert_allclose(periodic, superpose(even, z, NU, sides, 16), atol=3e-6)


@each_once(
    {
        "boundary": ["free", "periodic", "free-periodic", "periodic-free"],
        "slides": [False, True],
        "shape z sides": [
            ((128, 64), 8.0, (1.0, 1.0)),
            ((64, 160), 17.0, (1.0, 1.0)),
            ((96, 33), 40.0, (1.0, 1.0)),
            ((64, 64), 700.0, (1.0, 1.0)),
            ((50, 66), 9.0, (1.0, 1.0)),
            ((100, 76), 18.0, (1.0, 1.0)),
            ((64, 96), 20.0, (1.0, 2.0)),
            ((128, 64), 17.0, (1.0, 0.4)),
        ],
    }
)
def test_fewer_points_at_depth_lose_nothing(boundary, slides, shape, z, sides):
    rng = np.random.default_rng(int(z))
    steps = find_steps(shape, sides, z)
    assert max(steps) > 1

    of = "zxy" if slides else "z"
    fields = (rng.random((3, *shape)) * (rng.random((3, *shape)) < 0.2)).astype(np.float32)
    fields = fields[: len(of)]
    few = convolve(fields, z, boundary, sides, of, steps)
    # A finer grid has points there: each cell is cut into 2 x 2, and the middle of the block is a corner of the cells.
    fine = np.kron(fields, np.ones((1, 2, 2), np.float32))
    many = convolve(fine, 2.0 * z, boundary, sides, of)
    for axis, step in ((1, steps[0]), (2, steps[1])):
        # Cubic interpolation halfway between four points.
        first = np.arange(few.shape[axis]) * 2 * step + step - 1
        taken = [np.take(many, np.clip(first + k, 0, many.shape[axis] - 1), axis=axis) for k in (-1, 0, 1, 2)]
        many = (9.0 * (taken[1] + taken[2]) - taken[0] - taken[3]) / 16.0
    inner = (slice(None), slice(1, -1), slice(1, -1))
    assert np.abs(few - many)[inner].max() < (4e-4 if slides else 3e-4) * np.abs(many).max()


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_stresses_add_and_follow_the_symmetry(boundary):
    one, other = np.random.default_rng(2).random((2, 20, 14)).astype(np.float32)
    first, second = convolve(one, 1.5, boundary), convolve(other, 1.5, boundary)
    np.testing.assert_allclose(convolve(one + other, 1.5, boundary), first + second, atol=3e-6)
    turned = convolve(one.T, 1.5, boundary).transpose(0, 2, 1)
    np.testing.assert_allclose(turned, first[[YY, XX, ZZ, XZ, YZ, XY]], atol=2e-6)
    mirrored = convolve(one[::-1], 1.5, boundary)[:, ::-1]
    signs = np.array([-1.0 if is_odd("x", component, "z") else 1.0 for component in STRESS_COMPONENTS])
    signs = signs[:, np.newaxis, np.newaxis]
    np.testing.assert_allclose(mirrored, signs * first, atol=2e-6)


@given(hnp.arrays(np.float64, (6, 5), elements=st.floats(-10.0, 10.0)))
@example(np.full((6, 5), 3e-125))
def test_invariants_are_those_of_the_principal_stresses(values):
    xx, yy, zz, yz, xz, xy = values
    tensors = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
    low, middle, high = np.linalg.eigvalsh(tensors).T
    size = 1.0 + np.abs(values).max()
    np.testing.assert_allclose(maximum_shear(values), 0.5 * (high - low), atol=1e-7 * size)
    field = StressField(1.0, rc.Grid((5, 2), 1.0), np.repeat(values[:, :, np.newaxis], 2, axis=2), 2.0)
    mises = np.sqrt(0.5 * ((high - low) ** 2 + (high - middle) ** 2 + (middle - low) ** 2))
    np.testing.assert_allclose(field.von_mises[:, 0], 2.0 * mises, atol=1e-6 * size)
    np.testing.assert_allclose(field.shear[:, 0], high - low, atol=2e-7 * size)


def test_the_array_and_the_fields_are_the_same():
    solution, _ = press_rough(32, 6)
    h = solution.grid.spacing[0]
    stress = solution.stress([2.0 * h, 0.5 * h, 9.0 * h])
    assert len(stress) == 3
    assert stress.components.shape == (3, len(STRESS_COMPONENTS), 32, 32)
    assert stress.von_mises.shape == (3, 32, 32)
    fields = list(stress)
    assert [field.depth for field in fields] == [*stress.depths]
    assert [field.grid.shape for field in fields] == [(32, 32), (32, 32), (16, 16)]
    for place in (0, 1):
        np.testing.assert_array_equal(fields[place].components, stress.components[place])
        np.testing.assert_allclose(fields[place].von_mises, stress.von_mises[place], rtol=1e-5)
        assert stress.profile[place] == pytest.approx(fields[place].von_mises.max(), rel=0.05)
    np.testing.assert_array_equal(stress[-1].components, fields[2].components)
    assert "maximum von Mises" in str(stress)
    assert "16 x 16" in str(fields[2])
    assert not stress.components.flags.writeable


def test_an_array_beyond_the_memory_is_refused(monkeypatch):
    solution, _ = press_rough(128, 6)
    monkeypatch.setattr(machine, "available_memory", lambda *_: 2**20)
    with pytest.raises(rc.InputError, match="one at a time"):
        _ = solution.stress(np.linspace(1e-6, 1e-3, 64)).components


@pytest.mark.parametrize(
    ("radius", "sides", "boundary"),
    [(1.1, (1.0, 1.0), "free"), (2.6, (0.5, 1.0), "free-periodic"), (4.5, (1.0, 0.3), "free")],
)
def test_on_finer_cells_the_maximum_below_a_ball_is_hertzs(radius, sides, boundary):
    solution, hertz, _ = press_ball(radius, (25, 40), sides=sides, place=(0.31, -0.17), boundary=boundary)
    stress = solution.stress()
    found = find_near_maxima(solution, NU, lambda depth: stress._field(depth, (1, 1)))[maximum_shear]
    value, depth = maximum_on_axis(NU)
    value *= hertz.p_max
    assert found.value == pytest.approx(value, rel=0.01)
    assert abs(found.value - value) < 2.0 * found.uncertainty
    assert found.depth == pytest.approx(depth * hertz.semi_axes[0], rel=0.05)
    assert math.hypot(found.x - 0.31 * 4e-6, found.y + 0.17 * 4e-6) < 1e-6
