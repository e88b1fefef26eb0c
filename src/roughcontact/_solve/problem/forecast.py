"""The time of a solve, estimated before it runs."""

from __future__ import annotations

import functools
import math
import time

import numpy as np
import scipy.fft

from roughcontact._parts.grid import Boundary

# Transforms there and back of the grid's cells that a solve lasts as long as; measured on self-affine, wavy and
# spherical surfaces of 128 x 128 to 512 x 512 cells, of which most need less.
_TRANSFORMS = {Boundary.FREE: 64.0, Boundary.PERIODIC: 40.0, Boundary.WRAPPED: 40.0}
# Seconds that a solve takes on the smallest grid, measured on the same.
_ANY_GRID = 0.1
# Cells along a side of the transform that is timed, and how often it is.
_TIMED = 256
_REPEATS = 5


def forecast_seconds(cells: int, boundary: Boundary) -> float:
    """Return about how long one solve takes on this machine, s: likely within a factor of three."""
    return _ANY_GRID + _TRANSFORMS[boundary] * _time_of_transform() * cells * math.log(max(cells, 2))


@functools.cache
def _time_of_transform() -> float:
    """Return the time of a transform there and back over n log n, s, measured here and now."""
    values = np.random.default_rng(0).random((_TIMED, _TIMED))
    times = []
    for _ in range(_REPEATS):
        started = time.perf_counter()
        scipy.fft.irfft2(scipy.fft.rfft2(values), s=values.shape)
        times.append(time.perf_counter() - started)
    return min(times) / (values.size * math.log(values.size))
