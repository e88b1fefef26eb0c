"""Claims about solvers."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import RealArray
from roughcontact.convolvers import PlannedConvolution
from roughcontact.convolvers.base import Scene
from roughcontact.errors import InputError
from roughcontact.loads import LOAD_TOLERANCE, task_of
from roughcontact.solution import Status
from roughcontact.solvers import Solver
from roughcontact.testing.claim import Claim, DoesNotApply, require
from roughcontact.testing.common import common
from roughcontact.testing.scenes import allowed, judge, taken, trials

_CALLS = 4


def _tolerance(solver: Solver) -> str:
    require(solver.tolerance > 0.0 and np.isfinite(solver.tolerance), f"its tolerance is {solver.tolerance!r}")
    return f"{solver.tolerance:g}"


def _serves(solver: Solver) -> str:
    served, refused = set(), set()
    for trial in trials():
        try:
            trial.problem(solver).solve(throw=False, **trial.load)
        except InputError as error:
            require(len(str(error).split()) >= 4, f"it refuses {trial} with {str(error)!r}, which is no sentence")
            refused.add(str(error))
        else:
            served.add(str(trial))
    require(any("of E* slope" in name for name in served), "it serves no elastic contact at a given load")
    return f"{len(served)} kinds of problem; refuses {len(refused)} in words" if refused else "every problem"


def _conditions(solver: Solver) -> str:
    worst = 0.0
    for trial, problem, solution in taken(solver):
        require(solution.status.success, f"{trial}: {solution.status}")
        found = judge(problem, trial.load, solution)
        bound = allowed(solver, found, solution)
        require(found.error <= bound, f"{trial}: off by {found.error:.1e}, where {bound:.1e} is promised")
        worst = max(worst, found.error)
    return f"hold to {worst:.0e} of the scale at most"


def _honest(solver: Solver) -> str:
    for trial, problem, solution in taken(solver):
        require(solution.status is not Status.UNCONFIRMED, f"{trial}: it claims success, and the residuals do not")
        if solution.status.success:
            found = judge(problem, trial.load, solution)
            wrong = found.error > allowed(solver, found, solution)
            require(not wrong, f"{trial}: {solution.status}, and yet it is off by {found.error:.1e}")
    return "what it calls converged is so"


def _load(solver: Solver) -> str:
    worst = 0.0
    for trial, problem, solution in taken(solver):
        worst = max(worst, judge(problem, trial.load, solution).load)
        require(worst <= LOAD_TOLERANCE, f"{trial}: the load is off by {worst:.1e}")
    return f"carried to {worst:.0e}"


def _bounds(solver: Solver) -> str:
    # Judged on what the solver itself returns: a certificate would cut it off.
    for trial, problem, _ in taken(solver):
        task = task_of(problem.plan, problem.undeformed, **trial.load)
        pressure = solver.solve(problem.convolution, task).pressure
        lowest, over = float(pressure.min()), float(np.max(pressure - task.limit))
        require(lowest >= 0.0, f"{trial}: a pressure of {lowest:.1e}")
        require(over <= 0.0, f"{trial}: a pressure of {over:.1e} above the limit")
    return "no pressure below zero or above the limit, bit for bit"


def _untouched(solver: Solver) -> str:
    for trial, problem, solution in taken(solver):
        task = task_of(problem.plan, problem.undeformed, start=solution.pressure, **trial.load)
        limit = np.array(task.limit) if np.ndim(task.limit) else task.limit
        start = None if task.start is None else np.array(task.start)
        given = attrs.evolve(task, undeformed=np.array(task.undeformed), limit=limit, start=start)
        solver.solve(problem.convolution, given)
        for name in ("undeformed", "limit", "start"):
            same = np.array_equal(getattr(given, name), getattr(task, name))
            require(same, f"{trial}: it changed the {name} of its task")
    return "gap, limit and start are left as they were"


def _repeatable(solver: Solver) -> str:
    for trial, _, solution in taken(solver):
        again = trial.problem(solver).solve(throw=False, **trial.load)
        require(np.array_equal(solution.pressure, again.pressure), f"{trial}: solved again, bits differ")
    return "the same bits, solved again"


def _units(solver: Solver) -> str:
    for trial, _, solution in taken(solver):
        for length, stiffness in ((2.0**20, 1.0), (2.0**-30, 2.0**25)):
            load = {name: value * (length if name == "approach" else stiffness) for name, value in trial.load.items()}
            other = trial.problem(solver, length=length, stiffness=stiffness).solve(throw=False, **load)
            same = np.array_equal(other.pressure, stiffness * solution.pressure)
            require(same, f"{trial}: lengths times {length:g} and moduli times {stiffness:g} change bits")
    return "lengths and moduli times powers of two change no bit"


def _starts(solver: Solver) -> str:
    for trial, problem, solution in taken(solver):
        if not solution.status.success:
            continue
        for start in (solution.pressure, solution.pressure[::-1, ::-1]):
            other = problem.solve(throw=False, start=np.array(start), **trial.load)
            found = judge(problem, trial.load, other)
            wrong = not other.status.success or found.error > allowed(solver, found, other)
            require(not wrong, f"{trial}: from another start it ends {other.status}, off by {found.error:.1e}")
    return "any start leads to a solution"


class _Exploding(PlannedConvolution):
    """A convolution that turns to infinity after a few calls."""

    def __init__(self, plan: PlannedConvolution) -> None:
        self._plan, self.calls = plan, 0

    @property
    def scene(self) -> Scene:
        return self._plan.scene

    def apply(self, pressure: RealArray) -> RealArray:
        self.calls += 1
        return np.asarray(self._plan.apply(pressure) * (np.inf if self.calls > _CALLS else 1.0))


def _not_finite(solver: Solver) -> str:
    for trial, problem, _ in taken(solver):
        if "of E* slope" not in trial.name:
            continue
        plan = _Exploding(problem.convolution)
        with np.errstate(all="ignore"):
            outcome = solver.solve(plan, task_of(problem.plan, problem.undeformed, **trial.load))
        if plan.calls > _CALLS:
            require(not outcome.status.success, f"{trial}: displacements turned infinite, and it is {outcome.status}")
            require(plan.calls <= _CALLS + 20, f"{trial}: it went on for {plan.calls - _CALLS} more convolutions")
            return f"{outcome.status}"
    raise DoesNotApply("it needs too few convolutions")


CLAIMS = (
    Claim("solver", "tolerance above zero", _tolerance),
    Claim("solver", "serves, or refuses in words", _serves),
    Claim("solver", "conditions of contact", _conditions),
    Claim("solver", "honest status", _honest),
    Claim("solver", "exact load", _load),
    Claim("solver", "bounds bit for bit", _bounds),
    Claim("solver", "input left as it was", _untouched),
    Claim("solver", "repeatable", _repeatable),
    Claim("solver", "units", _units),
    Claim("solver", "any start", _starts),
    Claim("solver", "notices infinity", _not_finite),
    *common("solver"),
)
