"""Estimates of contacts whose fields are closed forms: maximum pressure, length, gaps, areas."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import special

import roughcontact as rc
from exact_contacts import MODULUS, ball, with_fields
from roughcontact import reference
from roughcontact._areas.ellipse import find_axes_ratio
from roughcontact._areas.hertz import _plastic_growth
from roughcontact._areas.peak import _fit_quadratics
from roughcontact._areas.quantities import _elliptic_quotient, find_shift
from roughcontact._areas.total import _count_hidden_gaps

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
        value, error, inner = _fit_quadratics(solution, highest)
        assert value[0] == pytest.approx(peak, rel=1e-9)
        assert inner.tolist() == [True]
        bend = 2.0 * (grid.spacing[0] ** 2 + grid.spacing[1] ** 2) / a**2 * (peak / solution.pressure.max()) ** 2
        assert error[0] == pytest.approx(0.006 * bend + 0.005 * bend**2 + 0.0012 * bend**4, rel=1e-6)
        assert solution.peak_pressure().value == pytest.approx(peak, rel=2e-3)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_strip_has_the_maximum_of_its_parabola_and_a_wider_error(axis):
    shape = (30, 24) if axis == 0 else (24, 30)
    grid = rc.Grid(shape, (30.0, 30.0))
    across = (grid.x, grid.y)[axis] - 0.27
    square = np.broadcast_to(np.maximum(1.0 - (across / 8.0) ** 2, 0.0), shape)
    solution = with_fields(grid, np.sqrt(square), square == 0.0, boundary="periodic")
    highest = np.array([int(np.argmax(solution.pressure))])
    value, error, inner = _fit_quadratics(solution, highest)
    # Along the strip nothing curves, and no maximum is fitted: the highest cell has it.
    assert value[0] == pytest.approx(solution.pressure.max())
    assert inner.tolist() == [True]
    bend = 2.0 * (grid.spacing[axis] / 8.0) ** 2 / square.max()
    assert error[0] == pytest.approx(4.0 * (0.006 * bend + 0.005 * bend**2 + 0.0012 * bend**4), rel=1e-6)


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
        assert found * 500.0 / grid.cell_area == pytest.approx(1.0 / 36.0, rel=0.15)
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
