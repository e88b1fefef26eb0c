"""Float64 proofs around the float32 descent."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from roughcontact.checks import Array
from roughcontact.convolvers import PlannedConvolution
from roughcontact.convolvers.inverse import inverse_of
from roughcontact.optimality import Optimality
from roughcontact.solution import Level, Status
from roughcontact.solvers.base import Monitor, Task
from roughcontact.solvers.conjugate.control import ApproachControl, LoadControl, exactly
from roughcontact.solvers.conjugate.descent import Descent
from roughcontact.solvers.conjugate.preconditioner import Preconditioner

# One pass in float32 lowers the error by this much at most; its own rounding ends there.
_GAIN = 2e-5
# The estimate aims a little below the tolerance that the proof has to meet.
_MARGIN = 0.7
# Late in a pass an iteration that does not lower the error to a third is slow; after three a proof is due.
_LATE, _SLOW, _PATIENCE = 3e-3, 1.0 / 3.0, 3
# Iterations of a pass that may go by without the error being halved.
_IDLE = 30
# Proofs that may pass without the error being halved.
_STALLED = 5


class Refinement:
    """Solves one task on one grid from a start.

    The gap of the pressure is computed in float64, and its descent in float32: the increments of the
    gap shrink as it does, so that float32 is as good as float64. Only the float64 gap decides.

    Parameters
    ----------
    convolution
        Displacement from pressure on the grid.
    task
        What is to be solved.
    monitor
        Judges the proofs.
    """

    def __init__(self, convolution: PlannedConvolution, task: Task, monitor: Monitor) -> None:
        self._convolution = convolution
        self._task = task
        self._monitor = monitor
        self._flat_limit = task.limit if isinstance(task.limit, float) else task.limit.ravel()
        load = None if task.mean_pressure is None else task.mean_pressure * task.undeformed.size
        self._control = ApproachControl() if load is None else LoadControl(load)
        self.proofs = 0

    @cached_property
    def _preconditioner(self) -> Preconditioner:
        # A start that needs no descent, such as full contact, needs no preconditioner either.
        lifting = self._task.mean_pressure is None
        return Preconditioner(inverse_of(self._convolution.scene, np.float32), self._convolution, lifting=lifting)

    @cached_property
    def _descent(self) -> Descent:
        return Descent(self._convolution, self._preconditioner, self._control, self._flat_limit)

    @property
    def met_limit(self) -> bool:
        """Whether any step so far was cut short by the limit of the pressure."""
        return len(self._monitor.history) > 1 and self._descent.met_limit

    @property
    def products(self) -> int:
        """Convolutions and inverse convolutions so far, in either precision."""
        level = self.level
        return level.double + level.single + level.inverse

    @property
    def level(self) -> Level:
        """The work so far."""
        shape, iterations = self._task.undeformed.shape, len(self._monitor.history) - 1
        if iterations == 0:
            return Level(shape, 0, self.proofs)
        return Level(shape, iterations, self.proofs, self._descent.products, self._preconditioner.products)

    def run(self, pressure: Array) -> tuple[Array, Optimality, Status]:
        """Solve from `pressure`, shape (nx, ny), in place; return the pressure, its measure and how it ended."""
        shape, flat = pressure.shape, pressure.reshape(-1)
        best, idle = math.inf, 0
        while True:
            flat = exactly(flat, self._control, self._flat_limit)
            displacement = self._convolution.apply(flat.reshape(shape))
            self.proofs += 1
            state, status = self._monitor.prove(flat.reshape(shape), displacement)
            if status is None:
                idle = 0 if state.error < 0.5 * best else idle + 1
                best = min(best, state.error)
                if idle > _STALLED:
                    status = Status.STALLED
            if status is not None:
                return flat.reshape(shape), state, status
            displacement += self._task.undeformed
            displacement -= state.approach
            self._descent.start(flat, displacement.ravel().astype(np.float32))
            del displacement
            self._pass(state)
            self._descent.stop()

    def _pass(self, state: Optimality) -> None:
        """Descend until the estimate of the error says that a proof is worth its convolution."""
        goal = max(_MARGIN * self._monitor.tolerance, _GAIN * state.error)
        error, slow, best, idle = state.error, 0, state.error, 0
        while self._monitor.goes_on() and self._descent.iterate():
            previous, error = error, self._descent.error() / state.scale
            self._monitor.note(error)
            late = error < _LATE * state.error
            slow = slow + 1 if late and error > _SLOW * previous else 0
            idle = 0 if error < 0.5 * best else idle + 1
            best = min(best, error)
            if error <= goal or slow >= _PATIENCE or idle >= _IDLE:
                return
