"""The descent in float32: one convolution an iteration."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array, Mask, RealArray
from roughcontact.convolvers import PlannedConvolution
from roughcontact.solvers.conjugate.control import Control
from roughcontact.solvers.conjugate.longwaves import Cells
from roughcontact.solvers.conjugate.preconditioner import Preconditioner, spread

# Step lengths: the first guess, the greatest, and the one after a fall back to the plain gradient.
_FIRST, _GREATEST, _CAREFUL = 0.8, 1.5, 0.3
_BACKTRACKS = 40
# A clipped step is kept whole if the energy still falls most of the way, shortened if it falls at all.
_WHOLE, _SHORTENED = 0.85, 0.1


@attrs.frozen(eq=False)
class Active:
    """The cells whose pressure may change: inside the bounds, or at one and drawn inside by the gap.

    Attributes
    ----------
    mask
        All cells, flat.
    cells
        Flat indices of the active ones, shape (n,).
    low, high
        Of the active cells, those that leave zero and those that leave the limit; None if none does.
    """

    mask: Mask
    cells: Cells
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
        self.cells: Cells = np.zeros(0, dtype=np.intp)

    def start(self, pressure: Array, gap: RealArray) -> None:
        """Go on from a pressure with its gap, both flat; the gap is float32 and is kept up to date."""
        self.pressure, self.gap = pressure, gap

    def iterate(self) -> bool:
        """Make one step; return whether the energy fell."""
        active = self._active()
        if active.cells.size == 0:
            return False
        weights = self._preconditioner.weights(active.mask, active.cells)
        gap = self.gap[active.cells]
        residual = np.float32(self._control.level(gap, weights)) - gap
        direction = self._direction(active, weights, residual)
        if direction is None:
            return False
        self.cells = active.cells
        return self._move(active.cells, weights, residual, direction)

    def error(self) -> float:
        """Return the violation of the descent's own gap, as `Conditions` would measure it, not scaled."""
        pressure, gap = self.pressure[self.cells], self.gap[self.cells]
        limit = self._limit if isinstance(self._limit, float) else self._limit[self.cells]
        free = np.where(pressure < limit, pressure, 0.0) if self._capped else pressure
        level = self._control.level(gap, free)
        gap = np.abs(np.where(pressure < limit, gap - level, np.maximum(gap - level, 0.0)))
        load = float(np.add.reduce(pressure))
        opened = float(np.einsum("i,i->", pressure, gap)) / load if load > 0.0 else 0.0
        outside = self.pressure < self._limit if self._capped else True
        deepest = float(np.minimum.reduce(self.gap, where=outside, initial=np.inf))
        return max(opened, level - deepest)

    def _active(self) -> Active:
        bearing = self.pressure > 0.0
        free = bearing & (self.pressure < self._limit) if self._capped else bearing
        inside = np.flatnonzero(free)
        level = np.float32(self._control.level(self.gap[inside], self._preconditioner.field[inside]))
        released = self.gap < level
        released &= ~bearing
        mask = free | released
        overloaded = None
        if self._capped:
            overloaded = (self.gap > level) & bearing & ~free
            mask |= overloaded
        cells = np.flatnonzero(mask)
        return Active(mask, cells, _some(released, cells), None if overloaded is None else _some(overloaded, cells))

    def _direction(self, active: Active, weights: RealArray, residual: RealArray) -> RealArray | None:
        """Return the first admissible descent of: conjugate, preconditioned, plain gradient."""
        image = self._preconditioner.apply(active.cells, weights, residual)
        for candidate in (self._conjugate(image, active.cells), image, weights * residual):
            direction = self._control.admissible(candidate, weights, active.low, active.high)
            if _dot(residual, direction) > 0.0:
                return direction
            self._length = _CAREFUL
        return None

    def _conjugate(self, image: RealArray, cells: Cells) -> RealArray:
        if self._step is None:
            return image
        share = -_dot(image, self._change[cells]) / self._curvature
        return image + np.float32(max(0.0, share)) * self._step[cells] if share > 0.0 else image

    def _move(self, cells: Cells, weights: RealArray, residual: RealArray, direction: RealArray) -> bool:
        before = self.pressure[cells]
        limit = self._limit if isinstance(self._limit, float) else self._limit[cells]
        for _ in range(_BACKTRACKS):
            trial = before + self._length * direction
            clipped = bool(trial.min() < 0.0 or (self._capped and (trial > limit).any()))
            if clipped:
                trial = self._control.feasible(trial, before, weights, limit)
            step = (trial - before).astype(np.float32)
            field = spread(cells, step, self._shape)
            change = self._convolution.apply(field).ravel()
            self.products += 1
            curvature = _dot(step, change[cells])
            part = _dot(residual, step) / curvature if curvature > 0.0 else 0.0
            taken = self._taken(part, clipped, before, step, limit)
            if taken > 0.0:
                self.pressure[cells] = trial if taken == 1.0 else np.clip(before + taken * step, 0.0, limit)
                self._step, self._change, self._curvature = field.ravel(), change, curvature
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


def _some(mask: Mask, cells: Cells) -> Mask | None:
    chosen = mask[cells]
    return chosen if chosen.any() else None


def _dot(one: RealArray, other: RealArray) -> float:
    return float(np.einsum("i,i->", one, other))
