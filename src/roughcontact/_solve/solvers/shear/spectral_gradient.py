"""Spectral projected gradients on discs: slower and robust."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array, sum_of_products
from roughcontact._solve.convolvers import ShearConvolution
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.driver import Log, iterate
from roughcontact._solve.solvers.shear.base import (
    ShearOutcome,
    ShearSolver,
    ShearSystem,
    ShearTask,
    Verified,
    solve_shear,
)
from roughcontact._solve.solvers.spectral_gradient import ProjectedGradients


@attrs.frozen
class SpectralShearGradient(ShearSolver):
    r"""Projected gradients with Barzilai and Borwein's step, which minimise the energy on the discs.

    .. math:: \min_{|q| \le s} \tfrac12\, q \cdot K q - q \cdot (b + d)

    A nonmonotone line search makes it converge from any start.

    References
    ----------
    Birgin, Martinez, Raydan, SIAM J. Optim. 10 (2000) 1196-1211,
    https://doi.org/10.1137/S1052623497330963
    """

    def solve(self, convolution: ShearConvolution, task: ShearTask) -> ShearOutcome:
        """Return the shear; see `ShearSolver.solve`."""
        return solve_shear(convolution, task, descend_by_gradients)


class _ShearGradients(ProjectedGradients):
    """The energy of a shear; where the force is given it is restored, so that the displacement there has no effect."""

    def __init__(self, system: ShearSystem, start: Verified) -> None:
        super().__init__(lambda values: system.control.project(values, system.limit)[0], sum_of_products)
        self._system = system
        self.length = 1.0 / system.own
        self.found = start

    def measure(self) -> tuple[float, float]:
        """Return the residual, and that by rounding."""
        self.point = self.found.shear
        self.gradient = -self.found.slip
        return self.found.residual, self.found.floor

    def look_ahead(self, step: Array, slope: float) -> tuple[float, float, float]:
        """Return the energy before and after a step, and its curvature."""
        self._system.iterations += 1
        found = self.found
        self._trial = trial = Verified(self._system, self.point + step)
        turned = found.slip - trial.slip - (found.displacement - trial.displacement)[:, np.newaxis]
        return found.energy, trial.energy, sum_of_products(step, turned)

    def is_stuck(self, step: Array, slope: float, curvature: float) -> bool:
        """Return whether there is no step: near rounding its slope has any sign, and the next ones fall again."""
        return not step.any()

    def move(self, step: Array, part: float, end: Array) -> None:
        """Take a part of a step."""
        self.found = self._trial if part == 1.0 else Verified(self._system, self.point + part * step)


def descend_by_gradients(system: ShearSystem, start: Verified, log: Log, tolerance: float) -> tuple[Verified, Status]:
    """Return the shear from a start, and how the solve ended."""
    method = _ShearGradients(system, start)
    status = iterate(method, log, tolerance)
    return method.found, status
