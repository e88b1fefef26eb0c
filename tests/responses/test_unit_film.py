"""The network of a periodic gap: a dense one, pieces that repeat, and Patir and Cheng's own construction."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy import ndimage

import roughcontact as rc
from roughcontact._answers.flow.factors import find_flow_factors
from roughcontact._answers.flow.periodic import find_endless_pieces, solve_periodic
from roughcontact._answers.laws.film_fits import patir_cheng
from roughcontact._answers.laws.film_rows import count_waves


def endless_by_copies(open_cells):
    """Return the cells of pieces that reach another copy of themselves, by a flood of 7 x 7 copies."""
    nx, ny = open_cells.shape
    labels, _ = ndimage.label(np.tile(open_cells, (7, 7)))
    copies = labels.reshape(7, nx, 7, ny)
    middle = copies[3, :, 3, :]
    found = np.zeros(open_cells.shape, dtype=bool)
    for i, j in itertools.product(range(7), repeat=2):
        if (i, j) != (3, 3):
            found |= (copies[i, :, j, :] == middle) & open_cells
    return found


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("shape", [(9, 7), (1, 6), (5, 1), (2, 8)])
def test_endless_pieces_are_those_that_reach_another_copy(seed, shape):
    open_cells = np.random.default_rng(seed).random(shape) < 0.6
    np.testing.assert_array_equal(find_endless_pieces(open_cells) > 0, endless_by_copies(open_cells))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("shape", [(6, 7), (5, 8), (9, 4), (3, 1)])
def test_both_tensors_are_those_of_four_right_sides_on_a_dense_network(seed, shape):
    """The drag of a sliding wall has a problem of its own; reciprocity gives it by the flow of a pressure gradient."""
    random = np.random.default_rng(seed)
    gap = np.exp(0.5 * random.normal(size=shape))
    open_cells = random.random(shape) < 0.75
    aspect = 1.7
    flow = solve_periodic(gap, open_cells, aspect=aspect)
    if flow.network is None:
        assert not endless_by_copies(open_cells).any()
        return
    faces, network = flow.network.faces, flow.network
    count = network.cells.size
    crossed = (np.arange(faces.first.size) >= faces.along).astype(int)
    step = np.where(crossed == 0, 1.0, aspect)
    beside = np.where(crossed == 0, aspect, 1.0)
    # Differences over faces, second less first cell; a face may join a cell to itself.
    difference = np.zeros((faces.first.size, count))
    np.add.at(difference, (np.arange(faces.first.size), faces.second), 1.0)
    np.add.at(difference, (np.arange(faces.first.size), faces.first), -1.0)
    cubes, films = faces.find_cubes(), faces.find_films()
    matrix = difference.T @ (difference * (cubes * beside / step)[:, np.newaxis])
    inverse = np.linalg.pinv(matrix, hermitian=True, rcond=1e-11)
    area = aspect * gap.size
    for axis in (0, 1):
        along = crossed == axis
        by_pressure, by_sliding = (
            np.where(along, values, 0.0) + values_of
            for values, values_of in (
                (cubes, cubes / step * (difference @ -inverse @ difference.T @ (np.where(along, cubes, 0.0) * beside))),
                (films, cubes / step * (difference @ -inverse @ difference.T @ (np.where(along, films, 0.0) * beside))),
            )
        )
        for other in (0, 1):
            through = crossed == other
            mean_flow = np.sum((by_pressure * beside * step)[through]) / area
            dragged = np.sum((by_sliding * beside * step)[through]) / area
            assert flow.cubes[axis, other] == pytest.approx(mean_flow, rel=1e-9, abs=1e-12)
            assert flow.films[axis, other] == pytest.approx(dragged, rel=1e-9, abs=1e-12)


@pytest.mark.slow
def test_the_construction_of_patir_and_cheng_has_their_factors():
    """Heights of a linear correlation, cut off where they overlap, not deformed."""
    cells, side = 192, 12
    found = []
    for seed in range(2):
        noise = np.random.default_rng(seed).normal(size=(cells, cells))
        heights = ndimage.uniform_filter(noise, side, mode="wrap")
        heights = (heights - heights.mean()) / heights.std()
        found.append([])
        for separation in (3.0, 2.0):
            gap = np.maximum(separation - heights, 0.0)
            factors = find_flow_factors(gap, gap > 0.0, rc.Grid((cells, cells), 1.0), separation, creased=0.0)
            found[-1].append(0.5 * np.trace(factors.pressure))
    theirs = patir_cheng(np.array([3.0, 2.0]), 0.0)
    assert theirs == pytest.approx([0.832, 0.706], abs=1e-3)
    np.testing.assert_allclose(np.mean(found, axis=0), theirs, atol=0.03)


def test_waves_of_a_mirrored_domain_are_those_of_one_image():
    surface = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-6, shortest=0.1, longest=0.5, seed=4)
    heights = surface.heights(rc.Grid((64, 48), (1.0, 0.75)))
    along, across = count_waves(heights)
    turned = np.concatenate((heights, heights[::-1]))
    assert count_waves(turned) == pytest.approx((along, across), rel=0.2)
    both = np.concatenate((turned, turned[:, ::-1]), axis=1)
    assert count_waves(both) == pytest.approx((along, across), rel=0.2)
