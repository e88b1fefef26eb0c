"""Strengths that count: shear strengths that no traction comes near change nothing, and slow the solves down."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._solve.convolvers import ShearConvolution
from roughcontact._solve.solvers import ShearOutcome, ShearTask, magnitude

# Iterations of the tangential solver.
MAX_SHEAR_ITERATIONS = 2000
# Strengths that count, over the largest traction that a load causes: less would count the edge of a stuck contact, more
# would change the solves of ordinary loads.
_CAUSED_TRACTIONS = 4.0
# Tractions over the maximum pressure that may be rounding.
_ROUNDING_TRACTION = 1e-12
# Traction over the mean one of a force that is looked for first.
_MAX_CONCENTRATION = 1e3
# Part of a bound of the strength that counts as reached, the growth of a bound that is, and the part of a bound below
# which a smaller one is taken.
_REACHED_BOUND = 1.0 - 1e-6
_BOUND_GROWTH = 4.0
_BOUND_SHRINKAGE = 0.5


@attrs.frozen(eq=False)
class StrengthBound:
    """Strengths that count: at most a few times the tractions that a load causes, in dimensionless variables.

    Strengths that no traction comes near change nothing, but an error over them says nothing: of a friction of 10,000,
    or a force of a millionth of that of sliding, any traction would count as right.

    Attributes
    ----------
    strength
        Strength of each cell, shape (nx, ny).
    own
        Displacement of a cell by a unit traction on it.
    peak
        Maximum pressure.
    """

    strength: Array
    own: float
    peak: float

    @property
    def smallest(self) -> float:
        """Smallest traction that is not rounding."""
        return _ROUNDING_TRACTION * self.peak

    def find(self, shear: Array, slip: Array) -> Array:
        """Return the strengths that count for a traction, and for those that would undo its slip, shape (nx, ny)."""
        touching = self.strength > 0.0
        moved = float(magnitude(slip)[touching].max(initial=0.0))
        largest = max(float(magnitude(shear).max()), moved / self.own, self.smallest)
        return np.minimum(self.strength, _CAUSED_TRACTIONS * largest)


def solve_within_strength(
    shear: ShearConvolution,
    task: ShearTask,
    peak: float,
    solve: Callable[[ShearConvolution, ShearTask], ShearOutcome],
) -> ShearOutcome:
    """Return the traction of a task, found with the strengths that count; `peak` is the maximum pressure."""
    counting = StrengthBound(task.limit, 0.5 * sum(shear.own), peak)
    start = task.start
    touching = task.limit > 0.0
    known = [0.0 if start is None else _CAUSED_TRACTIONS * float(magnitude(start).max())]
    # One cell would take more to follow a displacement, and the cells of a contact seldom so much of a force.
    shifts = [float(magnitude(task.offset)[touching].max(initial=0.0)), *map(abs, filter(None, task.displacement))]
    known += [_CAUSED_TRACTIONS * shift / counting.own for shift in shifts]
    known += [_MAX_CONCENTRATION * abs(force or 0.0) / np.count_nonzero(touching) for force in task.shear_force]
    bound = np.minimum(task.limit, max(*known, _CAUSED_TRACTIONS * counting.smallest))
    iterations = 0
    while True:
        outcome = solve(shear, attrs.evolve(task, limit=bound, start=start))
        iterations += outcome.iterations
        outcome = attrs.evolve(outcome, iterations=iterations)
        start = outcome.shear
        if ((magnitude(start) > _REACHED_BOUND * bound) & (bound < task.limit)).any():
            bound = np.minimum(task.limit, _BOUND_GROWTH * float(bound.max()))
            continue
        caused = _find_counting(shear, task, counting, outcome)
        if float(caused.max()) >= _BOUND_SHRINKAGE * float(bound.max()) or iterations >= MAX_SHEAR_ITERATIONS:
            return outcome
        bound = caused


def _find_counting(shear: ShearConvolution, task: ShearTask, counting: StrengthBound, outcome: ShearOutcome) -> Array:
    """Return the strengths that count for what a solve has found, shape (nx, ny)."""
    if _CAUSED_TRACTIONS * magnitude(outcome.shear).max() >= task.limit.max():
        return task.limit
    moved = np.array(outcome.displacement)[:, np.newaxis, np.newaxis] + task.offset
    return counting.find(outcome.shear, moved - shear.apply(outcome.shear))
