"""Contact conductance beside closed forms, and its figure: see docs/use/stiffness.md.

python docs/studies/conductance.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from doc_tables import DocTable, some_of, write_tables
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from stiffness import MODULUS, STEEL, hertz, rough

import roughcontact as rc
from roughcontact.plotting import LIGHT, add_key, draw_map, style

FIGURES = Path(__file__).parent.parent / "figures"
RADIUS = 1000.0


def press_spot(cells: float, place: tuple[float, float], ratio: float, film: float) -> float:
    """Return the relative error of the conductance of Hertz's spot, or how far it is outside the bounds of a film."""
    radii, n = (RADIUS, RADIUS * ratio), 2 * math.ceil(1.25 * cells * ratio**0.4 + 6)
    body = rc.Body(rc.ParaboloidSurface(radii, place), STEEL)
    force = 4 / 3 * MODULUS * cells**3 / (RADIUS * math.sqrt(ratio))
    found = rc.ContactProblem(body, grid=rc.Grid((n, n), float(n))).solve(force=force).conductance(2.0, film)
    exact = hertz(radii, force) * 2 / MODULUS
    if film == 0.0:
        return found.value / exact - 1
    area = math.pi * cells**2
    low, high = 1 / exact + film / area, 16 / (3 * math.pi**2 * cells * 2) + film / area
    return max(low * found.value - 1, 1 - high * found.value, 0.0)


def press_discs(cells: float, rng: np.random.Generator) -> float:
    """Return the relative error of the conductance of five discs, by the matrix of point currents."""
    n = 12 * round(cells)
    spots = n * np.array([(0.25, 0.25), (0.25, 0.75), (0.75, 0.25), (0.75, 0.75), (0.5, 0.5)])
    spots += rng.uniform(-0.5, 0.5, spots.shape)
    x, y = np.mgrid[:n, :n] + 0.5
    inside = [np.hypot(x - cx, y - cy) < cells for cx, cy in spots]
    heights = np.where(np.any(inside, axis=0), 1.0, 0.0)
    solution = rc.ContactProblem(rc.Body(rc.HeightMap(heights, (n, n)), STEEL)).solve(force=1e-3 * MODULUS)
    radii = np.sqrt([part.sum() / math.pi for part in inside])
    distance = np.hypot(*(spots[:, None] - spots[None]).transpose(2, 0, 1))
    np.fill_diagonal(distance, 2 * radii / math.pi)
    exact = 2 * np.linalg.solve(1 / (math.pi * distance), np.ones(len(spots))).sum()
    return solution.conductance(2.0).value / float(exact) - 1


def press_wave(cells: float, rng: np.random.Generator) -> float:
    """Return the relative error of the conductance of strips of a half width in cells, half of the area in contact."""
    n = round(4 * cells)
    grid, shift = rc.Grid((n, 8), (float(n), 8.0)), rng.uniform(-0.5, 0.5)
    heights = 1e-3 * n * np.cos(2 * np.pi * (grid.x - shift) / n) + 0 * grid.y
    body = rc.Body(rc.HeightMap(heights, grid.size, periodic=True), STEEL)
    problem = rc.ContactProblem(body, grid=grid, boundary="periodic")
    solution = problem.solve(pressure=0.5 * math.pi * 1e-3 * MODULUS)
    exact = 2 * grid.area * math.pi / (2 * n * math.log(math.sqrt(2.0)))
    return solution.conductance(2.0).value / exact - 1


def make_rows(radii: tuple[int, ...] = (3, 6, 12), draws: int = 6) -> list[list[str]]:
    kinds = ("disc of a ball", "ellipse, radii 1 : 4", "five discs", "strips of a wave", "outside the bounds of a film")
    rows = [["radius, cells", *kinds]]
    for cells in some_of(radii, 0, 1):
        rng, errors = np.random.default_rng(40 + cells), []
        for _ in range(draws):
            places = [tuple(rng.uniform(-0.5, 0.5, 2)) for _ in kinds]
            errors.append(
                [
                    press_spot(cells, places[0], 1.0, 0.0),
                    press_spot(cells, places[1], 4.0, 0.0),
                    press_discs(cells, rng),
                    press_wave(cells, rng),
                    press_spot(cells, places[2], 1.0, 0.5 * cells),
                ]
            )
        rms = 100 * np.sqrt(np.mean(np.square(errors), axis=0))
        rows.append([str(cells), *(f"{value:.2f}" for value in rms)])
    return rows


def draw_currents(axes: Axes, cells: int) -> None:
    """Draw what flows through each patch."""
    solution = rough(cells, 0.8, 3).solve(pressure=0.05 * 0.1 * MODULUS)
    flows = solution.conductance(50.0).patches
    field = np.full((cells, cells), np.nan)
    field[solution.contact] = 1e3 * flows[solution.patches.labels[solution.contact] - 1]
    axes.set_facecolor(LIGHT.open)
    ends = float(np.nanmin(field)), float(np.nanmax(field))
    draw_map(axes, field, solution.grid, "conductance of each patch", "mW/K", limits=ends, logarithmic=True)


def draw_loads(axes: Axes, cells: int, loads: int) -> None:
    """Draw the conductance per area over the pressure without and with a film."""
    problem = rough(cells, 0.8, 4, wide=True)
    pressures = np.geomspace(3e-3, 0.5, loads) * 0.1 * MODULUS
    solutions = problem.sweep(pressure=pressures.tolist()).states
    for film, color in zip((0.0, 1e-8, 1e-7), LIGHT.lines, strict=False):
        found = [solution.conductance(50.0, film).per_area for solution in solutions]
        label = f"film of {1e6 * film:g} mm² K/W" if film else "no film"
        axes.plot(1e-6 * pressures, 1e-6 * np.array(found), "o-", color=color, ms=4, label=label)
    axes.set(xscale="log", yscale="log", xlabel="pressure, MPa", ylabel="conductance, W/(mm² K)")
    add_key(axes)


def draw_bounds(axes: Axes, points: int) -> None:
    """Draw the resistance of a disc with a film beside its bounds."""
    films, a = np.geomspace(0.1, 1e3, points), 10.0
    body = rc.Body(rc.SphereSurface(RADIUS), STEEL)
    solution = rc.ContactProblem(body, grid=rc.Grid((40, 40), 40.0)).solve(force=4 / 3 * MODULUS * a**3 / RADIUS)
    series = 1 / (4 * a) + films / (math.pi * a**2)
    found = np.array([1 / solution.conductance(2.0, film).value for film in films])
    upper = 8 / (3 * math.pi**2 * a) + films / (math.pi * a**2)
    axes.plot(films / a, 100 * (upper / series - 1), "--", color="0.5", label="uniform current")
    axes.plot(films / a, 100 * (found / series - 1), "o-", color=LIGHT.lines[0], ms=4, label="solved")
    axes.axhline(0, color="0.5", lw=1, label="in series")
    axes.set(xscale="log", xlabel="film resistance times k / a", ylabel="one disc: excess over series, %")
    add_key(axes)


@style()
def main(cells: int = 256, loads: int = 8, points: int = 12, folder: Path = FIGURES) -> None:
    figure = Figure(figsize=(13, 4), layout="constrained")
    currents, law, bounds = figure.subplots(1, 3)
    draw_currents(currents, cells)
    draw_loads(law, cells, loads)
    draw_bounds(bounds, points)
    figure.savefig(folder / "conductance.png", dpi=110)


TABLES = {"conductance": DocTable(make_rows, seconds=11, units=3)}

if __name__ == "__main__":
    write_tables(TABLES)
    main()
