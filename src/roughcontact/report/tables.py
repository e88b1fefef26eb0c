"""A report as text, as Markdown and as records for a file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from roughcontact.report.advice import percent, signed, varying
from roughcontact.report.row import ReportRow, Timing
from roughcontact.report.truth import QUANTITIES
from roughcontact.units import si

if TYPE_CHECKING:
    from roughcontact.report.result import ErrorReport

_TRUE = {"area": ("area", "m2"), "p_max": ("greatest pressure", "Pa"), "approach": ("approach", "m")}
# Share of the comparison's own error below which a number says nothing but that it is small.
_NOTHING = 0.01


def text(report: ErrorReport) -> str:
    """Return the report as a table of aligned columns."""
    headings, body, footnotes = _cells(report)
    table = [headings, *body]
    widths = [max(len(line[column]) for line in table) for column in range(len(headings))]
    lines = ["  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in table]
    return "\n".join([*_head(report), "", *lines, "", *footnotes, *_notes(report)])


def markdown(report: ErrorReport) -> str:
    """Return the report as Markdown."""
    headings, body, footnotes = _cells(report)
    table = [headings, ["---:" for _ in headings], *body]
    lines = [f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in table]
    notes = [f"- {note}" for note in [*footnotes, *_notes(report)]]
    head = ["# Error against run time", "", *(f"{line}  " for line in _head(report))]
    return "\n".join([*head, "", *lines, "", *notes, ""])


def records(report: ErrorReport) -> Iterator[list[object]]:
    """Return the headings, then every row with every digit."""
    times = [f"{name}_s{end}" for name in ("cpu", "wall", "solve_cpu", "area_cpu") for end in ("", "_min", "_max")]
    yield [
        *("nx", "ny", "kernel", "convolver", "solver", "tolerance", "estimator"),
        *("area_m2", "area_uncertainty_m2", "p_max_Pa", "approach_m"),
        *(f"{name}_error" for name in QUANTITIES),
        *(f"{name}_resolved" for name in QUANTITIES),
        *("pareto", *times, "iterations", "convolutions", "float32_convolutions", "peak_bytes", "failure"),
    ]
    front = {id(row) for row in report.front()}
    for row in report.rows:
        spent = [
            value
            for timing in (row.cpu, row.wall, row.solve_cpu, row.area_cpu)
            for value in (timing.median, timing.low, timing.high)
        ]
        yield [
            *(*row.shape, row.kernel, row.convolver, row.solver, row.tolerance, row.estimator),
            *(row.area, row.area_uncertainty, row.p_max, row.approach),
            *(getattr(row, f"{name}_error") for name in QUANTITIES),
            *(int(_resolved(row, name)) for name in QUANTITIES),
            *(int(id(row) in front), *spent, row.iterations, row.convolutions, row.single, row.peak, row.failure),
        ]


def _resolved(row: ReportRow, quantity: str) -> bool:
    return math.isfinite(row.error(quantity)) and quantity not in row.unresolved


def _head(report: ErrorReport) -> list[str]:
    """Say what was solved and what it is compared with."""
    truth = report.truth
    known = []
    for name in truth.quantities:
        label, unit = _TRUE[name]
        value = getattr(truth, name)
        written = f"{value:.5g} m2" if unit == "m2" else si(value, unit, 5)
        known.append(f"{label} {written} +- {percent(truth.blur(name))}")
    row, differing = report.rows[0], varying(report.rows)
    common = [getattr(row, name) for name in ("kernel", "convolver", "solver") if name not in differing]
    if len({each.tolerance for each in report.rows}) == 1:
        common.append(f"tolerance {row.tolerance:.0e}")
    return [
        f"{report.scene}; {', '.join(common)}",
        f"Compared with {truth.source}: {'; '.join(known)}",
    ]


def _cells(report: ErrorReport) -> tuple[list[str], list[list[str]], list[str]]:
    """Return the headings, the table's cells, and the reasons of failures."""
    parts, known = varying(report.rows), report.truth.quantities
    headings = ["cells", *parts, "area by", "area, % of nominal"]
    headings += [f"{name} error, %" for name in known]
    headings += ["CPU, s (min..max)", "area, s", "wall, s (min..max)", "iter.", "conv.", "float32", "peak, MiB"]
    front = {id(row) for row in report.front()}
    failures = list(dict.fromkeys(row.failure for row in report.rows if row.failure))
    body = []
    for row in report.rows:
        line = [f"{row.shape[0]} x {row.shape[1]}", *(_part(row, part) for part in parts), row.estimator]
        if row.failure:
            line += [f"failed [{failures.index(row.failure) + 1}]", *["-"] * (len(headings) - len(line) - 1)]
        else:
            line += [
                f"{100 * row.area / report.nominal:.4g}",
                *(_error(row, name, report.truth.blur(name), id(row) in front) for name in known),
            ]
            line += [_span(row.cpu), f"{row.area_cpu.median:.2g}", _span(row.wall)]
            line += [str(row.iterations), str(row.convolutions), str(row.single), f"{row.peak / 2**20:.3g}"]
        body.append(line)
    return headings, body, [f"[{number}] {reason}" for number, reason in enumerate(failures, start=1)]


def _part(row: ReportRow, part: str) -> str:
    return f"{row.tolerance:.0e}" if part == "tolerance" else str(getattr(row, part))


def _error(row: ReportRow, name: str, blur: float, on_front: bool) -> str:
    error = getattr(row, f"{name}_error")
    star = "* " if on_front and name == "area" else ""
    if name in row.unresolved:
        return f"{star}({signed(error) if abs(error) > _NOTHING * blur else '0'})"
    return star + signed(error)


def _span(timing: Timing) -> str:
    return f"{timing.median:.2g} ({timing.low:.2g}..{timing.high:.2g})"


def _notes(report: ErrorReport) -> list[str]:
    """Say how to read the table."""
    notes = ["* on the Pareto front: no other case is both cheaper and nearer."] if report.front() else []
    if any(row.unresolved for row in report.rows):
        notes.append("(in brackets) the error is below that of the comparison itself: not resolved.")
    return [
        *notes,
        f"CPU (all threads) and wall time: medians of {report.repeats} after a warm-up, from the surface to the area; "
        "'area, s' is the estimator's part of the CPU time.",
        "conv.: convolutions the solve counts; float32: how many of its convolutions, on all grids, ran in float32.",
        "peak: numpy's memory, by tracemalloc in a pass of its own; scratch inside the transforms is not in it.",
    ]
