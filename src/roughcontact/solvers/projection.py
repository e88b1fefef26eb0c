"""Pressures that carry a load within their bounds."""

from __future__ import annotations

import math

import numpy as np

from roughcontact.checks import Array, RealArray

# Newton needs a handful of rounds; bisection to the last bit would need this many.
_ROUNDS = 200
_EXACT = 4e-16
# A load that is missed by more than this is not rounding.
_LOST = 1e-13
# Cells within this multiple of the first shift of a bound are near it.
_REACH = 4.0
# Above this share of near cells nothing is gained by setting them apart.
_FEW = 0.3


def onto_load(values: Array, mean: float, limit: float | Array) -> Array:
    """Project onto the pressures between zero and `limit` whose mean is `mean`.

    The nearest such field is clip(values - shift, 0, limit); the shift that meets the load is found
    by Newton's method, kept inside a bracket.

    Parameters
    ----------
    values
        Any finite field, shape (nx, ny); the search is short if the shift is near zero.
    mean
        Mean pressure, above zero and at most the mean of the limit.
    limit
        Greatest pressure, a number or an array of shape (nx, ny); may be infinite.

    Returns
    -------
    Array
        The pressure, shape (nx, ny).
    """
    load = mean * values.size
    if isinstance(limit, float):
        # With the lower shift every cell carries at least the mean, with the upper one none carries any.
        bracket = float(values.min()) - mean, float(values.max())
        shift = _shift(values.ravel(), None, load, limit, bracket, _EXACT * load)
    else:
        bracket = float((values - limit).min()), float(values.max())
        shift = _shift(values.ravel(), None, load, limit.ravel(), bracket, _EXACT * load)
    pressure = values - shift
    np.clip(pressure, 0.0, limit, out=pressure)
    # The shift is only known to the last digit of the values, which may be far greater than the mean.
    return restored(pressure, load, limit)


def onto_weighted_load(values: Array, weights: RealArray, load: float, limit: float | Array, error: float) -> Array:
    """Return clip(values - shift * weights, 0, limit) with the shift that gives the sum `load`.

    Parameters
    ----------
    values, weights
        Any finite values and weights that are not negative, shape (n,); what weighs nothing is only clipped.
    load
        Sum of the result.
    limit
        Greatest pressure, a number or an array of shape (n,); may be infinite.
    error
        How far the sum may miss the load.
    """
    error = max(error, _EXACT * load)
    shift = _small_shift(values, weights, load, limit, error)
    if shift is None:
        shift = _shift(values, weights, load, limit, (-math.inf, math.inf), error)
    return np.clip(values - shift * weights, 0.0, limit)


def restored(pressure: Array, load: float, limit: float | Array) -> Array:
    """Return the pressure with its unsaturated part scaled, in place, so that the sum is `load`, to rounding.

    Where that cannot be, for nothing is unsaturated, the pressure is shifted instead.
    """
    free = pressure < limit
    bearing = float(np.add.reduce(pressure, axis=None, where=free))
    saturated = float(np.add.reduce(pressure, axis=None, where=~free))
    if bearing > 0.0:
        np.multiply(pressure, max(load - saturated, 0.0) / bearing, out=pressure, where=free)
        np.minimum(pressure, limit, out=pressure)
    if abs(float(np.add.reduce(pressure, axis=None)) - load) > _LOST * load:
        flat, bound = pressure.ravel(), limit if isinstance(limit, float) else limit.ravel()
        touching = flat > 0.0
        capacity = float(np.sum(np.broadcast_to(bound, flat.shape), where=touching))
        weights = touching.astype(np.float64) if capacity > load else np.ones_like(flat)
        pressure = onto_weighted_load(flat, weights, load, bound, 0.0).reshape(pressure.shape)
    return pressure


def _small_shift(values: Array, weights: RealArray, load: float, limit: float | Array, error: float) -> float | None:
    """Return the same as `_shift`, from the cells near a bound alone, if it moves no others past one."""
    weight = float(np.add.reduce(weights, dtype=np.float64))
    if weight <= 0.0:
        return None
    excess = float(np.add.reduce(np.clip(values, 0.0, limit))) - load
    reach = _REACH * abs(excess) / weight
    swing = weights * weights.dtype.type(reach)
    # The precision of the weights tells near zero from far, not near the limit.
    near = values.astype(weights.dtype) < swing
    if np.isfinite(limit).any():
        near |= values > limit - swing
    if not 0 < np.count_nonzero(near) <= _FEW * near.size:
        return None
    inside, slopes = values[near], weights[near].astype(np.float64)
    bounds = limit if isinstance(limit, float) else limit[near]
    far = float(np.add.reduce(values)) - float(np.add.reduce(inside))
    shift = _shift(inside, slopes, load - far, bounds, (-reach, reach), error, weight - float(np.add.reduce(slopes)))
    return shift if abs(shift) < 0.5 * reach else None


def _shift(
    values: Array,
    weights: RealArray | None,
    load: float,
    limit: float | Array,
    bracket: tuple[float, float],
    error: float,
    elsewhere: float = 0.0,
) -> float:
    """Return the shift at which clip(values - shift * weights, 0, limit) - shift * elsewhere sums to `load`."""
    lower, upper = bracket
    reach = abs(load) / values.size
    shift = min(max(0.0, lower), upper)
    for _ in range(_ROUNDS):
        carried = values - (shift if weights is None else shift * weights)
        np.clip(carried, 0.0, limit, out=carried)
        excess = float(np.add.reduce(carried)) - shift * elsewhere - load
        inside = carried > 0.0
        moving = inside & (carried < limit)
        slope = elsewhere + float(
            np.count_nonzero(moving) if weights is None else np.add.reduce(weights, where=moving, dtype=float)
        )
        if excess > 0.0:
            # Cells that are open now stay so: the shift only grows from here.
            lower, values = shift, values[inside]
            weights = weights if weights is None else weights[inside]
            limit = limit if isinstance(limit, float) else limit[inside]
        else:
            upper = shift
        trial = shift + excess / slope if slope > 0.0 else math.nan
        if not lower < trial < upper:
            trial = 0.5 * (lower + upper) if math.isfinite(upper - lower) else _further(lower, upper, reach)
            reach *= 2.0
        if abs(excess) <= error or trial in (lower, upper):
            break
        shift = trial
    return shift


def _further(lower: float, upper: float, reach: float) -> float:
    """Return a shift beyond the bound that is known, to find the other one."""
    if math.isfinite(lower):
        return lower + reach
    return upper - reach if math.isfinite(upper) else reach
