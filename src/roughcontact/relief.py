"""Figures of a relief that tell whether it is what was meant."""

from __future__ import annotations

import math

import numpy as np

from roughcontact.checks import Array
from roughcontact.grid import Grid


def rms_slope(heights: Array, grid: Grid) -> float:
    """Return the root mean square of the gradient between neighbouring cells, shape (nx, ny), m."""
    steps = [np.diff(heights, axis=axis) / grid.spacing[axis] for axis in (0, 1) if grid.shape[axis] > 1]
    greatest = max(float(np.abs(step).max()) for step in steps)
    if not 0.0 < greatest < math.inf:
        return greatest
    return greatest * math.sqrt(sum(float(np.mean((step / greatest) ** 2)) for step in steps))


def seam_jump(heights: Array, axis: int | None = None) -> float:
    """Return the rms step across the border over that between neighbours, for one axis or the worse of both."""
    if axis is None:
        return max(seam_jump(heights, 0), seam_jump(heights, 1))
    if heights.shape[axis] <= 2:
        return 0.0
    inside = float(np.sqrt(np.mean(np.diff(heights, axis=axis) ** 2)))
    across = float(np.sqrt(np.mean((heights.take(0, axis) - heights.take(-1, axis)) ** 2)))
    if across == 0.0:
        return 0.0
    return across / inside if inside > 0.0 else math.inf
