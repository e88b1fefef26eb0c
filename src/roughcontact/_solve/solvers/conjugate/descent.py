"""Preconditioned conjugate-gradient descent in float32, with one convolution for each iteration."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, Mask, RealArray
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.driver import Method
from roughcontact._solve.solvers.passes import ActiveCells, Bounds, Levels, dot
from roughcontact._solve.solvers.projection import Control, ReleasedCells

# Step lengths in units of the direction: the first, the maximum, and the length after a return to the gradient, also
# the factor on a rejected step.
FIRST_LENGTH = 0.65
MAX_LENGTH = 1.5
CAREFUL_LENGTH = 0.3
# Maximum rejected steps: 0.3^40 = 1e-21 of the first is below any rounding.
_MAX_BACKTRACKS = 40
# Position of the minimum of the energy along a clipped step above which the step is taken in full, and above which it
# is taken up to the minimum; otherwise it is rejected.
_FULL_STEP_PART = 0.75
SHORTENED_STEP_PART = 0.1
# Minimum slope along the conjugate direction, over the slope along the preconditioned gradient, that is not rounding:
# they are equal except for released or clipped cells.
MIN_CONJUGATE_SLOPE = 0.01
# A pass whose error has fallen by the first factor ends after three iterations that do not lower it to a third.
_LATE_ERROR_FRACTION = 3e-3
_SLOW_ERROR_RATIO = 1.0 / 3.0
_MAX_SLOW_ITERATIONS = 3
# Maximum iterations of a pass that do not halve the error.
_MAX_IDLE_ITERATIONS = 30
_NO_CELLS: IntArray = np.zeros(0, dtype=np.intp)
_NO_GAP: RealArray = np.zeros(0, dtype=np.float32)


@attrs.frozen(eq=False)
class ActiveState:
    """The active cells with vectors on them: pressure and flat-punch weights."""

    active: ActiveCells
    pressure: Array
    weights: RealArray


class SupportsPreconditioning(Protocol):
    """An approximate inverse of an operator on the active cells."""

    def weights(self, active: ActiveCells) -> RealArray:
        """Return the vector of the metric, above zero."""

    def apply(self, active: ActiveCells, weights: RealArray, residual: RealArray) -> RealArray:
        """Return the vector of the preconditioned residual."""

    def levels(self, weights: RealArray, gap: RealArray, level: np.float32) -> Levels:
        """Return the level below which open cells are released, by tiles, from vectors; None if it is the given one."""


class Descent(Method):
    """Lowers the energy p.Kp/2 + h.p within the bounds by preconditioned conjugate gradients.

    K p is the displacement by the pressure p, h the initial gap. The step length is guessed, the
    displacement by the step is computed once, and the length is then corrected: exactly, because the
    energy is quadratic along the step. Fields are flat; the limit may have one entry.
    """

    def __init__(
        self,
        multiply: Callable[[RealArray], RealArray],
        shape: tuple[int, int],
        preconditioner: SupportsPreconditioning,
        control: Control,
        limit: Array,
    ) -> None:
        self._multiply = multiply
        self._preconditioner = preconditioner
        self._control = control
        self._limit = limit
        self._bounds = Bounds(limit)
        self._capped = self._bounds.capped
        self._shape = shape
        self._length = FIRST_LENGTH
        # The vector of the gap between two steps.
        self._active_gap = _NO_GAP
        self._step: RealArray | None = None
        self._change: RealArray | None = None
        self._curvature = 1.0
        # The minimum of the gap, where the last step has found it.
        self._minimum: float | None = None
        self.met_limit = False

    def start(self, pressure: Array, gap: RealArray, scale: float = 1.0, error: float | None = None) -> None:
        """Continue from a pressure and its gap, both flat; the gap, float32, is updated in place.

        Parameters
        ----------
        pressure, gap
            Both, float64 and float32.
        scale
            Scale of the error.
        error
            The verified error, for a descent that ends where rounding slows it down; None: it does not.
        """
        self._scale = scale
        self._late = 0.0 if error is None else _LATE_ERROR_FRACTION * error
        self._slow = 0
        self.patience = math.inf if error is None else _MAX_IDLE_ITERATIONS
        self.pressure = pressure
        self.gap = gap
        self._level = 0.0
        self._minimum = None
        self.met_limit |= self._capped and bool((pressure >= self._limit).any())
        active = self._bounds.find_inside(pressure)
        weights = self._preconditioner.weights(active) if active.count else active.ones
        self._state = ActiveState(active, self._gather_pressure(active), weights)
        self._active_gap = active.gather(gap)

    def stop(self) -> RealArray:
        """Return the gap from its level, flat, and free the arrays until the next start."""
        gap = self.gap
        gap -= np.float32(self._level)
        self._active_gap = _NO_GAP
        del self.gap, self._state
        return gap

    def step(self) -> Status | None:
        """Make one step; see `Method.step`."""
        return None if self._slow < _MAX_SLOW_ITERATIONS and self.iterate() else Status.STALLED

    def measure(self) -> tuple[float, float]:
        """Return the estimated error, and no rounding."""
        error = self.find_error() / self._scale
        self._slow = self._slow + 1 if error < self._late and error > _SLOW_ERROR_RATIO * self.error else 0
        return error, 0.0

    def iterate(self) -> bool:
        """Make one step; return whether the energy fell."""
        active = self._find_active()
        if active.count == 0:
            return False
        # Free the former vectors: memory peaks in the step.
        self._active_gap = _NO_GAP
        del self._state
        weights = self._preconditioner.weights(active)
        self._state = state = ActiveState(active, self._gather_pressure(active), weights)
        residual = self._find_residual(state)
        direction = self._find_direction(state, self._find_released(state), residual)
        return direction is not None and self._move(state, residual, direction)

    def _find_residual(self, state: ActiveState) -> RealArray:
        """Return the vector of the level less the gap."""
        gap = state.active.gather(self.gap)
        return np.float32(self._control.level(gap, state.weights)) * state.active.ones - gap

    def find_error(self) -> float:
        """Return the error of the gap of the descent, as in `Violation` but not divided by the scale."""
        state = self._state
        limit = state.active.limits(self._limit)
        elastic = np.where(state.pressure < limit, state.pressure, 0.0) if self._capped else state.pressure
        self._level = level = self._control.level(self._active_gap, elastic)
        gap = self._active_gap - np.float32(level)
        if self._capped:
            np.maximum(gap, 0.0, out=gap, where=state.pressure >= limit)
        load = float(np.add.reduce(state.pressure))
        open_gap = dot(state.pressure, np.abs(gap, out=gap)) / load if load > 0.0 else 0.0
        if self._minimum is None:
            self._minimum = self._bounds.minimum(self.gap, self.pressure)
        return max(open_gap, level - self._minimum)

    def _find_active(self) -> ActiveCells:
        """Return the cells inside the bounds, and the cells released from a bound by the sign of their gap."""
        state = self._state
        inside = self._bounds.inside(state.pressure, state.active.limits(self._limit))
        weights = state.weights * inside
        level = np.float32(self._find_level(inside, weights))
        # Without a limit all cells in contact are active: their vector takes less to read than the field.
        bearing = None if self._capped else state.active.scatter(inside)
        levels = None
        # Saturated cells are released too, and levels that are lower in some blocks would release more of them than of
        # open ones.
        if state.active.count and not self.met_limit:
            levels = self._preconditioner.levels(weights, self._active_gap, level)
        return self._bounds.release(self.gap, self.pressure, bearing, level, levels)

    def _find_released(self, state: ActiveState) -> ReleasedCells:
        """Return the active cells on a bound."""
        low = np.flatnonzero(state.active.mark(state.pressure <= 0.0))
        if not self._capped:
            return ReleasedCells(low, _NO_CELLS)
        return ReleasedCells(low, np.flatnonzero(state.active.mark(state.pressure >= state.active.limits(self._limit))))

    def _find_level(self, inside: Mask, weights: RealArray) -> float:
        """Return the gap below which open cells, and above which saturated cells, are released."""
        if self._capped and not inside.any():
            contact = self.pressure > 0.0
            if contact.any() and not contact.all():
                # A level that releases saturated cells must release open ones too, or nothing can move.
                saturated = self.gap[contact].max()
                opened = self.gap[~contact].min()
                return self._control.level_between(float(saturated), float(opened))
        return self._control.level(self._active_gap, weights)

    def _gather_pressure(self, active: ActiveCells) -> Array:
        """Return the vector of the pressure; without a limit no other cell has any, so that it may be the field."""
        return active.gather(self.pressure) if self._capped else active.share(self.pressure)

    def _find_direction(self, state: ActiveState, released: ReleasedCells, residual: RealArray) -> RealArray | None:
        """Return the first of conjugate, preconditioned and plain gradient that lowers the energy; None without one."""
        preconditioned = self._preconditioner.apply(state.active, state.weights, residual)
        steepness = MIN_CONJUGATE_SLOPE * dot(residual, preconditioned)
        candidates: tuple[tuple[Callable[[], RealArray], float], ...] = (
            (lambda: self._conjugate(preconditioned, state.active), steepness),
            (lambda: preconditioned, 0.0),
            (lambda: state.weights * residual, 0.0),
        )
        for find, minimum in candidates:
            direction = self._control.admissible(find(), state.weights, released)
            if dot(residual, direction) > max(minimum, 0.0):
                return direction
            self._length = CAREFUL_LENGTH
        return None

    def _conjugate(self, preconditioned: RealArray, active: ActiveCells) -> RealArray:
        if self._step is None or self._change is None:
            return preconditioned
        factor = -dot(preconditioned, active.gather(self._change)) / self._curvature
        step = self._step
        # Memory peaks from here on.
        self._step = self._change = None
        return preconditioned + np.float32(factor) * active.gather(step) if factor > 0.0 else preconditioned

    def _move(self, state: ActiveState, residual: RealArray, direction: RealArray) -> bool:
        limit = state.active.limits(self._limit)
        for _ in range(_MAX_BACKTRACKS):
            trial = state.pressure + np.float32(self._length) * direction
            clipped = self._is_outside(trial, limit)
            if clipped:
                trial = self._control.feasible(trial, state.pressure, state.weights, limit)
            step = np.subtract(trial, state.pressure, out=np.empty_like(trial, dtype=np.float32))
            field = state.active.scatter(step)
            change = self._multiply(field.reshape(self._shape)).ravel()
            # The step is zero on all other cells: a vector that is a field needs no copy.
            curvature = dot(step, change if field is step else state.active.gather(change))
            if not math.isfinite(curvature):
                return False
            part = dot(residual, step) / curvature if curvature > 0.0 else 0.0
            part, pressure = self._take_part(part, state, trial, direction, limit, clipped=clipped)
            del trial
            if part > 0.0:
                state.active.store(self.pressure, pressure)
                self._minimum = self._bounds.add(self.gap, change, np.float32(part), self.pressure)
                self._step = field
                self._change = change
                self._curvature = part * curvature
                if state.pressure is not self.pressure:
                    np.copyto(state.pressure, pressure)
                del pressure
                self._active_gap = state.active.gather(self.gap)
                return True
            self._length *= CAREFUL_LENGTH
        return False

    def _take_part(
        self, part: float, state: ActiveState, trial: Array, direction: RealArray, limit: Array, *, clipped: bool
    ) -> tuple[float, Array]:
        """Return the part of the step to be taken, zero for none, and the pressure there; set the next length.

        `part` is the position of the minimum of the energy along the step to `trial`, which is changed in place.
        """
        before = state.pressure
        if not clipped:
            length = np.float32(self._length)
            self._length = min(MAX_LENGTH, self._length * min(max(part, 0.25), 4.0))
            full = _move_between(before, trial, part)
            if not self._is_outside(full, limit):
                return part, full
            part = min(part, 1.0)
            np.copyto(trial, length * direction)
            trial += before
        else:
            part, factor = choose_part(part)
            self._length = min(MAX_LENGTH, self._length * factor)
            if part in (0.0, 1.0):
                return part, trial if part else before
        shortened = _move_between(before, trial, part)
        return part, np.clip(shortened, 0.0, limit, out=shortened)

    def _is_outside(self, pressure: Array, limit: Array) -> bool:
        above = self._capped and bool((pressure > limit).any())
        self.met_limit |= above
        return above or bool(pressure.min() < 0.0)


def choose_part(wanted: float) -> tuple[float, float]:
    """Return the part of a step that meets bounds to be taken, zero for none, and the factor on the next length.

    `wanted` is the position of the minimum of the energy along the step.
    """
    if wanted > _FULL_STEP_PART:
        return 1.0, math.sqrt(min(max(wanted, 0.8), 4.0))
    return (wanted, max(wanted, 0.5)) if wanted > SHORTENED_STEP_PART else (0.0, 1.0)


def _move_between(before: Array, trial: Array, part: float) -> Array:
    """Return before + part * (trial - before), in the place of the trial."""
    trial -= before
    trial *= part
    trial += before
    return trial
