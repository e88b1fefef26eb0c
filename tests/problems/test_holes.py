"""Numbers of contacts with non-measured points: outside the contact as without them, inside it within the error."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import ndimage

import roughcontact as rc
from scenes import each_once, rather_slow

ELASTIC = rc.Elastic(1.0, 0.0)
# Cells and their sides: square, long, turned, long cells, odd and prime.
DOMAINS = [((64, 64), (1.0, 1.0)), ((17, 137), (1.0, 1.0)), ((137, 17), (1.0, 1.0)), ((47, 63), (3.0, 1.0))]
FRACTIONS = (0.01, 0.03, 0.1)


def press(heights, cell, boundary, load, mask=None):
    size = (heights.shape[0] * cell[0], heights.shape[1] * cell[1])
    values = heights if mask is None else np.where(mask, np.nan, heights)
    surface = rc.HeightMap(values, size=size, periodic=boundary == "periodic")
    return rc.ContactProblem(rc.Body(surface, ELASTIC), boundary=boundary).solve(**load)


def make_ball(shape, cell):
    grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
    radius = 0.2 * min(grid.size)
    summit = rc.ParaboloidSurface(1e4 * radius, center=(0.31 * cell[0], -0.2 * cell[1]))
    return np.array(summit.heights(grid)), "free", {"force": 4 * radius**2 / 3e4}


def make_rough(shape, cell):
    grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.05, shortest=6.0 * max(cell), longest=float(min(grid.size)), seed=5
    )
    return np.array(surface.heights(grid)), "free", {"pressure": 1.5e-3}


def make_wave(shape, cell):
    x, y = (2 * np.pi * (np.arange(n) + 0.3) / n for n in shape)
    size = min(shape[0] * cell[0], shape[1] * cell[1])
    return 1e-3 * size * (np.cos(x)[:, None] + np.cos(y)), "periodic", {"pressure": 3e-4}


def lose_points(contact, fraction, grouped, seed):
    """Return a mask of about that fraction of the points, none of them in contact."""
    random = np.random.default_rng(seed).random(contact.shape)
    mask = ndimage.maximum_filter(random < fraction / 16, 4, mode="constant") if grouped else random < fraction
    return mask & ~contact


@each_once({"grouped": [False, True], "make": [make_ball, make_rough, make_wave]})
@pytest.mark.parametrize("domain", rather_slow(DOMAINS, DOMAINS[1::2]))
def test_points_that_are_missing_outside_the_contact_change_no_number(domain, make, grouped):
    shape, cell = domain
    heights, boundary, load = make(shape, cell)
    whole = press(heights, cell, boundary, load)
    area, gap = whole.area(), whole.response("mean-gap")
    for number, fraction in enumerate(FRACTIONS):
        mask = lose_points(whole.contact, fraction, grouped, number)
        holed = press(heights, cell, boundary, load, mask)
        # Groups beside the contact hide its edge.
        assert holed.area().value == pytest.approx(area.value, rel=1e-2 if grouped else 3e-3)
        assert holed.area().uncertainty == pytest.approx(area.uncertainty, rel=0.1, abs=2e-4 * area.value)
        assert holed.response("perimeter").value == pytest.approx(whole.response("perimeter").value, rel=0.03)
        found = holed.response("mean-gap")
        assert found.value == pytest.approx(gap.value, rel=1e-2 if grouped else 4e-3)
        assert abs(found.value - gap.value) <= 2.0 * found.uncertainty
        found, true = holed.response("approach"), whole.response("approach")
        assert abs(found.value - true.value) <= 2.0 * found.uncertainty


@pytest.mark.parametrize("grouped", rather_slow([False, True], [True]), ids=["single", "grouped"])
def test_areas_with_points_missing_inside_the_contact_are_within_two(grouped):
    ratios = []
    for seed in range(8):
        cells, boundary = 41 + 3 * seed, ("free", "periodic")[seed % 2]
        surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=7.0, longest=float(cells), seed=40 + seed)
        mask = np.random.default_rng(seed).random((cells, cells)) < (0.1 / 16 if grouped else 0.1)
        mask = ndimage.maximum_filter(mask, 4, mode="constant") if grouped else mask
        found = []
        # The holes are those cells, on both grids.
        for finer in (1, 3):
            heights = np.array(surface.heights(rc.Grid((finer * cells, finer * cells), float(cells))))
            fine = np.kron(mask, np.ones((finer, finer), dtype=bool))
            found.append(press(heights, (1.0 / finer, 1.0 / finer), boundary, {"pressure": 2e-3}, fine).area())
        ratios.append(abs(found[0].value - found[1].value) / found[0].uncertainty)
    assert sum(ratio <= 2.0 for ratio in ratios) >= 7, ratios


def test_peak_beside_a_hole_in_the_contact_is_unbounded():
    heights, boundary, load = make_ball((65, 65), (1.0, 1.0))
    mask = np.zeros(heights.shape, dtype=bool)
    mask[30:33, 33:36] = True
    peak = press(heights, (1.0, 1.0), boundary, load, mask).peak_pressure()
    assert peak.uncertainty == peak.value
    assert any("were not measured" in warning for warning in peak.warnings)


@pytest.mark.parametrize("shape", [(23, 61), (61, 23)])
def test_mean_gap_of_a_ball_on_a_free_domain(shape):
    # Against nine cells in the place of one along each axis.
    means = []
    for finer in (1, 9):
        grid = rc.Grid((finer * shape[0], finer * shape[1]), shape)
        heights = np.array(rc.ParaboloidSurface(4e4, center=(0.3, 0.1)).heights(grid))
        solution = press(heights, (1.0 / finer, 1.0 / finer), "free", {"force": 4 * 4.0**2 / 3e4})
        means.append(solution.response("mean-gap"))
    assert abs(means[0].value - means[1].value) <= 2.0 * means[0].uncertainty
    assert means[0].uncertainty < 1e-3 * means[0].value


def test_a_hole_that_covers_a_corner_and_whole_rows_is_filled():
    heights, boundary, load = make_ball((33, 40), (1.0, 2.0))
    mask = np.zeros(heights.shape, dtype=bool)
    mask[:3] = True
    mask[27:, 34:] = True
    whole, holed = press(heights, (1.0, 2.0), boundary, load), press(heights, (1.0, 2.0), boundary, load, mask)
    assert holed.area().value == pytest.approx(whole.area().value, rel=1e-4)
    found, true = holed.response("mean-gap"), whole.response("mean-gap")
    # The bulk of the corner is filled by the harmonic surface.
    assert found.value == pytest.approx(true.value, rel=0.05)
    assert math.isfinite(found.uncertainty)


@pytest.mark.parametrize("make", [make_ball, make_rough, make_wave])
def test_holes_of_any_size_are_filled_alike(make, monkeypatch):
    # Bands of the matrix are as wide as the largest hole; wide ones are factored with another order.
    heights, boundary, load = make((61, 40), (1.0, 3.0))
    mask = lose_points(press(heights, (1.0, 3.0), boundary, load).contact, 0.1, True, 5)
    found = []
    for widest in (40, 0):
        monkeypatch.setattr("roughcontact._solve.solution.healing.MAX_BANDWIDTH", widest)
        monkeypatch.setattr("roughcontact._parts.surfaces.filling.MAX_BANDWIDTH", widest)
        solution = press(heights, (1.0, 3.0), boundary, load, mask)
        found.append([solution.response(name).value for name in ("mean-gap", "approach", "perimeter")])
    assert found[1] == pytest.approx(found[0], rel=1e-9)


@pytest.mark.parametrize("shape", [(1, 40), (2, 20), (3, 3), (5, 1)])
def test_narrow_grids_with_missing_points(shape):
    heights = (
        -((np.arange(shape[0])[:, None] - 0.4 * shape[0]) ** 2 + (np.arange(shape[1]) - 0.4 * shape[1]) ** 2) / 1e4
    )
    mask = np.zeros(shape, dtype=bool)
    mask.flat[[0, -1]] = True
    solution = press(heights, (1.0, 1.0), "free", {"force": 1e-3}, mask)
    assert solution.area().value > 0.0
    assert math.isfinite(solution.response("mean-gap").value)
