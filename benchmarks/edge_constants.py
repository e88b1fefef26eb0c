"""Constants of the traced edge, measured on contacts with closed forms.

    python benchmarks/edge_constants.py [--write] [number of contacts of each kind]

Prints each constant of `roughcontact._answers.areas.calibration` beside what is measured again, and writes the table of
straight edges; two minutes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import attrs
import numpy as np

import roughcontact as rc
from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.contour import Contour, trace_contour

RADIUS = 1e4  # of all spheres, in cells; their modulus is one
SHIFT = rc.Love.edge_shift
STEP = 0.025  # between the places of straight edges, cells
STEEL = rc.Elastic(young=1e11, poisson=0.0)


def trace(solution: rc.ContactSolution) -> Contour:
    """Return the edge between neighbouring cells, none of it sharp."""
    return trace_contour(solution, np.zeros(solution.grid.shape, dtype=bool))


def press_sphere(radius: float, rng: np.random.Generator, cells: int = 0) -> rc.ContactSolution:
    """Return a contact of so many cells radius, its centre anywhere in a cell."""
    cells = cells or 2 * int(1.3 * radius + 6)
    sphere = rc.ParaboloidSurface(RADIUS, center=tuple(rng.random(2) - 0.5))
    problem = rc.ContactProblem(rc.Body(sphere, rc.Elastic(1.0, 0.0)), grid=rc.Grid((cells, cells), float(cells)))
    return problem.solve(force=4 * radius**3 / (3 * RADIUS))


def measure_spheres(rng: np.random.Generator, count: int) -> dict[str, float]:
    """Fit true area - polygons = shift * length + c * Euler number; the chords are 0.5 of c."""
    rows = []
    for radius in rng.uniform(3.0, 25.0, size=count):
        edge = trace(press_sphere(radius, rng))
        rows.append((np.pi * radius**2 - edge.area.sum(), edge.length.sum(), edge.euler.sum()))
    missing, length, euler = np.array(rows).T
    weight = 1.0 / np.sqrt(length)
    terms = np.stack((length, euler), axis=1)
    fit = np.linalg.lstsq(terms * weight[:, np.newaxis], missing * weight, rcond=None)[0]
    residual = missing - terms @ fit
    wander = np.sqrt(np.mean(residual**2 / (4.0 / np.pi * length)))
    return {"edge shift on spheres": fit[0], "PIECE_AREA_DEFICIT": fit[1] - 0.5, "EDGE_AREA_STD": wander}


def measure_border(rng: np.random.Generator, count: int) -> dict[str, float]:
    """Return the rms error of contacts that a free border cuts, against finer grids, over the rms of the cells cut."""
    errors, low, high = [], (0.35, -0.2, 5.5), (0.5, 0.2, 6.8)
    for x, y, power in rng.uniform(low, high, size=(count // 4, 3)):
        body = rc.Body(rc.ParaboloidSurface(1.0, center=(x, y)), rc.Elastic(1e9, 0.3))
        coarse, fine = (rc.ContactProblem(body, grid=rc.Grid((n, n), 1.0)).solve(force=10**power) for n in (64, 256))
        cells = coarse.contact
        cut = sum(np.count_nonzero(edge) for edge in (cells[0], cells[-1], cells[:, 0], cells[:, -1]))
        if cut:
            error = (coarse.area("level-set").fraction - fine.area("level-set").fraction) * cells.size
            errors.append((error, cut))
    rms, cut = np.sqrt(np.mean(np.square(errors), axis=0))
    return {"CUT_BORDER_STD (rms)": rms / cut}


def measure_straight_edges(half_width: int = 1600) -> np.ndarray:
    """Return places of straight edges and those traced, shape (n, 2), of half widths that differ by parts of a cell."""
    rows = []
    for part in np.arange(0.0, 1.0, STEP):
        half = half_width + part
        grid = rc.Grid((2 * int(1.1 * half) + 1, 1), (2.0 * int(1.1 * half) + 1.0, 1.0))
        body = rc.Body(rc.ParaboloidSurface((RADIUS, np.inf)), rc.Elastic(1.0, 0.0))
        problem = rc.ContactProblem(
            body, grid=grid, boundary=("free", "periodic"), solver=rc.ProjectedConjugateGradient(tolerance=1e-12)
        )
        solution = problem.solve(force=np.pi * half**2 / (4.0 * RADIUS), throw=False)
        # Only the edge of the kernel `love` is corrected.
        solution = attrs.evolve(solution, edge_shift=0.0)
        last = (np.count_nonzero(solution.contact) - 1) // 2
        rows.append((half - last, trace(solution).area.sum() / 2.0 - last))
    return np.array(sorted(rows))


def measure(count: int = 200) -> dict[str, float]:
    """Return what is measured on so many contacts of each kind."""
    rng = np.random.default_rng(1)
    found: dict[str, float] = {}
    for step in (measure_spheres, measure_border):
        found |= step(rng, count)
    return found


if __name__ == "__main__":
    arguments = sys.argv[1:]
    for name, value in measure(*(int(word) for word in arguments if word != "--write")).items():
        in_use = getattr(calibration, name.split()[0], None)
        print(f"{name:24} {value:8.4f}" + (f"   in use: {in_use:g}" if in_use else ""))
    table = measure_straight_edges()
    error = np.interp(table[:, 0], *calibration.STRAIGHT_EDGE_PLACES) - table[:, 1]
    print(f"STRAIGHT_EDGE_PLACES      differ by up to {np.abs(error).max():.4f} cells")
    if "--write" in arguments:
        # An edge at a centre is traced there, and that of the next cell behind the last place.
        table[0, 1] = 0.0
        table = np.append(table, [[table[-1, 0] + STEP, 1.0]], axis=0)
        file = Path(calibration.__file__).with_name("straight_edges.csv")
        header = f"place, traced place; cells from the last centre in contact; by benchmarks/{Path(__file__).name}"
        np.savetxt(file, table, ("%.3f", "%.4f"), ", ", header=header)
