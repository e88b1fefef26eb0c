"""The algorithm of the paper as it is printed, timed and judged against the certified solution of the default solver.

python docs/studies/paper_method.py

Writes the tables of plugins/roughcontact-paper/README.md. Needs plugins/roughcontact-paper. CPU times with one thread
(OMP_NUM_THREADS=1).
"""

from __future__ import annotations

import time

import numpy as np
from doc_tables import DocTable, pick, write_tables

import roughcontact as rc
from roughcontact_paper.printed_solver import PrintedPolonskyKeer
from roughcontact_paper.wave import wave_problem

CELLS = 128
# A steel ball of 5 mm at 10 N, with Hertz's contact radius and maximum pressure.
YOUNG, RADIUS, FORCE = 210e9, 5e-3, 10.0
MODULUS = YOUNG / (1 - 0.3**2)
CONTACT_RADIUS = (3 * FORCE * RADIUS / (4 * MODULUS)) ** (1 / 3)
PEAK = 1.5 * FORCE / (np.pi * CONTACT_RADIUS**2)
METHODS = {
    "as printed": PrintedPolonskyKeer(change=1e-6),
    "saturated cells released": PrintedPolonskyKeer(change=1e-6, release_saturated=True),
}


def solve_timed(problem: rc.ContactProblem, **load: float) -> tuple[rc.ContactSolution, float]:
    """Return the solution and the CPU time of one solve with a kernel at hand, s."""
    _ = problem.convolution
    started = time.process_time()
    solution = problem.solve(**load, throw=False)
    return solution, time.process_time() - started


def with_solver(problem: rc.ContactProblem, solver: rc.Solver) -> rc.ContactProblem:
    grid, boundary = problem.plan.grid, problem.plan.boundary
    return rc.ContactProblem(problem.body, problem.counterbody, grid=grid, boundary=boundary, solver=solver)


def make_elastic_rows(cells: int = 512) -> list[list[str]]:
    """Return iterations, time and errors by the change at which it stops, on the paper's wave at 100 MPa."""
    problem = wave_problem(cells)
    exact = with_solver(problem, rc.ProjectedConjugateGradient(1e-10)).solve(pressure=100e6)
    heading = ["stops at", "iterations", "CPU, s", "complementarity", "penetration", "maximum pressure", "counted area"]
    lines = [heading]
    runs = {f"change {change:.0e}": PrintedPolonskyKeer(change=change) for change in (1e-2, 1e-3, 1e-4, 1e-6, 1e-8)}
    runs |= {"polonsky-keer, 1e-8": rc.PolonskyKeer(1e-8), "default, 1e-8": rc.ProjectedConjugateGradient(1e-8)}
    for name, solver in runs.items():
        found, cpu = solve_timed(with_solver(problem, solver), pressure=100e6)
        peak = found.pressure.max() / exact.pressure.max() - 1
        count = np.count_nonzero(found.contact) / np.count_nonzero(exact.contact) - 1
        errors = [f"{found.residuals.complementarity:.0e}", f"{found.residuals.penetration:.0e}", f"{peak:+.0e}"]
        lines.append([name, f"{found.iterations}", f"{cpu:.2f}", *errors, f"{100 * count:+.2f} %"])
    return lines


def make_ball(limit: float) -> rc.ContactProblem:
    """Return the ball of a hardness in units of Hertz's maximum pressure, its summit between four cells."""
    steel = rc.ElasticPerfectlyPlastic(YOUNG, 0.3, limit * PEAK)
    size = 3 * max(CONTACT_RADIUS, (FORCE / (np.pi * steel.hardness)) ** 0.5)
    center = (0.3 * size / CELLS, -0.2 * size / CELLS)
    return rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(RADIUS, center=center), steel), grid=rc.Grid((CELLS,) * 2, size)
    )


def make_rough(limit: float) -> tuple[rc.ContactProblem, float]:
    """Return a rough surface of a hardness, and its mean pressure of 0.03 times E* rms slope; both in these units."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, longest=1.0, rolloff=0.25, shortest=8 / CELLS, seed=3)
    unit = 0.1 * MODULUS
    body = rc.Body(surface, rc.ElasticPerfectlyPlastic(YOUNG, 0.3, limit * unit))
    return rc.ContactProblem(body, grid=rc.Grid((CELLS,) * 2, 1.0), boundary="periodic"), 0.03 * unit


def make_capped_rows() -> list[list[str]]:
    """Return iterations, time, and errors of load, area and pressure, by hardness and method."""
    heading = ["scene", "H", "method", "iterations", "CPU, s", "default: CPU, s", "load", "counted area", "pressure"]
    lines = [heading]
    cases = [("ball", limit, make_ball(limit), {"force": FORCE}) for limit in (0.95, 0.8, 0.6, 0.4, 0.2)]
    for limit in (0.3, 0.1, 0.05):
        problem, mean = make_rough(limit)
        cases.append(("rough", limit, problem, {"pressure": mean}))
    for scene, limit, problem, load in cases:
        exact, default = solve_timed(problem, **load)
        assert exact.status.success
        for name, solver in METHODS.items():
            found, cpu = solve_timed(with_solver(problem, solver), **load)
            ended = found.iterations == solver.max_iterations
            count = np.count_nonzero(found.contact) / np.count_nonzero(exact.contact) - 1
            pressure = np.abs(found.pressure - exact.pressure).sum() / exact.pressure.sum()
            lines.append(
                [
                    *(scene, f"{limit:g}", name, f"{found.iterations}" + ", given up" * ended),
                    *(f"{cpu:.2f}", f"{default:.2f}", f"{100 * (found.force / exact.force - 1):+.2f} %"),
                    *(f"{100 * count:+.1f} %", f"{100 * pressure:.3f} %"),
                ]
            )
    return lines


# The columns and lines of the page.
ELASTIC = ("stops at", "iterations", "complementarity", "penetration", "maximum pressure", "counted area")
STOPS = ("change 1e-02", "change 1e-04", "change 1e-08", "default, 1e-8")
CAPPED = ("scene", "H", "method", "iterations", "load", "counted area")
SCENES = ("ball; 0.95", "ball; 0.6", "ball; 0.2", "rough; 0.3", "rough; 0.05")

# Paths of many iterations differ by rounding.
TABLES = {
    "printed-elastic": DocTable(
        make_elastic_rows, seconds=9, timed=("iterations", "CPU, s"), units=5, shown=pick(ELASTIC, STOPS)
    ),
    "printed-capped": DocTable(
        make_capped_rows,
        seconds=60,
        timed=("iterations", "CPU, s", "default: CPU, s"),
        units=5,
        shown=pick(CAPPED, SCENES),
    ),
}

if __name__ == "__main__":
    write_tables(TABLES)
