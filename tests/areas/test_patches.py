"""Contact patches: labels across the border, sums, statistics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import sparse

import roughcontact as rc
from roughcontact.solving import find_patches
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
def test_patches_cross_the_border_of_a_periodic_domain_only(cells, free, periodic):
    mask = marked(*cells)
    assert find_patches(mask, mask * 1.0, GRID, rc.Boundary.FREE).count == free
    for boundary in (rc.Boundary.PERIODIC, rc.Boundary.WRAPPED):
        assert find_patches(mask, mask * 1.0, GRID, boundary).count == periodic


@given(
    arrays(bool, st.tuples(st.integers(2, 9), st.integers(2, 9))),
    st.sampled_from((rc.Boundary.FREE, rc.Boundary.PERIODIC)),
)
def test_patches_are_the_connected_cells(mask, boundary):
    cells = np.arange(mask.size).reshape(mask.shape)
    # An independent path: all pairs of neighbouring cells, without the labels of open ones.
    mode = {"mode": "constant", "constant_values": -1} if boundary is rc.Boundary.FREE else {"mode": "wrap"}
    extended = np.pad(cells, 1, **mode)
    nx, ny = mask.shape
    around = [extended[1 + i : 1 + i + nx, 1 + j : 1 + j + ny] for i in (0, 1) for j in (-1, 0, 1)]
    one, other = np.tile(cells.ravel(), 6), np.stack(around).ravel()
    joined = (other >= 0) & mask.ravel()[one] & mask.ravel()[other]
    links = sparse.coo_matrix((np.ones(joined.sum()), (one[joined], other[joined])), shape=(mask.size,) * 2)
    _, numbers = sparse.csgraph.connected_components(links, directed=False)
    _, expected = np.unique(numbers[mask.ravel()], return_inverse=True)
    grid = rc.Grid(mask.shape, (float(nx), float(ny)))
    patches = find_patches(mask, mask * 1.0, grid, boundary)
    np.testing.assert_array_equal(patches.members, np.flatnonzero(mask))
    np.testing.assert_array_equal(patches.member_labels, expected + 1)
    assert patches.count == len(set(expected))


@given(problems())
def test_sums_over_patches_are_those_of_the_contact(case):
    problem, mean = case
    solution = problem.solve(pressure=mean)
    patches = solution.patches
    assert patches.cells.sum() == np.count_nonzero(solution.contact)
    assert patches.areas.sum() == pytest.approx(solution.area("cell-count").value)
    assert patches.forces.sum() == pytest.approx(solution.force, rel=1e-9)
    assert ((patches.labels > 0) == solution.contact).all()
    assert set(np.unique(patches.labels)) - {0} == set(range(1, patches.count + 1))


def test_perimeters_count_the_sides_in_metres():
    mask = marked((0, 2), (1, 2), (5, 5))
    grid = rc.Grid((6, 8), (6.0, 16.0))
    free = find_patches(mask, mask * 1.0, grid, rc.Boundary.FREE).perimeters
    # The side that lies on the border of a free domain bounds nothing.
    np.testing.assert_allclose(np.sort(free), [2 * 1.0 + 2.0, 4 * 1.0 + 2.0])
    periodic = find_patches(mask, mask * 1.0, grid, rc.Boundary.PERIODIC).perimeters
    np.testing.assert_allclose(np.sort(periodic), [2 * 1.0 + 2 * 2.0, 4 * 1.0 + 2 * 2.0])


def test_patches_read_well():
    mask = marked((0, 2), (1, 2), (4, 5))
    text = str(find_patches(mask, mask * 2.0, GRID, rc.Boundary.FREE))
    assert text.startswith("2 patches of 1.5 cells on average, 2 at most; the largest carries 66.7 % of the load")
    assert str(find_patches(marked(), marked() * 1.0, GRID, rc.Boundary.FREE)) == "no patches"
