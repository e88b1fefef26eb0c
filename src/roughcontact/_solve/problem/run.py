"""One solve: the solver's outcome, certified."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import attrs
import numpy as np

from roughcontact._base.checks import Array
from roughcontact._base.machine import use_threads
from roughcontact._parts.load import Load
from roughcontact._solve.problem.body import InitialGap
from roughcontact._solve.problem.certificate import certify
from roughcontact._solve.problem.task import LOAD_TOLERANCE, make_task
from roughcontact._solve.solution import ContactSolution
from roughcontact._solve.solvers import Step
from roughcontact.errors import NotConverged

if TYPE_CHECKING:
    from roughcontact._solve.problem.problem import ContactProblem

# Depth of non-measured points that touch, over the sum of the last depth and the approach, and the exponent that it
# gets in the last round: after eight rounds they are 4^36 = 5e21 times deeper.
_DEEPER = 4.0
_MAXIMUM_DEEPENED = 8


def run_solve(
    problem: ContactProblem,
    gap: InitialGap,
    load: Load,
    start: Array | None,
    on_step: Callable[[Step], None] | None,
) -> ContactSolution:
    """Return the certified solution at a load, which may be unfinished, without its origin."""
    started = time.perf_counter()
    with computing(problem):
        return _solve(problem, gap, load, start, on_step, started)


@contextlib.contextmanager
def computing(problem: ContactProblem) -> Iterator[None]:
    """Limit the threads used inside the context to those of a problem."""
    threads = problem.plan.thread_choice[0]
    with use_threads(threads), problem.convolution.use_threads(threads):
        yield


def _solve(
    problem: ContactProblem,
    gap: InitialGap,
    load: Load,
    start: Array | None,
    on_step: Callable[[Step], None] | None,
    started: float,
) -> ContactSolution:
    """Solve until no non-measured point touches; `started` is the time of the clock at the start."""
    plan = problem.plan
    deepened = 0
    while True:
        task = attrs.evolve(make_task(plan, gap.values, load, start), on_step=on_step)
        outcome = plan.solver.solve(problem.convolution, task)
        # A clock may be set back, as on a machine that was suspended.
        seconds = max(0.0, time.perf_counter() - started)
        solution = certify(plan, problem.convolution, gap.values, task, outcome, seconds=seconds)
        excess = gap.sum_non_measured(solution.pressure)
        touch = LOAD_TOLERANCE * float(solution.pressure.sum()) < excess < math.inf if excess else False
        if not touch or deepened == _MAXIMUM_DEEPENED:
            break
        # Non-measured points do not touch, however large the approach.
        deepened += 1
        gap = gap.with_depth(_DEEPER**deepened * (float(gap.values.max()) + abs(solution.approach)))
    if excess > 0.0:
        # The load of the measured points alone: the certificate tells whether it lacks more than rounding.
        outcome = attrs.evolve(outcome, pressure=np.where(np.asarray(gap.non_measured), 0.0, outcome.pressure))
        solution = certify(plan, problem.convolution, gap.values, task, outcome, seconds=seconds)
    return solution


def require_success(solution: ContactSolution) -> ContactSolution:
    """Return the solution, or raise `NotConverged` if it is not certified or not as accurate as was asked."""
    if not solution.status.success:
        status = f"The contact is {solution.status} ({solution.iterations} iterations; {solution.residuals})."
        raise NotConverged(" ".join((status, *solution.warnings)), solution)
    if solution.accuracy is not None and not solution.accuracy.met:
        raise NotConverged(solution.accuracy.explain(), solution)
    return solution
