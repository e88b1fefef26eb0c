"""What is given, the load or the approach, and what it demands of every step."""

from __future__ import annotations

import abc

import attrs
import numpy as np

from roughcontact.checks import Array, Mask, RealArray
from roughcontact.solvers.conjugate.active import dot, total
from roughcontact.solvers.projection import onto_weighted_load, restored

_ROUNDS = 60
_BALANCED = 1e-7
# Share of a step that may miss the load: every proof restores it.
_MISSED = 1e-5


class Control(abc.ABC):
    """The constraint that holds besides the bounds of the pressure."""

    @abc.abstractmethod
    def level(self, gap: RealArray, weights: RealArray) -> float:
        """Return the level that the gap of some cells is to have, shape (n,) both."""

    @abc.abstractmethod
    def admissible(self, direction: RealArray, weights: RealArray, low: Mask | None, high: Mask | None) -> RealArray:
        """Return the nearest direction that keeps the constraint and leaves no bound outward.

        `low` and `high` mark the cells, of shape (n,), that just leave zero and the limit.
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

    def admissible(self, direction: RealArray, weights: RealArray, low: Mask | None, high: Mask | None) -> RealArray:
        """Project onto sum zero and the half-lines of released cells, in the metric 1/w; see `Control`."""
        weight = total(weights)
        shift = total(direction) / weight
        moved = direction - np.float32(shift) * weights
        if low is None and high is None:
            return moved
        balanced = _BALANCED * total(np.abs(moved))
        for _ in range(_ROUNDS):
            held = _outward(moved, low, high)
            moved[held] = 0.0
            excess, slope = total(moved), weight - float(np.add.reduce(weights, where=held, dtype=np.float64))
            if slope <= 0.0 or abs(excess) <= balanced:
                break
            shift += excess / slope
            moved = direction - np.float32(shift) * weights
        return moved

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

    def admissible(self, direction: RealArray, weights: RealArray, low: Mask | None, high: Mask | None) -> RealArray:
        """Hold released cells that would go back out; see `Control.admissible`."""
        if low is None and high is None:
            return direction
        return np.where(_outward(direction, low, high), np.float32(0.0), direction)

    def feasible(self, trial: Array, before: Array, weights: RealArray, limit: float | Array) -> Array:
        """Clip; see `Control.feasible`."""
        return np.clip(trial, 0.0, limit)


def exactly(pressure: Array, control: Control, limit: float | Array) -> Array:
    """Return the pressure with the rounding of its load taken away."""
    return restored(pressure, control.load, limit) if isinstance(control, LoadControl) else pressure


def _outward(direction: RealArray, low: Mask | None, high: Mask | None) -> Mask:
    held = np.zeros(direction.shape, dtype=bool)
    if low is not None:
        held |= low & (direction < 0.0)
    if high is not None:
        held |= high & (direction > 0.0)
    return held
