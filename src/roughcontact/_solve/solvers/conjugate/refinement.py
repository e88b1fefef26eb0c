"""Verification in float64 around the descent in float32; near full contact a descent of the gap."""

from __future__ import annotations

import math
from functools import cached_property, partial

import attrs
import numpy as np

from roughcontact._base.arrays import Array, RealArray, sum_of_products
from roughcontact._solve.convolvers import InverseConvolution, PreparedConvolution
from roughcontact._solve.solution import GridLevel, Status, Violation
from roughcontact._solve.solvers.base import Task
from roughcontact._solve.solvers.conjugate.descent import Descent
from roughcontact._solve.solvers.conjugate.field_descent import FieldDescent, NumpyPasses
from roughcontact._solve.solvers.conjugate.preconditioner import Preconditioner, PunchWeights, is_steep, multiply_active
from roughcontact._solve.solvers.driver import Log, Monitor, Refinement, Work, iterate, judged
from roughcontact._solve.solvers.passes import ActiveCells, total
from roughcontact._solve.solvers.projection import ApproachControl, Control, LoadControl

# Support stiffness for waves longer than the openings, over the mean of a punch of their shape.
_SUPPORT_STIFFNESS = 0.25
# Error of a pressure in float32, and minimum factor of a pass in float32 on the error.
_FLOAT32_ERROR = 1e-6
_FLOAT32_GAIN = 2e-5
# Error at which a pass ends that cannot reach its goal, over the error of float32.
_EARLY_GOAL_FACTOR = 10.0
# Goal of the estimated error, over the tolerance of the verification.
_GOAL_FRACTION = 0.7
# Maximum verifications of a solve that do not halve the error.
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

    def __init__(self, start: NearlyFull, monitor: Monitor, work: Work) -> None:
        self._inverse = start.inverse
        self._closing = start.closing
        self._monitor = monitor
        self._work = work
        self.gain = _FLOAT32_GAIN
        self.gap = start.gap.astype(np.float64)
        shape = start.closing.shape
        inverse = start.inverse
        self._single = single = attrs.evolve(inverse, stiffness=inverse.stiffness.astype(np.float32))
        preconditioner = OpeningPreconditioner(single, shape, work)
        self._descent = Descent(
            partial(work.invert, single), shape, preconditioner, ApproachControl(), np.array([np.inf])
        )

    def approximate(self, goal: float) -> Array:
        """Return the pressure after one pass in float32."""
        self._pressure = self._closing
        if self.gap.any():
            self._pressure = self._closing + self._work.invert(self._single, self.gap.astype(np.float32))
        self._monitor.record(self._measure(self._pressure))
        exact = _EARLY_GOAL_FACTOR * _FLOAT32_ERROR
        return self._bound(self._descend(goal if goal > _FLOAT32_ERROR else exact).astype(np.float64))

    def solve(self, goal: float) -> Array:
        """Return the pressure, with an error below the goal if possible."""
        self.target = goal
        iterate(self, Log(self.gap.shape), goal)
        pressure = self._pressure
        del self._pressure
        return self._bound(pressure)

    def measure(self) -> tuple[float, float]:
        """Return the error of the pressure that follows from the gap, in float64, and no rounding."""
        self._pressure = self._work.invert(self._inverse, self.gap)
        self._pressure += self._closing
        return self._measure(self._pressure), 0.0

    def descend(self, goal: float) -> None:
        """Lower the error of the gap in float32."""
        self._descend(goal)

    def _descend(self, goal: float) -> RealArray:
        """Lower the error of the gap to a goal, as far as float32 allows; return the pressure."""
        peak = float(self._pressure.max())
        self._descent.start(self.gap.reshape(-1), self._pressure.astype(np.float32).ravel(), peak)
        # The pressure follows from the gap; the former one takes memory.
        del self._pressure
        iterate(self._descent, self._monitor, goal, math.inf)
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

    def __init__(self, inverse: InverseConvolution, shape: tuple[int, int], work: Work) -> None:
        self._inverse = inverse
        self._shape = shape
        self._work = work
        self._punch = PunchWeights(inverse, shape, work)
        self._support = np.float32(1.0)

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
        self._work.inverse += 1
        symbol = 1.0 / (self._inverse.stiffness + self._support)
        return multiply_active(active, residual, self._inverse, symbol, self._shape)


class PressureRefinement(Refinement):
    """Solves one task on one grid from a start.

    The gap of the pressure is computed in float64, and its increments in float32: they shrink with
    the error, so that float32 is enough. Only the float64 gap, which the monitor judges, decides.

    Attributes
    ----------
    work
        The products so far.
    met_limit
        Whether the pressure limit has shortened a step or changed a start so far.
    """

    verifies = True

    def __init__(
        self, convolution: PreparedConvolution, task: Task, monitor: Monitor, nearly_full: NearlyFull | None = None
    ) -> None:
        self._convolution = convolution
        self._task = task
        self._monitor = monitor
        self.target = monitor.tolerance
        self.patience = _MAX_IDLE_VERIFICATIONS + 1
        self.goal_fraction = _GOAL_FRACTION
        self.gain = _FLOAT32_GAIN
        self._limit = task.pressure_limit.ravel()
        mean = task.mean_pressure
        self._control: Control = ApproachControl() if mean is None else LoadControl(mean * task.initial_gap.size)
        self.work = Work()
        self._convolve = partial(self.work.convolve, convolution)
        self._openings = None if nearly_full is None else Openings(nearly_full, monitor, self.work)
        self.met_limit = False
        self._on_fields = FieldDescent.serves(task)

    @cached_property
    def _descent(self) -> Descent | FieldDescent:
        # A start without descent, such as full contact, needs no preconditioner.
        inverse = self._convolution.inverse(np.float32)
        self._on_fields = self._on_fields and not is_steep(inverse)
        if self._on_fields:
            limit = self._limit if self._task.capped else None
            load = self._control.load if isinstance(self._control, LoadControl) else None
            passes = (self._convolution.passes or NumpyPasses)(limit, load)
            return FieldDescent(self._convolve, inverse, self.work, passes, self._task.initial_gap.shape)
        rigid = self._task.mean_pressure is None
        preconditioner = Preconditioner(inverse, self._convolution, self.work, rigid=rigid)
        return Descent(self._convolve, self._task.initial_gap.shape, preconditioner, self._control, self._limit)

    @property
    def level(self) -> GridLevel:
        """The work so far."""
        return self.work.level(self._monitor)

    def begin(self, pressure: Array) -> Array:
        """Return a better start than a uniform pressure, on fields; see `FieldDescent.begin`."""
        descent = self._descent
        if isinstance(descent, FieldDescent):
            pressure = descent.begin(pressure, self._task.initial_gap)
            self.met_limit = descent.met_limit
        return pressure

    def approximate(self, pressure: Array) -> tuple[Array, RealArray]:
        """Return an improved pressure, shape (nx, ny), and its gap, from one pass in float32 alone.

        It starts from a pressure that is changed in place, and aims at the tolerance without verifying it.
        """
        if self._openings is not None:
            pressure = self._openings.approximate(_GOAL_FRACTION * self._monitor.tolerance)
            return pressure, self._openings.gap.astype(np.float32)
        shape = pressure.shape
        self._pressure = pressure.reshape(-1)
        self._displace(np.float32)
        violation = self._violation
        self._monitor.record(violation.error)
        largest = float(max(self._displacement.max(), -self._displacement.min())) / violation.scale
        goal = _GOAL_FRACTION * self._monitor.tolerance
        exact = _FLOAT32_ERROR * max(1.0, largest)
        if goal < exact:
            goal = _EARLY_GOAL_FACTOR * exact
        gap = self._find_gap() if violation.error <= goal else self._descend(self._find_gap(), goal)
        return self._pressure.reshape(shape), gap.reshape(shape)

    def run(self, pressure: Array) -> tuple[Array, Violation, Status]:
        """Return the solution from a start, shape (nx, ny), changed in place, its violation and how the solve ended."""
        self._pressure = pressure.reshape(-1)
        del pressure
        self._goal = _GOAL_FRACTION * self._monitor.tolerance
        status = iterate(self, self._monitor, self._monitor.tolerance)
        return self._pressure.reshape(self._task.initial_gap.shape), self._violation, status

    def measure(self) -> tuple[float, float]:
        """Return the error of the pressure, in float64, and that by rounding."""
        if self._openings is not None:
            # The pressure follows from the gap; the former one takes memory.
            del self._pressure
            self._pressure = self._openings.solve(self._goal).reshape(-1)
        self._displace(np.float64)
        return judged(self._violation)

    def descend(self, goal: float) -> None:
        """Lower the error in float32, near full contact of the gap as long as that halves it."""
        if self._openings is not None and self.idle == 0:
            self._goal = _GOAL_FRACTION * self._openings.error * self.target / self.error
            return
        # Continue with the pressure instead of the openings.
        self._openings = None
        self._descend(self._find_gap(), goal)

    def _displace(self, dtype: type[np.float32] | type[np.float64]) -> None:
        """Restore the load of the pressure, and find its displacement in a precision and its violation."""
        self._pressure = self._control.restore(self._pressure, self._limit)
        self.met_limit = self.met_limit or (self._task.capped and bool((self._pressure >= self._limit).any()))
        pressure = self._pressure.reshape(self._task.initial_gap.shape)
        self._displacement = self._convolve(pressure.astype(dtype, copy=False))
        self._violation = self._monitor.measure(pressure, self._displacement)

    def _find_gap(self) -> RealArray:
        """Return the gap, flat, in float32, from the displacement, which is freed."""
        gap = self._displacement.astype(np.float64, copy=False)
        del self._displacement
        gap += self._task.initial_gap
        gap -= self._violation.approach
        return gap.ravel().astype(np.float32)

    def _descend(self, gap: RealArray, goal: float) -> RealArray:
        """Iterate until the estimated error is worth a verification; return the gap."""
        violation = self._violation
        self._descent.start(self._pressure, gap, violation.scale, violation.error)
        del gap
        status = iterate(self._descent, self._monitor, goal, violation.error)
        self.met_limit = self.met_limit or self._descent.met_limit
        self._pressure = self._descent.pressure
        gap = self._descent.stop()
        if status is Status.STALLED and self._on_fields:
            # Lists of cells have a better preconditioner.
            self._on_fields = False
            del self._descent
        return gap
