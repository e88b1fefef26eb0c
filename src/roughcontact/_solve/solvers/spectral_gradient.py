"""Spectral projected gradients: slower and robust, with or without a pressure limit."""

from __future__ import annotations

import math
from collections import deque

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.base import (
    DEFAULT_TOLERANCE,
    Monitor,
    Outcome,
    Solver,
    Task,
    iteration_limit,
    nearest_pressure,
    positive_tolerance,
    starting_pressure,
)

# A step may raise the energy up to the maximum of the last 10, less 1e-4 of the predicted decrease: values of Birgin,
# Martinez and Raydan (2000).
_ENERGY_MEMORY = 10
_MIN_DECREASE = 1e-4
# Iterations between exact displacements; each update in between rounds by an eps or two, so that 50 stay well below the
# resolution of 1e-5.
_REFRESH_INTERVAL = 50


@attrs.frozen
class SpectralGradient(Solver):
    r"""Projected gradients with Barzilai and Borwein's step, which minimise the energy within the bounds.

    .. math:: \min_{0 \le p \le p_\mathrm{limit}} \tfrac12\, p \cdot K p + h \cdot p

    A nonmonotone line search makes it converge from any start. One convolution an iteration: the
    energy is quadratic, so that its change along a step follows from the displacement by the step.

    Parameters
    ----------
    tolerance
        Error (see `Violation`) to be reached.
    max_iterations
        Iterations after which the solve is given up.

    References
    ----------
    Birgin, Martinez, Raydan, SIAM J. Optim. 10 (2000) 1196-1211,
    https://doi.org/10.1137/S1052623497330963

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), solver=rc.SpectralGradient())
    >>> print(problem.solve(force=1.0).status)
    converged: the conditions of contact hold within the tolerance
    """

    tolerance: float = attrs.field(converter=positive_tolerance, default=DEFAULT_TOLERANCE)
    max_iterations: int = attrs.field(converter=iteration_limit, default=10_000)

    def solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        monitor = Monitor(task, self.tolerance, self.max_iterations)
        pressure = starting_pressure(task)
        displacement = convolution.apply(pressure)
        convolutions = 1
        exact = True
        search: SpectralSearch | None = None
        while True:
            violation, status = monitor.judge(pressure, displacement)
            if not exact and (status is not None or len(monitor.errors) % _REFRESH_INTERVAL == 0):
                # Only an exact displacement may decide, so that rounding does not accumulate.
                displacement = convolution.apply(pressure)
                convolutions += 1
                exact = True
                monitor.errors.pop()
                continue
            if status is not None:
                return monitor.outcome(pressure, status, convolutions)
            gradient = displacement + task.initial_gap
            gradient -= violation.approach
            if search is None:
                search = SpectralSearch(_first_length(gradient, convolution))
                convolutions += 1
            projected = nearest_pressure(_advance(pressure, gradient, -search.length), task)
            step = projected - pressure
            change = convolution.apply(step)
            convolutions += 1
            slope = convolution.dot(gradient, step)
            curvature = convolution.dot(step, change)
            if not (slope < 0.0 and math.isfinite(curvature)):
                return monitor.outcome(pressure, Status.STALLED, convolutions)
            before = _energy(pressure, displacement, gradient, convolution)
            after = before + slope + 0.5 * curvature
            part = search.find_part(before, after, slope, curvature, convolution.dot(step, step))
            pressure = projected if part == 1.0 else np.clip(_advance(pressure, step, part), 0.0, task.pressure_limit)
            displacement = _advance(displacement, change, part)
            exact = False


class SpectralSearch:
    """The length of the steps along projected gradients, after Barzilai and Borwein, with a nonmonotone line search.

    Attributes
    ----------
    length
        Length of the next step, in units of the gradient.
    """

    def __init__(self, length: float) -> None:
        self.length = length
        self._energies: deque[float] = deque(maxlen=_ENERGY_MEMORY)

    def find_part(self, before: float, after: float, slope: float, curvature: float, square: float) -> float:
        """Return the part of a step to be taken, and choose the length of the next one.

        Parameters
        ----------
        before, after
            Energy at both ends of the step.
        slope, curvature
            Derivatives of the energy along the step, at its start.
        square
            Square of the step.
        """
        self._energies.append(before)
        is_too_high = after > max(self._energies) + _MIN_DECREASE * slope
        if curvature > 0.0:
            # Zero for a given approach on a periodic domain, where a uniform pressure displaces nothing.
            self.length = square / curvature
        return -slope / curvature if is_too_high and curvature > -slope > 0.0 else 1.0


def _advance(start: Array, direction: Array, length: float) -> Array:
    result = direction * length
    result += start
    return result


def _energy(pressure: Array, displacement: Array, gradient: Array, convolution: PreparedConvolution) -> float:
    """Return p.Kp/2 + p.h up to a constant: the gradient is Kp + h less the approach."""
    return convolution.dot(pressure, gradient) - 0.5 * convolution.dot(pressure, displacement)


def _first_length(gradient: Array, convolution: PreparedConvolution) -> float:
    """Return the step that minimises the energy along the gradient at constant load, without bounds."""
    direction = gradient - convolution.sum(gradient) / gradient.size
    square = convolution.dot(direction, direction)
    curvature = convolution.dot(direction, convolution.apply(direction))
    # Lengths are in cells and E* = 1: a pressure displaces its own cell by about its own value.
    return square / curvature if curvature > 0.0 else 1.0
