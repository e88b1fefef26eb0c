"""All checks of one contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import attrs

from roughcontact._base.checks import callback, choice, flag
from roughcontact._base.machine.progress import show_progress, tell_both
from roughcontact._base.tables import Table, TableResult
from roughcontact._base.units import Force, Length, Pressure
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import ContactProblem
from roughcontact._solve.solution import ContactSolution
from roughcontact._work.reports.stability.check import RULES, Check, SolvedProblem, Verdict, find_worst, skip, summarize
from roughcontact._work.reports.stability.checks import (
    MAX_FLOAT64_CELLS,
    check_area,
    check_kernel,
    check_model,
    check_precision,
    check_residuals,
    check_variants,
)
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Parts of the work, and their time over that of the first solve: measured on rough contacts of 128 to 640 cells a side.
_WORK = {
    "the solve": 1.0,
    "kernel and model": 0.3,
    "float32 iterations": 6.0,
    "coarser grid": 0.3,
    "shifted grid": 1.0,
    "tighter tolerance": 0.7,
}


@attrs.frozen(eq=False)
class StabilityReport(TableResult):
    """The checks of a solution, with their results; `str` of it is a table."""

    checks: tuple[Check, ...]
    solution: ContactSolution

    @property
    def verdict(self) -> Verdict:
        """The worst of all verdicts."""
        return find_worst(check.verdict for check in self.checks)

    def __getitem__(self, name: str) -> Check:
        """Return the check of this name, or raise `InputError`."""
        names = [check.name for check in self.checks]
        return self.checks[names.index(choice(name, "The check", names))]

    @property
    def _worst_first(self) -> list[Check]:
        """The checks as they are shown: a notebook omits rows in the middle of a long table."""
        return sorted(self.checks, key=lambda check: list(Verdict).index(check.verdict), reverse=True)

    @property
    def _summary(self) -> str:
        return summarize([check.verdict for check in self.checks])

    def __repr__(self) -> str:
        return f"<StabilityReport {self._summary}>"

    def table(self) -> Table:
        """Return a row for each check, the worst first; see `roughcontact.typing.Table`."""
        checks = self._worst_first
        columns: dict[str, list[Any]] = {
            "verdict": [check.verdict for check in checks],
            "check": [check.name for check in checks],
            "value": [check.value for check in checks],
            "what was measured; what to do": [check.text for check in checks],
        }
        return Table(columns)

    def _list_head(self) -> Sequence[str]:
        return [self._summary]

    def _write_rows(self) -> str:
        lines = []
        before = ""
        for check in self._worst_first:
            lines.append(str(attrs.evolve(check, finding="as above") if check.finding == before else check))
            before = check.finding
        return "\n".join(lines)


@guarded
def stability(
    problem: ContactProblem,
    *,
    pressure: Pressure | None = None,
    force: Force | None = None,
    approach: Length | None = None,
    on_check: Callable[[str, float], None] | None = None,
    progress: bool = False,
) -> StabilityReport:
    """Return how far a solution depends on rounding, grid and tolerance, and whether the model holds.

    Four more solves: in float64 throughout, on half as many cells a side, on a grid shifted by half a
    cell, and to a thousandth of the tolerance.

    Parameters
    ----------
    problem
        The problem.
    pressure, force, approach
        Exactly one: nominal mean pressure, Pa; normal force, N; approach since first touch, m.
    on_check
        Called before each part of the work with its name and the fraction of the work that is done, about.
    progress
        Whether to show on standard error how far it has come (extra ``progress``).

    Returns
    -------
    StabilityReport
        Checks with measured values and verdicts; a check that cannot be made is skipped, with the reason.

    Raises
    ------
    InputError
        If `problem` is not a `ContactProblem`, not exactly one load is given, or it cannot be carried.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> report = rc.stability(problem, force=1.0)
    >>> print(report.verdict)
    pass
    """
    if not isinstance(problem, ContactProblem):
        raise InputError.about("The problem", problem, "a ContactProblem")
    told = callback(on_check, "on_check=", "name", "fraction")
    with show_progress("stability", shown=flag(progress, "progress=")) as change:
        begin = _count_work(problem, tell_both(told, change))
        return _check_solution(problem, {"pressure": pressure, "force": force, "approach": approach}, begin)


def _check_solution(problem: ContactProblem, load: dict[str, Any], begin: Callable[[str], None]) -> StabilityReport:
    begin("the solve")
    solution = problem.solve(**load, throw=False)
    solved = SolvedProblem(problem, solution, Load.of(**load))
    checks = check_residuals(solved)
    if solution.status.success:
        begin("kernel and model")
        checks += [*check_kernel(solved), *check_model(solved)]
        begin("float32 iterations")
        checks += [check_precision(solved), *check_variants(solved, begin)]
        checks += check_area(solution)
    else:
        checks += [skip(name, "the solution is not converged") for name in list(RULES)[len(checks) :]]
    return StabilityReport(tuple(checks), solution)


def _count_work(problem: ContactProblem, tell: Callable[[str, float], None]) -> Callable[[str], None]:
    """Return a function that says which part of the work begins, and the fraction that is done."""
    work = dict(_WORK)
    if problem.plan.grid.cells > MAX_FLOAT64_CELLS:
        work["float32 iterations"] = 0.0
    names = list(work)

    def begin(name: str) -> None:
        tell(name, sum(work[before] for before in names[: names.index(name)]) / sum(work.values()))

    return begin
