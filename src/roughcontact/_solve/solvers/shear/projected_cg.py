"""The default solver of shear: a descent in float32, verified in float64, and a second method if it stalls."""

from __future__ import annotations

import attrs

from roughcontact._solve.convolvers import ShearConvolution
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.base import IdleCount
from roughcontact._solve.solvers.shear.base import (
    ShearOutcome,
    ShearSolver,
    ShearSystem,
    ShearTask,
    Verified,
    solve_shear,
)
from roughcontact._solve.solvers.shear.descent import ShearDescent
from roughcontact._solve.solvers.shear.spectral_gradient import descend_by_gradients

# Goal of the estimated residual, over the tolerance of the verification.
_GOAL_FRACTION = 0.6
# Minimum factor of a pass in float32 on the residual.
_FLOAT32_GAIN = 3e-5
# Maximum passes that do not halve the residual.
_MAX_IDLE_PASSES = 3


@attrs.frozen
class ProjectedShearCG(ShearSolver):
    r"""Projected conjugate gradients on discs, preconditioned by the inverse kernel and the curvature of the circles.

    For given limits the problem of stick and slip is a convex one, a quadratic energy on a disc for each cell. A cell
    that sticks is free; one that slips moves along its circle, where the curvature of the circle adds to the kernel. If
    the descent stalls, `SpectralShearGradient` continues.

    References
    ----------
    Vollebregt, J. Optim. Theory Appl. 162 (2014) 862-879, https://doi.org/10.1007/s10957-013-0499-x, for pressures
    """

    def solve(self, convolution: ShearConvolution, task: ShearTask) -> ShearOutcome:
        """Return the shear; see `ShearSolver.solve`."""
        return solve_shear(convolution, task, _descend)


def _descend(system: ShearSystem, best: Verified, task: ShearTask) -> tuple[Verified, Status, int]:
    """Return the shear from a start, how the solve ended, and the iterations."""
    descent = ShearDescent(system)
    idles = IdleCount(best.residual)
    while (status := best.judge(task.tolerance)) is None and descent.iterations < task.max_iterations:
        goal = max(_GOAL_FRACTION * max(task.tolerance, best.floor), _FLOAT32_GAIN * best.residual)
        found = Verified(system, descent.run(best, goal, task.max_iterations))
        best = found if found.residual < best.residual else best
        if idles.add(found.residual) == _MAX_IDLE_PASSES:
            found, status, iterations = descend_by_gradients(system, best, task, descent.iterations)
            return found, Status.RESCUED if status is Status.CONVERGED else status, iterations
    return best, status or Status.MAXIMUM_ITERATIONS, descent.iterations
