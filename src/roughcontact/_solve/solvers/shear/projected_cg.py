"""The default solver of shear: a descent in float32, verified in float64, and a second method if it stalls."""

from __future__ import annotations

import attrs

from roughcontact._solve.convolvers import ShearConvolution
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.driver import Log, Refinement, iterate
from roughcontact._solve.solvers.shear.base import (
    Estimated,
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
        return solve_shear(convolution, task, _refine)

    def approximate(self, convolution: ShearConvolution, task: ShearTask) -> ShearOutcome:
        """Return the shear after one descent, with its estimated residual, if that suffices; else that of `solve`."""
        return solve_shear(convolution, task, _descend_once)


class _ShearRefinement(Refinement):
    """The best shear so far, from which each descent starts."""

    patience = _MAX_IDLE_PASSES
    verifies = True
    goal_fraction = _GOAL_FRACTION
    gain = _FLOAT32_GAIN

    def __init__(self, system: ShearSystem, start: Verified, log: Log, tolerance: float) -> None:
        self._system = system
        self._descent = ShearDescent(system)
        self._log = log
        self._tolerance = tolerance
        self._found = self.best = start

    def measure(self) -> tuple[float, float]:
        """Return the residual of the shear found last, and that by rounding."""
        found = self._found
        self.best = found if found.residual < self.best.residual else self.best
        self.target = max(self._tolerance, self.best.floor)
        return found.residual, self.best.floor

    def descend(self, goal: float) -> None:
        """Lower the residual in float32."""
        self._found = Verified(self._system, self._descent.run(self.best, goal, self._log))


def _refine(system: ShearSystem, start: Verified, log: Log, tolerance: float) -> tuple[Verified, Status]:
    """Return the shear, by a second method if the first stalls, and how the solve ended."""
    refinement = _ShearRefinement(system, start, log, tolerance)
    status = iterate(refinement, log, tolerance)
    if status is not Status.STALLED:
        return refinement.best, status
    found, status = descend_by_gradients(system, refinement.best, log, tolerance)
    return found, Status.RESCUED if status is Status.CONVERGED else status


def _descend_once(
    system: ShearSystem, start: Verified, log: Log, tolerance: float
) -> tuple[Verified | Estimated, Status]:
    """Return the shear after one descent without its verification, and how the solve ended."""
    if start.residual <= tolerance:
        return start, Status.CONVERGED
    descent = ShearDescent(system)
    shear = descent.run(start, max(_GOAL_FRACTION * tolerance, _FLOAT32_GAIN * start.residual), log)
    if descent.error <= tolerance:
        return Estimated(shear, descent.displacement, descent.error), Status.CONVERGED
    return _refine(system, Verified(system, shear), log, tolerance)
