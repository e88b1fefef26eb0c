"""Claims about solvers, of pressure and of shear."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array, RealArray
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import BoundKernel, Love
from roughcontact._parts.materials import PairConstants
from roughcontact._solve.convolvers import DCFFT, CircularFFT, ConvolutionSetup, PreparedConvolution, ShearConvolution
from roughcontact._solve.problem import LOAD_TOLERANCE, ContactProblem, make_task
from roughcontact._solve.solution import ContactSolution, Status
from roughcontact._solve.solvers import ShearSolver, ShearTask, Solver, natural_residual
from roughcontact.errors import InputError
from roughcontact.testing.claim import (
    DoesNotApply,
    claim,
    claim_input_unchanged,
    claim_powers_of_two,
    claim_repeatable,
    require,
    require_close,
)
from roughcontact.testing.problems import Case, cases, judge, solve_cases

# Convolutions before the displacements turn infinite, and the most that a solver may need to notice it.
_FINITE_CONVOLUTIONS = 4
_MAX_LATE_CONVOLUTIONS = 20
# Residual that the solvers must reach, and by how much shears may differ then, over the maximum limit.
_SHEAR_TOLERANCE = 1e-8
_SHEAR_DIFFERENCE = 1e-5
# Error of sums and magnitudes by rounding.
_ROUNDING = 1e-13
_SHAPE = (24, 20)
# Fraction of the force of sliding, or displacement, along x and y.
_GIVEN = {
    "small force": ((0.1, 0.0), (None, None)),
    "oblique force": ((0.4, 0.3), (None, None)),
    "near sliding": ((0.0, -0.97), (None, None)),
    "displacement": ((None, None), (2.0, 1.0)),
    "force and displacement": ((0.3, None), (None, 0.5)),
}


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


def _solve_without_raising(solver: Any, convolution: object, task: object) -> Any:
    try:
        return solver.solve(convolution, task)
    except Exception as error:
        advice = "a solver must return Status.NOT_FINITE"
        raise AssertionError(f"with infinite displacements it raised {error!r}: {advice}") from error


@claim("solver", "stops at non-finite values")
def _stops(solver: Solver) -> str:
    for _, case, problem, _ in solve_cases(solver):
        if "of E* slope" not in case.name:
            continue
        convolution = _Diverging(problem.convolution)
        task = make_task(problem.plan, problem.initial_gap, case.load)
        outcome = _solve_without_raising(solver, convolution, task)
        more = convolution.calls - _FINITE_CONVOLUTIONS
        if more > 0:
            require(not outcome.status.success, f"{case}: with infinite displacements it is {outcome.status}")
            require(
                more <= _MAX_LATE_CONVOLUTIONS,
                f"{case}: it needs {more} more convolutions to notice infinite displacements",
            )
            return f"{outcome.status}"
    raise DoesNotApply("the solver needs too few convolutions")


def _convolve(boundary: Boundary, compliance: float = 1.0) -> ShearConvolution:
    grid = Grid(_SHAPE, (float(_SHAPE[0]), float(_SHAPE[1])))
    kernel = BoundKernel(Love(), compliance=compliance, pair=PairConstants(0.0, 0.4))
    convolver = DCFFT() if boundary is Boundary.FREE else CircularFFT()
    return convolver.prepare(kernel, grid, boundary).shear()


def _shear_cases(_: object) -> Iterator[tuple[str, ShearConvolution, ShearTask]]:
    """Yield a name, a convolution and a task: a ball with a stretch of small limits, and displacements of cells."""
    x, y = ((np.arange(n) - 0.5 * n + 0.3) / (0.4 * n) for n in _SHAPE)
    limit = np.sqrt(np.maximum(1.0 - x[:, np.newaxis] ** 2 - y**2, 0.0))
    limit[:8] *= 1e-3
    offset = 0.2 * np.random.default_rng(1).standard_normal((2, *_SHAPE))
    for boundary in (Boundary.FREE, Boundary.PERIODIC):
        convolution = _convolve(boundary)
        for name, (force, displacement) in _GIVEN.items():
            fx, fy = (None if one is None else one * float(limit.sum()) for one in force)
            task = ShearTask(
                limit=limit, offset=offset, shear_force=(fx, fy), displacement=displacement, tolerance=_SHEAR_TOLERANCE
            )
            yield f"{name}, {boundary}", convolution, attrs.evolve(task, max_iterations=20_000)


@claim("shear solver", "stick and slip", _shear_cases)
def _stick_and_slip(solver: ShearSolver, convolution: ShearConvolution, task: ShearTask) -> float:
    found = solver.solve(convolution, task)
    require(found.status.success, f"{found.status}")
    moved = np.reshape(found.displacement, (2, 1, 1))
    slip = task.offset + moved - convolution.apply(found.shear)
    residual = natural_residual(found.shear, slip, task.limit, float(np.mean(convolution.own)))
    require(residual <= 1.01 * _SHEAR_TOLERANCE, f"a residual of {residual:.1e}, above {_SHEAR_TOLERANCE:.1e}")
    return residual


@claim("shear solver", "limits and forces to rounding", _shear_cases)
def _limits(solver: ShearSolver, convolution: ShearConvolution, task: ShearTask) -> None:
    found = solver.solve(convolution, task)
    beyond = float((np.hypot(*found.shear) - task.limit).max())
    require(beyond <= _ROUNDING * task.limit.max(), f"a shear of {beyond:.1e} above its limit")
    for axis, force in enumerate(task.shear_force):
        if force is not None:
            error = abs(float(found.shear[axis].sum()) - force)
            require(error <= _ROUNDING * task.limit.sum(), f"an error of the force of {error:.1e}")
    for given, moved in zip(task.displacement, found.displacement, strict=True):
        require(given is None or given == moved, f"a displacement of {moved} where {given} is given")


@claim("shear solver", "any start", _shear_cases)
def _shear_starts(solver: ShearSolver, convolution: ShearConvolution, task: ShearTask) -> float:
    expected = solver.solve(convolution, task).shear
    other = solver.solve(convolution, attrs.evolve(task, start=-2.0 * expected[:, ::-1]))
    return require_close(other.shear, expected, _SHEAR_DIFFERENCE, "another start changes the shear")


def _scaled(task: ShearTask, stress: float, length: float) -> ShearTask:
    """Return a task with all stresses and all lengths times a factor; a negative one turns them around."""
    fx, fy = (None if one is None else stress * one for one in task.shear_force)
    dx, dy = (None if one is None else length * one for one in task.displacement)
    return attrs.evolve(
        task,
        limit=abs(stress) * task.limit,
        offset=length * task.offset,
        shear_force=(fx, fy),
        displacement=(dx, dy),
    )


@claim("shear solver", "opposite directions", _shear_cases)
def _directions(solver: ShearSolver, convolution: ShearConvolution, task: ShearTask) -> float:
    expected = solver.solve(convolution, task).shear
    found = -solver.solve(convolution, _scaled(task, -1.0, -1.0)).shear
    return require_close(found, expected, _SHEAR_DIFFERENCE, "the opposite task has another shear")


def _prepare_shear(
    solver: ShearSolver, convolution: ShearConvolution, task: ShearTask
) -> tuple[dict[str, Any], Callable[[], object]]:
    given: dict[str, Any] = {"limit": task.limit.copy(), "offset": task.offset.copy(), "start": 0.1 * task.offset}
    return given, lambda: solver.solve(convolution, attrs.evolve(task, **given))


claim_input_unchanged("shear solver", _shear_cases, _prepare_shear)
claim_repeatable(
    "shear solver", _shear_cases, lambda solver, convolution, task: [solver.solve(convolution, task).shear]
)


def _scale_shear(
    solver: ShearSolver, convolution: ShearConvolution, task: ShearTask, stress: float, compliance: float
) -> list[tuple[RealArray, RealArray]]:
    other = _scaled(task, stress, stress * compliance)
    found = solver.solve(_convolve(convolution.setup.boundary, compliance), other).shear
    return [(found, stress * solver.solve(convolution, task).shear)]


claim_powers_of_two(
    "shear solver",
    _shear_cases,
    _scale_shear,
    ((2.0**20, 1.0), (2.0**-30, 2.0**25)),
    "limits times {:g} and compliances times {:g} change bits",
)


class _DivergingShear(ShearConvolution):
    """A convolution that returns infinite displacements after a few calls."""

    def __init__(self, convolution: ShearConvolution) -> None:
        self._convolution = convolution
        self.calls = 0

    @property
    def setup(self) -> ConvolutionSetup:
        return self._convolution.setup

    def apply(self, tractions: RealArray, of: str = "xy", to: str = "xy") -> Array:
        self.calls += 1
        response = self._convolution.apply(tractions, of, to)
        return np.asarray(response * (np.inf if self.calls > _FINITE_CONVOLUTIONS else 1.0))


@claim("shear solver", "stops at non-finite values")
def _shear_stops(solver: ShearSolver) -> str:
    name, convolution, task = next(_shear_cases(solver))
    broken = _DivergingShear(convolution)
    broken.own  # noqa: B018 - it is computed by two calls and kept
    outcome = _solve_without_raising(solver, broken, task)
    require(not outcome.status.success, f"{name}: with infinite displacements it is {outcome.status}")
    return f"{outcome.status}"
