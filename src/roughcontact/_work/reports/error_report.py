"""A report of errors: its rows, groups and advice, and tables for people and for programs."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array
from roughcontact._base.checks import choice, number
from roughcontact._base.registry import find_view
from roughcontact._base.tables import Table, TableResult
from roughcontact._base.units import counted, si
from roughcontact._work.reports.reference import QUANTITIES, UNITS, KnownAnswer
from roughcontact.errors import InputError

_LABELS = {"area": "area", "p_max": "maximum pressure", "approach": "approach"}
_ERROR_LABELS = {"area": "error", "p_max": "pressure error", "approach": "approach error"}
# Errors whose ratio is above this count as equal, so that chance does not decide between them.
_EQUAL_ERROR_RATIO = 0.99
# Errors below this part of the reference's error bound are printed as zero: their digits mean nothing.
_NEGLIGIBLE_ERROR_RATIO = 0.01


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
        The quantities that the reference took from this case: they have no error here, and are not ranked.
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
        """Return the CPU time of a quantity: only the area needs an estimator."""
        return self.cpu if quantity == "area" else self.solve_cpu

    def cost(self, quantity: str) -> float:
        """Return the median CPU time of a quantity, s."""
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
        row = min((row for group in groups for row in group), key=_find_accuracy)
        cost = f"{_percent(_find_accuracy(row))}, {_seconds(row)}"
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
        what = "uncertainty" if _find_accuracy(row) > row.error("area") else "error"
        error = f"{what} {_percent(_find_accuracy(row))} in {_seconds(row)}"
        clauses.append(f"{row.describe(parts)} needs more than {_cells(row)} ({error})")
    return "; ".join(clauses) + "."


def _find_cheapest(group: Sequence[ReportRow], area: float) -> ReportRow | None:
    """Return the cheapest row that is accurate enough, as all finer ones are."""
    accurate: list[ReportRow] = []
    for row in reversed(group):
        if not _find_accuracy(row) <= area:
            break
        accurate.append(row)
    return min(accurate, key=_cost, default=None)


def _find_accuracy(row: ReportRow) -> float:
    """Return the relative error of the area, or its standard deviation if that is larger: a smaller error is chance."""
    std = row.area_uncertainty / row.area if row.area > 0.0 else math.nan
    return max(row.error("area"), 0.0 if math.isnan(std) else std)


def _cost(row: ReportRow) -> float:
    return row.cost("area")


def _cells(row: ReportRow) -> str:
    return f"{row.shape[0]} x {row.shape[1]} cells"


def _seconds(row: ReportRow) -> str:
    return f"{_cost(row):.2g} s"


def _percent(fraction: float) -> str:
    return f"{format_percent(fraction).removeprefix('+')} %"


@attrs.frozen(eq=False, kw_only=True)
class ErrorReport(TableResult):
    """Errors against run time; `str` of it is a table.

    Attributes
    ----------
    rows
        Each case with each estimator, the grids of one setup from coarse to fine.
    reference
        The reference solution.
    nominal
        Nominal area of the domain, m2.
    description
        The problem, in words.
    repeats
        How often each case was timed.
    """

    rows: tuple[ReportRow, ...]
    reference: KnownAnswer
    nominal: float
    description: str
    repeats: int

    def front(self, quantity: str = "area") -> tuple[ReportRow, ...]:
        """Return the Pareto front of ``"area"``, ``"p_max"`` or ``"approach"``, from cheap to accurate.

        No other row is both cheaper and more accurate. Errors below the error bound of the reference count as
        that bound, and errors within a hundredth of each other as equal.
        """
        choice(quantity, "The quantity", QUANTITIES)
        bound = self.reference.relative_uncertainty(quantity)
        known = [row for row in self.rows if math.isfinite(row.error(quantity))]
        best = math.inf
        front = []
        for row in sorted(known, key=lambda row: (row.cost(quantity), row.error(quantity))):
            error = max(row.error(quantity), bound)
            if error < _EQUAL_ERROR_RATIO * best:
                best = error
                front.append(row)
        return tuple(front)

    def advice(self, area: float = 0.005) -> str:
        """Return in a sentence which case reaches a relative error of the area at the lowest cost.

        It adds the cells that the other estimators need. A case counts only if its standard deviation is at most
        that error, and all finer grids of the report are accurate enough too: a coarse grid may be right by
        chance.
        """
        advice = advise(self.rows, self.reference, area)
        if not any(row.of_reference for row in self.rows):
            return advice
        return (
            f"{advice} The errors are those of coarser grids, against {self.reference.source}; not of the measurement."
        )

    def __repr__(self) -> str:
        return f"<ErrorReport {counted(len(self.rows), 'row')}: {self.description}>"

    def to_markdown(self) -> str:
        """Return the table and its notes as Markdown."""
        head = ["# Error against run time", "", *(f"{line}  " for line in self._list_head())]
        notes = [f"- {note}" for note in self._list_notes()]
        return "\n".join([*head, "", self.short_table().to_markdown(), "", *notes, ""])

    def draw(self, path: str | os.PathLike[str]) -> None:
        """Draw errors against CPU time, hollow where not resolved, with the Pareto front; the ending gives the format.

        Needs matplotlib, and raises `MissingPackage` without it.
        """
        find_view("error-report")(self, checks.path(path, "The picture"))

    def _list_head(self) -> Sequence[str]:
        """Return the description of the problem, and the reference."""
        known = []
        for name in self.reference.quantities:
            value = getattr(self.reference, name)
            text = si(value, UNITS[name], 5)
            bound = format_percent(self.reference.relative_uncertainty(name)).removeprefix("+")
            known.append(f"{_LABELS[name]} {text} +- {bound} %")
        row = self.rows[0]
        varying = find_varying_parts(self.rows)
        common = [getattr(row, name) for name in ("kernel", "convolver", "solver") if name not in varying]
        if len({row.tolerance for row in self.rows}) == 1:
            common.append(f"tolerance {row.tolerance:.0e}")
        return [f"{self.description}; {', '.join(common)}", f"Reference: {self.reference.source}: {'; '.join(known)}"]

    @property
    def _keys(self) -> int:
        return 2 + len(find_varying_parts(self.rows))

    @property
    def _failures(self) -> list[str]:
        return list(dict.fromkeys(row.failure for row in self.rows if row.failure))

    def short_table(self) -> Table:
        """Return a row for each case for people, with errors in percent."""
        parts = find_varying_parts(self.rows)
        known = self.reference.quantities
        headings = ["cells", *parts, "estimator", "area, %", *(f"{_ERROR_LABELS[name]}, %" for name in known)]
        headings += ["CPU, s (min..max)", "area, s", "wall, s (min..max)", "iter.", "conv.", "float32", "peak, MiB"]
        front = {id(row) for row in self.front()}
        failures = self._failures
        body = []
        for row in self.rows:
            names = [f"{row.tolerance:.0e}" if part == "tolerance" else getattr(row, part) for part in parts]
            line = [f"{row.shape[0]} x {row.shape[1]}", *names, row.estimator]
            if row.failure:
                line += [f"failed [{failures.index(row.failure) + 1}]", *["-"] * (len(headings) - len(line) - 1)]
            else:
                line += [f"{100 * row.area / self.nominal:.4g}"]
                line += [
                    ("* " if id(row) in front and name == "area" else "") + self._error(row, name) for name in known
                ]
                line += [_format_timing(row.cpu), f"{row.area_cpu.median:.2g}", _format_timing(row.wall)]
                line += [str(row.iterations), str(row.convolutions), str(row.float32_convolutions)]
                line += [f"{row.peak_bytes / 2**20:.3g}"]
            body.append(line)
        return Table.from_rows(headings, body)

    def _error(self, row: ReportRow, name: str) -> str:
        if name in row.of_reference:
            return "reference"
        error = getattr(row, f"{name}_error")
        if name not in row.unresolved:
            return format_percent(error)
        negligible = abs(error) <= _NEGLIGIBLE_ERROR_RATIO * self.reference.relative_uncertainty(name)
        return f"({'0' if negligible else format_percent(error)})"

    def _list_notes(self) -> Sequence[str]:
        notes = [f"[{number}] {reason}" for number, reason in enumerate(self._failures, start=1)]
        if self.front():
            notes.append("* on the Pareto front: no other case is both cheaper and more accurate.")
        if any(row.unresolved for row in self.rows):
            notes.append("(in brackets) not resolved: the error is below the error bound of the reference.")
        if any(row.of_reference for row in self.rows):
            notes.append("reference: this case is the reference; the errors of the others are those of coarser grids.")
        return [
            *notes,
            "area: in % of nominal; errors of it, of the maximum pressure and of the approach are relative.",
            f"CPU (all threads) and wall time: median (min..max) of {self.repeats} after a warm-up, from the heights "
            "to the area; 'area, s' is the CPU time of the estimator.",
            "conv.: convolutions of the solve; float32: how many convolutions, on all grids, ran in float32.",
            "peak: memory of numpy's arrays, by tracemalloc in a separate run; without the work space of transforms.",
        ]

    def table(self) -> Table:
        """Return a row for each case, with relative errors; see `roughcontact.typing.Table`."""
        timings = ("cpu", "wall", "solve_cpu", "area_cpu")
        front = {id(row) for row in self.front()}
        names = [
            *("nx", "ny", "kernel", "convolver", "solver", "tolerance", "estimator"),
            *("area_m2", "area_uncertainty_m2", "p_max_Pa", "approach_m"),
            *(f"{name}_error" for name in QUANTITIES),
            *(f"{name}_resolved" for name in QUANTITIES),
            *("pareto", *(f"{name}_s{end}" for name in timings for end in ("", "_min", "_max"))),
            *("iterations", "convolutions", "float32_convolutions", "peak_bytes", "failure"),
        ]
        records: list[list[object]] = []
        for row in self.rows:
            errors = {name: getattr(row, f"{name}_error") for name in QUANTITIES}
            record = [
                *(*row.shape, row.kernel, row.convolver, row.solver, row.tolerance, row.estimator),
                *(row.area, row.area_uncertainty, row.p_max, row.approach, *errors.values()),
                *(int(math.isfinite(error) and name not in row.unresolved) for name, error in errors.items()),
                *(int(id(row) in front), *(time for name in timings for time in attrs.astuple(getattr(row, name)))),
                *(row.iterations, row.convolutions, row.float32_convolutions, row.peak_bytes, row.failure),
            ]
            records.append(record)
        return Table.from_rows(names, records)


def _format_timing(timing: Timing) -> str:
    return f"{timing.median:.2g} ({timing.minimum:.2g}..{timing.maximum:.2g})"
