"""Field parameters of surface texture against closed forms."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import ellipe
from scipy.stats import norm

import roughcontact as rc
from scenes import each_once

SIZE = (64e-6, 48e-6)


def values(found):
    return {name: getattr(found, name).value for name in rc.reference.Texture.__annotations__}


@pytest.fixture(scope="module")
def wave():
    """One cosine along x of amplitude 2 µm, 8 waves, finely sampled, whose every parameter is known."""
    grid = rc.Grid((4097, 4), SIZE)
    return values(rc.reference.texture(rc.WavySurface((2e-6, 0.0), 8e-6).heights(grid), grid))


def integrate_cosine(low, high):
    """Integral of the material ratio curve cos(pi p)."""
    return (np.sin(np.pi * high) - np.sin(np.pi * low)) / np.pi


class TestWave:
    """Lengths in units of the amplitude."""

    def test_heights(self, wave):
        exact = {"Sq": 1 / np.sqrt(2), "Sa": 2 / np.pi, "Sp": 1.0, "Sv": 1.0, "Sz": 2.0}
        for name, value in exact.items():
            assert wave[name] / 2e-6 == pytest.approx(value, rel=2e-5), name
        assert wave["Ssk"] == pytest.approx(0.0, abs=1e-12)
        assert wave["Sku"] == pytest.approx(1.5, rel=1e-12)

    def test_slopes(self, wave):
        steep = 2 * np.pi * 2e-6 / 8e-6
        assert wave["Sdq"] == pytest.approx(steep / np.sqrt(2), rel=1e-12)
        exact = 2 / np.pi * np.sqrt(1 + steep**2) * ellipe(steep**2 / (1 + steep**2)) - 1
        assert wave["Sdr"] == pytest.approx(exact, rel=1e-12)

    def test_volumes(self, wave):
        peaks, valleys = np.cos(0.1 * np.pi), np.cos(0.8 * np.pi)
        exact = {
            "Vmp": integrate_cosine(0, 0.1) - 0.1 * peaks,
            "Vmc": integrate_cosine(0, 0.8) - 0.8 * valleys - integrate_cosine(0, 0.1) + 0.1 * peaks,
            "Vvv": 0.2 * valleys - integrate_cosine(0.8, 1),
            "Vvc": 0.9 * peaks - integrate_cosine(0.1, 1) - 0.2 * valleys + integrate_cosine(0.8, 1),
            "Sxp": np.cos(0.025 * np.pi),
        }
        for name, value in exact.items():
            assert wave[name] / 2e-6 == pytest.approx(value, abs=5e-4), name

    def test_direction(self, wave):
        assert wave["Sal"] == pytest.approx(8e-6 * np.arccos(0.2) / (2 * np.pi), rel=1e-4)
        assert wave["Std"] == 90.0


@pytest.mark.slow
@each_once(
    {
        "shape": [(64, 48), (48, 64), (45, 75), (256, 32), (32, 256), (97, 61)],
        "size": [SIZE, (8e-3, 1e-3), (1e-6, 3e-6)],
        "phase": [0.0, 0.3],
    }
)
def test_sums_of_cosines_have_exact_moments(shape, size, phase):
    """Of a cos u + b cos 2u + c cos v: the means of products of waves below half of the shortest are exact on cells.

    Such surfaces are those of Todhunter et al., Surf. Topogr. 8 (2020) 015010, https://doi.org/10.1088/2051-672X/ab7367.
    """
    grid = rc.Grid(shape, size)
    a, b, c = 1e-6, 0.6e-6, 0.3e-6
    q, k = (2 * np.pi * waves / side for waves, side in zip((3, 5), size, strict=True))
    u = q * grid.x + phase
    heights = a * np.cos(u) + b * np.cos(2 * u) + c * np.cos(k * grid.y)
    square = (a**2 + b**2 + c**2) / 2
    fourth = 3 * (a**4 + b**4 + c**4) / 8 + 3 * a**2 * b**2 / 2 + 3 * (a**2 + b**2) * c**2 / 2
    exact = {
        "Sq": np.sqrt(square),
        "Ssk": 0.75 * a**2 * b / square**1.5,
        "Sku": fourth / square**2,
        "Sdq": np.sqrt(((a * q) ** 2 + (2 * b * q) ** 2 + (c * k) ** 2) / 2),
    }
    found = rc.reference.texture(heights, grid)
    for name, value in exact.items():
        assert getattr(found, name).value == pytest.approx(value, rel=1e-9), name


@functools.cache
def sample_wave(cells):
    grid = rc.Grid((cells, 4), SIZE)
    return rc.reference.texture(rc.WavySurface((2e-6, 0.0), SIZE[0] / 4).heights(grid), grid)


@pytest.mark.parametrize(
    ("name", "exact", "order"),
    [
        ("Sa", 2 / np.pi, 2),
        ("Sv", 1.0, 2),
        ("Sz", 2.0, 2),
        ("Vmp", integrate_cosine(0, 0.1) - 0.1 * np.cos(0.1 * np.pi), 1),
        ("Vvv", 0.2 * np.cos(0.8 * np.pi) - integrate_cosine(0.8, 1), 1),
        ("Sxp", np.cos(0.025 * np.pi), 1),
    ],
)
def test_numbers_of_sampled_heights_converge(name, exact, order):
    """Means of other functions have an error of second order in the cell, or of first where heights are counted."""
    errors = []
    for cells in (257, 4097):
        errors.append(abs(getattr(sample_wave(cells), name).value / 2e-6 - exact))
    assert errors[1] < 2.0 * errors[0] / 16.0**order
    assert order == 1 or errors[1] < 1e-6


def test_a_lay_at_an_angle_is_found():
    """Its decay is cos(q x cos(angle)) in every direction: the lay stands across the wave vector."""
    grid = rc.Grid((128, 96), SIZE)
    q = 2 * np.pi * np.array([3 / SIZE[0], 4 / SIZE[1]])
    found = rc.reference.texture(1e-6 * np.cos(q[0] * grid.x + q[1] * grid.y), grid)
    across = np.degrees(np.arctan2(q[1], q[0]))
    assert found.Std.value == pytest.approx(across + 90, abs=1e-9)
    assert found.Sal.value == pytest.approx(np.arccos(0.2) / np.hypot(*q), rel=2e-4)
    assert "bound from above" in found.Str.warnings[0]


@pytest.mark.slow
def test_isotropic_roughness_has_no_lay():
    grid = rc.Grid((256, 256), 64e-6)
    surface = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, shortest=1e-6, longest=8e-6, seed=2)
    found = rc.reference.texture(surface.heights(grid), grid)
    assert found.Str.value > 0.8
    assert not found.Str.warnings
    assert found.Sq.value == pytest.approx(1e-7, rel=1e-9)


@pytest.mark.slow
def test_the_core_of_gaussian_heights():
    """The line of least squares through the quantiles of 30 to 70 %, and triangles of the areas beyond it."""
    count = 400
    heights = norm.isf((np.arange(count**2) + 0.5) / count**2)
    heights = np.random.default_rng(1).permutation(heights).reshape(count, count)
    found = values(rc.reference.texture(1e-7 * heights, rc.Grid((count, count), 1e-3)))
    moment = quad(lambda p: (p - 0.5) * norm.isf(p), 0.3, 0.7)[0]
    upper = -0.5 * moment / (2 * 0.2**3 / 3)
    ratio = norm.sf(upper)
    reduced = 2 * (norm.pdf(upper) - upper * ratio) / ratio
    exact = {"Sk": 2 * upper, "Spk": reduced, "Svk": reduced}
    for name, value in exact.items():
        assert found[name] / 1e-7 == pytest.approx(value, rel=1e-3), name
    assert found["Smr1"] == pytest.approx(ratio, rel=1e-3)
    assert found["Smr2"] == pytest.approx(1 - ratio, rel=1e-3)


def test_a_ramp_is_all_core():
    """Heights of equal frequency: Sq = range / sqrt(12), and neither peaks nor valleys beyond the core."""
    grid = rc.Grid((500, 20), SIZE)
    found = values(
        rc.reference.texture(np.broadcast_to(np.linspace(-1e-6, 1e-6, 500)[:, None], (500, 20)), grid, periodic=False)
    )
    assert found["Sk"] == pytest.approx(2e-6, rel=1e-2)
    assert found["Spk"] == pytest.approx(0.0, abs=2e-9)
    assert found["Sq"] == pytest.approx(2e-6 / np.sqrt(12), rel=3e-3)
    assert found["Sku"] == pytest.approx(1.8, rel=1e-3)
    assert found["Sdq"] == pytest.approx(2e-6 / 499 * 500 / SIZE[0], rel=1e-9)


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32), st.floats(0.1, 10.0), st.booleans())
def test_units_and_rearrangements(seed, scale, periodic):
    """Heights and lengths in another unit, x and y exchanged, and the surface turned over."""
    grid = rc.Grid((24, 18), SIZE)
    heights = np.random.default_rng(seed).standard_normal(grid.shape) * 1e-7
    found = rc.reference.texture(heights, grid, periodic=periodic)
    one = values(found)
    wider = rc.Grid(grid.shape, (SIZE[0] * scale, SIZE[1] * scale))
    scaled = values(rc.reference.texture(scale * heights, wider, periodic=periodic))
    for name in one:
        length = scale if getattr(found, name).unit == "m" else 1.0
        assert scaled[name] == pytest.approx(length * one[name], rel=1e-6, abs=1e-15), name
    turned = values(rc.reference.texture(heights.T, rc.Grid((18, 24), SIZE[::-1]), periodic=periodic))
    below = values(rc.reference.texture(-heights, grid, periodic=periodic))
    for name in set(one) - {"Std", "Str", "Sal"}:
        assert turned[name] == pytest.approx(one[name], rel=1e-9), name
    for name, other in {"Sp": "Sv", "Spk": "Svk", "Sq": "Sq", "Sk": "Sk", "Sdr": "Sdr"}.items():
        assert below[name] == pytest.approx(one[other], rel=1e-6), name
    assert one["Vmp"] + one["Vmc"] <= one["Sz"]


@pytest.mark.slow
def test_sampling_errors_cover_other_places():
    """Of 12 surfaces of one spectrum, the parameters lie within two deviations of their means in most cases."""
    grid = rc.Grid((256, 256), 256e-6)
    found = [
        rc.reference.texture(
            rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=32e-6, seed=seed).heights(grid), grid
        )
        for seed in range(12)
    ]
    for name in ("Sa", "Sku", "Spk", "Svk", "Vmp", "Sxp", "Sal", "Str"):
        estimates = [getattr(one, name) for one in found]
        mean = np.mean([one.value for one in estimates])
        inside = [abs(one.value - mean) <= 2 * one.uncertainty for one in estimates]
        assert np.mean(inside) >= 0.75, name


@pytest.mark.parametrize(
    ("heights", "grid", "words"),
    [
        (np.ones((8, 8)), rc.Grid((8, 8), 1e-6), "All heights are equal"),
        (np.eye(8), rc.Grid((9, 8), 1e-6), "of the shape of the grid"),
        (np.eye(8), 3, "must be a Grid"),
        (np.arange(8.0)[:, None], rc.Grid((8, 1), 1e-6), "at least two cells along each axis"),
        (np.full((8, 8), np.nan), rc.Grid((8, 8), 1e-6), "finite"),
    ],
)
def test_what_has_no_texture_is_refused(heights, grid, words):
    with pytest.raises(rc.InputError, match=words):
        rc.reference.texture(heights, grid)


@pytest.mark.parametrize("shape", [(2, 2), (3, 5), (6, 2)])
def test_small_maps_have_a_texture(shape):
    """Their parts, by which numbers are uncertain, are single cells."""
    found = rc.reference.texture(np.random.default_rng(0).random(shape) * 1e-6, rc.Grid(shape, 1e-3))
    assert found.Sq.value > 0.0
    assert np.isfinite(found.Sk.uncertainty)
