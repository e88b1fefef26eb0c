"""The rows of a report, how they are grouped, and the advice that follows from them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact._base.checks import Array, number
from roughcontact._work.reports.error.reference import KnownAnswer
from roughcontact.errors import InputError


@attrs.frozen
class Timing:
    """Median, minimum and maximum of repeated timings, s."""

    median: float = math.nan
    minimum: float = math.nan
    maximum: float = math.nan

    @classmethod
    def of(cls, samples: Sequence[float] | Array) -> Timing:
        """Return the timing of some samples, s."""
        return cls(float(np.median(samples)), float(np.min(samples)), float(np.max(samples)))


@attrs.frozen(kw_only=True)
class ReportRow:
    """One case with one area estimator: results, errors and cost.

    Attributes
    ----------
    shape
        Cells (nx, ny).
    kernel, convolver, solver, estimator
        Names of the parts.
    tolerance
        Tolerance of the solver.
    area, area_uncertainty, p_max, approach
        Real contact area and its standard deviation, m2; maximum pressure, Pa; approach, m; nan if the case failed.
    area_error, p_max_error, approach_error
        Relative errors, with sign; nan where the reference does not have the quantity.
    unresolved
        The quantities whose error is below the error bound of the reference.
    of_reference
        The quantities that the reference has from this very case: they have no error here, and are not ranked.
    cpu, wall
        CPU time of all threads and wall time, from the heights to the area.
    solve_cpu, area_cpu
        CPU time of the solve, and of the estimator.
    iterations, convolutions
        The work of the solve.
    float32_convolutions
        Convolutions of the solve in float32; zero if it does not report them.
    peak_bytes
        Maximum memory of numpy's arrays during solve and estimate, bytes, by tracemalloc.
    failure
        Why the case failed, in a sentence; empty if it did not.
    """

    shape: tuple[int, int]
    kernel: str
    convolver: str
    solver: str
    tolerance: float
    estimator: str
    area: float = math.nan
    area_uncertainty: float = math.nan
    p_max: float = math.nan
    approach: float = math.nan
    area_error: float = math.nan
    p_max_error: float = math.nan
    approach_error: float = math.nan
    unresolved: frozenset[str] = frozenset()
    of_reference: frozenset[str] = frozenset()
    cpu: Timing = Timing()
    wall: Timing = Timing()
    solve_cpu: Timing = Timing()
    area_cpu: Timing = Timing()
    iterations: int = 0
    convolutions: int = 0
    float32_convolutions: int = 0
    peak_bytes: int = 0
    failure: str = ""

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    @property
    def setup(self) -> tuple[str, str, str, float, str]:
        """Everything but the grid: rows that share it make a line in the picture."""
        return (self.kernel, self.convolver, self.solver, self.tolerance, self.estimator)

    def error(self, quantity: str) -> float:
        """Return the absolute relative error of ``"area"``, ``"p_max"`` or ``"approach"``; nan if not known."""
        return abs(float(getattr(self, f"{quantity}_error")))

    def timing(self, quantity: str) -> Timing:
        """Return the CPU time that a quantity costs: only the area needs an estimator."""
        return self.cpu if quantity == "area" else self.solve_cpu

    def cost(self, quantity: str) -> float:
        """Return the median CPU time that a quantity costs, s."""
        return self.timing(quantity).median

    def describe(self, parts: Sequence[str]) -> str:
        """Return the estimator and the given parts, in words."""
        words = [f"tolerance {self.tolerance:.0e}" if part == "tolerance" else getattr(self, part) for part in parts]
        return ", ".join([self.estimator, *words])


def find_varying_parts(rows: Sequence[ReportRow]) -> tuple[str, ...]:
    """Return the names of the parts that differ between rows, the estimator excepted."""
    names = [name for name in ("kernel", "convolver", "solver") if len({getattr(row, name) for row in rows}) > 1]
    # Solvers that differ by their own tolerances are distinguished by their names.
    if len({(row.solver, row.tolerance) for row in rows}) > len({row.solver for row in rows}):
        names.append("tolerance")
    return tuple(names)


def group_by_setup(rows: Sequence[ReportRow]) -> list[list[ReportRow]]:
    """Return the rows of each setup that did not fail, from coarse to fine."""
    groups: dict[tuple[object, ...], list[ReportRow]] = {}
    for row in sorted(rows, key=lambda row: row.cells):
        if not row.failure:
            groups.setdefault(row.setup, []).append(row)
    return list(groups.values())


def format_percent(fraction: float) -> str:
    """Return a fraction in per cent, with its sign, as two digits or a whole number."""
    value = 100 * fraction
    return f"{value:+.2g}" if abs(value) < 99.5 else f"{value:+.0f}"


def advise(rows: Sequence[ReportRow], reference: KnownAnswer, area: float) -> str:
    """Return the advice; see `ErrorReport.advice`."""
    area = number(area, "The allowed error of the area", above=0.0, at_most=1.0)
    if reference.area is None:
        raise InputError("There is no advice on the area, because the reference has no area.")
    bound = reference.relative_uncertainty("area")
    if bound > area:
        text = f"The reference area is known to {_percent(bound)} only, which does not resolve {_percent(area)}."
        return text if bound > 1.0 else f"{text} {advise(rows, reference, bound)}"
    judged = [row for row in rows if "area" not in row.of_reference]
    groups = group_by_setup(judged)
    parts = find_varying_parts(rows)
    target = f"For an area error of {_percent(area)}"
    if not groups:
        why = "All cases failed" if len(judged) == len(rows) else "No case but the reference itself was solved"
        return f"{why}, so there is no advice."
    accurate = [row for group in groups if (row := _find_cheapest(group, area)) is not None]
    if not accurate:
        row = min((row for group in groups for row in group), key=lambda row: row.error("area"))
        cost = f"{_percent(row.error('area'))}, {_seconds(row)}"
        return (
            f"{target}: no case is accurate enough; the nearest is {_cells(row)} with {row.describe(parts)} ({cost})."
        )
    best = min(accurate, key=_cost)
    clauses = [f"{target}: {_cells(best)} with {best.describe(parts)}, {_seconds(best)}"]
    for name in dict.fromkeys(row.estimator for row in judged if row.estimator != best.estimator and not row.failure):
        row = min((row for row in accurate if row.estimator == name), key=_cost, default=None)
        if row is not None:
            clauses.append(f"{row.describe(parts)} needs {_cells(row)} ({_seconds(row)})")
            continue
        finest = [group[-1] for group in groups if group[-1].estimator == name]
        row = min(finest, key=lambda row: (-row.cells, _cost(row)))
        error = f"error {_percent(row.error('area'))} in {_seconds(row)}"
        clauses.append(f"{row.describe(parts)} needs more than {_cells(row)} ({error})")
    return "; ".join(clauses) + "."


def _find_cheapest(group: Sequence[ReportRow], area: float) -> ReportRow | None:
    """Return the cheapest row that is accurate enough, as all finer ones are."""
    accurate: list[ReportRow] = []
    for row in reversed(group):
        if not row.error("area") <= area:
            break
        accurate.append(row)
    return min(accurate, key=_cost, default=None)


def _cost(row: ReportRow) -> float:
    return row.cost("area")


def _cells(row: ReportRow) -> str:
    return f"{row.shape[0]} x {row.shape[1]} cells"


def _seconds(row: ReportRow) -> str:
    return f"{_cost(row):.2g} s"


def _percent(fraction: float) -> str:
    return f"{format_percent(fraction).removeprefix('+')} %"
