"""The largest value of the cells of layers, its place, and how far the one between the cells may lie above it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array

from roughcontact_volume.box import list_layers

# Of a value that is at its largest, relative.
_TOLERANCE = 1e-4


@attrs.frozen
class CellMaximum:
    """The largest of cell means, with its uncertainty and its place, m."""

    value: float
    uncertainty: float
    x: float
    y: float
    depth: float


def find_cell_maximum(
    values: Array, grid: rc.Grid, interfaces: Array, step_error: float, most: float = math.inf
) -> CellMaximum:
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
    most
        What no value exceeds but by the tolerance of the flow.
    """
    layer, i, j = (int(place) for place in np.unravel_index(values.argmax(), values.shape))
    value = float(values[layer, i, j])
    by_cells = sum(_find_rise(values, (layer, i, j), axis) for axis in range(3))
    depth = 0.5 * float(interfaces[layer] + interfaces[layer + 1])
    spread = min(math.hypot(by_cells, step_error * value), max(0.5 * (most - value), _TOLERANCE * value))
    return CellMaximum(value, spread, float(grid.x[i, 0]), float(grid.y[0, j]), depth)


def find_imprint_error(grid: rc.Grid, strain: Array, imprint: Array) -> tuple[float, float]:
    """Return the error of the depth of an imprint by the cells, and the depth of the plastic zone, m.

    Relative to it the error is that of the largest accumulated strain, shape (nz, nx, ny).
    """
    deep = np.flatnonzero(strain.any(axis=(1, 2)))
    if not deep.size:
        return 0.0, 0.0
    interfaces = np.concatenate(([0.0], np.cumsum(list_layers(grid, len(strain)))))
    largest = find_cell_maximum(strain, grid, interfaces, 0.0)
    depth = max(0.0, float(imprint.max()))
    return depth * largest.uncertainty / largest.value, float(interfaces[deep[-1] + 1])


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
