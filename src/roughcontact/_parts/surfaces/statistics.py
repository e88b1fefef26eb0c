"""Statistics of heights: rms slope, and whether they repeat across the border."""

from __future__ import annotations

import math

import numpy as np

from roughcontact._base.checks import Array
from roughcontact._parts.grid import Grid

# Heights repeat if their rms step across the border is at most this multiple of that between neighbouring cells.
_MAX_JUMP = 3.0


def rms_slope(heights: Array, grid: Grid) -> float:
    """Return the root mean square of the gradient of heights, shape (nx, ny), m, between neighbouring cells."""
    steps = [np.diff(heights, axis=axis) / grid.spacing[axis] for axis in (0, 1) if grid.shape[axis] > 1]
    maximum = max(float(np.abs(step).max()) for step in steps)
    if not 0.0 < maximum < math.inf:
        return maximum
    return maximum * math.sqrt(sum(float(np.mean((step / maximum) ** 2)) for step in steps))


def repeats(heights: Array, axis: int | None = None) -> bool:
    """Return whether heights, shape (nx, ny), repeat beyond the border without a jump, along one axis or both."""
    if axis is None:
        return repeats(heights, 0) and repeats(heights, 1)
    return border_jump(heights, axis) <= _MAX_JUMP


def border_jump(heights: Array, axis: int) -> float:
    """Return the rms step of heights, shape (nx, ny), across the border along an axis, over that between neighbours."""
    if heights.shape[axis] <= 2:
        return 0.0
    inside = float(np.sqrt(np.mean(np.diff(heights, axis=axis) ** 2)))
    across = float(np.sqrt(np.mean((heights.take(0, axis) - heights.take(-1, axis)) ** 2)))
    return across / inside if inside > 0.0 else 0.0
