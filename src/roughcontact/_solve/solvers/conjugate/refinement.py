"""Verification in float64 around the descent in float32; near full contact a descent of the gap."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array, RealArray, sum_of_products
from roughcontact._solve.convolvers import InverseConvolution, PreparedConvolution
from roughcontact._solve.solution import GridLevel, Status, Violation
from roughcontact._solve.solvers.base import IdleCount, Monitor, Task
from roughcontact._solve.solvers.conjugate.active import ActiveCells
from roughcontact._solve.solvers.conjugate.descent import Descent
from roughcontact._solve.solvers.conjugate.preconditioner import Preconditioner, PunchWeights, multiply_active
from roughcontact._solve.solvers.projection import ApproachControl, Control, LoadControl, total

# Support stiffness for waves longer than the openings, over the mean of a punch of their shape.
_SUPPORT_STIFFNESS = 0.25
# Error of a pressure in float32, and minimum factor of a pass in float32 on the error.
_FLOAT32_ERROR = 1e-6
_FLOAT32_GAIN = 2e-5
# Error at which a pass ends that cannot reach its goal, over the error of float32.
_EARLY_GOAL_FACTOR = 10.0
# Goal of the estimated error, over the tolerance of the verification.
_GOAL_FRACTION = 0.7
# A pass whose error has fallen by the first factor ends after three iterations that do not lower it to a third.
_LATE_ERROR_FRACTION = 3e-3
_SLOW_ERROR_RATIO = 1.0 / 3.0
_MAX_SLOW_ITERATIONS = 3
# Maximum iterations of a pass, and verifications of a solve, that do not halve the error.
_MAX_IDLE_ITERATIONS = 30
_MAX_IDLE_VERIFICATIONS = 5


@attrs.frozen(eq=False)
class NearlyFull:
    """A start near full contact on a periodic boundary.

    Attributes
    ----------
    inverse
        Inverse of the convolution.
    closing
        Pressure of full contact, shape (nx, ny); negative where cells must open.
    gap
        The gap, not negative, shape (nx, ny).
    """

    inverse: InverseConvolution
    closing: Array
    gap: RealArray

    def is_closed(self, limit: Array) -> bool:
        """Return whether the pressure of full contact is within its bounds."""
        return bool(self.closing.min() >= 0.0 and not (self.closing > limit).any())


class Openings:
    r"""Finds the gap g of the cells that open, and from it the pressure.

    With the pressure :math:`p_0` of full contact and the inverse kernel M, the pressure is
    :math:`p_0 + M g`, so that the gap minimises :math:`\tfrac12\,g \cdot M g + p_0 \cdot g` over :math:`g \ge 0`:
    the contact problem with both fields exchanged. M annihilates the mean, so that the load is that of
    :math:`p_0` and the approach is free. Vectors hold the few open cells.

    Attributes
    ----------
    gap
        The gap, shape (nx, ny).
    error
        Error of the last pressure, over its maximum.
    """

    def __init__(self, start: NearlyFull, monitor: Monitor) -> None:
        self._inverse = start.inverse
        self._closing = start.closing
        self._monitor = monitor
        self.gap = start.gap.astype(np.float64)
        shape = start.closing.shape
        inverse = start.inverse
        single = attrs.evolve(inverse, stiffness=inverse.stiffness.astype(np.float32))
        self._single = single
        self._preconditioner = OpeningPreconditioner(single, shape)
        self._descent = Descent(single, shape, self._preconditioner, ApproachControl(), np.array([np.inf]))
        self.error = np.inf
        self._products = 0

    @property
    def products(self) -> int:
        """Products with the inverse kernel so far."""
        return self._products + self._descent.products + self._preconditioner.products

    def approximate(self, goal: float) -> Array:
        """Return the pressure after one pass in float32."""
        pressure = self._closing
        if self.gap.any():
            self._products += 1
            pressure = pressure + self._single.apply(self.gap.astype(np.float32))
        self._monitor.record(self._measure(pressure))
        peak = self._start(pressure)
        del pressure
        exact = _EARLY_GOAL_FACTOR * _FLOAT32_ERROR
        return self._bound(self._descend(peak, goal if goal > _FLOAT32_ERROR else exact).astype(np.float64))

    def solve(self, goal: float) -> Array:
        """Return the pressure, with an error below the goal if possible."""
        previous = np.inf
        while True:
            self._products += 1
            pressure = self._inverse.apply(self.gap)
            pressure += self._closing
            self.error = self._measure(pressure)
            if self.error <= goal or self.error > 0.5 * previous or not self._monitor.has_iterations_left:
                return self._bound(pressure)
            previous = self.error
            peak = self._start(pressure)
            del pressure
            self._descend(peak, max(goal, _FLOAT32_GAIN * self.error))

    def _start(self, pressure: Array) -> float:
        """Start a descent in float32 from a pressure, which is then not needed any more; return its maximum."""
        self._descent.start(self.gap.reshape(-1), pressure.astype(np.float32).ravel())
        return float(pressure.max())

    def _descend(self, peak: float, goal: float) -> RealArray:
        """Lower the error of the gap to a goal, as far as float32 allows; return the pressure."""
        while self._monitor.has_iterations_left and self._descent.iterate():
            error = self._descent.error() / peak
            self._monitor.record(error)
            if error <= goal:
                break
        return self._descent.stop().reshape(self.gap.shape)

    def _measure(self, pressure: Array) -> float:
        """Return the error of a pressure, over its maximum: negative pressure, or pressure on open cells."""
        opened = float(self.gap.sum())
        mean = sum_of_products(self.gap, np.abs(pressure)) / opened if opened > 0.0 else 0.0
        return max(mean, -float(pressure.min())) / float(pressure.max())

    def _bound(self, pressure: Array) -> Array:
        """Return the pressure, changed in place, zero where it is negative or the cell is open."""
        np.maximum(pressure, 0.0, out=pressure)
        pressure[self.gap > 0.0] = 0.0
        return pressure


class OpeningPreconditioner:
    """The inverse of the stiffness between masks, with a support against waves longer than the openings."""

    def __init__(self, inverse: InverseConvolution, shape: tuple[int, int]) -> None:
        self._inverse = inverse
        self._shape = shape
        self._punch = PunchWeights(inverse, shape)
        self._support = np.float32(1.0)
        self._products = 0

    @property
    def products(self) -> int:
        """Products so far."""
        return self._products + self._punch.products

    def weights(self, active: ActiveCells) -> RealArray:
        """Return the vector of ones."""
        weights = self._punch.update(active)
        support = 1.0 if weights is None else _SUPPORT_STIFFNESS * total(weights) / active.count
        self._support = np.float32(support)
        return active.ones

    def levels(self, weights: RealArray, gap: RealArray, level: np.float32) -> None:
        """Return None: the level is the same everywhere."""

    def apply(self, active: ActiveCells, weights: RealArray, residual: RealArray) -> RealArray:
        """Return the vector of the preconditioned residual."""
        self._products += 1
        symbol = 1.0 / (self._inverse.stiffness + self._support)
        return multiply_active(active, residual, self._inverse, symbol, self._shape)


class Refinement:
    """Solves one task on one grid from a start.

    The gap of the pressure is computed in float64, and its increments in float32: they shrink with
    the error, so that float32 is enough. Only the float64 gap, which the monitor judges, decides.
    """

    def __init__(
        self, convolution: PreparedConvolution, task: Task, monitor: Monitor, nearly_full: NearlyFull | None = None
    ) -> None:
        self._convolution = convolution
        self._task = task
        self._monitor = monitor
        self._limit = task.pressure_limit.ravel()
        mean = task.mean_pressure
        self._control: Control = ApproachControl() if mean is None else LoadControl(mean * task.initial_gap.size)
        self._openings = None if nearly_full is None else Openings(nearly_full, monitor)
        self._started = self._limited = False
        self._verifications = self._estimates = self._others = 0

    @cached_property
    def _preconditioner(self) -> Preconditioner:
        # A start without descent, such as full contact, needs no preconditioner.
        inverse = self._convolution.inverse(np.float32)
        return Preconditioner(inverse, self._convolution, rigid=self._task.mean_pressure is None)

    @cached_property
    def _descent(self) -> Descent:
        shape = self._task.initial_gap.shape
        return Descent(self._convolution, shape, self._preconditioner, self._control, self._limit)

    @property
    def met_limit(self) -> bool:
        """Whether the pressure limit has shortened a step or changed a start so far."""
        return self._limited or (self._started and self._descent.met_limit)

    @property
    def products(self) -> int:
        """Convolutions and inverse convolutions so far, in either precision."""
        level = self.level
        return level.double + level.single + level.inverse

    @property
    def level(self) -> GridLevel:
        """The work so far."""
        single = self._estimates
        inverse = self._others
        if self._openings is not None:
            inverse += self._openings.products
        if self._started:
            single = single + self._descent.products
            inverse = inverse + self._preconditioner.products
        iterations = max(len(self._monitor.errors) - 1, 0)
        return GridLevel(self._task.initial_gap.shape, iterations, self._verifications, single, inverse)

    def approximate(self, pressure: Array) -> tuple[Array, RealArray]:
        """Return an improved pressure, shape (nx, ny), and its gap, from one pass in float32 alone.

        It starts from a pressure that is changed in place, and aims at the tolerance without verifying it.
        """
        if self._openings is not None:
            pressure = self._openings.approximate(_GOAL_FRACTION * self._monitor.tolerance)
            return pressure, self._openings.gap.astype(np.float32)
        shape = pressure.shape
        flat = self._restore(pressure.reshape(-1))
        displacement = self._convolution.apply(flat.astype(np.float32).reshape(shape))
        self._estimates += 1
        violation, _ = self._monitor.judge(flat.reshape(shape), displacement)
        largest = float(max(displacement.max(), -displacement.min())) / violation.scale
        goal = _GOAL_FRACTION * self._monitor.tolerance
        exact = _FLOAT32_ERROR * max(1.0, largest)
        if goal < exact:
            goal = _EARLY_GOAL_FACTOR * exact
        gap = self._find_gap(displacement, violation)
        del displacement
        if violation.error > goal:
            gap = self._descend(flat, gap, violation, goal)
        return flat.reshape(shape), gap.reshape(shape)

    def run(self, pressure: Array) -> tuple[Array, Violation, Status]:
        """Return the solution from a start, shape (nx, ny), changed in place, its violation and how the solve ended."""
        shape = pressure.shape
        flat = pressure.reshape(-1)
        del pressure
        idles = IdleCount()
        goal = _GOAL_FRACTION * self._monitor.tolerance
        while True:
            if self._openings is not None:
                # The pressure follows from the gap; the former one takes memory.
                del flat
                flat = self._openings.solve(goal).reshape(-1)
            flat = self._restore(flat)
            displacement = self._convolution.apply(flat.reshape(shape))
            self._verifications += 1
            if self._monitor.errors:
                # The verified error replaces the estimate.
                self._monitor.errors.pop()
            violation, status = self._monitor.judge(flat.reshape(shape), displacement)
            if status is None:
                idle = idles.add(violation.error)
                if idle > _MAX_IDLE_VERIFICATIONS:
                    status = Status.STALLED
            if status is not None:
                return flat.reshape(shape), violation, status
            if self._openings is not None and idle == 0:
                goal = _GOAL_FRACTION * self._openings.error * self._monitor.tolerance / violation.error
                continue
            self._leave_openings()
            gap = self._find_gap(displacement, violation)
            del displacement
            self._descend(
                flat, gap, violation, max(_GOAL_FRACTION * self._monitor.tolerance, _FLOAT32_GAIN * violation.error)
            )
            del gap

    def _restore(self, pressure: Array) -> Array:
        """Return a flat pressure, changed in place, with the load of the task."""
        pressure = self._control.restore(pressure, self._limit)
        self._limited = self._limited or (self._task.capped and bool((pressure >= self._limit).any()))
        return pressure

    def _leave_openings(self) -> None:
        """Continue with the pressure instead of the openings."""
        if self._openings is not None:
            self._others += self._openings.products
            self._openings = None

    def _find_gap(self, displacement: RealArray, violation: Violation) -> RealArray:
        """Return the gap, flat, in float32; a displacement in float64 is changed in place."""
        gap = displacement.astype(np.float64, copy=False)
        gap += self._task.initial_gap
        gap -= violation.approach
        return gap.ravel().astype(np.float32)

    def _descend(self, pressure: Array, gap: RealArray, violation: Violation, goal: float) -> RealArray:
        """Iterate until the estimated error is worth a verification; return the gap."""
        self._started = True
        self._descent.start(pressure, gap)
        error = violation.error
        slow = 0
        idles = IdleCount(violation.error)
        while self._monitor.has_iterations_left and self._descent.iterate():
            previous = error
            error = self._descent.error() / violation.scale
            self._monitor.record(error)
            late = error < _LATE_ERROR_FRACTION * violation.error
            slow = slow + 1 if late and error > _SLOW_ERROR_RATIO * previous else 0
            idle = idles.add(error)
            if error <= goal or slow >= _MAX_SLOW_ITERATIONS or idle >= _MAX_IDLE_ITERATIONS:
                break
        return self._descent.stop()
