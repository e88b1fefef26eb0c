"""Verification in float64 around the descent in float32; near full contact a descent of the gap."""

from __future__ import annotations

import math
from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array, RealArray, sum_of_products
from roughcontact._solve.convolvers import InverseConvolution, PreparedConvolution
from roughcontact._solve.solution import GridLevel, Status, Violation
from roughcontact._solve.solvers.base import Task
from roughcontact._solve.solvers.conjugate.active import ActiveCells
from roughcontact._solve.solvers.conjugate.descent import Descent
from roughcontact._solve.solvers.conjugate.preconditioner import Preconditioner, PunchWeights, multiply_active
from roughcontact._solve.solvers.driver import Log, Method, Monitor, Refinement, finite_error, iterate
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


class Estimates(Method):
    """A descent in float32, until its estimated error is worth a verification.

    Parameters
    ----------
    descent
        The descent, started.
    scale
        Scale of its error.
    start
        Verified error of its start, for a descent that ends where rounding slows it down; None: it does not.
    """

    def __init__(self, descent: Descent, scale: float, start: float | None = None) -> None:
        self._descent = descent
        self._scale = scale
        self._late = 0.0 if start is None else _LATE_ERROR_FRACTION * start
        self._slow = 0
        self.patience = math.inf if start is None else _MAX_IDLE_ITERATIONS

    def step(self) -> Status | None:
        """Make one step of the descent; see `Method.step`."""
        return None if self._slow < _MAX_SLOW_ITERATIONS and self._descent.iterate() else Status.STALLED

    def measure(self) -> float:
        """Return the estimated error."""
        error = self._descent.error() / self._scale
        self._slow = self._slow + 1 if error < self._late and error > _SLOW_ERROR_RATIO * self.error else 0
        return error


class Openings(Refinement):
    r"""Finds the gap g of the cells that open, and from it the pressure.

    With the pressure :math:`p_0` of full contact and the inverse kernel M, the pressure is
    :math:`p_0 + M g`, so that the gap minimises :math:`\tfrac12\,g \cdot M g + p_0 \cdot g` over :math:`g \ge 0`:
    the contact problem with both fields exchanged. M annihilates the mean, so that the load is that of
    :math:`p_0` and the approach is free. Vectors hold the few open cells.

    Attributes
    ----------
    gap
        The gap, shape (nx, ny).
    """

    patience = 1
    goal_fraction = 1.0
    gain = _FLOAT32_GAIN

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
        self.target = goal
        iterate(self, Log(self.gap.shape), goal)
        pressure = self._pressure
        del self._pressure
        return self._bound(pressure)

    def measure(self) -> float:
        """Return the error of the pressure that follows from the gap, in float64."""
        self._products += 1
        self._pressure = self._inverse.apply(self.gap)
        self._pressure += self._closing
        return self._measure(self._pressure)

    def descend(self, goal: float) -> None:
        """Lower the error of the gap in float32."""
        peak = self._start(self._pressure)
        del self._pressure
        self._descend(peak, goal)

    def _start(self, pressure: Array) -> float:
        """Start a descent in float32 from a pressure, which is then not needed any more; return its maximum."""
        self._descent.start(self.gap.reshape(-1), pressure.astype(np.float32).ravel())
        return float(pressure.max())

    def _descend(self, peak: float, goal: float) -> RealArray:
        """Lower the error of the gap to a goal, as far as float32 allows; return the pressure."""
        iterate(Estimates(self._descent, peak), self._monitor, goal, math.inf)
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


class PressureRefinement(Refinement):
    """Solves one task on one grid from a start.

    The gap of the pressure is computed in float64, and its increments in float32: they shrink with
    the error, so that float32 is enough. Only the float64 gap, which the monitor judges, decides.
    """

    patience = _MAX_IDLE_VERIFICATIONS + 1
    verifies = True
    goal_fraction = _GOAL_FRACTION
    gain = _FLOAT32_GAIN

    def __init__(
        self, convolution: PreparedConvolution, task: Task, monitor: Monitor, nearly_full: NearlyFull | None = None
    ) -> None:
        self._convolution = convolution
        self._task = task
        self._monitor = monitor
        self.target = monitor.tolerance
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
        self._pressure = pressure.reshape(-1)
        del pressure
        self._goal = _GOAL_FRACTION * self._monitor.tolerance
        status = iterate(self, self._monitor, self._monitor.tolerance)
        return self._pressure.reshape(self._task.initial_gap.shape), self._violation, status

    def measure(self) -> float:
        """Return the error of the pressure, in float64."""
        if self._openings is not None:
            # The pressure follows from the gap; the former one takes memory.
            del self._pressure
            self._pressure = self._openings.solve(self._goal).reshape(-1)
        self._pressure = self._restore(self._pressure)
        pressure = self._pressure.reshape(self._task.initial_gap.shape)
        self._displacement = self._convolution.apply(pressure)
        self._verifications += 1
        self._violation = violation = self._monitor.measure(pressure, self._displacement)
        self.floor = violation.floor
        return finite_error(violation)

    def descend(self, goal: float) -> None:
        """Lower the error in float32, near full contact of the gap as long as that halves it."""
        displacement = self._displacement
        del self._displacement
        if self._openings is not None and self.idle == 0:
            self._goal = _GOAL_FRACTION * self._openings.error * self.target / self.error
            return
        self._leave_openings()
        gap = self._find_gap(displacement, self._violation)
        del displacement
        self._descend(self._pressure, gap, self._violation, goal)

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
        iterate(Estimates(self._descent, violation.scale, violation.error), self._monitor, goal, violation.error)
        return self._descent.stop()
