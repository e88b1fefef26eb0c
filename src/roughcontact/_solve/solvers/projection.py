"""Pressures and steps that keep a load and the bounds of the pressure."""

from __future__ import annotations

import math
from typing import TypeAlias

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, RealArray
from roughcontact._solve.solvers.passes import dot, limits_at, total
from roughcontact.errors.door import guarded

# Maximum rounds of Newton's method for the shift of all cells, and of released cells: it needs about five; bisection to
# the last bit would need 200.
_MAX_ROUNDS = 200
_MAX_RELEASED_ROUNDS = 60
# Error of the load, over the load, at which the search ends (2 eps), and maximum error by rounding.
_LOAD_EPSILON = 4e-16
LOAD_ROUNDING = 1e-13
# Distance from a bound of the cells near it, over the expected shift, and maximum fraction of near cells for a search
# among them alone. Half or double costs up to 5 % more CPU time, or saves 1 % (docs/studies/solver_constants.py).
_REACH_FACTOR = 4.0
_MAX_NEAR_FRACTION = 0.3
# Admissible error of the load in a step, over the change of pressure: each verification in float64 restores the load.
STEP_LOAD_ERROR = 1e-5


@guarded
def project_to_load(values: Array, mean: float, pressure_limit: float | Array) -> Array:
    """Return the nearest pressure between zero and a limit whose mean is given, shape (nx, ny).

    It is clip(values - shift, 0, limit); Newton's method within a bracket finds the shift.

    Parameters
    ----------
    values
        Any finite field, shape (nx, ny); the search is short if the shift is near zero.
    mean
        Mean pressure, above zero and at most the mean of the limit.
    pressure_limit
        Maximum pressure, a number or an array that broadcasts to (nx, ny); may be infinite.
    """
    load = mean * values.size
    limit = np.asarray(pressure_limit, like=values)
    # At the lower shift every cell carries its limit, or at least the mean; at the upper one no cell carries any.
    lower = float(values.min()) - mean if limit.size == 1 else float((values - limit).min())
    bracket = lower, float(values.max())
    pressure = values - _find_shift(values.ravel(), None, load, limit.ravel(), bracket, _LOAD_EPSILON * load)
    np.clip(pressure, 0.0, limit, out=pressure)
    # The shift has the rounding of the values, which may be far larger than the mean.
    return rescale_to_load(pressure, load, limit)


def project_to_weighted_load(values: Array, weights: RealArray, load: float, limit: Array, error: float) -> Array:
    """Return clip(values - shift * weights, 0, limit) with the shift for which the sum is `load`, shape (n,).

    Parameters
    ----------
    values, weights
        Any finite values, changed in place, and weights that are not negative, shape (n,); values of weight zero are
        only clipped.
    load
        Sum of the result.
    limit
        Maximum pressure, shape (1,) or (n,); may be infinite.
    error
        Admissible error of the sum.
    """
    error = max(error, _LOAD_EPSILON * load)
    shift = _find_shift_near_bounds(values, weights, load, limit, error)
    if shift is None:
        shift = _find_shift(values, weights, load, limit, (-math.inf, math.inf), error)
    values -= shift * weights
    return np.clip(values, 0.0, limit, out=values)


@guarded
def rescale_to_load(pressure: Array, load: float, pressure_limit: float | Array) -> Array:
    """Return the pressure with its unsaturated part scaled, in place, so that its sum is `load` to rounding.

    Where nothing is unsaturated, or the scaled part reaches the limit, the pressure is shifted instead.

    Parameters
    ----------
    pressure
        Pressure within its bounds, of any shape.
    load
        Sum of the pressures.
    pressure_limit
        Maximum pressure, a number or an array that broadcasts to the shape.
    """
    limit = np.asarray(pressure_limit, like=pressure)
    if np.isfinite(limit).any():
        elastic = pressure < limit
        # Sums with `where=` are not pairwise: on 1024 x 1024 cells they miss the load by more than its rounding.
        carried = float(np.add.reduce(np.where(elastic, pressure, 0.0), axis=None))
        saturated = float(np.add.reduce(np.where(elastic, 0.0, limit), axis=None))
        if carried > 0.0:
            np.multiply(pressure, max(load - saturated, 0.0) / carried, out=pressure, where=elastic)
            np.minimum(pressure, limit, out=pressure)
    else:
        carried = float(np.add.reduce(pressure, axis=None))
        if carried > 0.0:
            pressure *= load / carried
    if abs(float(np.add.reduce(pressure, axis=None)) - load) > LOAD_ROUNDING * load:
        flat = pressure.ravel().astype(np.float64)
        bound = limit.ravel()
        weights = _choose_shifted(flat, load, bound)
        pressure = project_to_weighted_load(flat, weights, load, bound, 0.0).reshape(pressure.shape)
    return pressure


def shift_to_load(values: Array, load: float, limit: Array, error: float) -> Array:
    """Return clip(values - shift, 0, limit) with the shift for which the sum is `load`, shape (n,).

    `limit` has shape () or (n,), and the sum an admissible error.
    """
    error = max(error, _LOAD_EPSILON * load)
    shift = _find_shift(values, None, load, limit.reshape(-1), (-math.inf, math.inf), error)
    return np.minimum(np.maximum(values - shift, 0.0), limit)


def _choose_shifted(pressure: Array, load: float, limit: Array) -> Array:
    """Return weights of one for the cells whose shift gives the load: elastic, in contact, or all."""
    contact = pressure > 0.0
    elastic = contact & (pressure < limit)
    for cells in (elastic, contact):
        others = float(np.add.reduce(np.where(cells, 0.0, pressure)))
        capacity = float(np.add.reduce(np.where(cells, limit, 0.0)))
        if others <= load < others + capacity:
            return cells.astype(np.float64)
    return np.ones_like(pressure)


def _find_shift_near_bounds(values: Array, weights: RealArray, load: float, limit: Array, error: float) -> float | None:
    """Return `_find_shift` from the cells near a bound alone; None if the shift moves others across a bound."""
    weight = float(np.add.reduce(weights, dtype=np.float64))
    if weight <= 0.0:
        return None
    excess = float(np.add.reduce(np.clip(values, 0.0, limit))) - load
    reach = _REACH_FACTOR * abs(excess) / weight
    swing = weights * weights.dtype.type(reach)
    # Near zero the precision of the weights is enough, and a uniform limit needs no more.
    near = values.astype(weights.dtype) < swing
    if np.isfinite(limit).any():
        # With too much load pressures fall: none reaches its limit from below, and the limit changes no bit.
        near |= values > (limit if excess > 0.0 else limit.astype(weights.dtype) - swing)
    if not 0 < np.count_nonzero(near) <= _MAX_NEAR_FRACTION * near.size:
        return None
    inside = values[near]
    slopes = weights[near].astype(np.float64)
    far = float(np.add.reduce(values)) - float(np.add.reduce(inside))
    far_weight = weight - float(np.add.reduce(slopes))
    bracket = (-reach, reach)
    shift = _find_shift(inside, slopes, load - far, limits_at(limit, near), bracket, error, far_weight)
    return shift if abs(shift) < 0.5 * reach else None


def _find_shift(
    values: Array,
    weights: RealArray | None,
    load: float,
    limit: Array,
    bracket: tuple[float, float],
    error: float,
    elsewhere: float = 0.0,
) -> float:
    """Return the shift for which clip(values - shift * weights, 0, limit) - shift * elsewhere sums to `load`."""
    lower, upper = bracket
    reach = abs(load) / values.size
    shift = min(max(0.0, lower), upper)
    capped = bool(np.isfinite(limit).any())
    for _ in range(_MAX_ROUNDS):
        carried = values - (shift if weights is None else shift * weights)
        np.maximum(carried, 0.0, out=carried)
        if capped:
            np.minimum(carried, limit, out=carried)
        excess = float(np.add.reduce(carried)) - shift * elsewhere - load
        contact = carried > 0.0
        moving = contact & (carried < limit) if capped else contact
        # Without weights, counting is twice as fast as summing ones.
        moved = np.count_nonzero(moving) if weights is None else np.add.reduce(weights, where=moving, dtype=float)
        slope = elsewhere + float(moved)
        if excess > 0.0:
            # The shift only grows from here: open cells stay open.
            lower = shift
            values = values[contact]
            limit = limits_at(limit, contact)
            weights = weights if weights is None else weights[contact]
        else:
            upper = shift
        trial = shift + excess / slope if slope > 0.0 else math.nan
        if not lower < trial < upper:
            trial = 0.5 * (lower + upper) if math.isfinite(upper - lower) else _extend(lower, upper, reach)
            reach *= 2.0
        if abs(excess) <= error or trial in (lower, upper):
            break
        shift = trial
    return shift


def _extend(lower: float, upper: float, reach: float) -> float:
    """Return a shift beyond the known bound, to find the other one."""
    if math.isfinite(lower):
        return lower + reach
    return upper - reach if math.isfinite(upper) else reach


@attrs.frozen(eq=False)
class ReleasedCells:
    """Active cells at a bound that may leave it, zero (low) or the limit (high), as positions in a vector."""

    low: IntArray
    high: IntArray

    def hold_outward(self, direction: RealArray) -> RealArray:
        """Return a direction, changed in place, in which no released cell crosses its bound."""
        direction[self.low] = np.maximum(direction[self.low], 0.0)
        direction[self.high] = np.minimum(direction[self.high], 0.0)
        return direction


@attrs.frozen
class LoadControl:
    """The load, the sum of the pressure over all cells, is given; the datum of the gap is free."""

    load: float

    def level(self, gap: RealArray, weights: RealArray) -> float:
        """Return the level of the gap of some cells, shape (n,): its weighted mean."""
        weight = total(weights)
        return dot(weights, gap) / weight if weight > 0.0 else 0.0

    def level_between(self, saturated: float, opened: float) -> float:
        """Return the level if no cell is elastic, from the largest saturated and the smallest open gap."""
        return 0.5 * (saturated + opened)

    def admissible(self, direction: RealArray, weights: RealArray, released: ReleasedCells) -> RealArray:
        """Return the nearest direction of sum zero, in the metric 1/w, in which no released cell crosses its bound."""
        change = total(direction)
        weight = total(weights)
        shift = change / weight
        cells = np.concatenate((released.low, released.high))
        values = direction[cells].astype(np.float64)
        slopes = weights[cells].astype(np.float64)
        inward = np.concatenate((np.ones_like(released.low, dtype=float), -np.ones_like(released.high, dtype=float)))
        held = np.zeros_like(cells, dtype=bool)
        for _ in range(_MAX_RELEASED_ROUNDS):
            before = held
            held = inward * (values - shift * slopes) < 0.0
            slope = weight - float(np.add.reduce(slopes[held]))
            if slope <= 0.0 or np.array_equal(before, held):
                break
            shift = (change - float(np.add.reduce(values[held]))) / slope
        return released.hold_outward(direction - np.float32(shift) * weights)

    def feasible(self, trial: Array, before: Array, weights: RealArray, limit: Array) -> Array:
        """Return the pressure near `trial`, in its place, within the bounds, with the load of `before`, shape (n,)."""
        step = trial - before
        change = float(np.add.reduce(np.abs(step, out=step)))
        del step
        return project_to_weighted_load(trial, weights, float(np.add.reduce(before)), limit, STEP_LOAD_ERROR * change)

    def restore(self, pressure: Array, limit: Array) -> Array:
        """Return the pressure, changed in place, without the rounding of its load."""
        return rescale_to_load(pressure, self.load, limit)


class ApproachControl:
    """The approach is given: it is the datum of the gap, and the load is free; see `LoadControl`."""

    def level(self, gap: RealArray, weights: RealArray) -> float:
        """Return zero."""
        return 0.0

    def level_between(self, saturated: float, opened: float) -> float:
        """Return zero."""
        return 0.0

    def admissible(self, direction: RealArray, weights: RealArray, released: ReleasedCells) -> RealArray:
        """Return the nearest direction in which no released cell crosses its bound."""
        return released.hold_outward(direction.copy())

    def feasible(self, trial: Array, before: Array, weights: RealArray, limit: Array) -> Array:
        """Return the trial, clipped in its place."""
        return np.clip(trial, 0.0, limit, out=trial)

    def restore(self, pressure: Array, limit: Array) -> Array:
        """Return the pressure as it is."""
        return pressure


Control: TypeAlias = LoadControl | ApproachControl
