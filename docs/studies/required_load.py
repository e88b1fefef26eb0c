"""The table of docs/use/choose.md: the load of a wanted answer, its uncertainty and its cost.

python docs/studies/required_load.py
"""

from __future__ import annotations

import math

import numpy as np
from doc_tables import DocTable, pick, write_tables

import roughcontact as rc
from roughcontact.reference import hertz_sphere

STEEL = rc.Elastic(young=210e9, poisson=0.3)
RADIUS = 1e-3
BALLS = 60
SEEDS = range(8)
PRESSURES = (2e8, 2e9)
FLOW = {"viscosity": 1e-3, "pressure_drop": 1e5}
ANSWERS = {
    "area": ("area", {}),
    "stiffness": ("stiffness", {}),
    "mean gap": ("mean_gap", {}),
    "conductance": ("conductance", {"conductivity": 45.0}),
    "leakage": ("leakage", FLOW),
}


def solve_balls(name: str) -> list[tuple[rc.results.RequiredLoad, float, int]]:
    """Return the loads of balls beside the centre of a cell, the forces by Hertz, and the convolutions of one solve."""
    rng = np.random.default_rng(3)
    found = []
    for _ in range(BALLS):
        grid = rc.Grid((64, 64), 128e-6)
        x, y = rng.uniform(-1e-6, 1e-6, 2)
        heights = -((grid.x - x) ** 2 + (grid.y - y) ** 2) / (2.0 * RADIUS)
        problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, grid.size), STEEL), threads=1)
        force = math.exp(rng.uniform(math.log(0.2), math.log(10.0)))
        hertz = hertz_sphere(force=force, radius=RADIUS, modulus=problem.plan.modulus)
        wanted = {
            "area": hertz.area,
            "peak_pressure": 1.5 * force / hertz.area,
            "stiffness": 2.0 * problem.plan.modulus * math.sqrt(hertz.area / math.pi),
        }
        found.append((problem.solve_for(**{name: wanted[name]}), force, problem.solve(force=force).convolutions))
    return found


def solve_rough(name: str, fields: dict[str, float]) -> list[tuple[rc.results.RequiredLoad, float, int]]:
    """Return the loads on 128 x 128 cells of answers on 512 x 512, those forces, and the convolutions of one solve."""
    found = []
    for seed in SEEDS:
        surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=64e-6, rolloff=16e-6, seed=seed)
        coarse, fine = (
            rc.ContactProblem(
                rc.Body(surface, STEEL), grid=rc.Grid((cells, cells), 64e-6), boundary="periodic", threads=1
            )
            for cells in (128, 512)
        )
        for pressure in PRESSURES:
            truth = fine.solve(pressure=pressure)
            response = rc.responses.create(name.replace("_", "-"), **fields) if name != "area" else "blend"
            wanted = truth.area(response) if name == "area" else truth.response(response)
            load = coarse.solve_for(**{name: wanted.value}, **fields)
            found.append((load, truth.force, coarse.solve(pressure=pressure).convolutions))
    return found


def make_rows() -> list[list[str]]:
    rows = [["contact", "answer", "solves", "cost, solves", "uncertainty, %", "held by two"]]
    cases = [("ball", name, solve_balls(name)) for name in ("area", "peak_pressure", "stiffness")]
    cases += [("rough", name, solve_rough(*ANSWERS[name])) for name in ANSWERS]
    for contact, name, loads in cases:
        held = [abs(one.force.value - force) <= 2.0 * one.force.uncertainty for one, force, _ in loads]
        solves = float(np.mean([one.solves for one, _, _ in loads]))
        cost = float(np.mean([one.convolutions / alone for one, _, alone in loads]))
        spread = float(np.median([one.force.uncertainty / one.force.value for one, _, _ in loads]))
        cells = [f"{solves:.1f}", f"{cost:.1f}", f"{100.0 * spread:.2g}", f"{sum(held)} of {len(held)}"]
        rows.append([contact, name.replace("_", " "), *cells])
    return rows


# The lines of the page.
LINES = ("ball; area", "ball; stiffness", "rough; area", "rough; stiffness", "rough; leakage")
TABLES = {"required-load": DocTable(make_rows, seconds=150, shown=pick(lines=LINES))}

if __name__ == "__main__":
    write_tables(TABLES)
