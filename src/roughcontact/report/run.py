"""Errors against run time of a user's own problem."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from roughcontact.checks import integer
from roughcontact.convolvers import Convolver
from roughcontact.errors import InputError
from roughcontact.kernels import InfluenceKernel
from roughcontact.load import Load
from roughcontact.problem import ContactProblem
from roughcontact.report.cases import Case, cases_of, estimators_of
from roughcontact.report.measure import Bench
from roughcontact.report.result import ErrorReport
from roughcontact.report.row import ReportRow
from roughcontact.report.truth import Truth, refined_truth, truth_of
from roughcontact.solution import DEFAULT_AREA, EstimatesArea
from roughcontact.solvers import Solver
from roughcontact.units import si


def error_vs_time(
    problem: ContactProblem,
    *,
    pressure: float | None = None,
    force: float | None = None,
    approach: float | None = None,
    truth: object = None,
    cells: Sequence[int] | None = None,
    areas: Sequence[str | EstimatesArea] = (DEFAULT_AREA, "cell-count"),
    kernels: Sequence[str | InfluenceKernel] | None = None,
    convolvers: Sequence[str | Convolver] | None = None,
    solvers: Sequence[str | Solver] | None = None,
    tolerances: Sequence[float] | None = None,
    between: str | None = None,
    repeats: int = 3,
    on_case: Callable[[str, float], None] | None = None,
) -> ErrorReport:
    """Solve a problem in many ways, and say what each costs and how far it is off.

    Every combination of what is listed is solved; what is left out stays as the problem has it. A case
    that fails is a row that says so.

    Parameters
    ----------
    problem
        The problem.
    pressure, force, approach
        Exactly one: nominal mean pressure, Pa; normal force, N; approach since first touch, m.
    truth
        What to compare with: a `Truth`, or a dict or object with any of area (m2), p_max (Pa) and
        approach (m), such as `reference.Hertz`. If left out, the problem is solved on a grid twice as fine
        as the finest case, a height map that is not band-limited on its own grid; errors which that does
        not resolve are marked.
    cells
        Numbers of cells along x; those along y follow. If left out: an eighth, a quarter, half and all of
        the problem's.
    areas
        Area estimators, by name or as objects.
    kernels, convolvers, solvers
        Parts to compare, by name or as objects.
    tolerances
        Tolerances of the solvers; their own if left out.
    between
        How height maps go on between their points, as in `HeightMap.resample`.
    repeats
        How often each case is timed, after one warm-up and before one more solve that watches memory.
    on_case
        Called before each case with what is solved next and the share of the work that is done.

    Returns
    -------
    ErrorReport
        A row for each case and estimator; a table, a picture and advice.

    Raises
    ------
    InputError
        If not exactly one load is given or it cannot be carried, a name is not known, a list is empty, or
        the surfaces are not known on the grid of the reference.
    NotConverged
        If the reference solution is not certified.
    """
    if not isinstance(problem, ContactProblem):
        raise InputError.about("What is to be reported on", problem, "a ContactProblem")
    load = Load(pressure=pressure, force=force, approach=approach)
    load.require(problem)
    repeats = integer(repeats, "The number of repeats", at_least=1)
    estimators = estimators_of(areas)
    cases = cases_of(problem, cells, kernels, convolvers, solvers, tolerances)
    known = _truth(problem, truth, load, cases, between, on_case)
    bench = Bench(problem=problem, load=load, between=between, estimators=estimators, repeats=repeats, truth=known)
    rows = _run(bench, cases, on_case)
    lx, ly = problem.plan.grid.size
    scene = f"{si(lx, 'm')} x {si(ly, 'm')}, boundary {problem.boundary}, {load}"
    return ErrorReport(rows=rows, truth=known, nominal=problem.plan.grid.area, scene=scene, repeats=repeats)


def _truth(
    problem: ContactProblem,
    given: object,
    load: Load,
    cases: tuple[Case, ...],
    between: str | None,
    on_case: Callable[[str, float], None] | None,
) -> Truth:
    if given is not None:
        return truth_of(given)
    if on_case is not None:
        on_case("the reference", 0.0)
    return refined_truth(problem, load, max(case.shape for case in cases), between)


def _run(bench: Bench, cases: tuple[Case, ...], on_case: Callable[[str, float], None] | None) -> tuple[ReportRow, ...]:
    # A case costs about as much as its cells.
    work = [case.shape[0] * case.shape[1] for case in cases]
    rows: list[ReportRow] = []
    for number, case in enumerate(cases):
        if on_case is not None:
            on_case(str(case), sum(work[:number]) / sum(work))
        rows.extend(bench.rows(case))
    return tuple(rows)
