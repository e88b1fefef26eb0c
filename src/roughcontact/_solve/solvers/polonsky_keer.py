"""The solver of the paper: constrained conjugate gradients after Polonsky and Keer."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.base import (
    DEFAULT_TOLERANCE,
    Monitor,
    Outcome,
    Solver,
    Task,
    iteration_limit,
    positive_tolerance,
    starting_pressure,
)
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
        # In a contact of one cell there is no descent: a start that leads there is dropped, once.
        spare = None if task.start is None else attrs.evolve(task, start=None)
        state: _State | None = _State(starting_pressure(task))
        convolutions = 0
        while state is not None:
            pressure = state.pressure
            displacement = convolution.apply(pressure)
            convolutions += 1
            _, status = monitor.judge(pressure, displacement)
            if status is not None:
                return monitor.outcome(pressure, status, convolutions)
            state = state.advance(displacement + task.initial_gap, load, convolution)
            convolutions += 1
            if state is None and spare is not None:
                state = _State(starting_pressure(spare))
                spare = None
        return monitor.outcome(pressure, Status.STALLED, convolutions)


@attrs.frozen(eq=False)
class _State:
    """A pressure, the direction t of equations 12 to 18 that led to it, and the square of the gap before that step.

    A direction of None is that of the start, or of a step after which cells overlap: the next one is the gap itself.
    """

    pressure: Array
    direction: Array | None = None
    square: float = 1.0

    def advance(self, gap: Array, load: float, convolution: PreparedConvolution) -> _State | None:
        """Return the state after one step, from the gap; None if there is no descent."""
        contact = self.pressure > 0.0
        gap = _subtract_mean(gap, contact, convolution)
        direction = residual = np.where(contact, gap, 0.0)
        square = convolution.dot(residual, residual)
        if self.direction is not None:
            direction = residual + np.where(contact, square / self.square * self.direction, 0.0)
        curvature = convolution.dot(_subtract_mean(convolution.apply(direction), contact, convolution), direction)
        if not curvature > 0.0:
            return None
        length = convolution.dot(gap, direction) / curvature
        pressure = np.maximum(self.pressure - length * direction, 0.0)
        overlap = (pressure == 0.0) & (gap < 0.0)
        pressure[overlap] = -length * gap[overlap]
        pressure *= load / convolution.sum(pressure)
        return _State(pressure, None if overlap.any() else direction, square)


def _subtract_mean(values: Array, contact: Mask, convolution: PreparedConvolution) -> Array:
    """Return `values` less their mean over the contact."""
    count = int(np.count_nonzero(contact))
    return values - convolution.sum(np.where(contact, values, 0.0)) / count
