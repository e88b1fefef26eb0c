"""What is given, the load or the approach, and what it demands of every step."""

from __future__ import annotations

import abc

import attrs
import numpy as np

from roughcontact.checks import Array, RealArray
from roughcontact.solvers.conjugate.active import Cells, dot, total
from roughcontact.solvers.projection import onto_weighted_load, restored

_ROUNDS = 60
# Share of a step that may miss the load: every proof restores it.
_MISSED = 1e-5


class Control(abc.ABC):
    """The constraint that holds besides the bounds of the pressure."""

    @abc.abstractmethod
    def level(self, gap: RealArray, weights: RealArray) -> float:
        """Return the level that the gap of some cells is to have, shape (n,) both."""

    @abc.abstractmethod
    def admissible(self, direction: RealArray, weights: RealArray, low: Cells, high: Cells) -> RealArray:
        """Return the nearest direction that keeps the constraint and leaves no bound outward.

        `low` and `high` are the places of the cells that just leave zero and the limit.
        """

    @abc.abstractmethod
    def feasible(self, trial: Array, before: Array, weights: RealArray, limit: float | Array) -> Array:
        """Return the nearest pressure to `trial` within the bounds that keeps the constraint, shape (n,)."""


@attrs.frozen
class LoadControl(Control):
    """The load is given, and the level of the gap is free.

    Parameters
    ----------
    load
        Sum of the pressure over all cells.
    """

    load: float

    def level(self, gap: RealArray, weights: RealArray) -> float:
        """Return the weighted mean; see `Control.level`."""
        weight = total(weights)
        return dot(weights, gap) / weight if weight > 0.0 else 0.0

    def admissible(self, direction: RealArray, weights: RealArray, low: Cells, high: Cells) -> RealArray:
        """Project onto sum zero and the half-lines of released cells, in the metric 1/w; see `Control`."""
        moved = direction - np.float32(self._shift(direction, weights, low, high)) * weights
        return _inward(moved, low, high)

    def _shift(self, direction: RealArray, weights: RealArray, low: Cells, high: Cells) -> float:
        """Return the multiple of the weights to be taken from a direction, by Newton's method."""
        change, weight = total(direction), total(weights)
        shift = change / weight
        released = np.concatenate((low, high))
        values, slopes = direction[released].astype(np.float64), weights[released].astype(np.float64)
        inward = np.repeat((1.0, -1.0), (low.size, high.size))
        held = np.zeros(released.size, dtype=bool)
        for _ in range(_ROUNDS):
            before, held = held, inward * (values - shift * slopes) < 0.0
            slope = weight - float(np.add.reduce(slopes[held]))
            if slope <= 0.0 or np.array_equal(before, held):
                break
            shift = (change - float(np.add.reduce(values[held]))) / slope
        return shift

    def feasible(self, trial: Array, before: Array, weights: RealArray, limit: float | Array) -> Array:
        """Clip, and spread what is missing by the weights; see `Control.feasible`."""
        change = float(np.add.reduce(np.abs(trial - before)))
        return onto_weighted_load(trial, weights, float(np.add.reduce(before)), limit, _MISSED * change)


@attrs.frozen
class ApproachControl(Control):
    """The approach is given: the gap counts from it, and any load will do."""

    def level(self, gap: RealArray, weights: RealArray) -> float:
        """Return zero; see `Control.level`."""
        return 0.0

    def admissible(self, direction: RealArray, weights: RealArray, low: Cells, high: Cells) -> RealArray:
        """Hold released cells that would go back out; see `Control.admissible`."""
        return _inward(direction.copy(), low, high)

    def feasible(self, trial: Array, before: Array, weights: RealArray, limit: float | Array) -> Array:
        """Clip; see `Control.feasible`."""
        return np.clip(trial, 0.0, limit)


def exactly(pressure: Array, control: Control, limit: float | Array) -> Array:
    """Return the pressure with the rounding of its load taken away, in place."""
    return restored(pressure, control.load, limit) if isinstance(control, LoadControl) else pressure


def _inward(direction: RealArray, low: Cells, high: Cells) -> RealArray:
    """Hold the released cells that would go back out, in place."""
    direction[low] = np.maximum(direction[low], 0.0)
    direction[high] = np.minimum(direction[high], 0.0)
    return direction
