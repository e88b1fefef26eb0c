"""The tables and the figure of docs/trust/challenge.md: the Contact-Mechanics Challenge, without adhesion and with.

The surface of the challenge was one realisation of a spectrum. Its file (an array of HDF5) is read where it is given;
without one, surfaces of the same spectrum are made.

    python docs/studies/challenge.py                      # the tables and the figure: half an hour, 9 GiB
    python docs/studies/challenge.py surface.4096.h5      # the surface of a file, heights in micrometres, printed only
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from doc_tables import DocTable, format_rows, pick, write_tables

import roughcontact as rc
from roughcontact.plotting import add_key, style

FIGURES = Path(__file__).parent.parent / "figures"
# Müser et al. (2017): sides, roll-off and shortest wave, m, contact modulus, Pa, pressure over E* and rms slope.
SIDE, ROLLOFF, SHORTEST = 1e-4, 2e-5, 1e-7
MODULUS = 25e6
LOAD = 0.01
# Work of adhesion, J/m2, and range, m.
WORK, RANGE = 0.05, 2.071e-9
CASES = ((2048, 1), (2048, 2), (2048, 3), (2048, 4), (4096, 1), (4096, 2), (4096, 3), (4096, 4), (8192, 1), (8192, 2))
# Sides of the domain and of its cells, over the shortest wave, on which the edges of the contact are resolved.
EDGE_SIDE, EDGE_CELLS, EDGE_SEEDS = 32, (32, 64, 128), (1, 2, 3)
# Gap over the shortest wave and pressure over E* at a distance from an edge of one shortest wave, were it still near:
# they rise as distance^(3/2) and distance^(1/2), are resolved two cells from the edge and near it up to an eighth wave.
EDGE_GAP, EDGE_PRESSURE, NEAR = 0.2, 0.35, 0.125
# Pressure over E* and rms slope there: there are few edges at that of the challenge.
EDGE_LOAD = 0.05


def make_surface(seed: int, side: float = SIDE) -> rc.SelfAffineSurface:
    return rc.SelfAffineSurface(
        hurst=0.8, rms_slope=1.0, shortest=SHORTEST, longest=side, rolloff=min(ROLLOFF, side), seed=seed
    )


def make_problem(surface: rc.Surface, grid: rc.Grid, adhesion: rc.Interaction | None = None) -> rc.ContactProblem:
    return rc.ContactProblem(
        rc.Body(surface, rc.Elastic(MODULUS, 0.0)), grid=grid, boundary="periodic", adhesion=adhesion
    )


def measure(surface: rc.Surface, grid: rc.Grid, label: str) -> list[str]:
    """Return the line of the table for one surface at the pressure of the challenge."""
    problem = make_problem(surface, grid)
    heights = surface.heights(grid)
    rms = float(heights.std())
    load = LOAD * MODULUS
    start = time.perf_counter()
    solution = problem.solve(pressure=load)
    seconds = time.perf_counter() - start
    area = solution.area()
    stiffness = solution.stiffness()
    nominal = grid.size[0] * grid.size[1]
    unit = load * nominal / rms
    theory = rc.reference.persson(heights, grid, MODULUS, load)
    return [
        f"{grid.shape[0]}",
        label,
        f"{1e6 * rms:.3f}",
        f"{100 * area.fraction:.3f} ± {100 * area.uncertainty / nominal:.3f}",
        f"{100 * float(solution.contact.mean()):.3f}",
        f"{100 * float(theory.area_fraction):.3f}",
        f"{stiffness.value / unit:.3f} ± {stiffness.uncertainty / unit:.3f}",
        f"{float(theory.stiffness) * rms / load:.3f}",
        f"{float(solution.gap.mean()) / rms:.3f}",
        f"{solution.convolutions}",
        f"{seconds:.1f}",
    ]


HEADING = [
    "N",
    "seed",
    "rms height, µm",
    "area, %",
    "cells in contact, %",
    "area after Persson, %",
    "stiffness, p / rms height",
    "stiffness after Persson",
    "mean gap / rms height",
    "products",
    "solve, s",
]


def make_rows() -> list[list[str]]:
    lines = [measure(make_surface(seed), rc.Grid((cells, cells), SIDE), f"{seed}") for cells, seed in CASES]
    return [HEADING, *lines]


def fit_exponent(values: np.ndarray, low: float, high: float) -> float:
    """Return the exponent of the probability density of values between two bounds, by the largest likelihood."""
    inside = np.log(values[(values > low) & (values < high)] / low)
    width = np.log(high / low)
    # The density is x^n on [0, width] in the logarithm: exp((n + 1) t); its mean is matched by bisection.
    mean = float(inside.mean()) / width
    below, above = -20.0, 20.0
    while above - below > 1e-9:
        slope = 0.5 * (below + above)
        expected = 0.5 if abs(slope) < 1e-6 else 1.0 / (1.0 - np.exp(-slope)) - 1.0 / slope
        below, above = (slope, above) if expected < mean else (below, slope)
    return below / width - 1.0


def resolve_edges(cells: int) -> list[str]:
    """Return the exponents of gap and pressure near the edges of contact, for so many cells on the shortest wave."""
    side = EDGE_SIDE * SHORTEST
    grid = rc.Grid((cells * EDGE_SIDE,) * 2, side)
    found = []
    for seed in EDGE_SEEDS:
        solution = make_problem(make_surface(seed, side), grid).solve(pressure=EDGE_LOAD * MODULUS)
        gap = solution.gap[~solution.contact] / SHORTEST
        pressure = solution.pressure[solution.contact] / MODULUS
        resolved = 2.0 / cells
        found.append(
            (
                fit_exponent(gap, EDGE_GAP * resolved**1.5, EDGE_GAP * NEAR**1.5),
                fit_exponent(pressure, EDGE_PRESSURE * resolved**0.5, EDGE_PRESSURE * NEAR**0.5),
            )
        )
    mean, spread = np.mean(found, axis=0), np.std(found, axis=0, ddof=1)
    return [f"{cells}", *(f"{mean[k]:.2f} ± {spread[k]:.2f}" for k in range(2))]


def make_edge_rows() -> list[list[str]]:
    heading = ["cells on the shortest wave", "exponent of the gaps", "exponent of the pressures"]
    return [heading, *(resolve_edges(cells) for cells in EDGE_CELLS)]


def attract(side: float, cells: int, law: rc.Interaction, seed: int = 1) -> list[str]:
    """Return the line of the table for one law on a domain of one side."""
    surface = make_surface(seed, side)
    grid = rc.Grid((cells,) * 2, side)
    load = LOAD * MODULUS
    without = make_problem(surface, grid).solve(pressure=load)
    problem = make_problem(surface, grid, law)
    found = problem.solve(pressure=load)
    area = found.area()
    resolved = problem.plan.interaction
    return [
        f"{1e6 * side:g}",
        f"{cells * SHORTEST / side:.1f}",
        f"{1e9 * resolved.range:.3g}",
        f"{resolved.cohesive_cells(grid.spacing, MODULUS):.1f}",
        f"{100 * without.area().fraction:.2f}",
        f"{100 * area.fraction:.2f} ± {100 * area.uncertainty / side**2:.2f}",
        f"{found.convolutions}",
    ]


def make_adhesive_rows() -> list[list[str]]:
    heading = [
        "side, µm",
        "cells on the shortest wave",
        "range, nm",
        "cells on the cohesive length",
        "area without adhesion, %",
        "area, %",
        "products",
    ]
    law = rc.Exponential(WORK, RANGE)
    short = rc.ShortRange(WORK)
    cases = ((1.6e-6, 1024, law), (1.6e-6, 2048, law), (1.6e-6, 2048, short), (SIDE, 2048, short), (SIDE, 4096, short))
    return [heading, *(attract(*case) for case in cases)]


@style()
def draw(folder: Path = FIGURES, cells: int = 2048, edge_cells: int = 128) -> None:
    """Draw area over load, and the densities of gap and pressure with the slopes that the edges of contact have."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 3.6), layout="constrained")
    area, gap, pressure = figure.subplots(1, 3)
    grid = rc.Grid((cells, cells), SIDE)
    surface = make_surface(1)
    loads = np.geomspace(0.002, 0.3, 9)
    solutions = make_problem(surface, grid).sweep(pressure=loads * MODULUS).states
    theory = rc.reference.persson(surface.heights(grid), grid, MODULUS, loads * MODULUS)
    area.loglog(loads, [100 * one.area().fraction for one in solutions], "o", markerfacecolor="none", label="solved")
    area.loglog(loads, 100 * theory.area_fraction, "-", label="Persson")
    area.set(xlabel="pressure / (E* rms slope)", ylabel="real contact area, % of nominal")
    add_key(area)
    side = EDGE_SIDE * SHORTEST
    near = make_problem(make_surface(1, side), rc.Grid((edge_cells * EDGE_SIDE,) * 2, side))
    fields = near.solve(pressure=EDGE_LOAD * MODULUS)
    shown = (
        (gap, fields.gap[~fields.contact] / SHORTEST, (1e-4, 10.0), -1 / 3, "-1/3", "gap / shortest wavelength"),
        (pressure, fields.pressure[fields.contact] / MODULUS, (0.01, 2.0), 1.0, "1", "pressure / E*"),
    )
    for axes, values, bounds, slope, name, label in shown:
        density, edges = np.histogram(values, np.geomspace(*bounds, 31), density=True)
        middle = np.sqrt(edges[1:] * edges[:-1])
        axes.loglog(middle, density, "o", markerfacecolor="none", markersize=4)
        place = len(middle) // 3
        line = middle[place - 6 : place + 4]
        axes.loglog(line, density[place] * (line / middle[place]) ** slope, "-", label=f"slope {name}")
        axes.set(xlabel=label, ylabel=f"density of the {label.split()[0]}")
        add_key(axes)
    for axes in (area, gap, pressure):
        axes.grid(True)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "challenge.png", dpi=120)


TABLES = {
    "challenge": DocTable(
        make_rows,
        seconds=900,
        timed=("solve, s",),
        shown=pick(
            [name for name in HEADING if name not in ("area after Persson, %", "cells in contact, %")],
            ["2048; 1", "4096; 1", "8192; 1", "8192; 2"],
        ),
    ),
    "challenge-edges": DocTable(make_edge_rows, seconds=150),
    "challenge-adhesion": DocTable(
        make_adhesive_rows, seconds=300, shown=pick(lines=("1.6; 64.0", "1.6; 128.0; 2.07", "100; 4.1"))
    ),
}

if __name__ == "__main__":
    if len(sys.argv) > 1:
        surface = rc.read_surface(sys.argv[1], size=SIDE, unit=1e-6)
        print(format_rows([HEADING, measure(surface, surface.own_grid, "file")]))
    else:
        draw()
        write_tables(TABLES)
