"""The pressure next to a given field that carries a load within its bounds."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import Array

_ROUNDS = 200


def onto_load(values: Array, mean: float, limit: float) -> Array:
    """Project onto the pressures between zero and `limit` whose mean is `mean`.

    The nearest such field is clip(values - shift, 0, limit); the shift that meets the load is found
    by Newton's method, kept inside a bracket.

    Parameters
    ----------
    values
        Any finite field, shape (nx, ny).
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
    upper = float(values.max())
    # With this shift every cell carries at least the mean.
    lower = float(values.min()) - mean
    shift = min(max(float(np.add.reduce(values, axis=None)) / values.size - mean, lower), upper)
    for _ in range(_ROUNDS):
        pressure = np.clip(values - shift, 0.0, limit)
        excess = float(np.add.reduce(pressure, axis=None)) - load
        if excess > 0.0:
            lower = shift
        else:
            upper = shift
        free = int(np.count_nonzero((pressure > 0.0) & (pressure < limit)))
        trial = shift + excess / free if free else 0.5 * (lower + upper)
        if not lower < trial < upper:
            trial = 0.5 * (lower + upper)
        if abs(excess) <= 4e-16 * load or trial in (lower, upper):
            break
        shift = trial
    return pressure
