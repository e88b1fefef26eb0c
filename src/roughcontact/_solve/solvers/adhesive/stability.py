"""The stability of an adhesive contact: how far it is from a jump."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from roughcontact._base.arrays import Array, RealArray
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solvers.adhesive.descent import SUPPORT
from roughcontact._solve.solvers.adhesive.gap_problem import make_gap_problem
from roughcontact._solve.solvers.adhesive.stiffness import surface_stiffness
from roughcontact._solve.solvers.base import Task

# Steps of Lanczos' method: of a ball at half of its pull-off force 30 and 60 differ by 1 %.
_STEPS = 30
# Random part of the first vector, over its largest value, so that no mode is missing in it.
_RANDOM = 0.1


def stability_margin(convolution: PreparedConvolution, task: Task, gap: Array, steps: int = _STEPS) -> float:
    r"""Return the stability margin of a state: 1 far from a jump, 0 at one, negative where it is unstable.

    It is the lowest eigenvalue of Z (M + s'(g)) on the open cells, with the stiffness M, the slope s' of the law and
    the preconditioner Z of the descent, found by Lanczos' method.

    Parameters
    ----------
    convolution
        The convolution.
    task
        The task that was solved.
    gap
        Its gap, shape (nx, ny), zero or below where the surfaces touch.
    steps
        Steps of the method, each of two products.
    """
    problem = make_gap_problem(surface_stiffness(convolution), task)
    stiffness = problem.stiffness
    inverse = stiffness.inverse
    symbol = inverse.stiffness.copy()
    symbol[0, 0] = problem.mean_stiffness
    mask = np.ones(stiffness.extended, dtype=bool)
    stiffness.inner(mask)[:] = gap > 0.0
    opened = np.maximum(gap, 0.0)
    slope = np.zeros_like(gap) if task.interaction is None else task.interaction.slope(opened)
    slope = stiffness.embed(slope * (gap > 0.0))
    if not mask.any():
        return 1.0
    cells = mask.astype(np.float64)
    punch = float((inverse.multiply(cells, symbol, inverse.padded) * cells).sum()) / float(cells.sum())
    preconditioner = 1.0 / (symbol + max(SUPPORT * punch, 1e-2 * stiffness.longest))

    def apply(vector: RealArray) -> RealArray:
        return cells * (inverse.multiply(vector, symbol, inverse.padded) + slope * vector)

    def precondition(vector: RealArray) -> RealArray:
        image = cells * inverse.multiply(vector, preconditioner, inverse.padded)
        return image - weights * (float(image.sum()) / total) if problem.holds_mean else image

    weights = cells * inverse.multiply(cells, preconditioner, inverse.padded)
    total = float(weights.sum())
    random = np.random.default_rng(0).standard_normal(cells.shape)
    first = cells * (np.abs(slope) + _RANDOM * float(np.abs(slope).max() or 1.0) * random)
    return _lowest_eigenvalue(apply, precondition, first, steps)


def _lowest_eigenvalue(
    apply: Callable[[RealArray], RealArray],
    precondition: Callable[[RealArray], RealArray],
    first: RealArray,
    steps: int,
) -> float:
    """Return the lowest eigenvalue that Lanczos' method finds, in the metric of the preconditioner."""
    residual = first
    image = precondition(residual)
    norm = float(np.sqrt((residual * image).sum()))
    previous = np.zeros_like(residual)
    diagonal: list[float] = []
    beside: list[float] = []
    for _ in range(steps):
        if not norm > 0.0:
            break
        dual = residual / norm
        vector = image / norm
        residual = apply(vector) - norm * previous if diagonal else apply(vector)
        diagonal.append(float((vector * residual).sum()))
        residual = residual - diagonal[-1] * dual
        image = precondition(residual)
        previous = dual
        norm = float(np.sqrt(max((residual * image).sum(), 0.0)))
        beside.append(norm)
        if norm <= 1e-12 * max(abs(diagonal[-1]), 1.0):
            break
    matrix = np.diag(diagonal) + np.diag(beside[: len(diagonal) - 1], 1) + np.diag(beside[: len(diagonal) - 1], -1)
    return float(np.linalg.eigvalsh(matrix)[0])
