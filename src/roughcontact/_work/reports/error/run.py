"""Errors of one's own problem against run time: each case solved, timed and compared with the reference."""

from __future__ import annotations

import math
import time
import tracemalloc
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

import attrs
import numpy as np

from roughcontact._base.checks import Array, callback, integer
from roughcontact._base.units import si
from roughcontact._parts.kernels import InfluenceKernel
from roughcontact._parts.load import Load
from roughcontact._solve.convolvers import Convolver
from roughcontact._solve.problem import ContactProblem
from roughcontact._solve.solution import DEFAULT_AREA, Area, AreaEstimator, ContactSolution
from roughcontact._solve.solution import areas as area_registry
from roughcontact._solve.solvers import Solver
from roughcontact._work.reports.error.cases import Case, check_choices, make_cases, name_part
from roughcontact._work.reports.error.reference import KnownAnswer, read_reference, solve_reference
from roughcontact._work.reports.error.result import ErrorReport
from roughcontact._work.reports.error.row import ReportRow, Timing
from roughcontact.errors import InputError, NotConverged, RoughContactError
from roughcontact.errors.door import guarded

T = TypeVar("T")


@attrs.frozen(eq=False)
class Benchmark:
    """What all cases of a report have in common; see `error_vs_time`."""

    problem: ContactProblem
    load: Load
    interpolation: str | None
    estimators: tuple[str | AreaEstimator, ...]
    repeats: int
    reference: KnownAnswer

    def run(self, case: Case) -> list[ReportRow]:
        """Return a row for each estimator; what fails is a row that says why."""
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
    pressure: float | None = None,
    force: float | None = None,
    approach: float | None = None,
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
    notify = callback(on_case, "on_case=", "case", "fraction") or (lambda description, done: None)
    if reference is None:
        notify("the reference", 0.0)
        known = solve_reference(problem, load, max(case.shape for case in cases), interpolation)
    else:
        known = read_reference(reference)
    benchmark = Benchmark(problem, load, interpolation, estimators, repeats, known)
    # A case takes about as long as it has cells.
    work = [case.shape[0] * case.shape[1] for case in cases]
    rows: list[ReportRow] = []
    for number, case in enumerate(cases):
        notify(str(case), sum(work[:number]) / sum(work))
        rows += benchmark.run(case)
    grid = problem.plan.grid
    description = f"{si(grid.size[0], 'm')} x {si(grid.size[1], 'm')}, boundary {problem.boundary}, {load}"
    return ErrorReport(rows=tuple(rows), reference=known, nominal=grid.area, description=description, repeats=repeats)


def _try_area(solution: ContactSolution, estimator: str | AreaEstimator) -> Area | str:
    """Return the area, or why the estimator failed."""
    try:
        return solution.area(estimator)
    except Exception as error:
        return _describe_error(error)


def _measure_times(
    solve: Callable[[], ContactSolution], estimators: Sequence[str | AreaEstimator]
) -> list[tuple[float, float]]:
    """Return CPU and wall time of one solve, then those of each estimator, s."""
    solution, times = _measure_time(solve)
    # Copies: what one estimator caches in the solution would make the next one look cheap.
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
            attrs.evolve(solution).area(estimator)
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
