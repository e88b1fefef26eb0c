"""Clusters: labels across the border, sums, statistics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

import roughcontact as rc
from roughcontact.clusters import clusters_of
from strategies import problems

GRID = rc.Grid((6, 8), (6.0, 8.0))


def marked(*cells):
    mask = np.zeros(GRID.shape, dtype=bool)
    for cell in cells:
        mask[cell] = True
    return mask


@pytest.mark.parametrize(
    ("cells", "free", "periodic"),
    [
        (((0, 3), (5, 3)), 2, 1),
        (((0, 0), (5, 7)), 2, 1),
        (((2, 0), (3, 7)), 2, 1),
        (((1, 1), (2, 2)), 1, 1),
        (((1, 1), (3, 3)), 2, 2),
        ((), 0, 0),
    ],
)
def test_clusters_go_on_across_the_border_where_the_domain_does(cells, free, periodic):
    mask = marked(*cells)
    assert clusters_of(mask, mask * 1.0, GRID, rc.Boundary.FREE).count == free
    for boundary in (rc.Boundary.PERIODIC, rc.Boundary.WRAPPED):
        assert clusters_of(mask, mask * 1.0, GRID, boundary).count == periodic


@given(problems())
def test_sums_over_clusters_are_those_of_the_contact(case):
    problem, mean = case
    solution = problem.solve(pressure=mean)
    clusters = solution.clusters
    assert clusters.cells.sum() == np.count_nonzero(solution.contact)
    assert clusters.areas.sum() == pytest.approx(solution.area("cell-count").value)
    assert clusters.forces.sum() == pytest.approx(solution.force, rel=1e-9)
    assert ((clusters.labels > 0) == solution.contact).all()
    assert set(np.unique(clusters.labels)) - {0} == set(range(1, clusters.count + 1))


def test_perimeters_count_the_sides_in_metres():
    mask = marked((0, 2), (1, 2), (5, 5))
    grid = rc.Grid((6, 8), (6.0, 16.0))
    free = clusters_of(mask, mask * 1.0, grid, rc.Boundary.FREE).perimeters
    # The side that lies on the border of a free domain bounds nothing.
    np.testing.assert_allclose(np.sort(free), [2 * 1.0 + 2.0, 4 * 1.0 + 2.0])
    periodic = clusters_of(mask, mask * 1.0, grid, rc.Boundary.PERIODIC).perimeters
    np.testing.assert_allclose(np.sort(periodic), [2 * 1.0 + 2 * 2.0, 4 * 1.0 + 2 * 2.0])


def test_clusters_read_well():
    mask = marked((0, 2), (1, 2), (4, 5))
    text = str(clusters_of(mask, mask * 2.0, GRID, rc.Boundary.FREE))
    assert text.startswith("2 clusters of 1.5 cells on average, 2 at most; the largest bears 66.7 % of the load")
    assert str(clusters_of(marked(), marked() * 1.0, GRID, rc.Boundary.FREE)) == "no clusters"
