"""The pressure next to a given field that carries a load within its bounds."""

from __future__ import annotations

import math

import numpy as np

from roughcontact.checks import Array

# Newton needs a handful of rounds; bisection to the last bit would need this many.
_ROUNDS = 200
_EXACT = 4e-16


def onto_load(values: Array, mean: float, limit: float) -> Array:
    """Project onto the pressures between zero and `limit` whose mean is `mean`.

    The nearest such field is clip(values - shift, 0, limit); the shift that meets the load is found
    by Newton's method, kept inside a bracket.

    Parameters
    ----------
    values
        Any finite field, shape (nx, ny); the search is short if the shift is near zero.
    mean
        Mean pressure, above zero and at most `limit`.
    limit
        Greatest pressure; may be infinite.

    Returns
    -------
    Array
        The pressure, shape (nx, ny).
    """
    load = mean * values.size
    # With the lower shift every cell carries at least the mean, with the upper one none carries any.
    lower, upper = float(values.min()) - mean, float(values.max())
    shift = min(max(0.0, lower), upper)
    candidates = values.ravel()
    for _ in range(_ROUNDS):
        carried = np.clip(candidates - shift, 0.0, limit)
        excess = float(np.add.reduce(carried)) - load
        inside = int(np.count_nonzero((carried > 0.0) & (carried < limit)))
        if excess > 0.0:
            # Cells that are open now stay so: the shift only grows from here.
            lower, candidates = shift, candidates[carried > 0.0]
        else:
            upper = shift
        trial = shift + excess / inside if inside else 0.5 * (lower + upper)
        if not lower < trial < upper:
            trial = 0.5 * (lower + upper)
        if abs(excess) <= _EXACT * load or trial in (lower, upper):
            break
        shift = trial
    pressure = values - shift
    np.clip(pressure, 0.0, limit, out=pressure)
    # The shift is only known to the last digit of the values, which may be far greater than the mean.
    free = pressure < limit
    bearing = float(np.add.reduce(pressure, axis=None, where=free))
    if bearing > 0.0:
        rest = load - limit * (values.size - int(np.count_nonzero(free))) if math.isfinite(limit) else load
        np.multiply(pressure, max(rest, 0.0) / bearing, out=pressure, where=free)
        np.minimum(pressure, limit, out=pressure)
    return pressure
