"""Small functions of responses: rows of sides, throats, paths, searches for loads, and maxima beside closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import ndimage

import roughcontact as rc
from exact_contacts import ball, with_fields
from roughcontact._answers.flow.leakage import _count_open, _measure_width, _square_around, find_throat
from roughcontact._answers.flow.network import (
    _compare_rules,
    _find_distances,
    eliminate,
    estimate_uncertainty,
    find_paths,
    make_network,
)
from roughcontact._answers.flow.percolation import _BLOCKS, _CORNERS, _SIDES, _is_open
from roughcontact._answers.linear.conductance import _list_points
from roughcontact._answers.linear.stiffness import _find_loss, _find_trust, _measure_rows
from roughcontact._answers.subsurface.maximum import PlanePeak, _fit_parabola, find_maximum


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("cell", [(1.0, 1.0), (2.0, 3.0)])
def test_the_sides_of_rectangles_lie_in_rows(boundary, cell):
    """A rectangle of 4 x 6 cells, and one of 2 x 3 across a periodic border: sides, squares and what rows lack."""
    shape = (14, 17)
    grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
    contact = np.zeros(shape, dtype=bool)
    contact[3:7, 5:11] = True
    if boundary == "periodic":
        contact[np.ix_((13, 0), (0, 1, 16))] = True
    else:
        contact[9:11, 13:16] = True
    answer = np.where(contact, 2.0, 0.0)
    answer[3:7, 5:11] = 5.0
    solution = with_fields(grid, contact, ~contact, boundary=boundary)
    lost, sides, squares, along = _measure_rows(solution, answer, contact)
    large = int(solution.patches.labels[5, 8]) - 1
    order = [large, 1 - large]
    rectangles, values = ((4, 6), (2, 3)), (5.0, 2.0)
    for k, (m, n), value in zip(order, rectangles, values, strict=True):
        assert sides[k] == pytest.approx(2.0 * (m * cell[0] + n * cell[1]))
        assert squares[k] == pytest.approx(2.0 * (m + n) * value**2)
        assert along[k] == pytest.approx(value**2 * sides[k])
        rows = ((n, shape[1], cell[0] / cell[1]), (m, shape[0], cell[1] / cell[0]))
        loss = sum(2.0 * float(_find_loss(np.array([length]), longest, aspect)[0]) for length, longest, aspect in rows)
        assert lost[k] == pytest.approx(loss)
    np.testing.assert_allclose(solution.patches.sum(answer)[order], [5.0 * 24, 2.0 * 6])


def test_a_row_across_the_whole_domain_lacks_nothing_for_its_ends():
    """A strip along the grid: Westergaard's 0.1736 cells of each side; a row lacks less, by the logarithm of it."""
    whole, part = _find_loss(np.array([12, 12]), 12, 1.0)[0], _find_loss(np.array([12]), 40, 1.0)[0]
    assert whole == pytest.approx(12 * 0.1736)
    assert whole - part == pytest.approx(0.154 * math.log(12) + 0.0866)
    longer = _find_loss(np.array([12]), 40, 8.0)[0]
    assert whole - longer == pytest.approx(0.154 * 8.0**0.7 * math.log(12) + 0.0866)


def test_the_correction_of_edges_is_trusted_where_they_are_sharp_or_resolved():
    grid = rc.Grid((24, 20), 24e-6)
    smooth = ball(grid, 6e-6, 1e-3)
    assert _find_trust(smooth, 0.0) == 1.0
    assert _find_trust(smooth, 0.8) == pytest.approx(0.5)
    assert _find_trust(smooth, 1.6) == pytest.approx(1.0 / 17.0)
    inside = np.zeros(grid.shape, dtype=bool)
    inside[6:18, 5:15] = True
    x, y = grid.x / 6e-6, grid.y / (5 * grid.spacing[1])
    punch = np.where(inside, 1e6 / np.sqrt(np.maximum((1.0 - x**2) * (1.0 - y**2), 1e-9)), 0.0)
    sharp = with_fields(grid, punch, np.where(inside, 0.0, 1.0))
    assert _find_trust(sharp, 1.6) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("periodic", [False, True])
def test_widths_of_channels_in_four_directions(periodic):
    """Through a cell, along both axes and both diagonals: the shortest, in m and in cells."""
    open_cells = np.zeros((15, 12), dtype=bool)
    open_cells[:, 4:7] = True
    assert _measure_width(open_cells, (7, 5), 2.0, 1.0, periodic=periodic) == (3.0, 3.0)
    assert _measure_width(open_cells, (7, 4), 0.1, 1.0, periodic=periodic) == pytest.approx((1.5, 15.0))
    wide = np.ones((15, 12), dtype=bool)
    wide[3, 3] = wide[9, 9] = False
    # From corner to corner of both closed cells five diagonals fit between.
    width, cells = _measure_width(wide, (6, 6), 1.0, 1.0, periodic=False)
    assert (width, cells) == pytest.approx((5.0 * math.sqrt(2.0), 5.0 * math.sqrt(2.0)))
    other = np.ones((15, 12), dtype=bool)
    other[3, 9] = other[9, 3] = False
    assert _measure_width(other, (6, 6), 1.0, 1.0, periodic=False)[1] == pytest.approx(5.0 * math.sqrt(2.0))
    row = np.zeros((9, 12), dtype=bool)
    row[4] = True
    row[4, 8] = False
    assert _count_open(row, (4, 2), (0, 1), periodic=periodic) == 5
    assert _count_open(row, (4, 2), (0, -1), periodic=periodic) == (5 if periodic else 2)
    assert _count_open(np.ones((9, 12), dtype=bool), (4, 2), (0, 1), periodic=True) == 12
    assert _count_open(np.ones((9, 12), dtype=bool), (4, 2), (1, 0), periodic=True) == 4


@pytest.mark.parametrize("periodic", [False, True])
def test_a_square_around_a_cell_ends_at_the_border(periodic):
    rows, columns = _square_around((1, 10), 2, (9, 12), periodic=periodic)
    assert rows.ravel().tolist() == [0, 1, 2, 3]
    assert columns.tolist() == ([0, 8, 9, 10, 11] if periodic else [8, 9, 10, 11])
    rows, columns = _square_around((7, 1), 1, (9, 12), periodic=periodic)
    assert rows.ravel().tolist() == [6, 7, 8]
    assert columns.tolist() == [0, 1, 2]
    assert _square_around((4, 4), 9, (9, 12), periodic=True)[1].size == 12


@pytest.mark.parametrize("axis", [0, 1])
def test_the_critical_throat_of_two_in_series_is_the_narrower(axis):
    gap = np.full((21, 13), 2.0)
    open_cells = np.ones(gap.shape, dtype=bool)
    open_cells[5, :] = open_cells[15, :] = False
    open_cells[5, 4:9] = True
    open_cells[15, 7] = True
    network = make_network(np.where(open_cells, gap, 0.0), open_cells, aspect=1.5, periodic=False)
    _, lost = network.dissipation(eliminate(network))
    shape, size = ((21, 13), (21.0, 19.5)) if axis == 0 else ((13, 21), (19.5, 21.0))
    grid = rc.Grid(shape, size)
    found = find_throat(network, lost, open_cells, grid, axis, periodic=False)
    place = (grid.x[15, 0], grid.y[0, 7]) if axis == 0 else (grid.x[7, 0], grid.y[0, 15])
    assert found.place == pytest.approx(place)
    assert found.gap == pytest.approx(2.0)
    assert (found.width, found.cells) == pytest.approx((1.5, 1.0))
    square = np.zeros(gap.shape)
    square.reshape(-1)[network.cells] = lost
    assert found.fraction == pytest.approx(square[14:17, 6:9].sum() / lost.sum())


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_paths_of_three_widths(axis, boundary):
    """Two cells wide, one cell wide, through corners; and each of them across the border beside the flow."""

    def answers(open_cells):
        contact = ~(open_cells if axis == 0 else open_cells.T)
        grid = rc.Grid(contact.shape, 1.0)
        solution = with_fields(grid, contact, ~contact, boundary=boundary)
        return [_is_open(solution, axis, width) for width in (_BLOCKS, _SIDES, _CORNERS)]

    wide = np.zeros((7, 9), dtype=bool)
    wide[:, 3:5] = True
    assert answers(wide) == [True, True, True]
    thin = wide.copy()
    thin[2, 3] = False
    assert answers(thin) == [False, True, True]
    corner = np.zeros((7, 9), dtype=bool)
    corner[:3, 3] = corner[3:, 4] = True
    assert answers(corner) == [False, False, True]
    # Half of it on either side of the domain.
    around = np.zeros((7, 9), dtype=bool)
    around[:, [0, 8]] = True
    assert answers(around) == [boundary == "periodic", True, True]
    crossing = np.zeros((7, 9), dtype=bool)
    crossing[:3, 8] = crossing[3:, 0] = True
    assert answers(crossing) == [False, False, boundary == "periodic"]
    assert answers(np.zeros((7, 9), dtype=bool)) == [False, False, False]


@pytest.mark.parametrize("corners", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_cells_of_paths_are_those_that_a_flood_from_both_ends_reaches(seed, corners):
    open_cells = np.random.default_rng(seed).random((14, 11)) < (0.45 if corners else 0.62)
    cross = np.ones((3, 3), dtype=bool) if corners else ndimage.generate_binary_structure(2, 1)

    def flood(start, mask):
        while True:
            grown = ndimage.binary_dilation(start, cross) & mask
            if (grown == start).all():
                return start
            start = grown

    for periodic in (False, True):
        # Three copies side by side; what a path reaches in any of them counts.
        copies = 3 if periodic else 1
        mask = np.tile(open_cells, copies)
        reached = []
        for end in (0, -1):
            seed_cells = np.zeros(mask.shape, dtype=bool)
            seed_cells[end] = mask[end]
            for _ in range(12):
                found = flood(seed_cells, mask)
                folded = found.reshape(14, copies, 11).any(axis=1)
                seed_cells = np.tile(folded, copies)
            reached.append(folded)
        joined = find_paths(open_cells, periodic=periodic, corners=corners)
        # A piece that touches both ends.
        assert not (joined & ~(reached[0] & reached[1])).any()
        labels, count = ndimage.label(np.tile(open_cells, copies), structure=cross)
        del count
        both = np.intersect1d(labels[0][labels[0] > 0], labels[-1][labels[-1] > 0])
        whole = np.isin(labels, both).reshape(14, copies, 11).any(axis=1)
        assert not (whole & ~joined).any()


@pytest.mark.parametrize("aspect", [1.0, 2.5])
def test_the_uncertainty_of_a_flow_by_the_rule_and_the_walls(aspect):
    """In a row of cells of gaps one and two the film between them may be linear: a larger flow by a known part."""
    gap = np.array([[1.0], [2.0], [1.0]])
    network = make_network(gap, np.ones(gap.shape, dtype=bool), aspect=aspect, periodic=False)
    pressure = eliminate(network)
    faces, lost = network.dissipation(pressure)
    flow = float(lost.sum())
    # In series: two half cells at the ends and two faces of the harmonic mean of 1 and 8, over the widest, 8.
    resistance = (2 * 0.5 / (1.0 / 8.0) + 2 / (2.0 / 8.0 * 8.0 / 9.0)) / aspect
    assert flow == pytest.approx(1.0 / resistance)
    share = 2 / (2.0 / 8.0 * 8.0 / 9.0) / aspect / resistance
    # Between g1 and g2 the exact resistance of a linear film is (g1 + g2) / (2 g1^2 g2^2).
    exact = (1.0 + 2.0) / (2.0 * 4.0) / (0.5 * (1.0 + 1.0 / 8.0))
    assert _compare_rules(network, faces, flow) == pytest.approx(1.0 / (1.0 - share * (1.0 - exact)) - 1.0)
    open_cells = np.ones((3, 1), dtype=bool)
    assert np.isinf(_find_distances(network, open_cells)).all()
    rule = _compare_rules(network, faces, flow)
    assert estimate_uncertainty(network, faces, lost, open_cells, gap_error=0.0) == pytest.approx(0.27 * rule)
    more = estimate_uncertainty(network, faces, lost, open_cells, gap_error=0.01)
    by_gap = 3.0 * 0.01 * np.sum(lost / np.array([0.5, 1.0, 0.5])) / flow
    assert more == pytest.approx(math.hypot(0.27 * rule, by_gap))


@pytest.mark.parametrize("aspect", [1.0, 4.0])
def test_the_uncertainty_beside_walls_is_that_of_their_distance(aspect):
    """Cells of an even channel lose alike; those n cells from a wall weigh 1/n^2."""
    open_cells = np.ones((4, 7), dtype=bool)
    open_cells[:, [0, 6]] = False
    network = make_network(open_cells * 1.0, open_cells, aspect=aspect, periodic=False)
    faces, lost = network.dissipation(eliminate(network))
    steps = np.tile([1.0, 2.0, 3.0, 2.0, 1.0], 4) * math.sqrt(aspect)
    np.testing.assert_allclose(_find_distances(network, open_cells), steps)
    found = estimate_uncertainty(network, faces, lost, open_cells, gap_error=0.0)
    oblong = math.sqrt(max(aspect, 1.0 / aspect))
    assert found == pytest.approx(0.2 * np.mean((oblong / steps) ** 2))
    # Across a periodic border the wall is nearer.
    one = np.ones((4, 7), dtype=bool)
    one[:, 0] = False
    network = make_network(one * 1.0, one, aspect=aspect, periodic=True)
    steps = np.tile([1.0, 2.0, 3.0, 3.0, 2.0, 1.0], 4) * math.sqrt(aspect)
    np.testing.assert_allclose(_find_distances(network, one), steps)
    free = np.tile([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 4) * math.sqrt(aspect)
    network = make_network(one * 1.0, one, aspect=aspect, periodic=False)
    np.testing.assert_allclose(_find_distances(network, one), free)


@pytest.mark.parametrize("top", [-0.4, 0.0, 0.3])
def test_a_parabola_through_three_points_has_its_own_maximum(top):
    values = [5.0 - 2.0 * (at - top) ** 2 for at in (-1.0, 0.0, 1.0)]
    shift, rise = _fit_parabola(*values)
    assert shift == pytest.approx(top)
    assert values[1] + rise == pytest.approx(5.0)
    assert _fit_parabola(1.0, 1.0, 1.0) == (0.0, 0.0)
    assert _fit_parabola(2.0, 1.0, 2.0) == (0.0, 0.0)
    # A maximum beyond the middle between two points belongs to the next one.
    assert _fit_parabola(0.0, 3.0, 5.9)[0] == 0.5
    assert _fit_parabola(5.9, 3.0, 0.0)[0] == -0.5


def test_the_maximum_between_depths_is_that_over_their_logarithm():
    depths = np.array([0.5, 1.0, 2.0, 4.0, 8.0])
    best = 2.3
    peaks = [PlanePeak(3.0 - 0.5 * math.log(depth / best) ** 2, 10.0 + k, 20.0) for k, depth in enumerate(depths)]
    found = find_maximum(depths, peaks, 100.0, 0.1)
    assert found.value == pytest.approx(300.0)
    assert found.depth == pytest.approx(best)
    assert (found.x, found.y) == (12.0, 20.0)
    assert found.warnings == ()
    cells = best / 0.1
    relative = math.hypot(2e-4, 0.012 / cells**2 + 0.004 / cells**4)
    rise = 3.0 - peaks[2].value
    assert found.uncertainty == pytest.approx(100.0 * math.hypot(relative * 3.0, 0.3 * rise))
    for part, words in ((slice(2, None), "the smallest"), (slice(None, 3), "the largest")):
        edge = find_maximum(depths[part], peaks[part], 1.0, 0.1)
        assert edge.depth == 2.0
        assert words in edge.warnings[0]
        assert len(edge.warnings) == 1
    # The surface itself has no logarithm: the parabola is over the depth; and near it the cells make the stress.
    shallow = find_maximum(
        np.array([0.0, 1.0, 2.0]), [PlanePeak(value, 0.0, 0.0) for value in (1.0, 2.0, 1.5)], 1.0, 0.6
    )
    assert (shallow.value, shallow.depth) == (pytest.approx(2.0 + 1.0 / 48.0), pytest.approx(7.0 / 6.0))
    assert shallow.warnings == ()
    surface = find_maximum(np.array([0.0, 1.0]), [PlanePeak(value, 0.0, 0.0) for value in (2.0, 1.0)], 1.0, 0.6)
    assert (surface.value, surface.depth) == (2.0, 0.0)
    assert surface.warnings == ()
    flat = find_maximum(depths, [PlanePeak(1.0, 0.0, 0.0)] * 5, 1.0, 0.1)
    assert flat.value == 1.0


@pytest.mark.parametrize("s", [1e-5, 1e-3, 0.1, 1.0])
def test_the_waves_of_a_flow_through_a_disc_reach_from_wide_to_thin_layers(s):
    """The integral of exp(-s x) sin(x)^2 / x^2 is arctan(2 / s) - s / 4 ln(1 + 4 / s^2)."""
    x, (isothermal, _, _) = _list_points()
    exact = math.atan(2.0 / s) - 0.25 * s * math.log1p(4.0 / s**2)
    assert isothermal @ np.exp(-s * x) == pytest.approx(exact, rel=1e-6)
