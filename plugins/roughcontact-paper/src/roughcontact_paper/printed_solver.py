"""The algorithm of the paper as it is printed, for comparison."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt
import roughcontact as rc
from roughcontact.typing import Outcome, PreparedConvolution, Task

Array = npt.NDArray[np.float64]


@attrs.frozen
class PrintedPolonskyKeer(rc.Solver):
    """Equations 9 to 24 of the paper with their own stopping rule, and the pressure limit within the iteration.

    It stops where the pressure changes by less than `change` of the load (eq. 24, divided by the load). That need not
    be near the solution: the status of a result is what `ContactProblem` finds on its pressure. The misprints that
    would keep it from converging are corrected: the sign of eq. 9, the area of a cell in eq. 22, F/F' in eq. 23.

    Of the limit the paper says only "the maximum contact pressure is set to 6 GPa". Here what exceeds it is cut after
    the load is restored. Restoring by one factor cannot raise saturated cells, so that the load comes out too small.

    Parameters
    ----------
    change
        Change of the pressure in one iteration at which it stops, relative to the load; the paper states none.
    release_saturated
        Treat the limit like zero: saturated cells leave the set of eq. 10 to 19, and those whose gap opens return, as
        those of eq. 20 do. Not in the paper, where all cells with p > 0 belong to the set.
    tolerance
        Error (see `roughcontact.typing.Violation`) up to which the result counts as converged.
    max_iterations
        Iterations after which the solve is given up.

    References
    ----------
    https://doi.org/10.1080/17515831.2020.1720382; Polonsky, Keer, Wear 231 (1999) 206-219,
    https://doi.org/10.1016/S0043-1648(99)00113-1
    """

    change: float = attrs.field(default=1e-6, validator=attrs.validators.gt(0.0))
    release_saturated: bool = False
    tolerance: float = attrs.field(default=1e-8, validator=attrs.validators.gt(0.0))
    max_iterations: int = attrs.field(default=1000, validator=attrs.validators.ge(1))

    def require(self, *, capped: bool = False, approach: bool = False) -> None:
        """Refuse a given approach: the equations are those of a given load."""
        if approach:
            raise rc.InputError("The solver 'paper-as-printed' needs a load, not an approach: use solver='auto'.")

    def solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        """Return the pressure at which the change is small."""
        self.require(approach=task.mean_pressure is None)
        limit = task.pressure_limit
        load = float(task.mean_pressure or 0.0) * task.initial_gap.size
        pressure = np.full(task.initial_gap.shape, task.mean_pressure) if task.start is None else np.array(task.start)
        direction = np.zeros_like(pressure)
        square = 1.0
        restart = True
        errors: list[float] = []
        status = rc.Status.MAXIMUM_ITERATIONS
        while len(errors) < self.max_iterations:
            before = pressure
            contact = (pressure > 0.0) & (pressure < limit) if self.release_saturated else pressure > 0.0
            if not contact.any():
                status = rc.Status.STALLED
                break
            gap = _relative_to_contact(convolution.apply(pressure) + task.initial_gap, contact)  # eq. 9 to 11
            new_square = float(np.sum(gap[contact] ** 2))  # eq. 12
            direction = np.where(
                contact, gap + (0.0 if restart else new_square / square) * direction, 0.0
            )  # eq. 13, 14
            square = new_square
            response = _relative_to_contact(convolution.apply(direction), contact)  # eq. 15 to 17
            curvature = float(np.sum(response[contact] * direction[contact]))
            if not curvature > 0.0:
                status = rc.Status.STALLED
                break
            step = float(np.sum(gap[contact] * direction[contact])) / curvature  # eq. 18
            pressure = np.clip(pressure - step * direction, 0.0, limit)  # eq. 19
            wrong = (pressure == 0.0) & (gap < 0.0)  # eq. 20
            if self.release_saturated:
                wrong |= (pressure == limit) & (gap > 0.0)
            restart = bool(wrong.any())
            pressure = np.where(wrong, pressure - step * gap, pressure)  # eq. 21
            pressure = np.clip(pressure * (load / pressure.sum()), 0.0, limit)  # eq. 22, 23
            errors.append(float(np.abs(pressure - before).sum()) / load)  # eq. 24
            if not np.isfinite(errors[-1]):
                return _make_outcome(before, rc.Status.NOT_FINITE, errors)
            if errors[-1] <= self.change:
                status = rc.Status.CONVERGED
                break
        return _make_outcome(pressure, status, errors)


def _make_outcome(pressure: Array, status: rc.Status, errors: list[float]) -> Outcome:
    count = len(errors)
    return Outcome(pressure=pressure, status=status, iterations=count, convolutions=2 * count, errors=tuple(errors))


def _relative_to_contact(values: Array, contact: npt.NDArray[np.bool_]) -> Array:
    return np.asarray(values - values[contact].mean())
