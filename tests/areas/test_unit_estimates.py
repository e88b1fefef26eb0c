"""Estimates of contacts whose fields are closed forms: maximum pressure, length, gaps, areas."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import special

import roughcontact as rc
from exact_contacts import MODULUS, ball, with_fields
from roughcontact import reference
from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.approach import find_shift
from roughcontact._answers.areas.edges import _count_hidden_gaps
from roughcontact._answers.areas.hertz import _plastic_growth
from roughcontact._answers.areas.peak import _find_sharpness, _fit_quadratics
from roughcontact._answers.areas.quantities import _elliptic_quotient
from roughcontact._answers.areas.summits import find_axes_ratio
from scenes import each_once

CELLS = [(1.0, 1.0), (1.0, 2.5), (3.0, 1.0)]


def test_a_pressure_limit_widens_contacts_to_the_load_over_it():
    grid = rc.Grid((8, 8), 8.0)
    pressure = np.zeros(grid.shape)
    pressure[1, 1] = pressure[5, 5:7] = 1.0
    limit = np.full(grid.shape, 2.0)
    limit[5, 5:7] = 1.0, 3.0
    area = np.array([1.0, 4.0])
    for overload, growth in ((0.5, 1.0), (1.0, 1.0), (3.0, 2.0), (6.0, 4.0), (12.0, 8.0)):
        force = overload * area * 2.0 / 1.5
        found = _plastic_growth(with_fields(grid, pressure, 1.0, limit=limit), force, area)
        np.testing.assert_allclose(found, growth)
        # Fully plastic, the contact carries the limit all over.
        if overload >= 3.0:
            np.testing.assert_allclose(found * area * 2.0, force)
    assert _plastic_growth(with_fields(grid, pressure, 1.0), area, area).tolist() == [1.0, 1.0]


@pytest.mark.parametrize("cell", CELLS)
def test_the_maximum_of_hertzs_pressure_between_the_cells(cell):
    """p^2 is a paraboloid: the quadratic through it has the maximum exactly, wherever it lies in its cell."""
    rng = np.random.default_rng(5)
    for _ in range(5):
        grid = rc.Grid((40, 35), (40 * cell[0] * 1e-6, 35 * cell[1] * 1e-6))
        a, centre = 9.0 * max(cell) * 1e-6, rng.uniform(-0.5, 0.5, 2) * grid.spacing
        a = min(a, 0.4 * min(grid.size))
        solution = ball(grid, a, 1e-3, centre)
        peak = 2.0 * MODULUS * a / (np.pi * 1e-3)
        highest = np.array([int(np.argmax(solution.pressure))])
        assert _find_sharpness(solution, highest)[0] == pytest.approx(0.0, abs=1e-3)
        value, error = _fit_quadratics(solution, highest, np.zeros(1))
        assert value[0] == pytest.approx(peak, rel=1e-9)
        bend = 2.0 * max(grid.spacing) ** 2 / a**2 * (peak / solution.pressure.max()) ** 2
        first, _, cubic = calibration.PEAK_ERROR
        assert error[0] == pytest.approx(bend * (first + cubic * bend**3), rel=1e-6)
        assert solution.peak_pressure().value == pytest.approx(peak, rel=2e-3)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_strip_has_the_maximum_of_its_parabola_across_it_and_a_wider_error(axis):
    shape = (30, 24) if axis == 0 else (24, 30)
    grid = rc.Grid(shape, (30.0, 30.0))
    across = (grid.x, grid.y)[axis] - 0.27
    square = np.broadcast_to(np.maximum(1.0 - (across / 8.0) ** 2, 0.0), shape)
    solution = with_fields(grid, np.sqrt(square), square == 0.0, boundary="periodic")
    highest = np.array([int(np.argmax(solution.pressure))])
    value, error = _fit_quadratics(solution, highest, np.zeros(1))
    assert value[0] == pytest.approx(1.0, rel=1e-9)
    assert solution.pressure.max() < 1.0 - 1e-5
    bend = 2.0 * (grid.spacing[axis] / 8.0) ** 2 / square.max()
    first, _, cubic = calibration.PEAK_ERROR
    along = bend * (calibration.STRIP_PEAK_FACTOR * first + cubic * bend**3)
    edges = calibration.STRAIGHT_PEAK_STD * bend**0.75
    assert error[0] == pytest.approx(np.hypot(along, edges), rel=1e-6)


@pytest.mark.parametrize("ratio", [1.0, 0.6, 0.1])
def test_the_isoperimetric_quotient_of_ellipses(ratio):
    mean = np.array([1.0])
    difference = mean * (1.0 - ratio) / (1.0 + ratio)
    axes = float(find_axes_ratio(ratio))
    length = 4.0 * axes * special.ellipe(1.0 - 1.0 / axes**2)
    expected = length**2 / (4.0 * np.pi * np.pi * axes)
    assert _elliptic_quotient(mean, difference)[0] == pytest.approx(expected, rel=5e-4)
    # Saddles have that of a circle.
    assert _elliptic_quotient(mean, 1.2 * mean)[0] == pytest.approx(1.0)


def test_the_shift_of_the_mean_gap_is_that_of_the_curvature():
    """h^2 / 36 R for Love's edges, 0.018 cells inside: for a ball of many cells, on any cells."""
    assert find_shift(with_fields(rc.Grid((4, 4), 1.0), 0.0, 1.0)) == (0.0, 0.0)
    for sides in ((1.0, 1.0), (1.0, 2.0)):
        grid = rc.Grid((60, 44), (60 * sides[0], 44 * sides[1]))
        found = find_shift(ball(grid, 18.0, 500.0, edge_shift=0.018))[0]
        assert found * 500.0 / np.mean(np.square(sides)) == pytest.approx(1.0 / 36.0, rel=0.15)
        assert find_shift(ball(grid, 18.0, 500.0))[0] == 0.0


def test_gaps_between_the_cells_of_full_contact():
    """Where the steepest fall to a neighbour is more than twice the pressure it vanishes before half-way beyond."""
    pressure = np.full((7, 8), 10.0)
    pressure[3, 4], pressure[0, 2] = 3.0, 4.9
    grid = rc.Grid((7, 8), 1.0)
    for boundary in ("free", "periodic"):
        assert _count_hidden_gaps(with_fields(grid, pressure, 0.0, boundary=boundary)) == 1.0
    pressure[0, 2] = 3.0
    pressure[2:5, 4] = pressure[3, 3:6] = 3.0
    pressure[0, 1] = pressure[0, 3] = pressure[1, 2] = 3.0
    assert _count_hidden_gaps(with_fields(grid, pressure, 0.0)) == 0.0 + 4.0 + 3.0
    assert _count_hidden_gaps(with_fields(grid, pressure, 0.0, boundary="periodic")) == 1.0 + 4.0 + 3.0


def test_the_area_by_hertz_is_that_of_the_reference():
    grid = rc.Grid((48, 40), (48e-6, 60e-6))
    for a in (6e-6, 11e-6):
        solution = ball(grid, a, 2e-3, (1.2e-6, -0.4e-6))
        exact = reference.hertz_sphere(solution.force, 2e-3, MODULUS)
        assert solution.area("hertz").value == pytest.approx(exact.area, rel=3e-3)


@each_once(
    {
        "cell": CELLS,
        "cells": [0.8, 1.6, 3.2, 7.0],
    }
)
def test_small_contacts_have_the_area_of_their_load(cell, cells):
    """Hertz's area by load and curvature, however few the cells; the blend is it, or the traced one if that is sure."""
    rng, a = np.random.default_rng(7), cells * max(cell) * 1e-6
    for _ in range(4):
        shape = tuple(int(2.8 * cells * max(cell) / side) + 13 + rng.integers(2) for side in cell)
        grid = rc.Grid(shape, (shape[0] * cell[0] * 1e-6, shape[1] * cell[1] * 1e-6))
        # At a cell, or the smallest would have none.
        centre = (grid.x[shape[0] // 2, 0] + 0.2e-6 * cell[0], grid.y[0, shape[1] // 2] - 0.1e-6 * cell[1])
        solution = ball(grid, a, 1e-3, centre)
        exact = reference.hertz_sphere(solution.force, 1e-3, MODULUS).area
        assert solution.area("hertz").value == pytest.approx(exact, rel=2e-3)
        blend, traced = solution.area(), solution.area("level-set-richardson")
        low, high = sorted((exact, traced.value))
        assert low * 0.99 <= blend.value <= high * 1.01
        if cells < 1.0:
            assert blend.value == pytest.approx(exact, rel=0.01)
        assert abs(blend.value - exact) <= 3.0 * blend.uncertainty + 0.02 * exact


@pytest.mark.parametrize("cell", CELLS)
def test_length_approach_and_mean_gap_of_an_exact_ball(cell):
    """Counted from the highest cell, the approach lacks the height of the summit above it."""
    grid = rc.Grid((44, 40), (44e-6 * cell[0], 40e-6 * cell[1]))
    a, radius, centre = 12e-6, 1e-3, (0.37e-6, -0.21e-6)
    exact = ball(grid, a, radius, centre)
    lowest = exact.initial_gap.min()
    options = {"initial_gap": exact.initial_gap - lowest, "approach": exact.approach - lowest}
    solution = with_fields(grid, exact.pressure, exact.gap, **options)
    assert solution.response("perimeter").value == pytest.approx(2.0 * np.pi * a, rel=3e-3)
    approach = solution.response("approach")
    assert approach.value == pytest.approx(a**2 / radius, rel=1e-6)
    assert approach.uncertainty < 0.01 * approach.value
    gap = solution.response("mean-gap")
    shifted = with_fields(grid, exact.pressure, exact.gap, edge_shift=0.018, **options)
    shift, std = find_shift(shifted)
    found, fraction = shifted.response("mean-gap"), shifted.area().fraction
    assert gap.value - found.value == pytest.approx(shift * (1.0 - fraction), rel=1e-6)
    assert found.uncertainty >= std * (1.0 - fraction) * (1.0 - 1e-9)
    periodic = with_fields(grid, exact.pressure, exact.gap, boundary="periodic", **options)
    assert periodic.response("mean-gap").value == pytest.approx(exact.gap.mean(), rel=1e-9)
    assert shifted.response("approach").value == pytest.approx(a**2 / radius + shift, rel=1e-6)
    count = solution.response("patches")
    assert count.value == 1.0
    assert count.uncertainty < 0.2


def test_saturated_cells_have_no_gap_in_the_mean():
    grid = rc.Grid((10, 12), 1.0)
    pressure, gap = np.zeros(grid.shape), np.full(grid.shape, 3e-6)
    pressure[2:6, 2:6], gap[2:6, 2:6] = 2.0, -1e-6
    found = with_fields(grid, pressure, gap, limit=2.0, boundary="periodic").response("mean-gap")
    assert found.value == pytest.approx(3e-6 * 104 / 120)


def test_the_perimeter_corrects_the_sides_of_elastic_cells():
    """By (pi - 1 + ln 2) / 24 cells for each side; those of saturated cells are sharp, and the load must be carried."""
    overshoot = (math.pi - 1.0 + math.log(2.0)) / 24.0
    grid = rc.Grid((12, 14), (12.0, 28.0))
    pressure = np.zeros(grid.shape)
    pressure[2:6, 3:8] = 1.0
    pressure[9, 3:6] = 1.5
    found = with_fields(grid, pressure, pressure == 0.0).area("perimeter")
    assert found.value == pytest.approx(2.0 * (23.0 - overshoot * (18.0 + 8.0)))
    rows = [4, 4, 5, 5, 1, 1, 3, 3]
    spread = math.sqrt(sum(n * n for n in rows) / 12.0)
    assert found.uncertainty == pytest.approx(2.0 * (0.5 * overshoot * 26.0 + spread))
    counted = with_fields(grid, pressure, pressure == 0.0).area("cell-count")
    assert (counted.value, counted.uncertainty) == (46.0, pytest.approx(2.0 * overshoot * 26.0))
    limited = with_fields(grid, pressure, pressure == 0.0, limit=1.5)
    assert limited.area("perimeter").value == pytest.approx(2.0 * (23.0 - overshoot * 18.0))
    full = with_fields(grid, np.where(pressure > 0.0, 1.499, 0.0), pressure == 0.0, limit=1.5)
    assert full.area("perimeter").value == pytest.approx(2.0 * 23.0 * 1.499 / 1.5)


@pytest.mark.parametrize("cell", CELLS)
def test_the_mean_gap_of_a_free_domain_is_the_integral_over_it(cell):
    """Of a paraboloid, whose mean over the centres of the cells lacks a part of a cell's."""
    grid = rc.Grid((16, 13), (16.0 * cell[0], 13.0 * cell[1]))
    gap = 1e-3 + 2e-3 * grid.x**2 + 1e-3 * grid.y**2
    exact = 1e-3 + (2e-3 * grid.size[0] ** 2 + 1e-3 * grid.size[1] ** 2) / 12.0
    assert with_fields(grid, 0.0, gap).response("mean-gap").value == pytest.approx(exact, rel=1e-9)
    assert with_fields(grid, 0.0, gap, boundary="periodic").response("mean-gap").value == pytest.approx(gap.mean())
