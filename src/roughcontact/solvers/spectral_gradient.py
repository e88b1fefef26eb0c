"""Spectral projected gradients: the robust solver, with or without a pressure limit."""

from __future__ import annotations

import math
from collections import deque

import attrs
import numpy as np

from roughcontact.checks import Array
from roughcontact.convolvers import PlannedConvolution
from roughcontact.solution import Status
from roughcontact.solvers.base import (
    Monitor,
    Outcome,
    Solver,
    Task,
    iteration_limit,
    positive_tolerance,
    starting_pressure,
)
from roughcontact.solvers.projection import onto_load

# A step may raise the energy, but not above the greatest of so many before it.
_MEMORY = 10
_DECREASE = 1e-4
# Iterations between exact displacements, which are otherwise carried along.
_REFRESH = 50


@attrs.frozen
class SpectralGradient(Solver):
    r"""Minimise the energy by gradients projected onto 0 <= p <= limit at the given load.

    .. math:: \min_p \tfrac12\, p \cdot K p + h \cdot p

    with Barzilai and Borwein's step and a nonmonotone line search, which together converge from
    anywhere. One convolution an iteration: the energy is quadratic, so its change along a step is
    known from the displacement that the step causes.

    Parameters
    ----------
    tolerance
        Error (see `Optimality`) to be reached.
    max_iterations
        Iterations after which it gives up.

    References
    ----------
    Birgin, Martinez, Raydan, SIAM J. Optim. 10 (2000) 1196-1211,
    https://doi.org/10.1137/S1052623497330963
    """

    tolerance: float = attrs.field(converter=positive_tolerance, default=1e-8)
    max_iterations: int = attrs.field(converter=iteration_limit, default=10_000)

    def solve(self, convolution: PlannedConvolution, task: Task) -> Outcome:
        """Return the pressure that carries the load; see `Solver.solve`."""
        monitor = Monitor(task, self.tolerance, self.max_iterations)
        pressure = starting_pressure(task)
        displacement, convolutions, exact = convolution.apply(pressure), 1, True
        energies: deque[float] = deque(maxlen=_MEMORY)
        length = math.nan
        while True:
            state, status = monitor.judge(pressure, displacement)
            if not exact and (status is not None or len(monitor.history) % _REFRESH == 0):
                # Only an exact displacement may decide, so that rounding is not carried along.
                displacement, convolutions, exact = convolution.apply(pressure), convolutions + 1, True
                monitor.history.pop()
                continue
            if status is not None:
                return monitor.outcome(pressure, status, convolutions)
            gradient = displacement + task.undeformed
            gradient -= state.approach
            energies.append(_energy(pressure, displacement, gradient, convolution))
            if math.isnan(length):
                length, convolutions = _first_length(gradient, convolution), convolutions + 1
            projected = _projected(_moved(pressure, gradient, -length), task)
            step = projected - pressure
            change = convolution.apply(step)
            convolutions += 1
            slope, curvature = convolution.dot(gradient, step), convolution.dot(step, change)
            if not (slope < 0.0 and curvature > 0.0):
                return monitor.outcome(pressure, Status.STALLED, convolutions)
            part = 1.0
            if energies[-1] + slope + 0.5 * curvature > max(energies) + _DECREASE * slope:
                part = min(1.0, -slope / curvature)
            length = convolution.dot(step, step) / curvature
            pressure = projected if part == 1.0 else np.clip(_moved(pressure, step, part), 0.0, task.limit)
            displacement, exact = _moved(displacement, change, part), False


def _projected(values: Array, task: Task) -> Array:
    """Return the nearest pressure that the task allows."""
    if task.mean_pressure is None:
        return np.asarray(np.clip(values, 0.0, task.limit))
    return onto_load(values, task.mean_pressure, task.limit)


def _moved(start: Array, direction: Array, length: float) -> Array:
    moved = direction * length
    moved += start
    return moved


def _energy(pressure: Array, displacement: Array, gradient: Array, convolution: PlannedConvolution) -> float:
    """Return p.Kp/2 + p.h up to a constant: the gradient stands for Kp + h less its level."""
    return convolution.dot(pressure, gradient) - 0.5 * convolution.dot(pressure, displacement)


def _first_length(gradient: Array, convolution: PlannedConvolution) -> float:
    """Return the step that minimises the energy along the gradient, the load kept, without bounds."""
    direction = gradient - convolution.sum(gradient) / gradient.size
    return convolution.dot(direction, direction) / convolution.dot(direction, convolution.apply(direction))
