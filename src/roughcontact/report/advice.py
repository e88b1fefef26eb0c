"""From rows to a sentence of advice."""

from __future__ import annotations

from collections.abc import Sequence

from roughcontact.checks import number
from roughcontact.errors import InputError
from roughcontact.report.row import ReportRow
from roughcontact.report.truth import Truth


def varying(rows: Sequence[ReportRow]) -> tuple[str, ...]:
    """Return the parts that differ between rows, the estimator apart.

    Solvers that differ by their own tolerances are told apart by their names alone.
    """
    names = [name for name in ("kernel", "convolver", "solver") if len({getattr(row, name) for row in rows}) > 1]
    if len({(row.solver, row.tolerance) for row in rows}) > len({row.solver for row in rows}):
        names.append("tolerance")
    return tuple(names)


def series_of(rows: Sequence[ReportRow]) -> dict[tuple[object, ...], list[ReportRow]]:
    """Return the rows of each setup that have an answer, from coarse to fine."""
    found: dict[tuple[object, ...], list[ReportRow]] = {}
    for row in sorted(rows, key=lambda row: row.cells):
        if not row.failure:
            found.setdefault(row.setup, []).append(row)
    return found


def setup_words(row: ReportRow, parts: Sequence[str]) -> str:
    """Return the estimator and the given parts of a row, in words."""
    words = [f"tolerance {row.tolerance:.0e}" if part == "tolerance" else getattr(row, part) for part in parts]
    return ", ".join([row.estimator, *words])


def percent(share: float) -> str:
    """Return a share in per cent, in two digits."""
    return f"{signed(share).removeprefix('+')} %"


def signed(share: float) -> str:
    """Return the number of per cents with its sign, in two digits or as a whole number."""
    value = 100 * share
    return f"{value:+.2g}" if abs(value) < 99.5 else f"{value:+.0f}"


def advised(rows: Sequence[ReportRow], truth: Truth, area: float) -> str:
    """Return the advice; see `ErrorReport.advice`."""
    area = number(area, "The allowed error of the area", above=0.0, at_most=1.0)
    if truth.area is None:
        raise InputError("There is no advice on the area: the truth that was given does not tell it.")
    blur = truth.blur("area")
    if blur > area:
        told = f"The true area is known to {percent(blur)} only, which cannot tell what reaches {percent(area)}."
        return told if blur > 1.0 else f"{told} {advised(rows, truth, blur)}"
    series = series_of(rows)
    if not series:
        return "No case has an answer: there is nothing to advise."
    parts = varying(rows)
    enough = [row for line in series.values() if (row := _enough(line, area)) is not None]
    if not enough:
        nearest = min((row for line in series.values() for row in line), key=lambda row: row.error("area"))
        return (
            f"For {percent(area)} of area: nothing here is enough; the nearest is {_case(nearest, parts)} "
            f"({percent(nearest.error('area'))}, {_seconds(nearest)})."
        )
    best = min(enough, key=_cost)
    others = dict.fromkeys(row.estimator for row in rows if row.estimator != best.estimator and not row.failure)
    clauses = [_clause(name, series, enough, area, parts) for name in others]
    return "; ".join([f"For {percent(area)} of area: {_case(best, parts)}, {_seconds(best)}", *clauses]) + "."


def _enough(line: Sequence[ReportRow], area: float) -> ReportRow | None:
    """Return the cheapest row that is good enough, all finer ones being so too."""
    good: list[ReportRow] = []
    for row in reversed(line):
        if not row.error("area") <= area:
            break
        good.append(row)
    return min(good, key=_cost, default=None)


def _clause(
    name: str,
    series: dict[tuple[object, ...], list[ReportRow]],
    enough: Sequence[ReportRow],
    area: float,
    parts: Sequence[str],
) -> str:
    """Say what another estimator needs."""
    mine = [row for row in enough if row.estimator == name]
    if mine:
        row = min(mine, key=_cost)
        nx, ny = row.shape
        return f"{setup_words(row, parts)} needs {nx} x {ny} cells ({_seconds(row)})"
    finest = [line[-1] for line in series.values() if line[-1].estimator == name]
    row = min(finest, key=lambda row: (-row.cells, row.cost("area")))
    nx, ny = row.shape
    there = f"{percent(row.error('area'))} there, {_seconds(row)}"
    return f"{setup_words(row, parts)} needs more than {nx} x {ny} cells ({there})"


def _case(row: ReportRow, parts: Sequence[str]) -> str:
    nx, ny = row.shape
    return f"{nx} x {ny} cells with {setup_words(row, parts)}"


def _cost(row: ReportRow) -> float:
    return row.cost("area")


def _seconds(row: ReportRow) -> str:
    return f"{row.cost('area'):.2g} s"
