"""Noise of measured heights: found, told from creases and steps, and counted in answers."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._answers.areas.noise import _extrapolate, find_noise

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import edged_classes

ELASTIC = rc.Elastic(1.0, 0.0)
PERIODIC = rc.Boundary.PERIODIC


def rough(shape, size, cells=6.0, seed=1):
    """Return waves of so many cells at least."""
    shortest = cells * max(side / n for side, n in zip(size, shape, strict=True))
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=shortest, longest=min(size), seed=seed)
    return surface.heights(rc.Grid(shape, size))


def add_noise(heights, fraction, seed=7):
    return heights + fraction * heights.std() * np.random.default_rng(seed).standard_normal(heights.shape)


def solve(heights, size, boundary="periodic", lost=None, **load):
    heights = rc.HeightMap(heights, size=size, periodic=boundary == "periodic", non_measured=lost)
    return rc.ContactProblem(rc.Body(heights, ELASTIC), boundary=boundary).solve(**(load or {"pressure": 2e-3}))


@pytest.fixture(scope="module")
def noisy():
    return solve(add_noise(rough((64, 64), (1.0, 1.0)), 0.01), 1.0)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize(
    ("shape", "size"),
    [((64, 64), (1.0, 1.0)), ((128, 16), (8.0, 1.0)), ((48, 48), (1.0, 3.0)), ((63, 75), (1.0, 1.2))],
)
@pytest.mark.parametrize("fraction", [0.003, 0.01, 0.03])
def test_noise_is_found_in_any_geometry(fraction, shape, size, boundary):
    clean = rough(shape, size)
    heights = add_noise(clean, fraction)
    std, error = find_noise(heights, rc.Boundary(boundary))
    true = float((heights - clean).std())
    assert abs(std - true) < 3.0 * error
    assert error < 0.15 * true
    turned, _ = find_noise(np.ascontiguousarray(heights.T), rc.Boundary(boundary))
    assert turned == pytest.approx(std, rel=1e-9)
    assert find_noise(1e-9 * heights, rc.Boundary(boundary))[0] == pytest.approx(1e-9 * std, rel=1e-9)


@pytest.mark.parametrize("kind", [*edged_classes.EDGED, *edged_classes.SMOOTH])
def test_clean_surfaces_have_none(kind):
    for case in edged_classes.draw_cases(kind, 40, 3):
        problem = case.problem()
        assert find_noise(problem.body.surface.values, problem.boundary) == (0.0, 0.0), case.label


@pytest.mark.parametrize("cells", [2, 2.5, 3, 4, 8])
@pytest.mark.parametrize("hurst", [0.3, 0.8])
def test_short_waves_are_not_noise(hurst, cells):
    surface = rc.SelfAffineSurface(hurst=hurst, rms_slope=0.1, shortest=cells / 96, longest=0.5, seed=3)
    assert find_noise(surface.heights(rc.Grid((96, 96), 1.0)), PERIODIC) == (0.0, 0.0)


def test_flat_heights_and_rounding_are_not_noise():
    assert find_noise(np.zeros((32, 32)), PERIODIC) == (0.0, 0.0)
    x, y = np.mgrid[:64, :64]
    assert find_noise(1.0 / 3.0 * x**2 - 0.7 * x * y, rc.Boundary.FREE) == (0.0, 0.0)


def test_lost_points_do_not_count():
    heights = add_noise(rough((64, 48), (1.0, 1.0)), 0.01)
    lost = np.zeros(heights.shape, dtype=bool)
    lost[10:14, 20:30] = True
    filled = np.where(lost, 100.0 * heights.max(), heights)
    std, error = find_noise(filled, PERIODIC, lost)
    assert abs(std - 0.01 * heights.std()) < 3.0 * error
    solution = solve(heights, (1.0, 1.0), "free", lost)
    plain, found = (solution.area(uncertainty=kind) for kind in ("model", "noise"))
    assert found.uncertainty > plain.uncertainty


def test_a_response_says_how_much(noisy):
    found = noisy.response("noise")
    assert found.unit == "m"
    assert found.fraction == pytest.approx(0.01, rel=0.2)
    assert "of the rms height" in str(found)
    clean = solve(rough((64, 64), (1.0, 1.0)), 1.0)
    assert str(clean.response("noise")) == "no noise found in the heights"
    assert clean.area(uncertainty="noise") == clean.area()


@pytest.mark.parametrize("name", ["approach", "mean-gap", "peak-pressure", "perimeter"])
def test_numbers_keep_their_value_and_get_the_changes_by_as_much_more(noisy, name):
    plain, found = (noisy.response(name, uncertainty=kind) for kind in ("model", "noise"))
    assert found.value == plain.value
    assert found.uncertainty > plain.uncertainty
    again = noisy.response(name, uncertainty="noise")
    assert again.uncertainty == found.uncertainty


def test_results_repeat():
    heights = add_noise(rough((48, 40), (1.0, 1.0)), 0.01)
    first, second = (solve(heights, (1.0, 1.0)).area(uncertainty="noise") for _ in range(2))
    assert first == second


@pytest.mark.parametrize("boundary", ["free", "periodic", ("free", "periodic")])
@pytest.mark.parametrize(("shape", "size"), [((128, 16), (8.0, 1.0)), ((48, 48), (1.0, 3.0)), ((33, 45), (1.0, 1.0))])
def test_any_geometry_and_load(shape, size, boundary):
    heights = add_noise(rough(shape, size), 0.02)
    for load in ({"pressure": 2e-3}, {"approach": 0.3 * float(np.ptp(heights))}):
        solution = solve(heights, size, boundary, **load)
        plain, found = (solution.area(uncertainty=kind) for kind in ("model", "noise"))
        assert plain.uncertainty < found.uncertainty
        assert 0.0 < found.value <= solution.grid.area
        assert found.fraction == pytest.approx(found.value / solution.grid.area)


def test_the_area_without_noise_lies_within_the_uncertainty():
    """The model alone knows nothing of noise, which takes a tenth of the area."""
    missed = 0
    errors = []
    for seed in range(6):
        clean = rough((64, 64), (1.0, 1.0), seed=seed)
        area = solve(clean, 1.0).area().value
        solution = solve(add_noise(clean, 0.03, seed), 1.0)
        plain, found = (solution.area(uncertainty=kind) for kind in ("model", "noise"))
        missed += abs(plain.value - area) > 2.0 * plain.uncertainty
        assert abs(found.value - area) < 2.0 * found.uncertainty
        errors.append((abs(found.value - area), abs(plain.value - area)))
    assert missed >= 3
    found_error, plain_error = np.mean(errors, axis=0)
    assert found_error < 0.7 * plain_error


def test_areas_are_extrapolated_by_the_square_of_the_slope():
    """An area falls as one over the root of a constant and twice, once, not at all the noise."""
    twice, once, none = (1.0 / np.sqrt(1.0 + 0.2 * k) for k in (2, 1, 0))
    value, std = _extrapolate(once, twice - once, 10.0)
    assert value == pytest.approx(none)
    assert std == pytest.approx(none - once)
    assert _extrapolate(once, twice - once, 0.95)[0] == 0.95
    # Noise alone decides: nothing is known.
    assert _extrapolate(1.0, -0.3, 9.0) == (1.0, 4.0)
    assert _extrapolate(1.0, -1.0, 9.0) == (1.0, 4.0)


def test_noise_of_flat_lands_is_called_uncertain():
    grid = rc.Grid((64, 64), 1.0)
    lands = np.where(np.hypot(grid.x, grid.y) < 0.3, 0.0, -0.1)
    solution = solve(add_noise(lands, 0.01), 1.0)
    found = solution.area(uncertainty="noise")
    assert abs(found.value - np.pi * 0.09) < 2.0 * found.uncertainty
    assert any("in the heights changes this by about" in text for text in found.warnings)


def test_small_grids_and_laws_are_refused_in_a_sentence():
    line = rc.ContactProblem(rc.Body(rc.ParaboloidSurface((1.0, np.inf)), ELASTIC), grid=rc.Grid((64, 1), (0.2, 1.0)),
                             boundary=("free", "periodic")).solve(force=1e-3)  # fmt: skip
    with pytest.raises(rc.InputError, match="64 x 1 cells"):
        line.response("noise")
    law = rc.Exponential(0.05, 1e-8)
    heights = rc.HeightMap(1e-8 * np.random.default_rng(0).normal(size=(32, 32)), size=1e-6)
    sticky = rc.ContactProblem(rc.Body(heights, rc.Elastic(210e9, 0.3)), adhesion=law).solve(force=1e-6)
    with pytest.raises(rc.InputError, match="attract each other"):
        sticky.area(uncertainty="noise")
