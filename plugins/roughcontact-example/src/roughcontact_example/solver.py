"""A solver."""

import attrs
import numpy as np
import scipy

import roughcontact as rc
from roughcontact.typing import Monitor


@attrs.frozen
class AcceleratedGradient(rc.Solver):
    """Minimise the energy p.Kp/2 + p.h over 0 <= p <= limit at the given load, by Nesterov's projected gradients.

    The momentum is restarted where it points uphill (O'Donoghue and Candes, Found. Comput. Math. 15 (2015) 715-732,
    https://doi.org/10.1007/s10208-013-9150-3).
    """

    tolerance: float = 1e-8
    max_iterations: int = 10_000

    def solve(self, convolution, task):
        """Return the pressure that carries the load."""
        monitor = Monitor(task, self.tolerance, self.max_iterations)
        pressure = project(np.zeros(task.initial_gap.shape) if task.start is None else task.start, task)
        displacement = convolution.apply(pressure)
        convolutions = 1
        point = pressure
        point_displacement = displacement
        curvature = 1.0
        age = 0
        state, status = monitor.judge(pressure, displacement)
        while status is None:
            # The energy of `point` falls along its gradient, which is the gap there.
            gap = point_displacement + task.initial_gap - state.approach
            new = project(point - gap / curvature, task)
            new_displacement = convolution.apply(new)
            convolutions += 1
            step = new - point
            change = new - pressure
            if norm := convolution.dot(step, step):
                curvature = max(curvature, 1.1 * convolution.dot(step, new_displacement - point_displacement) / norm)
            age = age + 1 if convolution.dot(step, change) >= 0.0 else 0
            momentum = age / (age + 3)
            # The convolution is linear, so that extrapolation costs no further one.
            point = new + momentum * change
            point_displacement = new_displacement + momentum * (new_displacement - displacement)
            pressure = new
            displacement = new_displacement
            state, status = monitor.judge(pressure, displacement)
        return monitor.outcome(pressure, status, convolutions)


def project(values, task):
    """Return the nearest pressure between zero and the limit, of the given mean where the load is given."""
    limit = task.pressure_limit
    mean = task.mean_pressure
    if mean is None:
        return np.clip(values, 0.0, limit)
    if mean >= np.mean(limit):
        return np.full(values.shape, limit)
    lowest = values.min() - 2.0 * min(np.max(limit), values.size * mean)
    shift = scipy.optimize.brentq(
        lambda shift: np.clip(values - shift, 0.0, limit).mean() - mean, lowest, values.max(), xtol=1e-300
    )
    pressure = np.clip(values - shift, 0.0, limit)
    elastic = (pressure > 0.0) & (pressure < limit)
    # The shift is rounded, but the load must hold to 1e-12.
    pressure[elastic] += (mean * values.size - pressure.sum()) / max(1, elastic.sum())
    return np.clip(pressure, 0.0, limit)
