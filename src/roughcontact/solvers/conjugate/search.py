"""A given approach near full contact, found through loads.

There the approach hardly depends on the load any more: the load that belongs to an approach is badly
determined by it, while every load can be solved for, and gives its approach.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import attrs
import numpy as np

from roughcontact.checks import Array
from roughcontact.convolvers import PlannedConvolution
from roughcontact.convolvers.inverse import inverse_of
from roughcontact.grid import Boundary
from roughcontact.solution import Status
from roughcontact.solvers.base import Monitor, Outcome, Task

_TRIES = 60
# How fast the gap that is left closes with the load that is missing, as powers of each other: a guess.
_POWER = 2.0
# The search begins with no less than this share of the closing load missing.
_NEAREST = 1e-9


@attrs.frozen(eq=False)
class Found:
    """An outcome, its approach, and whether the limit of the pressure cut any step short on the way to it."""

    outcome: Outcome
    approach: float
    met_limit: bool


def searchable(convolution: PlannedConvolution, task: Task) -> bool:
    """Tell whether the task is one of an approach that loads can be searched for."""
    periodic = convolution.scene.boundary is Boundary.PERIODIC
    return periodic and task.approach is not None and bool(np.isinf(task.limit).all())


def by_load(
    solve: Callable[[Task], Found],
    convolution: PlannedConvolution,
    task: Task,
    monitor: Monitor,
    pressure: Array,
) -> Outcome:
    """Solve for loads until one gives the approach.

    The logarithms of the missing load and of the gap that is left are nearly in proportion, so that
    the secant through the last two, kept inside a bracket, finds it in a few steps.

    Parameters
    ----------
    solve
        Solves a task of given load; returns the approach as well.
    convolution, task, monitor
        What is to be solved, and who judges it.
    pressure
        A pressure to begin with, shape (nx, ny).
    """
    assert task.approach is not None
    left = float(task.undeformed.mean()) - task.approach
    closing = float(inverse_of(convolution.scene).apply(task.undeformed).max())
    low, high = -math.inf, math.log(closing)
    missing = math.log(max(closing - float(pressure.mean()), _NEAREST * closing))
    power, before, work = _POWER, None, []
    for _ in range(_TRIES):
        mean = closing - math.exp(missing)
        start = pressure * (mean / float(pressure.mean()))
        found = solve(attrs.evolve(task, approach=None, mean_pressure=mean, start=start))
        outcome, approach = found.outcome, found.approach
        pressure = outcome.pressure
        work.append(outcome)
        _, status = monitor.judge(pressure, convolution.apply(pressure))
        if status is not None or not outcome.status.success:
            break
        excess = math.log(max(left + task.approach - approach, _NEAREST * left) / left)
        low, high = (low, missing) if excess > 0.0 else (missing, high)
        if before is not None and (missing - before[0]) * (excess - before[1]) > 0.0:
            power = (excess - before[1]) / (missing - before[0])
        before, trial = (missing, excess), missing - excess / power
        if not low < trial < high:
            trial = 0.5 * (low + high) if math.isfinite(low) else high - 1.0
        missing = trial
    return Outcome(
        pressure=pressure,
        status=status or Status.STALLED,
        iterations=sum(outcome.iterations for outcome in work),
        convolutions=sum(outcome.convolutions + 1 for outcome in work),
        history=tuple(error for outcome in work for error in outcome.history),
    )
