"""Errors of a problem against run time: every combination of grids and parts, solved and timed."""

from __future__ import annotations

import itertools
import math
import time
import tracemalloc
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

import attrs
import numpy as np

from roughcontact._answers.refinement import on_grid
from roughcontact._base.arrays import Array
from roughcontact._base.checks import callback, flag, integer
from roughcontact._base.machine.progress import show_progress, tell_both
from roughcontact._base.registry import Registry
from roughcontact._base.units import Force, Length, Pressure, si
from roughcontact._parts.grid import Load
from roughcontact._parts.kernels import InfluenceKernel, kernels
from roughcontact._solve.convolvers import Convolver, convolvers
from roughcontact._solve.problem import ContactProblem
from roughcontact._solve.solution import DEFAULT_AREA, Area, AreaEstimator, ContactSolution
from roughcontact._solve.solution import areas as area_registry
from roughcontact._solve.solvers import Solver, positive_tolerance, solvers
from roughcontact._work.reports.error_report import ErrorReport, ReportRow, Timing
from roughcontact._work.reports.reference import KnownAnswer, read_reference, solve_reference
from roughcontact.errors import InputError, NotConverged, RoughContactError
from roughcontact.errors.door import guarded

# Cells a side below which a coarser grid is solved only if it is listed.
_MIN_COARSE_SIDE = 16
T = TypeVar("T")


@attrs.frozen(eq=False, kw_only=True)
class Case:
    """One combination: cells (nx, ny), parts, and the name of the solver."""

    shape: tuple[int, int]
    kernel: str | InfluenceKernel
    convolver: str | Convolver
    solver: Solver
    solver_name: str

    def with_parts(self, problem: ContactProblem) -> ContactProblem:
        """Return the problem with this case's parts, on its own grid."""
        return attrs.evolve(problem, kernel=self.kernel, convolver=self.convolver, solver=self.solver)

    def put_on_grid(self, problem: ContactProblem, interpolation: str | None) -> ContactProblem:
        """Return a problem on this case's grid, with nothing computed yet."""
        if self.shape == problem.plan.grid.shape:
            return attrs.evolve(problem)
        return on_grid(problem, self.shape, interpolation)

    def __str__(self) -> str:
        return f"{self.shape[0]} x {self.shape[1]}, {self.solver_name}"


def make_cases(
    problem: ContactProblem,
    cells: Sequence[int] | None,
    kernels_: Sequence[Any] | None,
    convolvers_: Sequence[Any] | None,
    solvers_: Sequence[Any] | None,
    tolerances: Sequence[float] | None,
) -> tuple[Case, ...]:
    """Return all combinations; parts that are not listed stay as the problem has them.

    Raises
    ------
    InputError
        If a list is empty or holds an unknown part.
    """
    auto = attrs.evolve(problem, convolver="auto", solver="auto").plan
    chosen_kernels = check_choices(kernels_, "The kernels", kernels, problem.kernel)
    chosen_convolvers = check_choices(convolvers_, "The convolvers", convolvers, problem.convolver, auto.convolver)
    chosen_solvers = check_choices(solvers_, "The solvers", solvers, problem.solver, auto.solver)
    return tuple(
        Case(shape=shape, kernel=kernel, convolver=convolver, solver=solver, solver_name=name)
        for kernel, convolver, (name, solver), shape in itertools.product(
            chosen_kernels, chosen_convolvers, _set_tolerances(chosen_solvers, tolerances), _make_shapes(problem, cells)
        )
    )


def check_choices(
    values: Sequence[Any] | None, what: str, registry: Registry[Any], own: object, auto: object = None
) -> tuple[Any, ...]:
    """Return the listed parts, or the problem's own without a list; the name of `auto` replaces ``"auto"``.

    Raises
    ------
    InputError
        If the list is empty, or holds a part that is neither registered nor an object of the kind.
    """
    allowed = f"a list of registered names or {registry.kind} objects, at least one"
    parts = (own,) if values is None else _check_list(values, what, allowed)
    if auto is not None:
        parts = tuple(registry.name_of(type(auto)) or auto if part == "auto" else part for part in parts)
    for part in parts if values is not None else ():
        registry.resolve(part)
    return parts


def name_part(choice: object) -> str:
    """Return the registered name of a part, or the repr of an object."""
    return choice if isinstance(choice, str) else repr(choice)


def _check_list(values: Any, what: str, allowed: str) -> tuple[Any, ...]:
    items = tuple(values) if isinstance(values, (list, tuple, range)) else ()
    if not items:
        raise InputError.about(what, values, allowed)
    return items


def _make_shapes(problem: ContactProblem, cells: Sequence[int] | None) -> tuple[tuple[int, int], ...]:
    """Return the grids, from coarse to fine, with the problem's proportions as nearly as whole numbers allow."""
    nx, ny = problem.plan.grid.shape
    if cells is None:
        counts = [nx // factor for factor in (8, 4, 2) if min(nx, ny) // factor >= _MIN_COARSE_SIDE] + [nx]
    else:
        given = _check_list(cells, "The cells along x", "a list of whole numbers, at least one")
        counts = sorted({integer(count, "The number of cells along x", at_least=2) for count in given})
    return tuple((count, max(round(count * ny / nx), 2)) for count in counts)


def _set_tolerances(choices: tuple[Any, ...], tolerances: Sequence[float] | None) -> list[tuple[str, Solver]]:
    """Return each solver at each tolerance, with its name."""
    named = [(name_part(choice), solvers.resolve(choice)) for choice in choices]
    if tolerances is None:
        return named
    given = _check_list(tolerances, "The tolerances", "a list of numbers above 0, at least one")
    values = [positive_tolerance(value) for value in given]
    changed = [(name, solver, solver.with_tolerance(value)) for name, solver in named for value in values]
    # The name of an object has its tolerance in it.
    return [(repr(new) if name == repr(old) else name, new) for name, old, new in changed]


@attrs.frozen(eq=False)
class Benchmark:
    """The problem, the load and the settings of all cases of a report; see `error_vs_time`."""

    problem: ContactProblem
    load: Load
    interpolation: str | None
    estimators: tuple[str | AreaEstimator, ...]
    repeats: int
    reference: KnownAnswer

    def run(self, case: Case) -> list[ReportRow]:
        """Return a row for each estimator; rows of a case that fails say why."""
        rows = [
            ReportRow(
                shape=case.shape,
                kernel=name_part(case.kernel),
                convolver=name_part(case.convolver),
                solver=case.solver_name,
                tolerance=case.solver.tolerance,
                estimator=name_part(estimator),
            )
            for estimator in self.estimators
        ]
        try:
            with_parts = case.with_parts(self.problem)

            def solve() -> ContactSolution:
                return case.put_on_grid(with_parts, self.interpolation).solve(**self.load.arguments)

            solution = solve()
            areas = [_try_area(solution, estimator) for estimator in self.estimators]
            usable = [by for by, area in zip(self.estimators, areas, strict=True) if isinstance(area, Area)]
            # Times come before memory: watching every allocation is slow.
            times = np.array([_measure_times(solve, usable) for _ in range(self.repeats)])
            costs = iter(zip(times[:, 1:].swapaxes(0, 1), _measure_peaks(solve, usable), strict=True))
        # A plug-in may raise anything: that ends its own case and not the report.
        except Exception as error:
            return [attrs.evolve(row, failure=_describe_error(error)) for row in rows]
        return [
            self._fill(row, solution, area, times[:, 0], *next(costs))
            if isinstance(area, Area)
            else attrs.evolve(row, failure=area)
            for row, area in zip(rows, areas, strict=True)
        ]

    def _fill(
        self, row: ReportRow, solution: ContactSolution, area: Area, solves: Array, estimates: Array, peak: int
    ) -> ReportRow:
        """Return a row with its results; times have the shape (repeats, 2), CPU and wall, s."""
        values = {"area": area.value, "p_max": float(solution.pressure.max()), "approach": solution.approach}
        own = self._of_reference(row)
        errors = {
            name: math.nan if name in own else self.reference.error(name, value) for name, value in values.items()
        }
        bounds = {name: self.reference.relative_uncertainty(name) for name in values}
        results: dict[str, Any] = {**values, **{f"{name}_error": error for name, error in errors.items()}}
        cpu, wall = (solves + estimates).T
        return attrs.evolve(
            row,
            **results,
            area_uncertainty=area.uncertainty,
            of_reference=own,
            unresolved=frozenset(name for name, error in errors.items() if abs(error) < bounds[name]),
            cpu=Timing.of(cpu),
            wall=Timing.of(wall),
            solve_cpu=Timing.of(solves[:, 0]),
            area_cpu=Timing.of(estimates[:, 0]),
            iterations=solution.iterations,
            convolutions=solution.convolutions,
            float32_convolutions=sum(level.single for level in solution.levels),
            peak_bytes=peak,
        )

    def _of_reference(self, row: ReportRow) -> frozenset[str]:
        """Return the quantities that the reference has from the same solution, whatever the solver."""
        if row.shape != self.reference.shape or row.kernel != name_part(self.problem.kernel):
            return frozenset()
        return frozenset(self.reference.quantities) - ({"area"} if row.estimator != DEFAULT_AREA else set())


@guarded
def error_vs_time(
    problem: ContactProblem,
    *,
    pressure: Pressure | None = None,
    force: Force | None = None,
    approach: Length | None = None,
    reference: object = None,
    cells: Sequence[int] | None = None,
    areas: Sequence[str | AreaEstimator] = (DEFAULT_AREA, "cell-count"),
    kernels: Sequence[str | InfluenceKernel] | None = None,
    convolvers: Sequence[str | Convolver] | None = None,
    solvers: Sequence[str | Solver] | None = None,
    tolerances: Sequence[float] | None = None,
    interpolation: str | None = None,
    repeats: int = 3,
    on_case: Callable[[str, float], None] | None = None,
    progress: bool = False,
) -> ErrorReport:
    """Return errors and run times of a problem on several grids, with several parts and area estimators.

    Every combination is solved. A case that fails is a row that says why.

    Parameters
    ----------
    problem
        The problem.
    pressure, force, approach
        Exactly one: nominal mean pressure, Pa; normal force, N; approach since first touch, m.
    reference
        A `KnownAnswer`, or a dict or object with any of area (m2), p_max (Pa) and approach (m), such as
        `reference.Hertz`. By default the problem is solved on a grid twice as fine as the finest case, a
        height map that is not band-limited on its own grid: the case on that grid is the reference, is not ranked, and
        the errors of the others are those of coarsening. Errors below the error bound are marked.
    cells
        Numbers of cells along x; those along y follow. By default an eighth, a quarter, half and all of
        the problem's.
    areas
        Area estimators, by name or as objects.
    kernels, convolvers, solvers
        Parts to compare, by name or as objects; by default the problem's.
    tolerances
        Tolerances of the solvers; by default their own.
    interpolation
        Interpolation of height maps, as in `HeightMap.resample`.
    repeats
        How often each case is timed, after a warm-up and before a run that measures memory.
    on_case
        Called before each case with its description and the fraction of the work that is done.
    progress
        Whether to show on standard error how far it has come (extra ``progress``).

    Returns
    -------
    ErrorReport
        A row for each case and estimator; a table, a picture and advice.

    Raises
    ------
    InputError
        If the load, a part or a list is not valid, or a surface is not known on the grid of the reference.
    NotConverged
        If the reference solution is not verified.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> report = rc.error_vs_time(problem, force=1.0, cells=[16, 32], repeats=1)
    >>> len(report.rows)
    4
    """
    if not isinstance(problem, ContactProblem):
        raise InputError.about("The problem", problem, "a ContactProblem")
    load = problem.require_load(pressure=pressure, force=force, approach=approach)
    repeats = integer(repeats, "The number of repeats", at_least=1)
    estimators = check_choices(areas, "The area estimators", area_registry, None)
    cases = make_cases(problem, cells, kernels, convolvers, solvers, tolerances)
    told = callback(on_case, "on_case=", "case", "fraction")
    with show_progress("report", shown=flag(progress, "progress=")) as change:
        tell = tell_both(told, change)
        if reference is None:
            tell("the reference", 0.0)
            known = solve_reference(problem, load, max(case.shape for case in cases), interpolation)
        else:
            known = read_reference(reference)
        benchmark = Benchmark(problem, load, interpolation, estimators, repeats, known)
        # A case takes about as long as it has cells.
        work = [case.shape[0] * case.shape[1] for case in cases]
        rows: list[ReportRow] = []
        for number, case in enumerate(cases):
            tell(str(case), sum(work[:number]) / sum(work))
            rows += benchmark.run(case)
    grid = problem.plan.grid
    description = f"{si(grid.size[0], 'm')} x {si(grid.size[1], 'm')}, boundary {problem.boundary}, {load}"
    return ErrorReport(rows=tuple(rows), reference=known, nominal=grid.area, description=description, repeats=repeats)


def _try_area(solution: ContactSolution, estimator: str | AreaEstimator) -> Area | str:
    """Return the area, or why the estimator failed."""
    try:
        return solution.area(estimator, uncertainty="model")
    except Exception as error:
        return _describe_error(error)


def _measure_times(
    solve: Callable[[], ContactSolution], estimators: Sequence[str | AreaEstimator]
) -> list[tuple[float, float]]:
    """Return CPU and wall time of one solve, then of each estimator, s."""
    solution, times = _measure_time(solve)
    # Copies: values that one estimator caches in the solution would make the next one look cheap.
    works = [partial(attrs.evolve(solution).area, estimator) for estimator in estimators]
    return [times, *(_measure_time(work)[1] for work in works)]


def _measure_time(work: Callable[[], T]) -> tuple[T, tuple[float, float]]:
    cpu = time.process_time()
    wall = time.perf_counter()
    result = work()
    return result, (time.process_time() - cpu, time.perf_counter() - wall)


def _measure_peaks(solve: Callable[[], ContactSolution], estimators: Sequence[str | AreaEstimator]) -> list[int]:
    """Return the maximum memory of the solve with each estimator, bytes."""
    tracing = tracemalloc.is_tracing()
    if not tracing:
        tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        solution = solve()
        solved = tracemalloc.get_traced_memory()[1] - before
        peaks = []
        for estimator in estimators:
            tracemalloc.reset_peak()
            attrs.evolve(solution).area(estimator, uncertainty="model")
            peaks.append(max(solved, tracemalloc.get_traced_memory()[1] - before))
        return peaks
    finally:
        if not tracing:
            tracemalloc.stop()


def _describe_error(error: Exception) -> str:
    if isinstance(error, NotConverged):
        return f"{error.solution.status} ({error.solution.iterations} iterations)"
    words = " ".join(str(error).split())
    return words if isinstance(error, RoughContactError) else f"{type(error).__name__}: {words}"
