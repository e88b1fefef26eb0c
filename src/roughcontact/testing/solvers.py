"""Claims about solvers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import RealArray
from roughcontact._solve.convolvers import ConvolutionSetup, PreparedConvolution
from roughcontact._solve.problem import LOAD_TOLERANCE, ContactProblem, make_task
from roughcontact._solve.solution import ContactSolution, Status
from roughcontact._solve.solvers import Solver
from roughcontact.errors import InputError
from roughcontact.testing.claim import DoesNotApply, claim, require
from roughcontact.testing.generic import claim_input_unchanged, claim_powers_of_two, claim_repeatable
from roughcontact.testing.problems import Case, cases, judge, solve_cases

# Convolutions before the displacements turn infinite, and the most that a solver may need to notice it.
_FINITE_CONVOLUTIONS = 4
_MAX_LATE_CONVOLUTIONS = 20


@claim("solver", "tolerance")
def _tolerance(solver: Solver) -> str:
    require(solver.tolerance > 0.0 and np.isfinite(solver.tolerance), f"its tolerance is {solver.tolerance!r}")
    return f"{solver.tolerance:g}"


@claim("solver", "solves, or raises InputError")
def _serves(solver: Solver) -> str:
    served = set()
    refused = set()
    for case in cases():
        try:
            case.solve(solver)
        except InputError as error:
            require(len(str(error).split()) >= 4, f"it refuses {case} with {str(error)!r}, which is not a sentence")
            refused.add(str(error))
        else:
            served.add(str(case))
    elastic = any("of E* slope" in name for name in served)
    require(elastic, f"it solves no elastic contact at a given load: {' '.join(refused)}")
    return f"solves {len(served)} kinds of problem; {len(refused)} reasons to refuse others"


@claim("solver", "conditions of contact", solve_cases)
def _conditions(_: Solver, case: Case, problem: ContactProblem, solution: ContactSolution) -> float:
    require(solution.status.success, f"{solution.status}")
    found = judge(problem, case.load.arguments, solution)
    require(found.error <= found.bound, f"an error of {found.error:.1e}, above {found.bound:.1e}")
    return found.error


@claim("solver", "confirmed status", solve_cases)
def _confirmed(_: Solver, case: Case, problem: ContactProblem, solution: ContactSolution) -> None:
    require(solution.status is not Status.UNCONFIRMED, "the residuals do not confirm its status")
    found = judge(problem, case.load.arguments, solution)
    confirmed = not solution.status.success or found.error <= found.bound
    require(confirmed, f"{solution.status}, but its error is {found.error:.1e}")


@claim("solver", "load", solve_cases)
def _load(_: Solver, case: Case, problem: ContactProblem, solution: ContactSolution) -> float:
    error = judge(problem, case.load.arguments, solution).load
    require(error <= LOAD_TOLERANCE, f"an error of the load of {error:.1e}")
    return error


@claim("solver", "bounds", solve_cases)
def _bounds(solver: Solver, case: Case, problem: ContactProblem, _: ContactSolution) -> None:
    # The solver's own pressure: the solution's is cut off at the limit.
    task = make_task(problem.plan, problem.initial_gap, case.load)
    pressure = solver.solve(problem.convolution, task).pressure
    lowest = float(pressure.min())
    over = float(np.max(pressure - task.pressure_limit))
    require(lowest >= 0.0, f"a pressure of {lowest:.1e}")
    require(over <= 0.0, f"a pressure of {over:.1e} above the limit")


def _prepare_task(
    solver: Solver, case: Case, problem: ContactProblem, solution: ContactSolution
) -> tuple[dict[str, Any], Callable[[], object]]:
    task = make_task(problem.plan, problem.initial_gap, case.load, solution.pressure)
    names = ("initial_gap", "pressure_limit", "start")
    given: dict[str, Any] = {name: np.array(getattr(task, name)) for name in names if np.ndim(getattr(task, name))}
    return given, lambda: solver.solve(problem.convolution, attrs.evolve(task, **given))


claim_input_unchanged("solver", solve_cases, _prepare_task)
claim_repeatable("solver", solve_cases, lambda solver, case, *_: [case.solve(solver).pressure])
claim_powers_of_two(
    "solver",
    solve_cases,
    lambda solver, case, _, solution, length, stiffness: [
        (case.scaled(length, stiffness).solve(solver).pressure, stiffness * solution.pressure)
    ],
    ((2.0**20, 1.0), (2.0**-30, 2.0**25)),
    "lengths times {:g} and moduli times {:g} change bits",
)


@claim("solver", "any initial guess", solve_cases)
def _starts(_: Solver, case: Case, problem: ContactProblem, solution: ContactSolution) -> None:
    for start in (solution.pressure, solution.pressure[::-1, ::-1]) if solution.status.success else ():
        other = problem.solve(throw=False, start=np.array(start), **case.load.arguments)
        found = judge(problem, case.load.arguments, other)
        solved = other.status.success and found.error <= found.bound
        require(solved, f"from another start it ends {other.status}, with an error of {found.error:.1e}")


class _Diverging(PreparedConvolution):
    """A convolution that returns infinite displacements after a few calls."""

    def __init__(self, convolution: PreparedConvolution) -> None:
        self._convolution = convolution
        self.calls = 0

    @property
    def setup(self) -> ConvolutionSetup:
        return self._convolution.setup

    def apply(self, pressure: RealArray) -> RealArray:
        self.calls += 1
        return np.asarray(self._convolution.apply(pressure) * (np.inf if self.calls > _FINITE_CONVOLUTIONS else 1.0))


@claim("solver", "stops at non-finite values")
def _stops(solver: Solver) -> str:
    for _, case, problem, _ in solve_cases(solver):
        if "of E* slope" not in case.name:
            continue
        convolution = _Diverging(problem.convolution)
        try:
            outcome = solver.solve(convolution, make_task(problem.plan, problem.initial_gap, case.load))
        except Exception as error:
            advice = "a solver must return Status.NOT_FINITE"
            raise AssertionError(f"with infinite displacements it raised {error!r}: {advice}") from error
        more = convolution.calls - _FINITE_CONVOLUTIONS
        if more > 0:
            require(not outcome.status.success, f"{case}: with infinite displacements it is {outcome.status}")
            require(
                more <= _MAX_LATE_CONVOLUTIONS,
                f"{case}: it needs {more} more convolutions to notice infinite displacements",
            )
            return f"{outcome.status}"
    raise DoesNotApply("the solver needs too few convolutions")
