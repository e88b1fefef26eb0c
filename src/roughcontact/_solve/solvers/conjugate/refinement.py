"""Verification in float64 around the descent in float32."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from roughcontact._base.checks import Array, RealArray
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import GridLevel, Status, Violation
from roughcontact._solve.solvers.base import Monitor, Task
from roughcontact._solve.solvers.conjugate.descent import Descent
from roughcontact._solve.solvers.conjugate.openings import NearlyFull, Openings
from roughcontact._solve.solvers.conjugate.preconditioner import Preconditioner
from roughcontact._solve.solvers.projection import ApproachControl, Control, LoadControl

# Factor by which one pass in float32 may lower the error: its own rounding, 6e-8, leaves a margin of 300.
_GAIN = 2e-5
# Error to which float32 tells an elastic displacement of the size of the scale.
_SINGLE = 1e-6
# A pass that cannot reach the tolerance before a verification ends at this multiple of it: the next one starts anew.
_EARLY = 10.0
# The estimate aims at this fraction of the tolerance, which the verification has to meet.
_MARGIN = 0.7
# Below the first factor of its error a pass ends after three iterations that do not lower the error to a third.
_LATE = 3e-3
_SLOW = 1.0 / 3.0
_PATIENCE = 3
# Iterations of a pass, and verifications of a solve, that may go by without the error being halved.
_IDLE = 30
_STALLED = 5


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
        # A start that needs no descent, such as full contact, needs no preconditioner either.
        inverse = self._convolution.inverse(np.float32)
        return Preconditioner(inverse, self._convolution, rigid=self._task.mean_pressure is None)

    @cached_property
    def _descent(self) -> Descent:
        shape = self._task.initial_gap.shape
        return Descent(self._convolution, shape, self._preconditioner, self._control, self._limit)

    @property
    def met_limit(self) -> bool:
        """Whether the pressure limit has shortened any step, or changed a start, so far."""
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
            pressure = self._openings.approximate(_MARGIN * self._monitor.tolerance)
            return pressure, self._openings.gap.astype(np.float32)
        shape = pressure.shape
        flat = self._restore(pressure.reshape(-1))
        displacement = self._convolution.apply(flat.astype(np.float32).reshape(shape))
        self._estimates += 1
        violation, _ = self._monitor.judge(flat.reshape(shape), displacement)
        largest = float(max(displacement.max(), -displacement.min())) / violation.scale
        goal = _MARGIN * self._monitor.tolerance
        exact = _SINGLE * max(1.0, largest)
        if goal < exact:
            goal = _EARLY * exact
        gap = self._find_gap(displacement, violation)
        del displacement
        if violation.error > goal:
            gap = self._descend(flat, gap, violation, goal)
        return flat.reshape(shape), gap.reshape(shape)

    def run(self, pressure: Array) -> tuple[Array, Violation, Status]:
        """Return the solution from a start, shape (nx, ny), changed in place, its violation and how the solve ended."""
        shape = pressure.shape
        flat = pressure.reshape(-1)
        best = math.inf
        idle = 0
        goal = _MARGIN * self._monitor.tolerance
        while True:
            if self._openings is not None:
                flat = self._openings.solve(goal).reshape(-1)
            flat = self._restore(flat)
            displacement = self._convolution.apply(flat.reshape(shape))
            self._verifications += 1
            if self._monitor.errors:
                # An estimate, which the verified error replaces.
                self._monitor.errors.pop()
            violation, status = self._monitor.judge(flat.reshape(shape), displacement)
            if status is None:
                idle = 0 if violation.error < 0.5 * best else idle + 1
                best = min(best, violation.error)
                if idle > _STALLED:
                    status = Status.STALLED
            if status is not None:
                return flat.reshape(shape), violation, status
            if self._openings is not None and idle == 0:
                goal = _MARGIN * self._openings.error * self._monitor.tolerance / violation.error
                continue
            self._leave_openings()
            gap = self._find_gap(displacement, violation)
            del displacement
            self._descend(flat, gap, violation, max(_MARGIN * self._monitor.tolerance, _GAIN * violation.error))
            del gap

    def _restore(self, pressure: Array) -> Array:
        """Return a flat pressure, changed in place, of the load of the task."""
        pressure = self._control.restore(pressure, self._limit)
        self._limited = self._limited or (self._task.capped and bool((pressure >= self._limit).any()))
        return pressure

    def _leave_openings(self) -> None:
        """Go on with the pressure where the openings have not settled."""
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
        """Iterate until the estimate of the error makes a verification worth its convolution; return the gap."""
        self._started = True
        self._descent.start(pressure, gap)
        error = violation.error
        slow = 0
        best = violation.error
        idle = 0
        while self._monitor.has_iterations_left and self._descent.iterate():
            previous = error
            error = self._descent.error() / violation.scale
            self._monitor.record(error)
            late = error < _LATE * violation.error
            slow = slow + 1 if late and error > _SLOW * previous else 0
            idle = 0 if error < 0.5 * best else idle + 1
            best = min(best, error)
            if error <= goal or slow >= _PATIENCE or idle >= _IDLE:
                break
        return self._descent.stop()
