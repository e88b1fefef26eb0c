"""The work-precision picture of a report."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from roughcontact.errors import InputError, MissingPackage
from roughcontact.report.advice import series_of, setup_words, varying
from roughcontact.report.row import ReportRow

try:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
except ImportError:
    raise MissingPackage("Drawing needs matplotlib: pip install 'roughcontact[plot]'.") from None

if TYPE_CHECKING:
    from roughcontact.report.result import ErrorReport

_MARKERS = "oDs^vP*X<>hp"
_DASHES = ("-", "--", "-.", ":")
_TITLES = {"area": "real contact area", "p_max": "greatest pressure", "approach": "approach"}
# Errors below this share of the truth's own are drawn there: a zero has no place on a logarithmic axis.
_LEAST = 0.1
_TINY = 1e-9
# Axes that span less than this get ticks between the powers of ten.
_WIDE = 300.0


def draw_report(report: ErrorReport, path: Path, ending: str) -> None:
    """Draw a panel for each quantity whose truth is known, as a file of that ending; see `ErrorReport.draw`."""
    names = report.truth.quantities
    figure = Figure(figsize=(5.6 * len(names), 5.6), layout="constrained")
    for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
        draw_errors(axes, report, name)
    known = figure.canvas.get_supported_filetypes()
    if ending.lstrip(".") not in known:
        raise InputError.about("The ending of a picture", ending, f"one of {', '.join(sorted(known))}")
    figure.savefig(path, dpi=150, format=ending.lstrip("."))


def draw_errors(axes: Axes, report: ErrorReport, quantity: str) -> None:
    """Draw the errors of one quantity against CPU time.

    Parameters
    ----------
    axes
        Where to.
    report
        The report.
    quantity
        ``"area"``, ``"p_max"`` or ``"approach"``.
    """
    blur = report.truth.blur(quantity)
    parts = varying(report.rows)
    lines = _lines(report.rows, quantity)
    axes.set_title(_TITLES[quantity])
    if not lines:
        axes.text(0.5, 0.5, "no case has an answer", ha="center", transform=axes.transAxes)
        return
    for rows, style in zip(lines, _styles(lines, quantity), strict=True):
        label = setup_words(rows[0], parts) if quantity == "area" else _without_estimator(rows[0], parts)
        _line(axes, rows, quantity, blur, style, label)
    front = report.front(quantity)
    axes.plot(
        [row.cost(quantity) for row in front],
        [_shown(row, quantity, blur) for row in front],
        color="0.8",
        linewidth=7,
        solid_capstyle="round",
        zorder=0,
        label="Pareto front",
    )
    if blur > 0.0:
        axes.axhline(100 * blur, color="0.4", linestyle="--", linewidth=1, label="error of the comparison itself")
    low, high = axes.dataLim.intervaly
    if low == high:
        # A single number spans no axis.
        axes.set_ylim(0.5 * low, 2.0 * high)
    axes.set(xscale="log", yscale="log", xlabel="CPU time, s (beside the points: cells along x)", ylabel="error, %")
    axes.grid(alpha=0.3)
    axes.margins(x=0.12)
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < _WIDE * low else (1.0,), numticks=12))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.legend(
        fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2, handlelength=4, frameon=False
    )


def _lines(rows: Sequence[ReportRow], quantity: str) -> list[list[ReportRow]]:
    """Return the rows of each line; pressure and approach need no estimator, so its rows are taken once."""
    lines = list(series_of(rows).values())
    if quantity == "area":
        return lines
    return list({line[0].setup[:-1]: line for line in reversed(lines)}.values())[::-1]


def _styles(lines: Sequence[Sequence[ReportRow]], quantity: str) -> list[tuple[str, int]]:
    """Return a colour for each estimator and a marker for each of the other setups; if there is one, for each line."""
    estimators = list(dict.fromkeys(rows[0].estimator for rows in lines))
    setups = list(dict.fromkeys(rows[0].setup[:-1] for rows in lines))
    one = quantity != "area" or len(estimators) == 1
    return [
        (f"C{(setup if one else estimators.index(rows[0].estimator)) % 10}", setup)
        for rows in lines
        for setup in [setups.index(rows[0].setup[:-1])]
    ]


def _line(
    axes: Axes, rows: Sequence[ReportRow], quantity: str, blur: float, style: tuple[str, int], label: str
) -> None:
    color, setup = style
    marker, dashes = _MARKERS[setup % len(_MARKERS)], _DASHES[setup % len(_DASHES)]
    x = [row.cost(quantity) for row in rows]
    y = [_shown(row, quantity, blur) for row in rows]
    timings = [row.cpu if quantity == "area" else row.solve_cpu for row in rows]
    spread = [[time.median - time.low for time in timings], [time.high - time.median for time in timings]]
    axes.errorbar(x, y, xerr=spread, linewidth=1.2, linestyle=dashes, elinewidth=0.8, color=color)
    # Numbers of the second line lie below it, so that two solvers on one grid do not write over each other.
    place = (5, -10) if setup % 2 else (5, 4)
    for across, up, row in zip(x, y, rows, strict=True):
        face = "white" if quantity in row.unresolved else color
        axes.plot(across, up, marker, markerfacecolor=face, color=color)
        axes.annotate(
            f"{row.shape[0]}", (across, up), xytext=place, textcoords="offset points", fontsize=7, color="0.3"
        )
    axes.plot([], [], marker, linestyle=dashes, color=color, label=label)


def _shown(row: ReportRow, quantity: str, blur: float) -> float:
    return 100 * max(row.error(quantity), _LEAST * blur, _TINY)


def _without_estimator(row: ReportRow, parts: Sequence[str]) -> str:
    return setup_words(row, parts).removeprefix(row.estimator).removeprefix(", ") or row.solver
