"""The figure and the tables of docs/use/adhesion.md: balls, ranges that cells do not resolve, cost, and a rough cycle.

python docs/studies/adhesion.py
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from doc_tables import DocTable, pick, some_of, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import adhesion_classes

import roughcontact as rc
from roughcontact.errors import InputError, NotConverged
from roughcontact.plotting import style
from roughcontact.reference import JKR, MaugisDugdale

SPLITS = ("tuned", "held-out")
FIGURES = Path(__file__).parent.parent / "figures"
RADIUS = 1e-6
MODULUS = 1e9
WORK = 0.05
UNIT = math.pi * WORK * RADIUS
LIMIT = JKR(RADIUS, MODULUS, WORK)
MATERIAL = rc.Elastic(young=0.75 * MODULUS, poisson=0.5)
ELASTOMER = rc.Elastic(young=2e6, poisson=0.5)
# Cells along a side of its domain, of which the cohesive length has 1.7, 2.6 and 3.5, and the law.
ELASTOMER_CELLS = (256, 384, 512)
ELASTOMER_LAW = rc.Exponential(WORK, 0.113e-6)
# Maugis' parameter, smoothing, side of the domain over the contact radius of Johnson at zero load, and cells.
BALLS = (
    (0.1, 0.2, 6.0, 64),
    (0.25, 0.2, 5.0, 64),
    (0.5, 0.2, 4.3, 64),
    (1.0, 0.3, 3.8, 96),
    (2.0, 0.5, 3.4, 128),
    (3.0, 0.7, 3.3, 200),
    (5.0, 1.0, 3.1, 320),
)


def make_ball(
    law: rc.Interaction, side: float, cells: int, place: tuple[float, float] = (0.0, 0.0)
) -> rc.ContactProblem:
    """Return a ball on a free domain of a side, in contact radii of Johnson at zero load, its place in cells."""
    grid = rc.Grid((cells, cells), side * LIMIT.radius_at_zero_load)
    x, y = (grid.spacing[0] * part for part in place)
    body = rc.Body(rc.ParaboloidSurface(RADIUS, center=(x, y)), MATERIAL)
    return rc.ContactProblem(body, grid=grid, adhesion=law)


def count_cells(problem: rc.ContactProblem) -> float:
    """Return the number of cells of the cohesive length."""
    law = problem.adhesion
    assert law is not None
    plan = problem.plan
    return law.resolve(plan.grid.spacing, plan.modulus).cohesive_cells(plan.grid.spacing, plan.modulus)


def make_theory(transition: float) -> MaugisDugdale:
    """Return the theory of Maugis for his parameter."""
    strength = 0.5 * transition * math.cbrt(math.pi * WORK * (4.0 / 3.0 * MODULUS) ** 2 / RADIUS)
    return MaugisDugdale(RADIUS, MODULUS, WORK, strength)


def make_stiffness_rows() -> list[list[str]]:
    rows = [["λ", "cells", "n_c", "error, %", "stated, %", "within two, %"]]
    random = np.random.default_rng(1)
    for transition, smoothing, side, _ in some_of(BALLS[1:5], 0, 1):
        theory = make_theory(transition)
        for cells in (32, 48, 64, 96):
            problem = make_ball(rc.Dugdale(WORK, theory.strength, smoothing), 1.25 * side, cells)
            found = []
            for load in (-1.0, 0.0, 2.0):
                exact = _find_stiffness(theory, load * UNIT)
                for place in random.uniform(-0.5, 0.5, (8, 2)):
                    moved = make_ball(problem.adhesion, 1.25 * side, cells, tuple(place))
                    stiffness = moved.solve(force=load * UNIT).stiffness()
                    found.append((stiffness.value / exact - 1.0, stiffness.uncertainty / exact))
            errors, stated = np.array(found).T
            rows.append(
                [
                    f"{transition:g}",
                    f"{cells} x {cells}",
                    f"{count_cells(problem):.1f}",
                    f"{100.0 * math.sqrt(np.mean(errors**2)):.1f}",
                    f"{100.0 * math.sqrt(np.mean(stated**2)):.1f}",
                    f"{100.0 * np.mean(np.abs(errors) < 2.0 * stated):.0f}",
                ]
            )
    return rows


def _find_stiffness(theory: MaugisDugdale, force: float) -> float:
    """Return dF/d(approach) of a ball, N/m, by differences over the contact radius."""
    radii = theory.contact_radius(force) * np.array([1.0 - 1e-4, 1.0 + 1e-4])
    forces, approaches = (
        np.diff([function(radius) for radius in radii]) for function in (theory.force, theory.approach)
    )
    return float((forces / approaches)[0])


def make_ball_rows() -> list[list[str]]:
    rows = [["λ", "cells", "n_c", "Maugis", "pull-off", "stated, %", "difference, %"]]
    for transition, smoothing, side, cells in some_of(BALLS, 0, 1, 2, 3, 4):
        theory = make_theory(transition)
        problem = make_ball(rc.Dugdale(WORK, theory.strength, smoothing), side, cells)
        found = problem.pull_off()
        rows.append(
            [
                f"{transition:g}",
                f"{cells} x {cells}",
                f"{count_cells(problem):.1f}",
                f"{theory.pull_off / UNIT:.4f}",
                f"{found.value / UNIT:.4f}",
                f"{-100.0 * found.uncertainty / found.value:.2f}",
                f"{100.0 * (found.value / theory.pull_off - 1.0):+.2f}",
            ]
        )
    return rows


def make_range_rows() -> list[list[str]]:
    length = math.cbrt(RADIUS * WORK**2 / MODULUS**2)
    law = rc.Exponential(WORK, 0.5 * length)
    rows = [["cells", "n_c", "pull-off", "stated, %", "area, loading", "area, unloading", "what is said"]]
    for cells in (16, 32, 64, 128):
        problem = make_ball(law, 3.4, cells)
        areas = [_find_area(problem, branch) for branch in ("loading", "unloading")]
        warnings = problem.solve(force=0.0, throw=False).warnings
        said = "nothing" if not warnings else "warning"
        try:
            found = problem.pull_off()
            pull_off = [f"{found.value / UNIT:.3f}", f"{-100.0 * found.uncertainty / found.value:.1f}"]
        except InputError:
            pull_off = ["refused", ""]
            said = "warning; pull-off and cycles are refused"
        rows.append([f"{cells} x {cells}", f"{count_cells(problem):.2g}", *pull_off, *areas, said])
    return rows


def _find_area(problem: rc.ContactProblem, branch: str) -> str:
    """Return the area at zero load over that of Johnson."""
    try:
        solution = problem.solve(force=0.0, branch=branch)
    except NotConverged:
        return "not converged"
    return f"{solution.area().value / (math.pi * LIMIT.radius_at_zero_load**2):.3f}"


def make_cost_rows() -> list[list[str]]:
    rows = [
        ["cells", "mean pressure / E*", "without", "work 2", "work 16", "area without, %", "work 2, %", "work 16, %"]
    ]
    for cells in some_of((512, 1024), 0):
        for load in (0.002, 0.01):
            solutions = [_solve_rough(cells, load, work) for work in (0.0, 2.0, 16.0)]
            products = [f"{solution.convolutions}" for solution in solutions]
            areas = [f"{100.0 * solution.area().value / solution.grid.area:.1f}" for solution in solutions]
            rows.append([f"{cells} x {cells}", f"{load:g}", *products, *areas])
    return rows


def _solve_rough(cells: int, load: float, work: float) -> rc.ContactSolution:
    """Return the contact of waves of 16 cells to a quarter of the domain; a work in hundredths of E* h'^2 cell."""
    slope = 0.1
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=slope, shortest=16.0, longest=0.25 * cells, seed=1)
    energy = 0.01 * work * slope**2 * MODULUS
    law = None if work == 0.0 else rc.Exponential(energy, math.sqrt(4.0 * energy / MODULUS))
    problem = rc.ContactProblem(
        rc.Body(surface, MATERIAL), grid=rc.Grid((cells, cells), float(cells)), boundary="periodic", adhesion=law
    )
    return problem.solve(pressure=load * MODULUS)


def make_elastomer(cells: int, law: rc.Interaction, rms_height: float = 0.5e-6) -> rc.ContactProblem:
    """Return a rough elastomer on glass, 100 µm wide and periodic."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_height=rms_height, longest=50e-6, shortest=20e-6, seed=4)
    grid = rc.Grid((cells, cells), 100e-6)
    return rc.ContactProblem(rc.Body(surface, ELASTOMER), grid=grid, boundary="periodic", adhesion=law)


def run_elastomer(cells: int, law: rc.Interaction, steps: int = 41) -> rc.results.AdhesionCycle:
    """Return a cycle of it from before the first touch to nine tenths of the mean gap."""
    problem = make_elastomer(cells, law)
    gap = float(problem.initial_gap.mean())
    return problem.cycle(approach=np.linspace(-0.1 * gap, 0.9 * gap, steps))


def make_cycle_rows() -> list[list[str]]:
    rows = [["cells", "n_c", "pull-in, kPa", "pull-off, kPa", "loss, mJ/m2", "stated", "jumps"]]
    for cells in some_of(ELASTOMER_CELLS, 0):
        cycle = run_elastomer(cells, ELASTOMER_LAW)
        area = cycle.loading[0].grid.area
        loss = cycle.dissipated
        rows.append(
            [
                f"{cells} x {cells}",
                f"{count_cells(make_elastomer(cells, ELASTOMER_LAW)):.1f}",
                f"{1e-3 * cycle.pull_in.value / area:.2f}",
                f"{1e-3 * cycle.pull_off.value / area:.2f}",
                # Rounding decides whether a patch near a jump joins, and moves the loss by a part of what is stated.
                f"{1e3 * loss.value / area:.1f}",
                f"{1e3 * loss.uncertainty / area:.1f}",
                f"{len(cycle.jumps)}",
            ]
        )
    return rows


def make_class_rows() -> list[list[str]]:
    found = {split: adhesion_classes.report(list(adhesion_classes.CLASSES), split) for split in SPLITS}
    rows = [["class", *(f"{split}: {part}" for split in SPLITS for part in ("n", "error, %", "within two, %"))]]
    for name in adhesion_classes.CLASSES:
        row = [name]
        for split in SPLITS:
            judged = found[split][name]
            sizes = (f"{100 * judged[part]:.2g}" for part in ("median error", "median uncertainty"))
            row += [f"{judged['n']}", " / ".join(sizes), f"{100 * judged['within 2']:.0f}"]
        rows.append(row)
    return rows


def find_theory(strength: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return approach and force of Johnson, and of Maugis, of contact radii down to small ones."""
    theory = MaugisDugdale(RADIUS, MODULUS, WORK, strength)
    radii = np.linspace(0.1, 1.25, 200) * LIMIT.radius_at_zero_load
    johnson = np.array([(LIMIT.approach(radius), LIMIT.force(radius)) for radius in radii])
    maugis = np.array([(theory.approach(radius), theory.force(radius)) for radius in radii])
    return johnson[:, 0], johnson[:, 1], maugis[:, 0], maugis[:, 1]


@style()
def draw(folder: Path = FIGURES, cells: int = 128) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    transition = 2.0
    strength = 0.5 * transition * math.cbrt(math.pi * WORK * (4.0 / 3.0 * MODULUS) ** 2 / RADIUS)
    problem = make_ball(rc.Dugdale(WORK, strength, 0.5), 3.6, cells)
    cycle = problem.cycle(approach=np.linspace(-4.5e-9, 6e-9, 43))
    approach, force, between, maugis = find_theory(strength)
    # An approach counts from the first touch of a cell, which lies beside the summit.
    offset = problem.summit
    left.plot(1e9 * approach, force / UNIT, "k--", linewidth=1.0, label="Johnson, Kendall, Roberts")
    left.plot(1e9 * between, maugis / UNIT, "k-", linewidth=1.0, label="Maugis, λ = 2")
    left.plot(1e9 * (cycle.loading.approach - offset), cycle.loading.force / UNIT, "o", markersize=4, label="loading")
    unloading = cycle.unloading
    left.plot(1e9 * (unloading.approach - offset), unloading.force / UNIT, "s", markersize=3, label="unloading")
    left.set(xlabel="approach, nm", ylabel="force / (π w R)", xlim=(-4.7, 6.2), ylim=(-1.8, 1.6), title="A ball")
    left.legend(loc="upper left")
    rough = run_elastomer(2 * cells, ELASTOMER_LAW)
    area = rough.loading[0].grid.area
    for sweep, name, marker in ((rough.loading, "loading", "o-"), (rough.unloading, "unloading", "s-")):
        right.plot(1e6 * sweep.approach, 1e-3 * sweep.force / area, marker, markersize=3, label=name)
    right.axhline(0.0, color="0.5", linewidth=0.5)
    right.set(xlabel="approach, µm", ylabel="mean pressure, kPa", title="A rough elastomer on glass")
    right.legend()
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "adhesion.png", dpi=120)


# What the page shows.
RANGE = ("cells", "n_c", "pull-off", "stated, %", "area, loading", "area, unloading")
CLASSES = (
    *("pull-off-free", "pull-off-short-range", "pull-off-short-range-rough", "pull-off-rough"),
    *("area-free", "area-rough", "gap-rough"),
)
TABLES = {
    "adhesion-classes": DocTable(
        make_class_rows, seconds=350, shown=pick(["class", "held-out: error, %", "held-out: within two, %"], CLASSES)
    ),
    "adhesion-balls": DocTable(make_ball_rows, seconds=30, shown=pick(lines=("0.1", "0.5", "5"))),
    "adhesion-stiffness": DocTable(
        make_stiffness_rows, seconds=20, shown=pick(lines=[f"{part:g}; 64 x 64" for part in (0.25, 1.0, 2.0)])
    ),
    "adhesion-range": DocTable(make_range_rows, seconds=4, shown=pick(RANGE)),
    "adhesion-cost": DocTable(
        make_cost_rows,
        seconds=15,
        units=2,
        shown=pick(["cells", "mean pressure / E*", "without", "work 2", "work 16"], ["1024 x 1024"]),
    ),
    "adhesion-cycle": DocTable(make_cycle_rows, seconds=60, shown=pick(lines=("256 x 256", "512 x 512"))),
}

if __name__ == "__main__":
    write_tables(TABLES)
    draw()
