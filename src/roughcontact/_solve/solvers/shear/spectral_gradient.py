"""Spectral projected gradients on discs: slower and robust."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import sum_of_products
from roughcontact._solve.convolvers import ShearConvolution
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.shear.base import (
    ShearOutcome,
    ShearSolver,
    ShearSystem,
    ShearTask,
    Verified,
    solve_shear,
)
from roughcontact._solve.solvers.spectral_gradient import SpectralSearch


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


def descend_by_gradients(
    system: ShearSystem, found: Verified, task: ShearTask, iterations: int = 0
) -> tuple[Verified, Status, int]:
    """Return the shear from a start, how the solve ended, and the iterations, of which some may have been made."""
    search = SpectralSearch(1.0 / system.own)
    while (status := found.judge(task.tolerance)) is None:
        if iterations >= task.max_iterations:
            return found, Status.MAXIMUM_ITERATIONS, iterations
        iterations += 1
        # With the force restored, the displacement of an axis with a given force does not matter.
        step = system.control.project(found.shear + search.length * found.slip, system.limit)[0] - found.shear
        if not step.any():
            return found, Status.STALLED, iterations
        slope = -sum_of_products(found.slip, step)
        trial = Verified(system, found.shear + step)
        turned = found.slip - trial.slip - (found.displacement - trial.displacement)[:, np.newaxis]
        part = search.find_part(
            found.energy, trial.energy, slope, sum_of_products(step, turned), sum_of_products(step, step)
        )
        found = trial if part == 1.0 else Verified(system, found.shear + part * step)
    return found, status, iterations
