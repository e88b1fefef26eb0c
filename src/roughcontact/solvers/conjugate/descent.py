"""The descent in float32: one convolution an iteration."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact.checks import Array, Mask, RealArray
from roughcontact.convolvers import PlannedConvolution
from roughcontact.solvers.conjugate.active import Active, Cells, active_set, dot
from roughcontact.solvers.conjugate.control import Control
from roughcontact.solvers.conjugate.preconditioner import Preconditioner

# Step lengths: the first guess, the greatest, and the one after a fall back to the plain gradient.
_FIRST, _GREATEST, _CAREFUL = 0.8, 1.5, 0.3
_BACKTRACKS = 40
# A clipped step is kept whole if the energy still falls most of the way, shortened if it falls at all.
_WHOLE, _SHORTENED = 0.8, 0.1
_NONE: Cells = np.zeros(0, dtype=np.intp)
_NOTHING: RealArray = np.zeros(0, dtype=np.float32)


@attrs.frozen(eq=False)
class Released:
    """The active cells that just leave a bound, by their places in a vector.

    Attributes
    ----------
    low, high
        Those that leave zero and those that leave the limit.
    """

    low: Cells
    high: Cells


@attrs.frozen(eq=False)
class Touching:
    """A set of active cells and what is known on them, as vectors.

    Attributes
    ----------
    active
        The set.
    pressure, gap, weights
        Pressure, gap from any datum and flat-punch weights.
    """

    active: Active
    pressure: Array
    gap: RealArray
    weights: RealArray


class Descent:
    """Lowers the energy p.Kp/2 + h.p within the bounds by preconditioned conjugate gradients.

    The step length is guessed, the displacement that the step causes is computed once, and the step
    is corrected with it: exactly along the step, because the energy is quadratic.

    Parameters
    ----------
    convolution
        Displacement from pressure.
    preconditioner
        The inverse kernel on the active cells.
    control
        What is given besides the bounds.
    limit
        Greatest pressure, a number or a flat array.
    """

    def __init__(
        self,
        convolution: PlannedConvolution,
        preconditioner: Preconditioner,
        control: Control,
        limit: float | Array,
    ) -> None:
        self._convolution = convolution
        self._preconditioner = preconditioner
        self._control = control
        self._limit = limit
        self._capped = bool(np.isfinite(limit).any())
        self._shape = convolution.scene.grid.shape
        self._length = _FIRST
        self._step: RealArray | None = None
        self._change: RealArray | None = None
        self._curvature = 1.0
        self.products = 0
        self.met_limit = False
        self.pressure: Array = np.zeros(0)
        self.stop()

    def start(self, pressure: Array, gap: RealArray) -> None:
        """Go on from a pressure with its gap, both flat; the gap is float32 and is kept up to date."""
        self.pressure, self.gap = pressure, gap
        active = active_set(self._free(pressure, self._limit))
        weights = active.take(self._preconditioner.field)
        self._touching = Touching(active, active.take(pressure), active.take(gap), weights)

    def stop(self) -> None:
        """Let go of what the next start will bring anew."""
        self.gap = _NOTHING
        self._touching = Touching(active_set(np.zeros(0, dtype=bool)), np.zeros(0), _NOTHING, _NOTHING)

    def iterate(self) -> bool:
        """Make one step; return whether the energy fell."""
        active, released = self._active()
        if active.count == 0:
            return False
        weights = self._preconditioner.weights(active)
        at = Touching(active, active.take(self.pressure), active.take(self.gap), weights)
        residual = np.float32(self._control.level(at.gap, weights)) * active.ones - at.gap
        direction = self._direction(at, released, residual)
        return direction is not None and self._move(at, residual, direction)

    def error(self) -> float:
        """Return the violation of the descent's own gap, as `Conditions` would measure it, not scaled."""
        at = self._touching
        limit = self._limits(at.active)
        bearing = np.where(at.pressure < limit, at.pressure, 0.0) if self._capped else at.pressure
        level = self._control.level(at.gap, bearing)
        gap = at.gap - np.float32(level)
        if self._capped:
            np.maximum(gap, 0.0, out=gap, where=at.pressure >= limit)
        load = float(np.add.reduce(at.pressure))
        opened = dot(at.pressure, np.abs(gap, out=gap)) / load if load > 0.0 else 0.0
        # Saturated cells may overlap.
        outside = self.pressure < self._limit if self._capped else True
        deepest = float(np.minimum.reduce(self.gap, where=outside, initial=np.inf))
        return max(opened, level - deepest)

    def _active(self) -> tuple[Active, Released]:
        """Return the cells inside the bounds and those at one that the gap draws inside."""
        at = self._touching
        inside = self._free(at.pressure, self._limits(at.active))
        level = np.float32(self._control.level(at.gap, at.weights * inside))
        bearing = self.pressure > 0.0
        low = self.gap < level
        np.greater(low, bearing, out=low)
        if not self._capped:
            active = active_set(bearing | low)
            return active, Released(active.places(low), _NONE)
        free = self._free(self.pressure, self._limit)
        high = self.gap > level
        high &= bearing
        np.greater(high, free, out=high)
        active = active_set(free | low | high)
        return active, Released(active.places(low), active.places(high))

    def _free(self, pressure: Array, limit: float | Array) -> Mask:
        """Mark what lies strictly inside the bounds."""
        free = pressure > 0.0
        if self._capped:
            free &= pressure < limit
        return free

    def _limits(self, active: Active) -> float | Array:
        return self._limit if isinstance(self._limit, float) else active.take(self._limit)

    def _direction(self, at: Touching, released: Released, residual: RealArray) -> RealArray | None:
        """Return the first admissible descent of: conjugate, preconditioned, plain gradient."""
        image = self._preconditioner.apply(at.active, at.weights, residual)
        for candidate in (self._conjugate(image, at.active), image, at.weights * residual):
            direction = self._control.admissible(candidate, at.weights, released.low, released.high)
            if dot(residual, direction) > 0.0:
                return direction
            self._length = _CAREFUL
        return None

    def _conjugate(self, image: RealArray, active: Active) -> RealArray:
        if self._step is None or self._change is None:
            return image
        share = -dot(image, active.take(self._change)) / self._curvature
        return image + np.float32(share) * active.take(self._step) if share > 0.0 else image

    def _move(self, at: Touching, residual: RealArray, direction: RealArray) -> bool:
        limit = self._limits(at.active)
        # The last step is no longer needed, and memory is widest here.
        self._step = self._change = None
        for _ in range(_BACKTRACKS):
            trial = at.pressure + np.float32(self._length) * direction
            clipped = self._outside(trial, limit)
            if clipped:
                trial = self._control.feasible(trial, at.pressure, at.weights, limit)
            step = (trial - at.pressure).astype(np.float32)
            field = at.active.put(step)
            change = self._convolution.apply(field.reshape(self._shape)).ravel()
            self.products += 1
            response = at.active.take(change)
            curvature = dot(step, response)
            if not math.isfinite(curvature):
                return False
            part = dot(residual, step) / curvature if curvature > 0.0 else 0.0
            taken, moved = self._taken(part, at.pressure, trial, limit, clipped=clipped)
            if taken > 0.0:
                at.active.store(self.pressure, moved)
                change *= np.float32(taken)
                self.gap += change
                self._step, self._change, self._curvature = field, change, taken * curvature
                self._touching = Touching(at.active, moved, at.active.take(self.gap), at.weights)
                return True
            self._length *= _CAREFUL
        return False

    def _taken(
        self, part: float, before: Array, trial: Array, limit: float | Array, *, clipped: bool
    ) -> tuple[float, Array]:
        """Return the part of the step to be taken, zero for none, and where it leads; set the length of the next.

        `part` is where along the step the energy is least.
        """
        if not clipped:
            self._length = min(_GREATEST, self._length * min(max(part, 0.25), 4.0))
            whole = _between(before, trial, part)
            if not self._outside(whole, limit):
                return part, whole
            part = min(part, 1.0)
        elif part > _WHOLE:
            self._length = min(_GREATEST, self._length * min(max(part, 0.8), 4.0))
            return 1.0, trial
        elif part > _SHORTENED:
            self._length *= max(part, 0.5)
        else:
            return 0.0, before
        shortened = _between(before, trial, part)
        return part, np.clip(shortened, 0.0, limit, out=shortened)

    def _outside(self, pressure: Array, limit: float | Array) -> bool:
        above = self._capped and bool((pressure > limit).any())
        self.met_limit |= above
        return above or bool(pressure.min() < 0.0)


def _between(before: Array, trial: Array, part: float) -> Array:
    """Return before + part * (trial - before), with one array alive."""
    point = trial - before
    point *= part
    point += before
    return point
