"""Error against run time on the paper's wave at 100 MPa: the default beside cell count and beside eq. 28.

Writes docs/figures/report_wavy.png and prints the tables of docs/studies.md. The default is one solve on
256 x 256 cells with the blended area. Cell count is what the paper reports; its extrapolation by eq. 28,
or by a power law, costs the solves of all its grids.

    python docs/studies/report_wavy.py
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import attrs
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.extrapolation import exponential, power_law
from roughcontact.paper import printed
from roughcontact.report.picture import draw_errors

FIGURES = Path(__file__).parent.parent / "figures"
GRIDS = (64, 128, 256, 512, 1024, 2048)
LOAD = 100
# The converged answers are good to 0.02 %.
GOOD = 2e-4


@attrs.frozen
class Rival:
    """A way to the area.

    Attributes
    ----------
    name
        What it is.
    error
        Relative error of the area, with sign.
    cpu
        CPU time, s.
    """

    name: str
    error: float
    cpu: float


def truth() -> rc.Truth:
    """Return the converged answers of docs/paper.md."""
    area = printed.TRUE_AREA[LOAD] / 100 * 250e-6**2
    p_max = printed.TRUE_P_MAX[LOAD] * 1e9
    return rc.Truth(
        area=area, area_error=GOOD * area, p_max=p_max, p_max_error=GOOD * p_max, source="converged answers"
    )


def report(grids: Sequence[int], repeats: int) -> rc.ErrorReport:
    """Twenty whole waves on a truly periodic domain: no sampling tricks."""
    surface = rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6)
    body = rc.Body(surface, rc.Elastic(young=200e9, poisson=0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((grids[0], grids[0]), 250e-6), boundary="periodic")
    return rc.error_vs_time(
        problem,
        pressure=1e6 * LOAD,
        truth=truth(),
        cells=grids,
        solvers=("projected-cg", "polonsky-keer"),
        repeats=repeats,
        on_case=lambda what, share: print(f"{100 * share:3.0f} %: {what}", flush=True),
    )


def rivals(found: rc.ErrorReport, default: int) -> list[Rival]:
    """Return the default, then for both solvers the finest count, eq. 28, and a power law through the finest three."""
    chosen = next(row for row in found.rows if row.shape[0] == default and row.estimator == "blend")
    ways = [Rival(f"blend on {default} x {default}, {chosen.solver}", chosen.area_error, chosen.cpu.median)]
    for solver in ("polonsky-keer", "projected-cg"):
        counts = [row for row in found.rows if row.solver == solver and row.estimator == "cell-count"]
        finest = counts[-1]
        count = f"count on {finest.shape[0]} x {finest.shape[0]}, {solver}"
        ways.append(Rival(count, finest.area_error, finest.cpu.median))
        for name, rule, used in (("eq. 28", exponential, counts), ("power law", power_law, counts[-3:])):
            limit = rule([row.shape[0] for row in used], [row.area for row in used]).value
            spent = sum(row.cpu.median for row in used)
            grids = f"{used[0].shape[0]} to {finest.shape[0]}"
            ways.append(Rival(f"{name}, counts on {grids}, {solver}", found.truth.error("area", limit), spent))
    return ways


def table(ways: Sequence[Rival]) -> str:
    """Each way beside the first one."""
    default = ways[0]
    lines = [
        "| way to the area | error, % | CPU time, s | error / default's | time / default's |",
        "|---|---|---|---|---|",
    ]
    for way in ways:
        error, cost = abs(way.error / default.error), way.cpu / default.cpu
        lines.append(f"| {way.name} | {100 * way.error:+.2g} | {way.cpu:.2g} | {error:.0f} | {cost:.0f} |")
    return "\n".join(lines)


def draw(found: rc.ErrorReport, ways: Sequence[Rival], path: Path) -> None:
    figure = Figure(figsize=(8.2, 6.4), layout="constrained")
    axes = figure.subplots()
    draw_errors(axes, found, "area")
    for way in ways:
        rule, _, of = way.name.partition(", counts on ")
        if of:
            place, above = (way.cpu, 100 * abs(way.error)), rule == "eq. 28"
            text = f"{rule},\n{of.split(', ')[1]}"
            axes.plot(*place, "k*", markersize=11)
            axes.annotate(
                text, place, xytext=(0, 8 if above else -24), textcoords="offset points", ha="center", fontsize=7
            )
    default = (ways[0].cpu, 100 * abs(ways[0].error))
    axes.plot(*default, "ko", markersize=20, markerfacecolor="none")
    axes.annotate("the default", default, xytext=(-10, -22), textcoords="offset points", ha="right")
    axes.set_title(
        f"the paper's wave at {LOAD} MPa: area\nstars: cell counts extrapolated, at the cost of all their solves"
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)


def main(grids: Sequence[int] = GRIDS, default: int = 256, repeats: int = 3, folder: Path = FIGURES) -> None:
    found = report(grids, repeats)
    ways = rivals(found, default)
    print(found, found.advice(), table(ways), sep="\n\n")
    draw(found, ways, folder / "report_wavy.png")


if __name__ == "__main__":
    main()
