"""The largest value of the cells of layers, its place, and how far the one between the cells may lie above it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array


@attrs.frozen
class CellMaximum:
    """The largest of cell means, with its uncertainty and its place, m."""

    value: float
    uncertainty: float
    x: float
    y: float
    depth: float


def find_cell_maximum(values: Array, grid: rc.Grid, interfaces: Array, step_error: float) -> CellMaximum:
    """Return the largest of values of shape (nz, nx, ny), the means over the cells of layers.

    Its uncertainty is that by the substeps, relative to it, and by the cells: along each axis as much as the maximum of
    a parabola through the means of three cells can lie above that of the middle one.

    Parameters
    ----------
    values
        The values.
    grid
        The cells of a layer.
    interfaces
        Depths between the layers, m.
    step_error
        The error by the substeps, over the value.
    """
    layer, i, j = (int(place) for place in np.unravel_index(values.argmax(), values.shape))
    value = float(values[layer, i, j])
    by_cells = sum(_find_rise(values, (layer, i, j), axis) for axis in range(3))
    depth = 0.5 * float(interfaces[layer] + interfaces[layer + 1])
    return CellMaximum(value, math.hypot(by_cells, step_error * value), float(grid.x[i, 0]), float(grid.y[0, j]), depth)


def _find_rise(values: Array, place: Sequence[int], axis: int) -> float:
    """Return how far a parabola through three cell means can rise above that of the middle one, along an axis.

    With the second difference D it has the curvature D over the square of the side, and its maximum lies within half a
    side of the middle: D / 8 above the middle, which is D / 24 above the mean. At an end the change to the next cell
    stands for half of D.
    """
    others = [at for number, at in enumerate(place) if number != axis]
    line = np.moveaxis(values, axis, -1)[tuple(others)]
    at = place[axis]
    falls = [float(line[at] - line[one]) for one in (at - 1, at + 1) if 0 <= one < len(line)]
    return sum(falls) / len(falls) / 3.0 if falls else 0.0
