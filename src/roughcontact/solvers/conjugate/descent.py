"""The descent in float32: one convolution an iteration."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact.checks import Array, Mask, RealArray
from roughcontact.convolvers import PlannedConvolution
from roughcontact.solvers.conjugate.active import Active, active_set, dot
from roughcontact.solvers.conjugate.control import Control
from roughcontact.solvers.conjugate.preconditioner import Preconditioner

# Step lengths: the first guess, the greatest, and the one after a fall back to the plain gradient.
_FIRST, _GREATEST, _CAREFUL = 0.8, 1.5, 0.3
_BACKTRACKS = 40
# A clipped step is kept whole if the energy still falls most of the way, shortened if it falls at all.
_WHOLE, _SHORTENED = 0.85, 0.1


@attrs.frozen(eq=False)
class Released:
    """Marks of the active cells that just leave a bound, as vectors; None if none does.

    Attributes
    ----------
    low, high
        Those that leave zero and those that leave the limit.
    """

    low: Mask | None
    high: Mask | None


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
        self._change: RealArray = np.zeros(0, dtype=np.float32)
        self._curvature = 1.0
        self.products = 0
        self.pressure: Array = np.zeros(0)
        self.gap: RealArray = np.zeros(0, dtype=np.float32)
        self.active: Active = active_set(np.zeros(0, dtype=bool))

    def start(self, pressure: Array, gap: RealArray) -> None:
        """Go on from a pressure with its gap, both flat; the gap is float32 and is kept up to date."""
        self.pressure, self.gap = pressure, gap

    def iterate(self) -> bool:
        """Make one step; return whether the energy fell."""
        active, released = self._active()
        if active.count == 0:
            return False
        weights = self._preconditioner.weights(active)
        gap = active.take(self.gap)
        residual = np.float32(self._control.level(gap, weights)) * active.ones - gap
        direction = self._direction(active, released, weights, residual)
        if direction is None:
            return False
        self.active = active
        return self._move(active, weights, residual, direction)

    def error(self) -> float:
        """Return the violation of the descent's own gap, as `Conditions` would measure it, not scaled."""
        pressure, gap = self.active.take(self.pressure), self.active.take(self.gap)
        limit = self._limits(self.active)
        bearing = np.where(pressure < limit, pressure, 0.0) if self._capped else pressure
        level = self._control.level(gap, bearing)
        gap = gap - np.float32(level)
        if self._capped:
            np.maximum(gap, 0.0, out=gap, where=pressure >= limit)
        load = float(np.add.reduce(pressure))
        opened = dot(pressure, np.abs(gap)) / load if load > 0.0 else 0.0
        outside = self.pressure < self._limit if self._capped else True
        deepest = float(np.minimum.reduce(self.gap, where=outside, initial=np.inf))
        return max(opened, level - deepest)

    def _active(self) -> tuple[Active, Released]:
        """Return the cells inside the bounds and those at one that the gap draws inside."""
        bearing = self.pressure > 0.0
        free = bearing & (self.pressure < self._limit) if self._capped else bearing
        inside = active_set(free)
        level = np.float32(self._control.level(inside.take(self.gap), inside.take(self._preconditioner.field)))
        low = self.gap < level
        low &= ~bearing
        mask = free | low
        high = None
        if self._capped:
            high = (self.gap > level) & bearing & ~free
            mask |= high
        active = active_set(mask)
        return active, Released(_some(low, active), None if high is None else _some(high, active))

    def _limits(self, active: Active) -> float | Array:
        return self._limit if isinstance(self._limit, float) else active.take(self._limit)

    def _direction(
        self, active: Active, released: Released, weights: RealArray, residual: RealArray
    ) -> RealArray | None:
        """Return the first admissible descent of: conjugate, preconditioned, plain gradient."""
        image = self._preconditioner.apply(active, weights, residual)
        for candidate in (self._conjugate(image, active), image, weights * residual):
            direction = self._control.admissible(candidate, weights, released.low, released.high)
            if dot(residual, direction) > 0.0:
                return direction
            self._length = _CAREFUL
        return None

    def _conjugate(self, image: RealArray, active: Active) -> RealArray:
        if self._step is None:
            return image
        share = -dot(image, active.take(self._change)) / self._curvature
        return image + np.float32(share) * active.take(self._step) if share > 0.0 else image

    def _move(self, active: Active, weights: RealArray, residual: RealArray, direction: RealArray) -> bool:
        before = active.take(self.pressure)
        limit = self._limits(active)
        for _ in range(_BACKTRACKS):
            trial = before + self._length * direction
            clipped = bool(trial.min() < 0.0 or (self._capped and (trial > limit).any()))
            if clipped:
                trial = self._control.feasible(trial, before, weights, limit)
            step = (trial - before).astype(np.float32)
            field = active.put(step)
            change = self._convolution.apply(field.reshape(self._shape)).ravel()
            self.products += 1
            curvature = dot(step, active.take(change))
            if not math.isfinite(curvature):
                return False
            part = dot(residual, step) / curvature if curvature > 0.0 else 0.0
            taken = self._taken(part, clipped, before, step, limit)
            if taken > 0.0:
                moved = trial if taken == 1.0 else np.clip(before + taken * step, 0.0, limit)
                active.store(self.pressure, moved)
                self._step, self._change, self._curvature = field, change, curvature
                self.gap += np.float32(taken) * change
                return True
            self._length *= _CAREFUL
        return False

    def _taken(self, part: float, clipped: bool, before: Array, step: RealArray, limit: float | Array) -> float:
        """Return the part of the step to be taken, zero for none, and set the length of the next.

        `part` is where along the step the energy is least.
        """
        if not clipped:
            self._length = min(_GREATEST, self._length * min(max(part, 0.25), 4.0))
            whole = before + part * step
            feasible = whole.min() >= 0.0 and not (self._capped and (whole > limit).any())
            return part if feasible else min(part, 1.0)
        if part > _WHOLE:
            self._length = min(_GREATEST, self._length * min(max(part, 0.8), 1.5))
            return 1.0
        if part > _SHORTENED:
            self._length *= max(part, 0.5)
            return part
        return 0.0


def _some(mask: Mask, active: Active) -> Mask | None:
    return active.take(mask) if mask.any() else None
