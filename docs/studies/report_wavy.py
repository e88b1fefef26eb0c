"""Error against run time on the paper's wave at 100 MPa: the default, cell counts, and cell counts extrapolated.

Writes docs/figures/report_wavy.png and the table of docs/trust/error_report.md. The default is one solve, blended area,
on 256 cells a side. Cell count is what the paper reports; its extrapolation by eq. 28, or by a power law, costs the
solves of all its grids.

    python docs/studies/report_wavy.py
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path

import attrs
from doc_tables import DocTable, pick, write_tables
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact._faces.panels.results import draw_errors
from roughcontact.extrapolation import exponential, power_law
from roughcontact.plotting import style
from roughcontact.results import ErrorReport
from roughcontact_paper import published

FIGURES = Path(__file__).parent.parent / "figures"
GRIDS = (64, 128, 256, 512, 1024, 2048)
DEFAULTS = (256,)
LOAD = 100
# Error bound of the converged answers: the change between the finest grids of docs/trust/paper.md.
BOUND = 2e-4


@attrs.frozen
class Method:
    """A method for the area: its name, relative error with sign, and CPU time, s."""

    name: str
    error: float
    cpu: float


def make_reference() -> rc.results.KnownAnswer:
    """Return the converged answers of docs/trust/paper.md."""
    area = published.TRUE_AREA[LOAD] / 100 * 250e-6**2
    p_max = published.TRUE_P_MAX[LOAD] * 1e9
    return rc.results.KnownAnswer(
        area=area, area_error=BOUND * area, p_max=p_max, p_max_error=BOUND * p_max, source="converged answers"
    )


@functools.cache
def make_report(grids: Sequence[int], defaults: Sequence[int], repeats: int) -> ErrorReport:
    """Return the report on twenty wavelengths a side of a periodic domain."""
    surface = rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6)
    body = rc.Body(surface, rc.Elastic(young=200e9, poisson=0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((grids[0], grids[0]), 250e-6), boundary="periodic")
    return rc.error_vs_time(
        problem,
        pressure=1e6 * LOAD,
        reference=make_reference(),
        cells=sorted({*grids, *defaults}),
        solvers=("projected-cg", "polonsky-keer"),
        repeats=repeats,
        on_case=lambda case, done: print(f"{100 * done:3.0f} %: {case}", flush=True),
    )


def compare_methods(report: ErrorReport, grids: Sequence[int], defaults: Sequence[int]) -> list[Method]:
    """Return the default, from the largest error, then for both solvers the count, eq. 28, and a power law."""
    blends = {row.shape[0]: row for row in report.rows if row.estimator == "blend" and row.solver == "projected-cg"}
    methods = [
        Method(
            f"blend on {cells} x {cells}, {blends[cells].solver}", blends[cells].area_error, blends[cells].cpu.median
        )
        for cells in defaults
    ]
    methods.sort(key=lambda method: -abs(method.error))
    for solver in ("polonsky-keer", "projected-cg"):
        counts = [row for row in report.rows if row.solver == solver and row.estimator == "cell-count"]
        counts = [row for row in counts if row.shape[0] in grids]
        finest = counts[-1]
        count = f"count on {finest.shape[0]} x {finest.shape[0]}, {solver}"
        methods.append(Method(count, finest.area_error, finest.cpu.median))
        for name, rule, used in (("eq. 28", exponential, counts), ("power law", power_law, counts[-3:])):
            limit = rule([row.shape[0] for row in used], [row.area for row in used]).value
            spent = sum(row.cpu.median for row in used)
            names = f"{used[0].shape[0]} to {finest.shape[0]}"
            methods.append(Method(f"{name}, counts on {names}, {solver}", report.reference.error("area", limit), spent))
    return methods


def _two_digits(value: float) -> str:
    return f"{float(f'{value:.2g}'):g}"


def make_rows(grids: Sequence[int] = GRIDS, defaults: Sequence[int] = DEFAULTS, repeats: int = 3) -> list[list[str]]:
    """Return each method beside the first one."""
    methods = compare_methods(make_report(grids, defaults, repeats), grids, defaults)
    lines = [["method", "error, %", "CPU time, s", "error / first", "time / first"]]
    for method in methods:
        error, cost = abs(method.error / methods[0].error), method.cpu / methods[0].cpu
        lines.append(
            [method.name, f"{100 * method.error:+.2g}", f"{method.cpu:.2g}", _two_digits(error), _two_digits(cost)]
        )
    return lines


@style()
def draw(report: ErrorReport, methods: Sequence[Method], path: Path) -> None:
    figure = Figure(figsize=(8.2, 6.4), layout="constrained")
    axes = figure.subplots()
    draw_errors(axes, report, "area")
    for method in methods:
        rule, _, of = method.name.partition(", counts on ")
        if of:
            place, above = (method.cpu, 100 * abs(method.error)), rule == "eq. 28"
            text = f"{rule},\n{of.split(', ')[1]}"
            axes.plot(*place, "k*", markersize=11)
            axes.annotate(
                text, place, xytext=(0, 8 if above else -24), textcoords="offset points", ha="center", fontsize=7
            )
    defaults = [method for method in methods if method.name.startswith("blend")]
    places = [method.cpu for method in defaults], [100 * max(abs(method.error), BOUND) for method in defaults]
    axes.plot(*places, "ko", markersize=9, markerfacecolor="none")
    axes.annotate("the default", (places[0][0], places[1][0]), xytext=(-20, -28), textcoords="offset points")
    axes.set_ylim(bottom=20 * BOUND)
    axes.set_title(
        f"the paper's wave at {LOAD} MPa: area\nstars: cell counts extrapolated, at the cost of all their solves"
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)


def main(
    grids: Sequence[int] = GRIDS, defaults: Sequence[int] = DEFAULTS, repeats: int = 3, folder: Path = FIGURES
) -> None:
    report = make_report(grids, defaults, repeats)
    print(report, report.advice(), sep="\n\n")
    draw(report, compare_methods(report, grids, defaults), folder / "report_wavy.png")


# The columns and lines of the page.
SHOWN = ("method", "error, %", "CPU time, s", "time / first")
METHODS = (
    "blend on 256 x 256, projected-cg",
    "count on 2048 x 2048, polonsky-keer",
    "eq. 28, counts on 64 to 2048, polonsky-keer",
    "count on 2048 x 2048, projected-cg",
)
TABLES = {
    "report-wavy": DocTable(
        make_rows, seconds=200, timed=("CPU time, s", "time / first"), units=2, shown=pick(SHOWN, METHODS)
    ),
}

if __name__ == "__main__":
    write_tables(TABLES)
    main()
