"""The parts that the area estimators share: the spline, neighbours of cells, dual cells and far fields."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

import roughcontact as rc
from roughcontact._answers.areas.cells import Neighbourhood, split
from roughcontact._answers.areas.dual_cells import find_dual_cells
from roughcontact._answers.areas.initial_gap import Spline
from roughcontact._answers.areas.summits import find_far_field

BOUNDARIES = (rc.Boundary.PERIODIC, rc.Boundary.FREE)


def press(cells, count, boundary="periodic"):
    """Return a contact at about so many places of a random surface."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4.0, longest=32.0, rolloff=16.0, seed=count)
    body = rc.Body(surface, rc.Elastic(1.0, 0.0))
    problem = rc.ContactProblem(body, grid=rc.Grid(cells, tuple(map(float, cells))), boundary=boundary)
    return problem.solve(pressure=2e-5 * count)


def test_the_periodic_spline_is_that_of_scipy():
    rng = np.random.default_rng(0)
    values = rng.normal(size=(13, 20))
    i, j = rng.uniform(-15.0, 30.0, size=(2, 3000))
    found = Spline.through(values, (1.0, 1.0), rc.Boundary.PERIODIC).derivatives(i, j, 0)[0]
    expected = ndimage.map_coordinates(values, (i, j), order=5, mode="grid-wrap")
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_a_spline_has_the_derivatives_of_its_values(boundary):
    rng = np.random.default_rng(1)
    spline = Spline.through(rng.normal(size=(15, 12)), (0.5, 2.0), boundary)
    i, j = rng.uniform(1.0, 10.0, size=(2, 40))
    step = 1e-4

    def value(a, b):
        return spline.derivatives(i + a * step, j + b * step, 0)[0]

    ahead, behind, left, right = value(1, 0), value(-1, 0), value(0, 1), value(0, -1)
    crossed = value(1, 1) - value(1, -1) - value(-1, 1) + value(-1, -1)
    x, y, xx, xy, yy = spline.derivatives(i, j, 1, 2)
    np.testing.assert_allclose(x, (ahead - behind) / (2 * step * 0.5), rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(y, (left - right) / (2 * step * 2.0), rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(xx, (ahead + behind - 2 * value(0, 0)) / (step * 0.5) ** 2, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(yy, (left + right - 2 * value(0, 0)) / (step * 2.0) ** 2, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(xy, crossed / (4 * step * step), rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_the_cells_around_each_cell(boundary):
    shape = (5, 7)
    number = np.arange(35).reshape(shape)
    extended = np.pad(number, 2, mode="edge" if boundary is rc.Boundary.FREE else "wrap")
    cells = np.arange(35)
    near = Neighbourhood.of(*split(cells, shape[1]), shape, boundary, 2)
    for i in range(-2, 3):
        for j in range(-2, 3):
            expected = extended[2 + i : 7 + i, 2 + j : 9 + j]
            np.testing.assert_array_equal(near.at(np.array([(i, j)]))[0], expected.ravel())


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("stride", [1, 2])
def test_dual_cells_cover_the_patches_by_quarters(boundary, stride):
    solution = press((24, 36), 80, boundary)
    dual = find_dual_cells(solution, stride)
    m, n = (weights.size for weights in dual.weights)
    i, j = (part.ravel() for part in np.indices((m, n)))
    label, weight = solution.patches.labels.ravel()[dual.corners(i, j)], dual.weights[0][i] * dual.weights[1][j]
    expected = np.bincount(label.ravel(), weights=np.tile(0.25 * weight, 4))
    np.testing.assert_allclose(dual.cover(solution)[1:], expected[1:])
    edges = np.isin(np.count_nonzero(label, axis=0), (1, 2, 3))
    np.testing.assert_array_equal(np.stack(dual.find_edge(solution.contact)), np.stack((i[edges], j[edges])))


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("cells", [(128, 128), (24, 36)])
def test_the_far_field_is_the_sum_over_the_contacts_within_a_circle(boundary, cells):
    """Few contacts have several images of each other within it."""
    solution = press(cells, 40, boundary)
    count, size = solution.patches.count, np.array(solution.grid.size)
    x, y = np.random.default_rng(2).uniform(0.0, 1.0, size=(2, count)) * size[:, np.newaxis]
    radius = np.sqrt(24 * solution.grid.area / (np.pi * count))
    images = range(-3, 4) if boundary == "periodic" else (0,)
    curvature, slope = np.zeros((3, count)), np.zeros((2, count))
    for a in images:
        for b in images:
            dx, dy = x[:, np.newaxis] - x - a * size[0], y[:, np.newaxis] - y - b * size[1]
            r = np.hypot(dx, dy)
            near = (r > 0.0) & (r <= radius)
            r[~near] = 1.0
            load = np.where(near, solution.patches.forces / (np.pi * solution.modulus), 0.0)
            slope += [(load * -step / r**3).sum(axis=1) for step in (dx, dy)]
            curvature += [
                (load * (3 * p / r**5 - q / r**3)).sum(axis=1) for p, q in ((dx * dx, 1), (dx * dy, 0), (dy * dy, 1))
            ]
    if boundary == "periodic":
        curvature[::2] += solution.mean_pressure / (radius * solution.modulus)
    far = find_far_field(solution, x, y, np.zeros_like(x))
    np.testing.assert_allclose(far.slope, slope, rtol=1e-9, atol=1e-12 * np.abs(slope).max())
    np.testing.assert_allclose(far.curvature, curvature, rtol=1e-9, atol=1e-12 * np.abs(curvature).max())
