r"""How far creases and sharp edges between the cells shift the bodies.

The top of a crease lies between the cells, which know only its flanks. With the falls a and b from cell to cell on both
sides it is :math:`ab / (2(a + b))` above the higher of two cells on average. At a sharp edge the pressure rises as
:math:`K / \sqrt{2 \pi x}`. An edge that is moved outwards by s along the length b lowers the approach by

.. math:: \frac{K^2 s b}{E^* F}, \qquad K^2 = \frac{\pi}{2} p^2 h,

with the pressure p of the outermost cells, of width h: the derivative of the energy by the position of the edge.

References
----------
Johnson, Contact Mechanics (1985), section 5.3, https://doi.org/10.1017/CBO9781139171731
"""

from __future__ import annotations

import math

import numpy as np

from roughcontact._answers.areas import quantity_calibration as calibration
from roughcontact._answers.areas.cells import Neighbourhood, find_sharp_edges, split
from roughcontact._base.arrays import Array, IntArray
from roughcontact._parts.grid import extend
from roughcontact._solve.solution import ContactSolution

# Second differences beside the two at a crease, in cells from the first of both, that must be small.
_BESIDE_CREASE = (-2, -1, 2, 3)
# Cells on each side that the second differences at a cell and beside it need.
_REACH = 4
# Cells in contact across a crease up to which its height counts in full: two lie at it. In a wider contact it is a part
# of a line, whose sampling is of second order.
_NARROW_RUN = 2.0


def find_lost_std(solution: ContactSolution) -> float:
    """Return the standard deviation of the approach by creases and sharp edges between the cells, m."""
    # Approach, mean gap and leakage ask for the same.
    return solution._keep("lost heights", lambda: math.hypot(_find_crease_std(solution), _find_sharp_std(solution)))


def _find_crease_std(solution: ContactSolution) -> float:
    """Return the standard deviation of the approach by creases between the cells in contact, m."""
    chosen = np.flatnonzero(solution.contact)
    load = np.maximum(solution.pressure.ravel()[chosen], 0.0)
    if not load.any():
        return 0.0
    lost = np.zeros(chosen.shape)
    shape = solution.grid.shape
    i, j = split(chosen, shape[1])
    axes = zip((i, j), shape, solution.boundary.free_axes, strict=True)
    # At a free border the differences are those of the cells inside.
    row, column = (np.clip(k, _REACH, n - 1 - _REACH) if free and n > 2 * _REACH else k for k, n, free in axes)
    near = Neighbourhood.of(row, column, shape, solution.boundary, _REACH)
    touching = Neighbourhood.of(i, j, shape, solution.boundary, _REACH)
    for step, cells in zip(((1, 0), (0, 1)), shape, strict=True):
        if cells > 2 * _REACH:
            narrow = np.minimum(_NARROW_RUN / _count_run(solution, touching, step), 1.0)
            lost += narrow**2 * _find_lost_height(solution, near, step)
    return calibration.CREASE_STD * float(np.sum(load * lost) / np.sum(load))


def _find_lost_height(solution: ContactSolution, near: Neighbourhood, step: tuple[int, int]) -> Array:
    """Return the mean height of a crease across an axis above the cells, m; zero where there is none."""
    heights = solution.initial_gap.ravel()
    line = np.stack([heights.take(near.at(k * step[0], k * step[1])) for k in range(-_REACH, _REACH + 1)])
    bends = np.diff(line, 2, axis=0)
    lost = np.zeros(line.shape[1])
    for side in (1, -1):
        before, here, after, beyond = (line[_REACH + side * k] for k in (-1, 0, 1, 2))
        sharp = before - here - after + beyond
        beside = np.max(np.abs([bends[_REACH - 1 + side * k] for k in _BESIDE_CREASE]), axis=0)
        slopes = np.maximum(before - here, 0.0) * np.maximum(beyond - after, 0.0)
        found = (sharp > 0.0) & (beside < calibration.MAX_BEND_BESIDE * sharp)
        lost = np.where(found, np.maximum(lost, 0.5 * slopes / np.where(found, sharp, 1.0)), lost)
    return lost


def _count_run(solution: ContactSolution, near: Neighbourhood, step: tuple[int, int]) -> IntArray:
    """Return how many cells are in contact in line through each cell, up to `_REACH` on both sides."""
    contact = solution.contact.ravel()
    count = np.ones(near.cells.shape, dtype=np.intp)
    for side in (1, -1):
        joined = np.ones(near.cells.shape, dtype=bool)
        for k in range(1, _REACH + 1):
            joined &= contact[near.at(side * k * step[0], side * k * step[1])]
            count += joined
    return count


def _find_sharp_std(solution: ContactSolution) -> float:
    """Return the standard deviation of the approach by sharp edges, which lie anywhere between two cells, m."""
    if solution.force == 0.0:
        return 0.0
    closed = solution.contact if solution.non_measured is None else solution.contact | solution.non_measured
    # Beyond a free border nothing is open: where it cuts the contact is counted apart.
    around = extend(closed, 1, solution.boundary)
    pressure = np.where(find_sharp_edges(solution) & ~solution.saturated, solution.pressure, 0.0)
    energy = 0.0
    for step, before, after in (
        (solution.grid.spacing[0], around[:-2, 1:-1], around[2:, 1:-1]),
        (solution.grid.spacing[1], around[1:-1, :-2], around[1:-1, 2:]),
    ):
        count = (~before).astype(np.intp) + ~after
        energy += step * solution.grid.cell_area * float(np.sum(count * pressure**2))
    modulus = float(solution.effective_modulus(1.0 / math.sqrt(solution.grid.resolved.cell_area)))
    return calibration.SHARP_EDGE_STD * energy / (modulus * abs(solution.force))
