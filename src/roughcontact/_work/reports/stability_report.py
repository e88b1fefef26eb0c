"""Checks, their thresholds and verdicts, the solved problem that they examine, and the report on all of them."""

from __future__ import annotations

import math
import textwrap
from collections import Counter
from collections.abc import Iterable, Sequence
from enum import StrEnum
from functools import cached_property
from typing import Any

import attrs

from roughcontact._base.checks import choice
from roughcontact._base.tables import Table, TableResult
from roughcontact._base.units import WIDTH, ShownAsPrinted
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import ContactProblem
from roughcontact._solve.solution import PLAUSIBILITY_RULES, ContactSolution, Rule

_KERNEL = "Use a kernel whose sums do not cancel, such as 'love', or report the error to its author."
_SOLVER = "Read the status; try the solver spectral-gradient, or lengths and moduli in units nearer to one."
_GRID = "Refine the grid; for measured maps, measure with a finer pitch."
_TOLERANCE = "Lower the solver's tolerance."

RULES = {
    "convergence": Rule(0, 0, "decided by the status; an unconverged solution is not checked further", _SOLVER),
    "load balance": Rule(1e-12, 1e-9, "the sum of 1e6 pressures has a rounding error of 1e-13", _SOLVER),
    "complementarity": Rule(
        2e-5, 1e-3, "twice the solvers' tolerance of 1e-5; 1e-3 moves areas and maximum pressures by 0.1 %", _TOLERANCE
    ),
    "penetration": Rule(2e-5, 1e-3, "as for complementarity", _TOLERANCE),
    "convolution: digits lost": Rule(
        3, 7, "of 16 digits the gap needs 8, and the displacement may be 1e4 times the rms height", _KERNEL
    ),
    "kernel: digits lost": Rule(3, 7, "as for the convolution", _KERNEL),
    "kernel: two forms": Rule(1e-10, 1e-6, "both forms describe one body; beyond 1e-6 the formulas differ", _KERNEL),
    **PLAUSIBILITY_RULES,
    "cells per wavelength": Rule(8, 4, "from eight on the area is right to 0.1 %; white noise has 3.4", _GRID),
    "float32 iterations": Rule(
        1e-5,
        1e-3,
        "at a tolerance of 1e-8 two solvers differ by up to 1e-6 of the maximum pressure",
        "Use the solver spectral-gradient, which works in float64 throughout.",
    ),
    "coarser grid: area": Rule(
        0.05, 0.2, "at second order a change of 5 % leaves an error of less than 2 % on the finer grid", _GRID
    ),
    "coarser grid: maximum pressure": Rule(
        0.15, 0.5, "peaks are local: a change by half leaves about a tenth on the finer grid", _GRID
    ),
    "coarser grid: approach or load": Rule(0.05, 0.2, "as for the area", _GRID),
    "shifted grid: area": Rule(
        0.02, 0.1, "the position of the grid is arbitrary; the change is an uncertainty of about that size", _GRID
    ),
    "shifted grid: maximum pressure": Rule(0.05, 0.2, "as for the area; a peak between cell centres is missed", _GRID),
    "shifted grid: approach or load": Rule(0.02, 0.1, "as for the area", _GRID),
    "tighter tolerance: area": Rule(1e-4, 1e-2, "at 1e-5 only cells at the contact edge may still change", _TOLERANCE),
    "tighter tolerance: maximum pressure": Rule(1e-4, 1e-2, "as for the area", _TOLERANCE),
    "tighter tolerance: approach or load": Rule(1e-4, 1e-2, "as for the area", _TOLERANCE),
    "area: uncertainty": Rule(
        0.05, 0.3, "one standard deviation over the area; above 30 % only its order of magnitude is known", _GRID
    ),
    "area: warnings": Rule(0, math.inf, "a warning is not an error, but the uncertainty does not include it", _GRID),
}


# Where the text of a check begins, below its name.
_INDENT = 11 * " "
# Factor by which the solver's tolerance is lowered.
_TOLERANCE_DIVISOR = 1000.0


class Verdict(StrEnum):
    """The result of a check; of several checks, the last one in this order counts."""

    SKIPPED = "skipped"
    PASS = "pass"
    ATTENTION = "attention"
    FAIL = "fail"


def find_worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the worst verdict."""
    return max(verdicts, key=list(Verdict).index, default=Verdict.SKIPPED)


def summarize(verdicts: Sequence[Verdict]) -> str:
    """Return the worst verdict and how often each was given, in a line."""
    counts = ", ".join(f"{count} {verdict}" for verdict, count in Counter(verdicts).most_common())
    return f"overall: {find_worst(verdicts)} ({counts})"


@attrs.frozen
class Check(ShownAsPrinted):
    """One property of a solution, measured and compared with its thresholds.

    Attributes
    ----------
    name
        The property.
    verdict
        The result.
    value
        The measured value; nan where the check was skipped.
    finding
        The measurement in words, or why the check was skipped.
    advice
        What to do; empty where nothing needs to be done.
    """

    name: str
    verdict: Verdict
    value: float
    finding: str
    advice: str = ""

    @property
    def text(self) -> str:
        """Finding and advice."""
        return f"{self.finding}. {self.advice}" if self.advice else self.finding

    def __str__(self) -> str:
        value = "" if math.isnan(self.value) else f"{self.value:.3g}"
        return format_row(self.verdict, self.name, value, self.text)


def format_row(verdict: str, name: str, value: str, text: str) -> str:
    """Return a verdict, a name and a value in a line, and a text that is wrapped below them."""
    below = textwrap.wrap(text, WIDTH, initial_indent=_INDENT, subsequent_indent=_INDENT)
    return "\n".join([f"{verdict:<10} {name:<44} {value:>9}".rstrip(), *below])


def assess(name: str, value: float, finding: str) -> Check:
    """Return the check of this name with the verdict of its rule; nan fails."""
    rule = RULES[name]
    sign = 1.0 if rule.good <= rule.admissible else -1.0
    if sign * value <= sign * rule.good:
        return Check(name, Verdict.PASS, value, finding)
    verdict = Verdict.ATTENTION if sign * value <= sign * rule.admissible else Verdict.FAIL
    return Check(name, verdict, value, finding, rule.advice)


def skip(name: str, reason: str) -> Check:
    """Return the check of this name as one that cannot be made."""
    return Check(name, Verdict.SKIPPED, math.nan, reason)


@attrs.frozen(eq=False)
class SolvedProblem:
    """A problem, the load, and the solution, converged or not."""

    problem: ContactProblem
    solution: ContactSolution
    load: Load

    @cached_property
    def tighter(self) -> tuple[ContactProblem, ContactSolution]:
        """The problem with a thousandth of the tolerance, and its solution, or the errors of `solve_variant`.

        `InputError` too where the solver has no tolerance to be set.
        """
        solver = self.problem.plan.solver
        problem = attrs.evolve(self.problem, solver=solver.with_tolerance(solver.tolerance / _TOLERANCE_DIVISOR))
        return problem, self.solve_variant(problem)

    def solve_variant(self, variant: ContactProblem) -> ContactSolution:
        """Return the solution of a variant of the problem at the same load, or the same position of the bodies.

        It raises `InputError` where the variant cannot carry the load, and `NotConverged`.
        """
        load = self.load
        if load.kind == "approach":
            load = attrs.evolve(load, value=load.value + (variant.summit - self.problem.summit))
        return variant.solve(**load.arguments)


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
