"""The response of half-spaces to shear, and its convolution, against extended precision and plain sums."""

from __future__ import annotations

import pickle

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.typing import BoundKernel, PairConstants, pair_constants
from strategies import aspects, grids, seeds

COMPONENTS = ("xx", "yy", "xy", "zx", "zy")
PAIR = PairConstants(0.29, 0.43)
KERNEL = BoundKernel(rc.Love(), pair=PAIR)
SERVED = [(rc.DCFFT(), rc.Boundary.FREE), (rc.Direct(), rc.Boundary.FREE), (rc.CircularFFT(), rc.Boundary.PERIODIC)]


def integrate(corner, i, j, dx, dy):
    """The integral over a cell from its double primitive, with 60 digits."""
    with mp.workdps(60):
        (x1, x2), (y1, y2) = (
            ((mp.mpf(k) - mp.mpf(1) / 2) * step, (mp.mpf(k) + mp.mpf(1) / 2) * step)
            for k, step in ((i, mp.mpf(dx)), (j, mp.mpf(dy)))
        )
        return corner(x2, y2) - corner(x1, y2) - corner(x2, y1) + corner(x1, y1)


PRIMITIVES = {
    "xx": lambda x, y: (1 + mp.mpf(PAIR.gamma)) * y * mp.asinh(x / abs(y)) + x * mp.asinh(y / abs(x)),
    "yy": lambda x, y: y * mp.asinh(x / abs(y)) + (1 + mp.mpf(PAIR.gamma)) * x * mp.asinh(y / abs(x)),
    "xy": lambda x, y: -mp.mpf(PAIR.gamma) * mp.hypot(x, y),
    "zx": lambda x, y: mp.mpf(PAIR.beta) * (y * mp.log(mp.hypot(x, y)) + x * mp.atan(y / x)),
    "zy": lambda x, y: mp.mpf(PAIR.beta) * (x * mp.log(mp.hypot(x, y)) + y * mp.atan(x / y)),
}


@pytest.mark.parametrize("spacing", [(1.0, 1.0), (1.5, 1.0), (1.0, 8.0), (20.0, 1.0), (1.0, 20.0)])
@pytest.mark.parametrize("component", COMPONENTS)
def test_coefficients_agree_with_mpmath_to_1e_14(component, spacing):
    # A column, a row and a square beside the origin, so that all ways to integrate are met.
    for shape in ((4000, 2), (2, 4000), (130, 130)):
        values = rc.Love().shear_coefficients(component, shape, spacing, np.pi, PAIR)
        scale = rc.Love().coefficients(shape, spacing, np.pi)
        rng = np.random.default_rng(5)
        some = [(int(i) % shape[0], int(j) % shape[1]) for i, j in 2 ** (12 * rng.random((25, 2)))]
        for i, j in (*some, (0, 0), (1, 0), (0, 1), (9, 0), (0, 10), (shape[0] - 1, shape[1] - 1)):
            if i < shape[0] and j < shape[1]:
                exact = integrate(PRIMITIVES[component], i, j, *spacing)
                assert abs(values[i, j] - exact) < 1e-14 * scale[i, j]
                # Beside the axes on which it vanishes each component is as exact by itself.
                if abs(exact) > 1e-20:
                    assert abs(values[i, j] / exact - 1) < 1e-14


def plain_alias_sum(component, theta_x, theta_y, dx, dy, count):
    """The defining sum, each alias with its own direction, smoothed by averaging squares."""
    # The sum over the longer side converges later.
    counts = (round(count * max(1.0, 0.2 * dx / dy)), round(count * max(1.0, 0.2 * dy / dx)))
    x, y = (t + 2 * np.pi * np.arange(-n, n + 1) for t, n in zip((theta_x, theta_y), counts, strict=True))
    waves = {"x": (x / dx)[:, None], "y": (y / dy)[None, :]}
    length = np.hypot(waves["x"], waves["y"])
    one, other = component
    if one == "z":
        factor = -PAIR.beta * waves[other] / length
    else:
        factor = (one == other) * (1 + PAIR.gamma) - PAIR.gamma * waves[one] * waves[other] / length**2
    terms = np.sinc(x / 2 / np.pi)[:, None] * np.sinc(y / 2 / np.pi)[None, :] * factor / length
    tapers = [np.clip((n + 1 - np.abs(np.arange(-n, n + 1))) / (n / 2), 0, 1) for n in counts]
    smooth_x, smooth_y = (taper**2 * (3 - 2 * taper) for taper in tapers)
    return 2 * np.sum(terms * smooth_x[:, None] * smooth_y[None, :])


@pytest.mark.slow
@pytest.mark.parametrize(("dx", "dy", "count"), [(1.0, 1.0, 400), (1.0, 2.5, 400), (20.0, 1.0, 400), (1.0, 20.0, 400)])
def test_spectrum_is_the_alias_sum_of_directions(dx, dy, count):
    theta = np.array([0.02, 2.0, np.pi])
    qx, qy = theta[:, None] / dx, theta[None, :] / dy
    scale = rc.Love().spectrum(qx, qy, (dx, dy), 1.0)
    for component in COMPONENTS:
        values = rc.Love().shear_spectrum(component, qx, qy, (dx, dy), 1.0, PAIR)
        for i, j in np.ndindex(3, 3):
            exact = plain_alias_sum(component, theta[i], theta[j], dx, dy, count)
            assert abs(values[i, j] - exact) < 1e-12 * scale[i, j]


@pytest.mark.slow
@pytest.mark.parametrize("aspect", [0.2, 1.0, 5.0])
@given(angle=st.floats(0.0, 2 * np.pi))
def test_long_waves_are_those_of_the_half_space(aspect, angle):
    q = 1e-3
    qx, qy = np.array([[q * np.cos(angle)]]), np.array([[q * np.sin(angle)]])
    for component in COMPONENTS:
        love, fourier = (
            kernel.shear_spectrum(component, qx, qy, (1.0, aspect), 1.0, PAIR)
            for kernel in (rc.Love(), rc.FourierHalfSpace())
        )
        np.testing.assert_allclose(love, fourier, rtol=0, atol=1e-5 * 2 / q)


def test_a_wave_of_shear_across_its_normal_displaces_more_by_one_plus_gamma():
    q, none = np.array([[0.7]]), np.zeros((1, 1))
    along = rc.FourierHalfSpace().shear_spectrum("xx", q, none, (1.0, 1.0), 1.0, PAIR).item()
    across = rc.FourierHalfSpace().shear_spectrum("yy", q, none, (1.0, 1.0), 1.0, PAIR).item()
    assert along == pytest.approx(2 / 0.7, rel=1e-15)
    assert across / along == pytest.approx(1 + PAIR.gamma, rel=1e-15)


@given(aspects, st.integers(2, 12), st.integers(2, 12))
def test_turning_the_cells_turns_the_components(aspect, nx, ny):
    turned = {"xx": "yy", "yy": "xx", "xy": "xy", "zx": "zy", "zy": "zx"}
    for component, other in turned.items():
        upright = rc.Love().shear_coefficients(component, (nx, ny), (1.0, aspect), 1.0, PAIR)
        lying = rc.Love().shear_coefficients(other, (ny, nx), (aspect, 1.0), 1.0, PAIR)
        np.testing.assert_allclose(upright, lying.T, rtol=1e-14)


@given(st.floats(1e8, 1e12), st.floats(-0.9, 0.5), st.floats(1e8, 1e12), st.floats(-0.9, 0.5))
def test_constants_of_a_pair(young, poisson, other_young, other_poisson):
    one, other = rc.Elastic(young, poisson), rc.Elastic(other_young, other_poisson)
    pair, exchanged = pair_constants(one, other), pair_constants(other, one)
    assert exchanged.beta == pytest.approx(-pair.beta, abs=1e-14)
    assert exchanged.gamma == pytest.approx(pair.gamma, abs=1e-14)
    like = pair_constants(one, one)
    assert like.beta == 0.0
    assert like.gamma == pytest.approx(poisson / (1 - poisson), rel=1e-13, abs=1e-14)
    rigid = pair_constants(one, rc.Rigid())
    assert rigid.beta == pytest.approx((1 - 2 * poisson) / (2 - 2 * poisson), rel=1e-13, abs=1e-14)
    if min(poisson, other_poisson) >= 0.0:
        assert abs(pair.beta) <= 0.5
        assert -1e-14 <= pair.gamma <= 1.0 + 1e-14


@pytest.mark.parametrize("given", [(np.nan, 0.0), (-1.0, 0.0), (1.5, 0.0), (0.0, -1.0), (0.0, "soft")])
def test_constants_of_no_pair_are_refused(given):
    with pytest.raises(rc.InputError):
        PairConstants(*given)


class Cork(rc.Material):
    compliance = 1.0 / 20e6
    pressure_limit = 1e6


def test_a_material_without_poissons_ratio_is_refused():
    with pytest.raises(rc.InputError, match="give the class Cork an attribute `poisson`"):
        pair_constants(rc.Elastic(1e9, 0.3), Cork())


@given(grids(14), seeds)
def test_transforms_agree_with_the_direct_sum(grid, seed):
    tractions = np.random.default_rng(seed).standard_normal((3, *grid.shape))
    direct, fast = (
        convolver.prepare(KERNEL, grid, rc.Boundary.FREE).shear() for convolver in (rc.Direct(), rc.DCFFT())
    )
    expected = direct.apply(tractions, "xyz", "xyz")
    scale = np.abs(expected).max()
    np.testing.assert_allclose(fast.apply(tractions, "xyz", "xyz"), expected, rtol=0, atol=1e-13 * scale)
    np.testing.assert_allclose(fast.own, direct.own, rtol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize(("convolver", "boundary"), SERVED)
@settings(max_examples=25)
@given(grid=grids(10), seed=seeds)
def test_the_axes_can_be_exchanged(convolver, boundary, grid, seed):
    tractions = np.random.default_rng(seed).standard_normal((3, *grid.shape))
    turned = rc.Grid(grid.shape[::-1], grid.size[::-1])
    here, there = (convolver.prepare(KERNEL, one, boundary).shear() for one in (grid, turned))
    expected = here.apply(tractions, "xyz", "xyz")
    found = there.apply(np.ascontiguousarray(tractions.transpose(0, 2, 1)), "yxz", "yxz").transpose(0, 2, 1)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.slow
@settings(max_examples=25)
@given(grid=grids(16), seed=seeds, shift=st.tuples(st.integers(0, 15), st.integers(0, 15)))
def test_periodic_displacement_moves_with_the_tractions(grid, seed, shift):
    tractions = np.random.default_rng(seed).standard_normal((3, *grid.shape))
    convolution = rc.CircularFFT().prepare(KERNEL, grid, rc.Boundary.PERIODIC).shear()
    here = np.roll(convolution.apply(tractions, "xyz", "xyz"), shift, axis=(1, 2))
    there = convolution.apply(np.roll(tractions, shift, axis=(1, 2)), "xyz", "xyz")
    np.testing.assert_allclose(there, here, rtol=0, atol=1e-13 * np.abs(here).max() + 1e-300)


def test_the_other_body_as_the_first_sees_shear_the_other_way_round():
    grid = rc.Grid((12, 9), (12.0, 9.0))
    x, y, z = np.random.default_rng(2).standard_normal((3, *grid.shape))
    exchanged = BoundKernel(rc.Love(), pair=PairConstants(-PAIR.beta, PAIR.gamma))
    here, there = (rc.DCFFT().prepare(kernel, grid, rc.Boundary.FREE).shear() for kernel in (KERNEL, exchanged))
    expected = here.apply(np.stack([x, y, z]), "xyz", "xyz") * np.array([-1.0, -1.0, 1.0])[:, None, None]
    found = there.apply(np.stack([-x, -y, z]), "xyz", "xyz")
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14 * np.abs(expected).max())


@pytest.mark.parametrize(("convolver", "boundary"), SERVED)
def test_without_constants_each_axis_is_the_normal_one(convolver, boundary):
    grid = rc.Grid((9, 8), (9.0, 12.0))
    prepared = convolver.prepare(BoundKernel(rc.Love()), grid, boundary)
    convolution = prepared.shear()
    tractions = np.random.default_rng(3).standard_normal((3, *grid.shape))
    expected = np.stack([prepared.apply(one) for one in tractions])
    found = convolution.apply(tractions, "xyz", "xyz")
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())
    assert not convolution.coupled
    assert not convolution.apply(tractions[:2], "xy", "z").any()


@pytest.mark.parametrize(("convolver", "boundary"), SERVED)
def test_preconditioning_by_the_inverse_leaves_a_small_condition(convolver, boundary):
    grid = rc.Grid((11, 10), (11.0, 14.0))
    convolution = convolver.prepare(KERNEL, grid, boundary).shear()
    inverse = convolution.inverse(np.float64)
    units = np.eye(220).reshape(220, 2, 11, 10)
    matrix = np.array([inverse.apply(convolution.apply(unit)).ravel() for unit in units])
    eigenvalues = np.sort(np.linalg.eigvals(matrix).real)
    # The mean of each axis moves nothing on a periodic boundary.
    kept = eigenvalues[2:] if boundary is rc.Boundary.PERIODIC else eigenvalues
    assert kept[0] > 0.0
    assert kept[-1] / kept[0] < (1 + 1e-9 if boundary is rc.Boundary.PERIODIC else 25.0)


@pytest.mark.parametrize(("convolver", "boundary"), SERVED)
def test_a_pickled_convolution_gives_the_same_bits(convolver, boundary):
    grid = rc.Grid((9, 8), (9.0, 12.0))
    convolution = convolver.prepare(KERNEL, grid, boundary).shear()
    shear = np.random.default_rng(4).standard_normal((2, *grid.shape))
    again = pickle.loads(pickle.dumps(convolution))
    np.testing.assert_array_equal(again.apply(shear), convolution.apply(shear))
    np.testing.assert_array_equal(convolution.on(grid).apply(shear), convolution.apply(shear))


def test_more_columns_than_one_block():
    grid = rc.Grid((21, 150), (21.0, 150.0))
    tractions = np.random.default_rng(0).standard_normal((3, *grid.shape))
    direct, fast = (
        convolver.prepare(KERNEL, grid, rc.Boundary.FREE).shear() for convolver in (rc.Direct(), rc.DCFFT())
    )
    expected = direct.apply(tractions, "xyz", "xyz")
    np.testing.assert_allclose(
        fast.apply(tractions, "xyz", "xyz"), expected, rtol=0, atol=1e-13 * np.abs(expected).max()
    )


class Springs(rc.InfluenceKernel):
    def coefficients(self, shape, spacing, compliance):
        return np.eye(*shape) * compliance

    def spectrum(self, qx, qy, spacing, compliance):
        return np.full((qx.shape[0], qy.shape[1]), compliance)


class Plain(rc.Convolver):
    boundaries = frozenset({rc.Boundary.FREE})

    def prepare(self, kernel, grid, boundary):
        return rc.DCFFT().prepare(kernel, grid, boundary)


@pytest.mark.parametrize(
    ("convolver", "kernel", "boundary", "sentence"),
    [
        (rc.DCFFT(), Springs(), "free", "has no response to shear, which friction needs: use kernel='love'"),
        (rc.CircularFFT(), Springs(), "periodic", "has no response to shear"),
        (rc.Direct(), Springs(), "free", "has no response to shear"),
        (rc.CircularFFT(), rc.Love(), "wrapped", "A wrapped boundary has no response to shear"),
        (rc.Direct(), rc.Love(), "wrapped", "use boundary='free' or boundary='periodic'"),
    ],
)
def test_what_has_no_shear_says_so(convolver, kernel, boundary, sentence):
    prepared = convolver.prepare(BoundKernel(kernel), rc.Grid((4, 4), 1.0), rc.Boundary(boundary))
    with pytest.raises(rc.InputError, match=sentence):
        prepared.shear()


def test_an_unknown_component_is_refused():
    with pytest.raises(rc.InputError, match="one of 'xx', 'yy', 'xy', 'zx', 'zy'"):
        rc.Love().shear_coefficients("yx", (2, 2), (1.0, 1.0), 1.0, PAIR)
    convolution = rc.DCFFT().prepare(KERNEL, rc.Grid((4, 4), 1.0), rc.Boundary.FREE).shear()
    with pytest.raises(rc.InputError, match="one of 'x', 'y', 'z'"):
        convolution.apply(np.ones((1, 4, 4)), "a", "x")
