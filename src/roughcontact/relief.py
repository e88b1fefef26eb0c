"""Figures of a relief that tell whether it is what was meant."""

from __future__ import annotations

import math

import numpy as np

from roughcontact.checks import Array
from roughcontact.grid import Grid

# The rms step across the border of heights that repeat is at most this multiple of that between neighbours.
_JUMP = 3.0


def rms_slope(heights: Array, grid: Grid) -> float:
    """Return the root mean square of the gradient between neighbouring cells, shape (nx, ny), m."""
    steps = [np.diff(heights, axis=axis) / grid.spacing[axis] for axis in (0, 1) if grid.shape[axis] > 1]
    greatest = max(float(np.abs(step).max()) for step in steps)
    if not 0.0 < greatest < math.inf:
        return greatest
    return greatest * math.sqrt(sum(float(np.mean((step / greatest) ** 2)) for step in steps))


def repeats(heights: Array, axis: int | None = None) -> bool:
    """Tell whether heights, shape (nx, ny), go on with their own copy along one axis, or along both, without a jump."""
    if axis is None:
        return repeats(heights, 0) and repeats(heights, 1)
    if heights.shape[axis] <= 2:
        return True
    inside = float(np.sqrt(np.mean(np.diff(heights, axis=axis) ** 2)))
    across = float(np.sqrt(np.mean((heights.take(0, axis) - heights.take(-1, axis)) ** 2)))
    return across <= _JUMP * inside
