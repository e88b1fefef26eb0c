"""Extreme and unsolvable contacts: each converges and is confirmed, is refused, or says that it did not converge.

    python benchmarks/stability_gallery.py             # the table, as text; five seconds
    python benchmarks/stability_gallery.py --markdown  # the table of docs/trust/stability.md

The exit status is 1 if a solution is called converged and is not. `stability_gallery()` returns the table.
"""

from __future__ import annotations

import math
import sys
import textwrap
from collections.abc import Callable

import attrs
import numpy as np

import roughcontact as rc
from roughcontact._solve.problem import pressure_unit
from roughcontact._solve.solution import ContactConditions
from roughcontact._work.reports.stability_checks import sum_displacement
from roughcontact._work.reports.stability_report import RULES, find_worst, format_row, summarize
from roughcontact.results import Verdict
from roughcontact.typing import Array, Table

# Cells a side, few enough for plain sums.
CELLS = 48
# Young's modulus and hardness, Pa; their size does not matter.
YOUNG = 1e9
HARDNESS = 1e6
BOUNDARIES = ("free", "periodic")


@attrs.frozen
class GalleryRow:
    """One contact of the gallery and its result.

    Attributes
    ----------
    case
        What is extreme about it.
    status
        The solver's status, or why the case was refused.
    iterations, convolutions
        The work of the solve.
    gap, load
        The violation of the contact conditions, and the relative error of the load, by plain sums; nan if refused.
    verdict
        Pass: converged and confirmed, or refused. Attention: not converged. Fail: called converged, and is not.
    """

    case: str
    status: str
    iterations: int
    convolutions: int
    gap: float
    load: float
    verdict: Verdict

    def describe(self) -> str:
        """Return verdict, case and residuals in a line of at most 80 columns, and below it what did not converge."""
        residuals = "" if math.isnan(self.gap) else f"{self.gap:>8.1e} {self.load:>8.1e}"
        text = "" if self.status.startswith("converged") else self.status
        return format_row(self.verdict, self.case, residuals, text)


@attrs.frozen
class Gallery:
    """All contacts of the gallery; `str` of it is a table."""

    rows: tuple[GalleryRow, ...]

    @property
    def verdict(self) -> Verdict:
        """The worst verdict."""
        return find_worst(row.verdict for row in self.rows)

    def __repr__(self) -> str:
        return f"<Gallery {summarize([row.verdict for row in self.rows])}>"

    def _repr_html_(self) -> str:
        # A notebook omits rows in the middle of a long table.
        rows = sorted(self.rows, key=lambda row: list(Verdict).index(row.verdict), reverse=True)
        columns = {one.name: [getattr(row, one.name) for row in rows] for one in attrs.fields(GalleryRow)}
        return Table(columns).to_html(summarize([row.verdict for row in self.rows]))

    def __str__(self) -> str:
        head = format_row("verdict", "case", "gap     load", "")
        summary = summarize([row.verdict for row in self.rows])
        return "\n".join([summary, "", head, *(row.describe() for row in self.rows)])

    def to_markdown(self) -> str:
        """Return the table as Markdown."""
        names = [one.name for one in attrs.fields(GalleryRow)]
        table = Table.from_rows(names, map(_abbreviate, self.rows), left=("case", "status", "verdict"))
        return f"{table.to_markdown()}\n\n{summarize([row.verdict for row in self.rows])}"


def _abbreviate(row: GalleryRow) -> list[str]:
    converged = row.status.startswith("converged")
    status = row.status.split(":")[0] if converged else textwrap.shorten(row.status, 100, placeholder=" ...")
    work = [str(row.iterations), str(row.convolutions), f"{row.gap:.1e}", f"{row.load:.1e}"]
    return [row.case, status, *([""] * len(work) if math.isnan(row.gap) else work), row.verdict]


def stability_gallery() -> Gallery:
    """Return the results of all cases: each converges and is confirmed, is refused, or says that it did not converge.

    Residuals are recomputed by plain sums, which share no transform with the solver.
    """
    return Gallery(tuple(_solve(case) for case in make_cases()))


@attrs.frozen(eq=False)
class Case:
    """A contact: what is extreme about it, a function that makes the problem, and the mean pressure, Pa."""

    name: str
    make: Callable[[], rc.ContactProblem]
    pressure: float


def make_cases() -> tuple[Case, ...]:
    """Return all cases of the gallery."""
    return (*_magnitudes(), *_shapes(), *_loads(), *_refused())


def _solve(case: Case) -> GalleryRow:
    try:
        problem = case.make()
        solution = problem.solve(pressure=case.pressure, throw=False)
    except rc.InputError as refusal:
        return GalleryRow(case.name, f"refused: {refusal}", 0, 0, math.nan, math.nan, Verdict.PASS)
    gap = _recompute(problem, solution)
    load = abs(math.fsum(solution.pressure.ravel()) / solution.grid.cells / case.pressure - 1.0)
    verdict = Verdict.ATTENTION
    if solution.status.success:
        rule = RULES["complementarity"]
        rounded = solution.status is rc.Status.CONVERGED_TO_ROUNDING
        confirmed = gap <= (rule.admissible if rounded else rule.good) and load <= RULES["load balance"].good
        verdict = Verdict.PASS if confirmed else Verdict.FAIL
    work = solution.iterations, solution.convolutions
    return GalleryRow(case.name, str(solution.status), *work, gap, load, verdict)


def _recompute(problem: rc.ContactProblem, solution: rc.ContactSolution) -> float:
    """Return the violation of the contact conditions with the displacement by plain sums, over its scale."""
    plan = problem.plan
    unit = pressure_unit(plan)
    displacement = sum_displacement(problem, solution.pressure, np.arange(plan.grid.cells)).reshape(plan.grid.shape)
    conditions = ContactConditions(solution.initial_gap / plan.peak_to_valley, plan.pressure_limit / unit)
    return conditions.measure(solution.pressure / unit, displacement / plan.peak_to_valley).error


def _rough(cells: int = CELLS) -> Array:
    """Return heights of about one on cells of side one."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_height=1.0, shortest=6.0, longest=float(cells), seed=0)
    return surface.heights(rc.Grid((cells, cells), float(cells)))


def _case(
    name: str,
    heights: Array,
    size: float | tuple[float, float] = 1.0,
    *,
    young: float = YOUNG,
    hardness: float | None = None,
    load: float = 0.01,
    pressure: float | None = None,
    boundary: str = "free",
) -> Case:
    """Return a map on a rigid flat under a pressure, or under `load` times E times peak-to-valley height over side."""

    def make() -> rc.ContactProblem:
        material = rc.Elastic(young, 0.3) if hardness is None else rc.ElasticPerfectlyPlastic(young, 0.3, hardness)
        surface = rc.HeightMap(heights, size=np.broadcast_to(size, 2))
        return rc.ContactProblem(rc.Body(surface, material), boundary=boundary)

    if pressure is None:
        pressure = load * young * float(np.ptp(heights)) / float(np.max(size))
    return Case(name, make, pressure)


def _magnitudes() -> tuple[Case, ...]:
    return (
        *(_case(f"E = {young:.0e} Pa", 1e-2 * _rough(), young=young) for young in (1.0, 1e5, 1e10, 1e15)),
        *(_case(f"heights of {height:.0e} m on 1 m", height * _rough()) for height in (1e-12, 1e-6, 1.0, 1e3)),
        _case("heights of 1e-12 m on 1e-9 m", 1e-12 * _rough(), 1e-9),
        _case("heights of 1e3 m on 1e9 m", 1e3 * _rough(), 1e9),
        _case("two scales 1e6 apart", _rough() + 1e-6 * np.random.default_rng(1).standard_normal((CELLS, CELLS))),
    )


def _shapes() -> tuple[Case, ...]:
    needle = np.zeros((CELLS, CELLS))
    step = np.zeros((CELLS, CELLS))
    needle[CELLS // 2, CELLS // 3] = 1e-2
    step[: CELLS // 2] = 1e-2
    noise = np.random.default_rng(0).standard_normal((2, 4096))
    return (
        *(_case(f"cells of aspect {aspect:g}, {boundary}, {'light' if load < 0.1 else 'heavy'} load", _rough(16),
                (aspect, 1.0), boundary=boundary, load=load * max(aspect, 1.0))
          for aspect in (1e-3, 1e3) for boundary in BOUNDARIES for load in (0.01, 1.0)),
        *(_case(f"one high cell, load {load:g} E h/L", needle, load=load) for load in (1e-6, 1e-2)),
        *(_case(f"step, {boundary}", step, boundary=boundary) for boundary in BOUNDARIES),
        *(_case(f"2 x 4096 cells, {boundary}", noise, (2.0, 4096.0), load=10.0, boundary=boundary)
          for boundary in BOUNDARIES),
        *(_case(f"1 x 500 cells, {boundary}", noise[:1, :500], (1.0, 500.0), boundary=boundary)
          for boundary in BOUNDARIES),
        _case("two cells", np.array([[0.0, 1e-3]]), (1.0, 2.0)),
    )  # fmt: skip


def _loads() -> tuple[Case, ...]:
    rough = 1e-2 * _rough()
    above = float(np.nextafter(HARDNESS, np.inf))
    return (
        *(_case(f"one cell in contact, {boundary}", _rough(), load=1e-9, boundary=boundary) for boundary in BOUNDARIES),
        *(_case(f"full contact, {boundary}", rough, load=1e2, boundary=boundary) for boundary in BOUNDARIES),
        *(_case(f"mean pressure {load:.0e} E h/L, periodic", rough, load=load, boundary="periodic")
          for load in (1e6, 1e9, 1e12)),
        *(_case(f"mean pressure {load:g} H, {boundary}", rough, hardness=HARDNESS, pressure=load * HARDNESS,
                boundary=boundary)
          for load in (0.999, 1.0) for boundary in BOUNDARIES),
        _case("H is the next number above the mean pressure", rough, hardness=above, pressure=HARDNESS),
        _case("mean pressure 1.001 H", rough, hardness=HARDNESS, pressure=1.001 * HARDNESS),
    )  # fmt: skip


def _refused() -> tuple[Case, ...]:
    lost = _rough()
    lost[3, 5] = np.inf
    return (
        _case("one infinite height", lost, pressure=HARDNESS),
        _case("two flats", np.zeros((CELLS, CELLS)), pressure=0.0),
        _case("heights of 1e300 m", 1e300 * _rough(), pressure=HARDNESS),
        _case("E = 210 Pa, meant as GPa", 1e-9 * _rough(), 0.1, young=210.0, pressure=1e9),
    )


def main() -> int:
    """Print the table, and return the exit status."""
    gallery = stability_gallery()
    print(gallery.to_markdown() if "--markdown" in sys.argv else gallery)
    return 1 if gallery.verdict is Verdict.FAIL else 0


if __name__ == "__main__":
    sys.exit(main())
