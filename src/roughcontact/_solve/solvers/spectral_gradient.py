"""Spectral projected gradients: slower and robust, with or without a pressure limit."""

from __future__ import annotations

import abc
import math
from collections import deque
from collections.abc import Callable
from functools import cached_property, partial

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.base import (
    DEFAULT_TOLERANCE,
    Outcome,
    Solver,
    Task,
    iteration_limit,
    nearest_pressure,
    positive_tolerance,
    starting_pressure,
)
from roughcontact._solve.solvers.driver import Method, Monitor, Work, iterate, judge_error, judged

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
        method = _PressureGradients(convolution, task, monitor)
        status = iterate(method, monitor, self.tolerance)
        return monitor.outcome(method.point, status, method.work.double)


class ProjectedGradients(Method):
    """Projected gradients with Barzilai and Borwein's step and a nonmonotone line search, for any quadratic energy.

    Parameters
    ----------
    project
        Returns the admissible point nearest to any other one.
    dot
        Returns the sum of the products of two fields.

    Attributes
    ----------
    point
        The iterate.
    gradient
        The gradient of the energy there, up to what no admissible step changes.
    length
        Length of the next step, in units of the gradient.
    """

    point: Array
    gradient: Array
    length: float

    def __init__(self, project: Callable[[Array], Array], dot: Callable[[Array, Array], float]) -> None:
        self._project = project
        self._dot = dot
        self._energies: deque[float] = deque(maxlen=_ENERGY_MEMORY)

    @abc.abstractmethod
    def look_ahead(self, step: Array, slope: float) -> tuple[float, float, float]:
        """Return the energy before and after a step along which it has a slope, and its curvature."""

    @abc.abstractmethod
    def move(self, step: Array, part: float, end: Array) -> None:
        """Take a part of the last step looked at, which leads to an end."""

    def is_stuck(self, step: Array, slope: float, curvature: float) -> bool:
        """Return whether a step lowers no energy."""
        return not (slope < 0.0 and math.isfinite(curvature))

    def step(self) -> Status | None:
        """Make one step; see `Method.step`."""
        end = self._project(_advance(self.point, self.gradient, -self.length))
        step = end - self.point
        slope = self._dot(self.gradient, step)
        before, after, curvature = self.look_ahead(step, slope)
        if self.is_stuck(step, slope, curvature):
            return Status.STALLED
        self._energies.append(before)
        is_too_high = after > max(self._energies) + _MIN_DECREASE * slope
        if curvature > 0.0:
            # Zero for a given approach on a periodic domain, where a uniform pressure displaces nothing.
            self.length = self._dot(step, step) / curvature
        self.move(step, -slope / curvature if is_too_high and curvature > -slope > 0.0 else 1.0, end)
        return None


class _PressureGradients(ProjectedGradients):
    """The energy of a pressure, whose displacement is updated by that of each step."""

    def __init__(self, convolution: PreparedConvolution, task: Task, monitor: Monitor) -> None:
        super().__init__(partial(nearest_pressure, task=task), convolution.dot)
        self.work = Work()
        self._convolve = partial(self.work.convolve, convolution)
        self._convolution = convolution
        self._task = task
        self._monitor = monitor
        self.point = starting_pressure(task)
        self._displacement = self._convolve(self.point)
        self._exact = True

    def measure(self) -> tuple[float, float]:
        """Return the errors; only an exact displacement may decide, so that rounding does not accumulate."""
        violation = self._monitor.measure(self.point, self._displacement)
        count = len(self._monitor.errors) + 1
        ends = judge_error(*judged(violation), self._monitor.tolerance) or count > self._monitor.max_iterations
        if not self._exact and (ends or count % _REFRESH_INTERVAL == 0):
            self._displacement = self._convolve(self.point)
            self._exact = True
            return self.measure()
        self.gradient = self._displacement + self._task.initial_gap
        self.gradient -= violation.approach
        return judged(violation)

    @cached_property
    def length(self) -> float:  # type: ignore[override]
        """The length of the next step."""
        self.work.double += 1
        return _first_length(self.gradient, self._convolution)

    def look_ahead(self, step: Array, slope: float) -> tuple[float, float, float]:
        """Return the energy before and after a step, and its curvature."""
        self._change = self._convolve(step)
        curvature = self._dot(step, self._change)
        before = _energy(self.point, self._displacement, self.gradient, self._convolution)
        return before, before + slope + 0.5 * curvature, curvature

    def move(self, step: Array, part: float, end: Array) -> None:
        """Take a part of a step."""
        self.point = end if part == 1.0 else np.clip(_advance(self.point, step, part), 0.0, self._task.pressure_limit)
        self._displacement = _advance(self._displacement, self._change, part)
        self._exact = False


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
