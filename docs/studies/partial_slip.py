"""Partial slip of a ball against Cattaneo and Mindlin, and of a rough surface: see docs/use/partial_slip.md.

python docs/studies/partial_slip.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from doc_tables import DocTable, pick, some_of, write_tables
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.plotting import LIGHT, add_key, style
from roughcontact.responses import PartialSlip

FIGURES = Path(__file__).parent.parent / "figures"
STEEL = rc.Elastic(young=210e9, poisson=0.3)
FLAT = rc.Body(rc.FlatSurface(), STEEL)
MODULUS = 210e9 / (2 * 0.91)
FRICTION, RADIUS, CELL = 0.3, 5e-3, 1e-6
FRACTIONS = (0.2, 0.5, 0.9)


def press_ball(cells: int, place: tuple[float, float]) -> rc.ContactSolution:
    """Return the contact of a ball of a contact radius in cells, at a place in cells from the centre."""
    radius, count = cells * CELL, 3 * cells + 8
    ball = rc.ParaboloidSurface(RADIUS, (place[0] * CELL, place[1] * CELL))
    problem = rc.ContactProblem(rc.Body(ball, STEEL), FLAT, grid=rc.Grid((count, count), count * CELL))
    return problem.solve(force=4 * MODULUS * radius**3 / (3 * RADIUS))


def slide(solution: rc.ContactSolution, fraction: float) -> PartialSlip:
    """Return the partial slip at a fraction of the force of sliding."""
    return solution.partial_slip(tangential_force=fraction * FRICTION * solution.force, friction=FRICTION)


def mindlin(cells: int, fraction: float) -> tuple[float, float, float]:
    """Return stick radius, m, displacement, m, and energy in a cycle, J: Mindlin and Deresiewicz (1953)."""
    a, stuck = cells * CELL, 1 - fraction
    compliance = 2 * (2 - 0.3) / (210e9 / 2.6)
    force = FRICTION * 4 * MODULUS * a**3 / (3 * RADIUS)
    moved = 3 * force / (16 * a) * compliance * (1 - stuck ** (2 / 3))
    energy = 1 - stuck ** (5 / 3) - 5 * fraction / 6 * (1 + stuck ** (2 / 3))
    return a * stuck ** (1 / 3), moved, 9 * force**2 / (10 * a) * compliance * energy


def make_rows(radii: tuple[int, ...] = (3, 6, 12, 24), draws: int = 8) -> list[list[str]]:
    names = ("stick radius", "displacement", "energy")
    rows = [["contact radius, cells", "Q / (µ P)", *(f"{name}, %" for name in names)]]
    for cells in some_of(radii, 0, 1, 2):
        errors = []
        for place in np.random.default_rng(cells).uniform(-0.5, 0.5, (draws, 2)):
            solution = press_ball(cells, place)
            found = [slide(solution, fraction) for fraction in FRACTIONS]
            values = [(math.sqrt(f.stick_area.value / math.pi), f.displacement.value, f.energy.value) for f in found]
            errors.append(np.divide(values, [mindlin(cells, fraction) for fraction in FRACTIONS]) - 1)
        rms = 100 * np.sqrt(np.mean(np.square(errors), axis=0))
        rows += [
            [str(cells), f"{fraction:g}", *(f"{error:.2g}" for error in row)]
            for fraction, row in zip(FRACTIONS, rms, strict=True)
        ]
    return rows


def draw_profile(axes: Axes, cells: int) -> None:
    """Draw the traction of the ball along x beside that of Cattaneo and Mindlin."""
    solution = press_ball(cells, (0.0, 0.0))
    a, p_max = cells * CELL, 1.5 * solution.force / (math.pi * (cells * CELL) ** 2)
    x, middle = solution.grid.x[:, 0] / a, solution.grid.shape[1] // 2
    fine = np.linspace(-1.2, 1.2, 1001)
    for fraction, color in zip(FRACTIONS, LIGHT.lines[:3], strict=True):
        found, c = slide(solution, fraction), (1 - fraction) ** (1 / 3)
        exact = np.sqrt(np.maximum(1 - fine**2, 0)) - c * np.sqrt(np.maximum(1 - (fine / c) ** 2, 0))
        axes.plot(fine, exact, "-", color=color, label=f"Q = {fraction:g} µP")
        axes.plot(x, found.traction[:, middle] / (FRICTION * p_max), ".", color=color)
    add_key(axes)
    axes.set(xlim=(-1.2, 1.2), ylim=(0, 1.05), xlabel="x / a", ylabel="q / µp$_0$ (points: solved; lines: exact)")


def draw_rough(axes: Axes, loops: Axes, cells: int, points: int) -> None:
    """Draw where a rough surface sticks and slips, and its loops."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=4e-6, longest=64e-6, rolloff=32e-6, seed=5)
    problem = rc.ContactProblem(rc.Body(surface, STEEL), FLAT, grid=rc.Grid((cells, cells), 64e-6), boundary="periodic")
    solution = problem.solve(pressure=0.2 * 0.05 * MODULUS)
    shares = np.full((cells, cells), np.nan)
    for fraction in (0.95, 0.5):
        found = slide(solution, fraction)
        loop = found.loop(points)
        force, moved = loop.cycle
        (line,) = loops.plot(1e9 * moved, force / (FRICTION * solution.force), label=f"Q = {fraction:g} µP")
        loops.plot(1e9 * loop.displacement, loop.force / (FRICTION * solution.force), "--", color=line.get_color())
    touching = solution.contact
    shares[touching] = found.traction[touching] / (FRICTION * solution.pressure[touching])
    image = axes.imshow(shares.T, origin="lower", extent=(-32, 32, -32, 32), cmap="cividis", vmin=0, vmax=1)
    axes.set_facecolor(LIGHT.open)
    axes.figure.colorbar(image, ax=axes, label="q / µp (1: slip)")
    axes.set(title="rough surface, Q = 0.5 µP", xlabel="x, µm", ylabel="y, µm")
    loops.plot([], [], "--", color=LIGHT.ink, label="first loading")
    add_key(loops)
    loops.set(xlabel="displacement, nm", ylabel="force / µP")
    loops.grid(True)


@style()
def main(cells: int = 256, points: int = 16, folder: Path = FIGURES) -> None:
    figure = Figure(figsize=(13, 4), layout="constrained")
    profile, places, loops = figure.subplots(1, 3)
    draw_profile(profile, max(6, cells // 12))
    draw_rough(places, loops, cells, points)
    figure.savefig(folder / "partial_slip.png", dpi=110)


SHOWN = ("contact radius, cells", "Q / (µ P)", "displacement, %", "energy, %")
TABLES = {"partial-slip": DocTable(make_rows, seconds=12, units=3, shown=pick(SHOWN, ("3", "6", "12")))}

if __name__ == "__main__":
    write_tables(TABLES)
    main()
