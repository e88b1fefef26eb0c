"""Is an accuracy that is asked for met, on which grid and at which cost? The table of docs/use/choose.md.

    python docs/studies/accuracy.py          # writes the table
    python docs/studies/accuracy.py CASES    # prints it for fewer cases

Each class has so many random cases (phases, seeds, places, loads), which no constant was measured on. An area counts
as met if it is within 1 % of the converged one. The smallest fixed grid that would have met it is that of a list from
which on all finer ones meet it too; it is solved with the default tolerance. CPU times are of one thread.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from doc_tables import DocTable, pick, write_tables

import roughcontact as rc

WITHIN = 0.01
STEEL, SOFT = rc.Elastic(200e9, 0.3), rc.Elastic(1.0, 0.0)
# Grids of which the smallest fixed one is sought, and that of the comparison and of the reference.
FIXED, FINEST = (64, 96, 128, 192, 256, 384, 512), 1024
# Converged areas of the paper's wave over nominal, by pressure, Pa.
WAVES = {50e6: 0.71689e-2, 100e6: 1.14192e-2, 200e6: 1.82266e-2}
# Dimensionless pressures p / (E* slope) of rough surfaces, and what is in contact there.
ROUGH = {0.005: "1 %", 0.025: "5 %", 0.1: "20 %"}

Case = tuple[rc.ContactProblem, dict[str, float], float | None]


def rough(random: np.random.Generator, seed: int, longest: float = 64.0) -> rc.SelfAffineSurface:
    hurst = float(random.choice([0.4, 0.6, 0.8]))
    return rc.SelfAffineSurface(hurst=hurst, rms_slope=0.1, shortest=2.0, longest=longest, rolloff=16.0, seed=seed)


def wave(random: np.random.Generator, number: int) -> Case:
    """Return the paper's wave; every third at phase zero, where a grid of whole cells a wave cuts all summits alike."""
    pressure = list(WAVES)[number % 3]
    phase = (0.0, 0.0) if number // 3 % 3 == 0 else tuple(random.uniform(0.0, 2.0 * np.pi, 2))
    body = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6, phase), STEEL)
    problem = rc.ContactProblem(body, grid=rc.Grid((FINEST, FINEST), 250e-6), boundary="periodic", threads=1)
    return problem, {"pressure": pressure}, WAVES[pressure] * 250e-6**2


def rough_at(load: float) -> Callable[[np.random.Generator, int], Case]:
    def make(random: np.random.Generator, number: int) -> Case:
        body = rc.Body(rough(random, 7000 + number), SOFT)
        problem = rc.ContactProblem(body, grid=rc.Grid((FINEST, FINEST), 64.0), boundary="periodic", threads=1)
        return problem, {"pressure": 0.1 * load}, None

    return make


def ball(random: np.random.Generator, number: int) -> Case:
    """Return a ball with a contact of 2 to 20 % of the domain across; every third in the very middle."""
    radius, curvature = 64.0 * float(random.uniform(0.01, 0.1)), 1e4
    center = (0.0, 0.0) if number % 3 == 0 else tuple(random.uniform(-8.0, 8.0, 2))
    problem = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(curvature, center), SOFT), grid=rc.Grid((FINEST, FINEST), 64.0), threads=1
    )
    return problem, {"force": 4.0 / 3.0 * radius**3 / curvature}, np.pi * radius**2


def capped_pair(random: np.random.Generator, number: int) -> Case:
    """Return two rough bodies of limited hardness."""
    hard = rc.ElasticPerfectlyPlastic(1.0, 0.0, 0.03)
    one, other = (rc.Body(rough(random, 8000 + 2 * number + side), hard) for side in (0, 1))
    problem = rc.ContactProblem(one, other, grid=rc.Grid((FINEST, FINEST), 64.0), boundary="periodic", threads=1)
    return problem, {"pressure": float(random.uniform(0.001, 0.005))}, None


CLASSES = {
    "the paper's wave, 50 to 200 MPa": wave,
    **{f"rough, {name} in contact": rough_at(load) for load, name in ROUGH.items()},
    "a ball": ball,
    "a rough pair with a hardness": capped_pair,
}


def measure(solve: Callable[[], rc.ContactSolution]) -> tuple[rc.ContactSolution, float, float]:
    """Return a solution, its area, m2, and the CPU time of both, s."""
    started = time.process_time()
    solution = solve()
    return solution, solution.area().value, time.process_time() - started


def solve_on(problem: rc.ContactProblem, load: dict[str, float], cells: int) -> rc.ContactSolution:
    return rc.on_grid(problem, (cells, cells)).solve(**load)


def smallest_fixed(problem: rc.ContactProblem, load: dict[str, float], true: float) -> tuple[int, float]:
    """Return the smallest fixed grid from which on areas are within what is asked, and its CPU time, s."""
    found = FINEST, np.nan
    for cells in reversed(FIXED):
        try:
            _, area, seconds = measure(partial(solve_on, problem, load, cells))
        except rc.RoughContactError:
            break
        if abs(area / true - 1.0) > WITHIN:
            break
        found = cells, seconds
    return found


def cases_of(make: Callable[[np.random.Generator, int], Case], count: int) -> Iterator[tuple[float, ...]]:
    """Yield error, stated standard deviation, cells, CPU time, grids; fixed cells, time; time on the finest grid."""
    random = np.random.default_rng(2026)
    for number in range(count):
        problem, load, true = make(random, number)
        _, finest, of_finest = measure(partial(problem.solve, **load))
        true = finest if true is None else true
        solution, area, seconds = measure(partial(problem.solve, **load, area_within=WITHIN, throw=False))
        trials = solution.accuracy.trials
        stated = trials[-1].area_uncertainty / area if solution.accuracy.met else np.nan
        fixed, of_fixed = smallest_fixed(problem, load, true)
        yield area / true - 1.0, stated, solution.grid.shape[0], seconds, len(trials), fixed, of_fixed, of_finest


def make_rows(count: int = 8) -> list[list[str]]:
    heading = "contact|cases|met|rms error, %|stated, %|N|grids|CPU, s|smallest fixed N|its CPU, s"
    lines = [[*heading.split("|"), f"CPU at {FINEST}, s"]]
    for name, make in CLASSES.items():
        rows = np.array(list(cases_of(make, count)))
        error, stated, cells, seconds, grids, fixed, of_fixed, of_finest = rows.T
        met = np.mean((np.abs(error) <= WITHIN) & ~np.isnan(stated))
        numbers = (
            f"{count}|{100 * met:.0f} %|{100 * np.sqrt(np.mean(error**2)):.2f}|{100 * np.nanmedian(stated):.2f}",
            f"{np.median(cells):.0f}|{np.mean(grids):.1f}|{np.mean(seconds):.2f}",
            f"{np.median(fixed):.0f}|{np.nanmean(of_fixed):.2f}|{np.mean(of_finest):.2f}",
        )
        lines.append([name, *"|".join(numbers).split("|")])
        print("| " + " | ".join(lines[-1]) + " |", file=sys.stderr, flush=True)
    return lines


TIMES = "CPU, s", "its CPU, s", f"CPU at {FINEST}, s"
# The columns of the page.
SHOWN = ("contact", "rms error, %", "stated, %", "N", "CPU, s", "smallest fixed N", "CPU at 1024, s")
LINES = (
    "the paper's wave, 50 to 200 MPa",
    "rough, 1 % in contact",
    "rough, 20 % in contact",
    "a rough pair with a hardness",
)
TABLES = {"accuracy": DocTable(make_rows, seconds=900, timed=TIMES, units=2, shown=pick(SHOWN, LINES))}

if __name__ == "__main__":
    if len(sys.argv) > 1:
        make_rows(int(sys.argv[1]))
    else:
        write_tables(TABLES)
