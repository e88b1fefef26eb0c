"""Edges, dual cells and areas of contacts whose fields are closed forms, on oblong cells and odd and even grids."""

from __future__ import annotations

import math

import numpy as np
import pytest

import roughcontact as rc
from exact_contacts import MODULUS, ball, distances, edge, with_fields
from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.cells import Neighbourhood, find_sharp_edges
from roughcontact._answers.areas.contour import find_distances, trace_contour
from roughcontact._answers.areas.dual_cells import CellOwners, find_dual_cells, find_kinds
from roughcontact._answers.areas.edges import trace_edges
from roughcontact._answers.areas.estimators import edge_law
from scenes import each_once

GRIDS = [((15, 16), (1.0, 1.0)), ((15, 22), (2.0, 1.0)), ((24, 13), (1.0, 3.0))]


def cut_by_a_line(shape, cell, angle, boundary="free", **options):
    """A contact on one side of a straight line through the middle, and the signed distance from the line."""
    grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
    depth = np.cos(angle) * (grid.x - 0.21) + np.sin(angle) * (grid.y + 0.37)
    return edge(grid, depth, boundary=boundary, **options), depth


@pytest.mark.parametrize(("shape", "cell"), GRIDS)
@pytest.mark.parametrize("angle", [0.0, 0.4, 1.1, 2.5, 3.9])
def test_the_distance_from_a_straight_edge_is_exact(shape, cell, angle):
    """K sqrt(d) inside and 4 K / (3 E*) d^1.5 outside: the signed distance has the gradient one, whatever K."""
    solution, depth = cut_by_a_line(shape, cell, angle)
    i, j = np.nonzero(np.diff(np.sign(depth), axis=0)[:, :-1])
    i, j = i[(i < shape[0] - 1)], j[(i < shape[0] - 1)]
    k = (i * shape[1] + j) + np.array((0, shape[1], shape[1] + 1, 1))[:, np.newaxis]
    touching = solution.contact.ravel()[k]
    mixed = touching.any(axis=0) & ~touching.all(axis=0)
    k, touching = k[:, mixed], touching[:, mixed]
    assert k.size
    found = find_distances(solution, k, touching)
    np.testing.assert_allclose(found, depth.ravel()[k], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("shape", "cell"), GRIDS)
@pytest.mark.parametrize("stride", [1, 2])
def test_dual_cells_cover_the_domain_as_often_as_there_are_choices(shape, cell, stride):
    """Corners at least half inside: the parts in the domain add up to its cells, times the choices of corners."""
    for boundary in ("free", "periodic"):
        contact = with_fields(rc.Grid(shape, 1.0), np.ones(shape), 0.0, boundary=boundary)
        dual = find_dual_cells(contact, stride)
        assert [weights.sum() for weights in dual.weights] == pytest.approx(list(shape))
        np.testing.assert_allclose(dual.cover(contact), [0.0, shape[0] * shape[1]])
        before = stride if boundary == "free" else 0
        assert dual.before == (before, before)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("stride", [1, 2])
@pytest.mark.parametrize("shape", [(5, 8), (8, 5), (7, 7)])
def test_corners_of_dual_cells_are_the_cells_that_a_padded_field_has_there(shape, stride, boundary):
    rng = np.random.default_rng(1)
    contact = rng.random(shape) < 0.4
    solution = with_fields(rc.Grid(shape, 1.0), contact, ~contact, boundary=boundary)
    dual = find_dual_cells(solution, stride)
    padded = np.pad(contact, (dual.before[0], stride), mode="edge" if boundary == "free" else "wrap")
    numbers = np.pad(
        np.arange(contact.size).reshape(shape), (dual.before[0], stride), mode="edge" if dual.before[0] else "wrap"
    )
    m, n = padded.shape[0] - stride, padded.shape[1] - stride
    corners = np.stack([numbers[a : a + m, b : b + n] for a, b in ((0, 0), (stride, 0), (stride, stride), (0, stride))])
    inside = contact.ravel()[corners].sum(axis=0)
    np.testing.assert_array_equal(dual.count_inside(contact), inside)
    i, j = dual.find_edge(contact)
    np.testing.assert_array_equal(np.transpose((i, j)), np.argwhere((inside > 0) & (inside < 4)))
    np.testing.assert_array_equal(dual.corners(i, j), corners[:, i, j])


def test_a_dual_cell_between_patches_is_divided_by_its_corners():
    label = np.array([[1, 1, 2], [1, 2, 0], [0, 2, 2], [1, 0, 3]])
    owners = CellOwners.find(label, find_kinds(label > 0), 3)
    np.testing.assert_allclose(
        owners.sum(np.array([1.0, 10.0, 100.0])), [0.0, 1.0 + 10.0 / 3, 20.0 / 3 + 200.0 / 3, 100.0 / 3]
    )
    alone = CellOwners.find(label[:, :1], find_kinds(label[:, :1] > 0), 3)
    np.testing.assert_allclose(alone.sum(np.array([7.0])), [0.0, 7.0, 0.0, 0.0])


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("shape", [(5, 9), (6, 4)])
def test_surroundings_are_those_of_a_padded_field(shape, boundary):
    field = np.random.default_rng(2).normal(size=shape)
    reach = 2
    padded = np.pad(field, reach, mode="edge" if boundary == "free" else "wrap")
    i, j = (one.ravel() for one in np.indices(shape))
    near = Neighbourhood.of(i, j, shape, rc.Boundary(boundary), reach)
    for a in range(-reach, reach + 1):
        for b in range(-reach, reach + 1):
            expected = padded[reach + a : reach + a + shape[0], reach + b : reach + b + shape[1]]
            np.testing.assert_array_equal(field.ravel()[near.at(np.array([(a, b)]))[0]].reshape(shape), expected)


@pytest.mark.parametrize(("shape", "cell"), GRIDS)
@pytest.mark.parametrize("stride", [1, 2])
def test_area_and_length_inside_a_band_along_the_grid(shape, cell, stride):
    """A band across a periodic domain: two straight edges between the centres, which polygons meet exactly."""
    for axis in (0, 1):
        grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
        across = (grid.x, grid.y)[axis]
        half = 3.3 * cell[axis]
        solution = edge(grid, half - np.abs(across - 0.1 * cell[axis]) + np.zeros(shape), boundary="periodic")
        found = trace_contour(solution, np.zeros(shape, dtype=bool), stride)
        other = grid.size[1 - axis]
        assert found.area[1] == pytest.approx(2.0 * half * other, rel=1e-9)
        assert found.length[1] == pytest.approx(2.0 * other, rel=1e-9)
        assert found.euler[1] == pytest.approx(0.0, abs=1e-12)
        assert found.sharp[1] == 0.0
        assert found.area[0] == found.length[0] == 0.0


@pytest.mark.parametrize(("shape", "cell"), GRIDS)
@pytest.mark.parametrize("angle", [0.0, 0.5, 2.2])
def test_area_and_length_on_one_side_of_a_line_that_a_free_border_cuts(shape, cell, angle):
    """Beyond the outermost centres the fields are repeated: half a cell of the line is turned there, at both ends."""
    solution, _ = cut_by_a_line(shape, cell, angle)
    grid = solution.grid
    fine = [(np.arange(1200) + 0.5) / 1200 * side - 0.5 * side for side in grid.size]
    inside = np.cos(angle) * (fine[0][:, np.newaxis] - 0.21) + np.sin(angle) * (fine[1] + 0.37) > 0.0
    found = trace_contour(solution, np.zeros(shape, dtype=bool))
    assert found.area.sum() == pytest.approx(inside.mean() * grid.area, abs=0.6 * max(cell) ** 2)
    along = (grid.size[1] / abs(np.cos(angle)), grid.size[0] / max(abs(np.sin(angle)), 1e-9))
    assert found.length.sum() == pytest.approx(min(along), rel=1e-9 if angle == 0.0 else 0.1)


def cut_off_by_chords(radius, centre, size):
    """Return the area between a circle and the polygon of its crossings with the lines of a lattice of this size."""
    angles = []
    for side, at, turn in ((size[0], centre[0], np.arccos), (size[1], centre[1], np.arcsin)):
        lines = side * np.arange(math.ceil((at - radius) / side), math.floor((at + radius) / side) + 1) - at
        angle = turn(lines / radius)
        angles += [angle, (-angle if turn is np.arccos else np.pi - angle)]
    angles = np.sort(np.concatenate(angles) % (2.0 * np.pi))
    steps = np.diff(angles, append=angles[0] + 2.0 * np.pi)
    return 0.5 * radius**2 * float(np.sum(steps - np.sin(steps)))


@pytest.mark.parametrize("stride", [1, 2])
@pytest.mark.parametrize("cell", [(1.0, 1.0), (1.0, 2.0), (3.0, 1.0)])
def test_polygons_in_a_disc_lack_what_their_chords_cut_off(cell, stride):
    """Half a cell for all of the edge; that the distances are not linear moves the crossings by less."""
    rng, radius = np.random.default_rng(3), 6.0 * stride * max(cell)
    missing, chords, lengths = [], [], []
    for _ in range(12):
        shape = tuple(2 * math.ceil(1.4 * radius / side) + rng.integers(2) for side in cell)
        grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
        depth = radius - np.hypot(*distances(grid, rng.uniform(-0.5, 0.5, 2) * cell))
        found = trace_contour(edge(grid, depth), np.zeros(shape, dtype=bool), stride)
        assert found.euler[1] == pytest.approx(1.0)
        missing.append((np.pi * radius**2 - found.area[1]) / (stride**2 * grid.cell_area))
        size = (stride * cell[0], stride * cell[1])
        chords.append(cut_off_by_chords(radius, rng.random(2) * size, size) / (size[0] * size[1]))
        lengths.append(found.length[1] / (2.0 * np.pi * radius))
    assert np.mean(chords) == pytest.approx(0.5, abs=0.05)
    assert 0.1 < np.mean(missing) - np.mean(chords) < 0.17 * max(cell) / min(cell)
    assert np.std(missing) < 0.2
    assert 0.985 < np.mean(lengths) < 1.0


@each_once(
    {
        "cell": [(1.0, 1.0), (1.0, 2.0), (3.0, 1.0)],
        "boundary": ["free", "periodic"],
        "cells": [3.0, 7.0],
    }
)
def test_areas_of_exact_balls(cell, cells, boundary):
    """Extrapolated, the area errs by hundredths of a cell; by one stride by the chords of oblong cells beside it."""
    rng, a = np.random.default_rng(4), cells * max(cell) * 1e-6
    for _ in range(4):
        shape = tuple(int(2.8 * cells * max(cell) / side) + 9 + rng.integers(2) for side in cell)
        grid = rc.Grid(shape, (shape[0] * cell[0] * 1e-6, shape[1] * cell[1] * 1e-6))
        centre = (
            rng.uniform(-0.5, 0.5, 2) * grid.spacing if boundary == "free" else rng.uniform(-0.5, 0.5, 2) * grid.size
        )
        solution = ball(grid, a, 1e-3, centre, boundary)
        edges = trace_edges(solution)
        oblong = max(cell) / min(cell)
        assert abs(edges.refined[1] - np.pi * a**2) < 0.12 * grid.cell_area
        assert abs(edges.area[1] - np.pi * a**2) < (0.1 + 0.2 * (oblong - 1.0)) * grid.cell_area
        assert edges.length[1] == pytest.approx(2.0 * np.pi * a, rel=0.25 / cells**1.5)
        assert edges.width[1] == pytest.approx(np.pi * a**2 / grid.cell_area, rel=0.15)
        assert edges.roundness[1] == 1.0
        assert edges.sharp[1] == edges.border == edges.topology == 0.0
        assert edges.strip[1] == pytest.approx(edges.length[1] * math.sqrt(grid.cell_area))
        shift = trace_edges(ball(grid, a, 1e-3, centre, boundary, edge_shift=0.1))
        moved = 0.1 * math.sqrt(grid.cell_area) * edges.length[1]
        assert shift.area[1] - edges.area[1] == pytest.approx(moved, rel=1e-9)
        assert shift.refined[1] - edges.refined[1] == pytest.approx(moved, rel=0.1)


def test_the_edge_law_of_balls_is_that_of_hertz():
    """p^2 / p0^2 is uniform over Hertz's circle: the distribution of p over the area is 2 p / p0^2 per unit area."""
    for cell in ((1.0, 1.0), (1.0, 2.0)):
        grid = rc.Grid((64, 57), (64e-6 * cell[0], 57e-6 * cell[1]))
        a = 15e-6
        solution = ball(grid, a, 1e-3, (0.3e-6, 0.2e-6))
        peak = 2.0 * MODULUS * a / (np.pi * 1e-3)
        assert edge_law(solution) == pytest.approx(2.0 * np.pi * a**2 / peak**2 / grid.area, rel=0.03)


@pytest.mark.parametrize("axis", [0, 1])
def test_sharp_edges_are_those_of_a_punch_and_not_those_of_a_ball(axis):
    """Across a rigid strip p = P / (pi sqrt(b^2 - x^2)) rises outward over all cells."""
    shape = (19, 24) if axis == 0 else (24, 19)
    grid = rc.Grid(shape, (shape[0] * 1.0, shape[1] * 2.0))
    across = np.broadcast_to((grid.x, grid.y)[axis], shape)
    side = grid.spacing[axis]
    inside = np.abs(across) < 5.6 * side
    pressure = np.where(inside, 1e6 / np.sqrt(np.maximum(1.0 - (across / (5.6 * side)) ** 2, 1e-9)), 0.0)
    sharp = find_sharp_edges(with_fields(grid, pressure, np.where(inside, 0.0, 1.0), boundary="periodic"))
    steps = np.abs(np.round(across / side - (0.5 if shape[axis] % 2 == 0 else 0.0)))
    assert steps[sharp].min() >= 4
    outermost = inside & (np.abs(across) > 4.6 * side)
    np.testing.assert_array_equal(sharp, outermost)
    smooth = find_sharp_edges(
        with_fields(grid, np.where(inside, 1.0 / np.maximum(pressure, 1.0), 0.0), np.where(inside, 0.0, 1.0))
    )
    assert not smooth.any()


def test_the_border_counts_the_cells_that_it_cuts():
    grid = rc.Grid((9, 12), (9.0, 12.0))
    contact = np.zeros(grid.shape, dtype=bool)
    contact[0, 2:7] = contact[1, 2:7] = contact[5:8, -1] = contact[5, 5] = True
    solution = with_fields(grid, contact, ~contact)
    assert trace_edges(solution).border == pytest.approx(calibration.CUT_BORDER_STD * 8 * grid.cell_area)
    assert trace_edges(with_fields(grid, contact, ~contact, boundary="periodic")).border == 0.0
    saturated = np.where(contact, np.where(np.indices(grid.shape)[0] == 0, 1.0, 0.5), 0.0)
    limited = with_fields(grid, saturated, ~contact, limit=1.0)
    assert trace_edges(limited).border == pytest.approx(calibration.CUT_BORDER_STD * 3 * grid.cell_area)
