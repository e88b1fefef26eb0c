"""Conjugate gradients on whole fields: for small grids, where to list cells costs more than it saves.

The same energy and the same steps as of `Descent`, with two products each, but all vectors are fields, the metric of
the projections is uniform, and the preconditioner is the inverse kernel between masks alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import final

import numpy as np

from roughcontact._base.arrays import Array, IntArray, Mask, RealArray
from roughcontact._solve.convolvers import FieldPasses, InverseConvolution, LastStep
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.base import Task
from roughcontact._solve.solvers.conjugate.descent import (
    CAREFUL_LENGTH,
    FIRST_LENGTH,
    MAX_LENGTH,
    MIN_CONJUGATE_SLOPE,
    choose_part,
)
from roughcontact._solve.solvers.driver import Method, Work
from roughcontact._solve.solvers.passes import dot, limits_at, total
from roughcontact._solve.solvers.projection import STEP_LOAD_ERROR, shift_to_load

# Maximum cells of a grid on which the pressure is found on whole fields: on 256 x 256 cells long waves need the
# correction of `Preconditioner`. Compiled passes take two thirds of the time there without it, but half as many
# products again, and vectors of all cells.
_MAX_FIELD_CELLS = 2**15
# Maximum iterations that do not halve the error; the descent on lists of cells then goes on.
_MAX_IDLE_ITERATIONS = 12
# Maximum rejected steps, and rounds that find the released cells that stay on their bounds.
_MAX_BACKTRACKS = 12
_MAX_RELEASED_ROUNDS = 20
# Maximum fraction in contact at a start by an approximate inverse.
_MAX_INEXACT_CONTACT = 0.6
# Fraction of the cells whose change of state makes the response to the active cells outdated.
_MAX_OUTDATED_FRACTION = 0.03


@final
class FieldDescent(Method):
    """Lowers the energy p.Kp/2 + h.p within the bounds on all cells of a small grid; see `Descent`.

    Parameters
    ----------
    multiply
        The displacement by a pressure, both of the shape of the grid.
    inverse
        Approximate inverse of that, in float32.
    work
        Counts the products of the inverse.
    passes
        What is done beside the products, for the limit and the load.
    shape
        Cells of the grid.
    """

    patience = _MAX_IDLE_ITERATIONS

    def __init__(
        self,
        multiply: Callable[[RealArray], RealArray],
        inverse: InverseConvolution,
        work: Work,
        passes: FieldPasses,
        shape: tuple[int, int],
    ) -> None:
        self._multiply = multiply
        self._inverse = inverse
        self._work = work
        self._passes = passes
        self._shape = shape
        self._length = FIRST_LENGTH
        self._last: LastStep | None = None
        self._rigid = _RigidMotion()
        self.met_limit = False

    @staticmethod
    def serves(task: Task) -> bool:
        """Return whether the pressure is found so: on small grids of numpy's arrays."""
        gap = task.initial_gap
        return isinstance(gap, np.ndarray) and gap.size <= _MAX_FIELD_CELLS

    def begin(self, pressure: Array, height: Array) -> Array:
        """Return the pressure of a given load that is nearest to that which closes all gaps, shape (nx, ny).

        From there 64 x 64 cells take a sixth less products than from a uniform pressure. That one, which is given, is
        returned at a given approach, and where an approximate inverse has nearly all cells in contact.
        """
        load = self._passes.load
        limit = self._passes.limit
        # The maximum load has one pressure.
        if load is None or (limit is not None and bool((pressure.ravel() >= limit).all())):
            return pressure
        closing = self._work.invert(self._inverse, -height.astype(np.float32)).ravel()
        step = pressure.ravel(), closing, 1.0, np.ones(closing.shape, dtype=bool)
        # A limit that is not reached must not change a bit.
        nearest, _, _ = type(self._passes)(None, load).advance(*step)
        if not self._inverse.exact and np.count_nonzero(nearest) > _MAX_INEXACT_CONTACT * nearest.size:
            return pressure
        if limit is not None and bool((nearest > limit).any()):
            self.met_limit = True
            nearest, _, _ = self._passes.advance(*step)
        return nearest.reshape(self._shape)

    def start(self, pressure: Array, gap: RealArray, scale: float = 1.0, error: float | None = None) -> None:
        """Continue from a pressure and its gap, both flat; the gap is changed in place; see `Descent.start`."""
        self._scale = scale
        self._level = 0.0
        self.pressure = pressure
        self.gap = gap

    def stop(self) -> RealArray:
        """Return the gap from its level, flat."""
        self.gap -= np.float32(self._level)
        return self.gap

    def measure(self) -> tuple[float, float]:
        """Return the estimated error, and no rounding."""
        self._level, error = self._passes.measure(self.pressure, self.gap)
        return error / self._scale, 0.0

    def step(self) -> Status | None:
        """Make one step; see `Method.step`."""
        residual, active, count = self._passes.release(self.pressure, self.gap)
        if count == 0:
            return Status.STALLED
        direction = self._find_direction(residual, active)
        moved = direction is not None and self._move(residual, active, direction)
        return None if moved else Status.STALLED

    def _find_direction(self, residual: RealArray, active: Mask) -> RealArray | None:
        """Return the first of conjugate, preconditioned and plain gradient that lowers the energy; None without one."""
        image = self._precondition(residual, active)
        conjugate, slope = self._passes.conjugate(image, residual, active, self._last)
        for direction, minimum in ((conjugate, MIN_CONJUGATE_SLOPE * slope), (image, 0.0), (residual, 0.0)):
            admitted, slope = self._passes.admit(direction, residual, active, self.pressure)
            if slope > max(minimum, 0.0):
                return admitted
            self._length = CAREFUL_LENGTH
        return None

    def _precondition(self, residual: RealArray, active: Mask) -> RealArray:
        """Return the preconditioned residual, at a given approach with its rigid part."""
        image = self._work.invert(self._inverse, residual.reshape(self._shape)).ravel()
        if self._passes.load is None:
            image += np.float32(self._rigid.part(active, residual, self._displace))
        return image

    def _displace(self, field: RealArray) -> RealArray:
        return self._multiply(field.reshape(self._shape)).ravel()

    def _move(self, residual: RealArray, active: Mask, direction: RealArray) -> bool:
        passes = self._passes
        for _ in range(_MAX_BACKTRACKS):
            trial, step, clipped = passes.advance(self.pressure, direction, self._length, active)
            if clipped:
                self._compare_with_limit(self._length, direction)
            change = self._displace(step)
            slope, curvature = passes.slopes(residual, step, change)
            if not math.isfinite(curvature):
                return False
            part = slope / curvature if curvature > 0.0 else 0.0
            part, pressure = self._take_part(part, trial, clipped=clipped)
            if part > 0.0:
                self.pressure = pressure
                passes.add(self.gap, change, part)
                self._last = LastStep(step, change, part * curvature)
                return True
            self._length *= CAREFUL_LENGTH
        return False

    def _take_part(self, part: float, trial: Array, *, clipped: bool) -> tuple[float, Array]:
        """Return the part of the step to be taken, zero for none, and the pressure there, as `Descent` does."""
        if clipped:
            part, factor = choose_part(part)
            self._length = min(MAX_LENGTH, self._length * factor)
        else:
            self._length = min(MAX_LENGTH, self._length * min(max(part, 0.25), 4.0))
        if part in (0.0, 1.0):
            return part, trial
        moved, inside = self._passes.move(self.pressure, trial, part)
        if inside or part <= 1.0:
            return part, moved
        self._compare_with_limit(part, trial - self.pressure)
        return 1.0, trial

    def _compare_with_limit(self, length: float, direction: RealArray) -> None:
        """Note whether a step would cross the limit: it is then another one than without, wherever it ends."""
        limit = self._passes.limit
        if limit is not None and not self.met_limit:
            self.met_limit = bool((self.pressure + length * direction > limit).any())


class _RigidMotion:
    """The active cells as a uniform pressure, and the displacement by it: at a given approach the load is free."""

    def __init__(self) -> None:
        self._active: Mask | None = None
        self._stiffness = 0.0

    def part(self, active: Mask, residual: RealArray, displace: Callable[[RealArray], RealArray]) -> float:
        """Return the uniform pressure on the active cells that removes the mean of a residual."""
        before = self._active
        if before is None or np.count_nonzero(before ^ active) > _MAX_OUTDATED_FRACTION * active.size:
            uniform = active.astype(np.float32)
            self._active = active
            self._stiffness = dot(uniform, displace(uniform))
        return total(residual) / self._stiffness if self._stiffness > 0.0 else 0.0


class NumpyPasses(FieldPasses):
    """The passes in numpy, few calls each."""

    def measure(self, pressure: Array, gap: RealArray) -> tuple[float, float]:
        """See `FieldPasses.measure`."""
        limit = self.limit
        single = pressure.astype(np.float32)
        load = total(single)
        level = 0.0
        if self.load is not None:
            elastic = single if limit is None else single * (pressure < limit)
            carried = load if limit is None else total(elastic)
            level = dot(elastic, gap) / carried if carried > 0.0 else 0.0
        rest = gap - np.float32(level)
        if limit is not None:
            np.maximum(rest, 0.0, out=rest, where=pressure >= limit)
        overlap = -float(np.minimum.reduce(rest))
        opened = dot(single, np.abs(rest, out=rest)) / load if load > 0.0 else 0.0
        return level, max(opened, overlap)

    def release(self, pressure: Array, gap: RealArray) -> tuple[RealArray, Mask, int]:
        """See `FieldPasses.release`."""
        limit = self.limit
        by_load = self.load is not None
        inside = pressure > 0.0
        if limit is not None:
            inside &= pressure < limit
        level = np.float32(_mean(gap, inside) if by_load else 0.0)
        active = gap < level
        if limit is None:
            active |= inside
        else:
            saturated = pressure >= limit
            active &= ~saturated
            active |= inside
            active |= saturated & (gap > level)
        count = int(np.count_nonzero(active))
        ones = active.astype(np.float32)
        residual = np.float32(dot(gap, ones) / count if by_load and count else 0.0) - gap
        residual *= ones
        return residual, active, count

    def conjugate(
        self, image: RealArray, residual: RealArray, active: Mask, last: LastStep | None
    ) -> tuple[RealArray, float]:
        """See `FieldPasses.conjugate`."""
        image *= active
        slope = dot(residual, image)
        factor = 0.0 if last is None else -dot(image, last.change) / last.curvature
        if last is None or factor <= 0.0:
            return image, slope
        direction = last.step * active
        direction *= np.float32(factor)
        direction += image
        return direction, slope

    def admit(
        self, direction: RealArray, residual: RealArray, active: Mask, pressure: Array
    ) -> tuple[RealArray, float]:
        """See `FieldPasses.admit`."""
        low = (active & (pressure <= 0.0)).nonzero()[0]
        high = low[:0] if self.limit is None else (active & (pressure >= self.limit)).nonzero()[0]
        if self.load is None:
            admitted = direction.copy()
        else:
            count = int(np.count_nonzero(active))
            admitted = direction - np.float32(_held_mean(direction, count, low, high))
            admitted *= active
        if low.size:
            admitted[low] = np.maximum(admitted[low], 0.0)
        if high.size:
            admitted[high] = np.minimum(admitted[high], 0.0)
        return admitted, dot(residual, admitted)

    def advance(
        self, pressure: Array, direction: RealArray, length: float, active: Mask
    ) -> tuple[Array, RealArray, bool]:
        """See `FieldPasses.advance`."""
        limit = self.limit
        trial = pressure + np.float32(length) * direction
        clipped = not _is_within(trial, limit)
        if clipped:
            bound = np.inf if limit is None else limit
            if self.load is None:
                np.clip(trial, 0.0, bound, out=trial)
            else:
                error = STEP_LOAD_ERROR * length * float(np.abs(direction).sum())
                cells = active.nonzero()[0]
                bounds = bound if limit is None else limits_at(limit, cells)
                carried = float(np.add.reduce(pressure[cells]))
                trial[cells] = shift_to_load(trial[cells], carried, np.asarray(bounds), error)
        step = np.subtract(trial, pressure, out=np.empty(trial.shape, dtype=np.float32), casting="same_kind")
        return trial, step, clipped

    def slopes(self, residual: RealArray, step: RealArray, change: RealArray) -> tuple[float, float]:
        """See `FieldPasses.slopes`."""
        return dot(residual, step), dot(step, change)

    def move(self, pressure: Array, trial: Array, part: float) -> tuple[Array, bool]:
        """See `FieldPasses.move`."""
        moved = trial - pressure
        moved *= part
        moved += pressure
        inside = _is_within(moved, self.limit)
        if not inside:
            np.clip(moved, 0.0, np.inf if self.limit is None else self.limit, out=moved)
        return moved, inside

    def add(self, gap: RealArray, change: RealArray, part: float) -> None:
        """See `FieldPasses.add`."""
        change *= np.float32(part)
        gap += change


def _mean(values: RealArray, cells: Mask) -> float:
    """Return the mean over some cells; zero without any."""
    count = int(np.count_nonzero(cells))
    return dot(values, cells.astype(np.float32)) / count if count else 0.0


def _held_mean(direction: RealArray, count: int, low: IntArray, high: IntArray) -> float:
    """Return the mean of a direction over the active cells but those that it would move across their bounds.

    `low` and `high` are the released cells at zero and at the limit; what is subtracted decides which of them stay.
    """
    change = total(direction)
    mean = change / count
    if not low.size and not high.size:
        return mean
    lowest = direction[low]
    highest = direction[high]
    below = -math.inf
    above = math.inf
    for _ in range(_MAX_RELEASED_ROUNDS):
        down = lowest[lowest < mean]
        up = highest[highest > mean]
        moving = count - down.size - up.size
        trial = (change - total(down) - total(up)) / moving if moving else mean
        if trial == mean:
            break
        if trial > mean:
            below = mean
        else:
            above = mean
        # Cells at zero and at the limit that change places would repeat for ever.
        mean = trial if below < trial < above else 0.5 * (below + above)
    return mean


def _is_within(pressure: Array, limit: Array | None) -> bool:
    return not float(np.minimum.reduce(pressure)) < 0.0 and (limit is None or not bool((pressure > limit).any()))
