"""The solver of the paper: constrained conjugate gradients after Polonsky and Keer."""

from __future__ import annotations

from functools import partial

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.base import (
    DEFAULT_TOLERANCE,
    Outcome,
    Solver,
    Task,
    iteration_limit,
    positive_tolerance,
    starting_pressure,
)
from roughcontact._solve.solvers.driver import Method, Monitor, Work, iterate, judged
from roughcontact.errors import InputError, argument


@attrs.frozen
class PolonskyKeer(Solver):
    """Conjugate gradients on the cells in contact, equations 9 to 24 of the paper; without a pressure limit.

    Two convolutions an iteration. Three misprints are corrected: the gap is K p + h (eq. 9 has its
    sign reversed, against eq. 19 to 21), the load is the sum times the area of a cell (eq. 22), and
    the pressure is scaled by F/F' (eq. 23). It stops on the conditions of contact themselves (see
    `Violation`) and not on the change of the pressure (eq. 24), which can be small far from the
    solution.

    Parameters
    ----------
    tolerance
        Error (see `Violation`) to be reached.
    max_iterations
        Iterations after which the solve is given up.

    References
    ----------
    Polonsky, Keer, Wear 231 (1999) 206-219, https://doi.org/10.1016/S0043-1648(99)00113-1

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), solver=rc.PolonskyKeer())
    >>> print(problem.solve(force=1.0).status)
    converged: the conditions of contact hold within the tolerance
    """

    tolerance: float = attrs.field(converter=positive_tolerance, default=DEFAULT_TOLERANCE)
    max_iterations: int = attrs.field(converter=iteration_limit, default=10_000)

    def require(self, *, capped: bool = False, approach: bool = False) -> None:
        """Refuse both; see `Solver.require`."""
        if capped:
            raise InputError(
                "The solver 'polonsky-keer' has no pressure limit, but a material has one: use "
                f"{argument('solver', 'auto')}."
            )
        if approach:
            raise InputError(
                f"The solver 'polonsky-keer' needs a load, not an approach: use {argument('solver', 'auto')}."
            )

    def solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        """Return the contact pressure; see `Solver.solve`.

        Raises
        ------
        InputError
            If the pressure is limited or the approach is given.
        """
        self.require(capped=task.capped, approach=task.mean_pressure is None)
        monitor = Monitor(task, self.tolerance, self.max_iterations)
        load = (task.mean_pressure or 0.0) * task.initial_gap.size
        method = _Descent(convolution, task, load, monitor)
        status = iterate(method, monitor, self.tolerance)
        return monitor.outcome(method.pressure, status, method.work.double)


class _Descent(Method):
    """A pressure, the direction t of equations 12 to 18 that led to it, and the square of the gap before that step.

    A direction of None is that of the start, or of a step after which cells overlap: the next one is the gap itself. In
    a contact of one cell there is no descent: a start that leads there is dropped, once.
    """

    def __init__(self, convolution: PreparedConvolution, task: Task, load: float, monitor: Monitor) -> None:
        self.work = Work()
        self._convolve = partial(self.work.convolve, convolution)
        self._convolution = convolution
        self._task = task
        self._load = load
        self._monitor = monitor
        self._direction: Array | None = None
        self._square = 1.0
        self.pressure = starting_pressure(task)

    def measure(self) -> tuple[float, float]:
        """Return the error of the pressure, and that by rounding."""
        displacement = self._convolve(self.pressure)
        self._gap = displacement + self._task.initial_gap
        return judged(self._monitor.measure(self.pressure, displacement))

    def step(self) -> Status | None:
        """Make one step, or begin anew without the start."""
        if not self._advance():
            if self._task.start is None:
                return Status.STALLED
            self._task = attrs.evolve(self._task, start=None)
            self._direction = None
            self.pressure = starting_pressure(self._task)
        return None

    def _advance(self) -> bool:
        """Make one step from the gap; return whether there is a descent."""
        convolution = self._convolution
        contact = self.pressure > 0.0
        gap = _subtract_mean(self._gap, contact, convolution)
        direction = residual = np.where(contact, gap, 0.0)
        square = convolution.dot(residual, residual)
        if self._direction is not None:
            direction = residual + np.where(contact, square / self._square * self._direction, 0.0)
        curvature = convolution.dot(_subtract_mean(self._convolve(direction), contact, convolution), direction)
        if not curvature > 0.0:
            return False
        length = convolution.dot(gap, direction) / curvature
        pressure = np.maximum(self.pressure - length * direction, 0.0)
        overlap = (pressure == 0.0) & (gap < 0.0)
        pressure[overlap] = -length * gap[overlap]
        pressure *= self._load / convolution.sum(pressure)
        self.pressure = pressure
        self._direction = None if overlap.any() else direction
        self._square = square
        return True


def _subtract_mean(values: Array, contact: Mask, convolution: PreparedConvolution) -> Array:
    """Return `values` less their mean over the contact."""
    count = int(np.count_nonzero(contact))
    return values - convolution.sum(np.where(contact, values, 0.0)) / count
