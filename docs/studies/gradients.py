"""The gradient of the area against differences, and heights for a wanted area over load: see docs/use/gradients.md.

python docs/studies/gradients.py
"""

from __future__ import annotations

import math
from pathlib import Path

import attrs
import numpy as np
from doc_tables import DocTable, pick, some_of, write_tables
from matplotlib.figure import Figure
from scipy.optimize import minimize

import roughcontact as rc
from roughcontact.plotting import LIGHT, add_key, style

FIGURES = Path(__file__).parent.parent / "figures"
STEEL = rc.Elastic(young=210e9, poisson=0.3)
MODULUS = 210e9 / 0.91
PRESSURES, WANTED = [25e6, 50e6, 100e6, 200e6], np.array([0.04, 0.07, 0.12, 0.20])


def slope_by_difference(solution: rc.ContactSolution, step: float = 0.05) -> float:
    """Return d(area)/d(approach), m, by the difference of two solves."""
    problem = solution.origin.source
    low, high = (problem.solve(approach=solution.approach * (1 + sign * step)) for sign in (-1, 1))
    return (high.area().value - low.area().value) / (high.approach - low.approach)


def slopes_of_ball(cells: int, draws: int) -> list[tuple[float, float]]:
    """Return d(area)/d(approach) over the exact one, from area and from participation."""
    found = []
    for place in np.random.default_rng(cells).uniform(-0.5e-6, 0.5e-6, (draws, 2)):
        count = 3 * cells + 8
        ball = rc.Body(rc.ParaboloidSurface(1e-2, place), STEEL)
        solution = rc.ContactProblem(ball, grid=rc.Grid((count, count), count * 1e-6)).solve(
            approach=(cells * 1e-6) ** 2 / 1e-2
        )
        found.append(tuple(solution.gradient(of, "load") / (math.pi * 1e-2) for of in ("area", "participation")))
    return found


def slopes_of_rough(load: float, seeds: tuple[int, ...], cells: int = 128) -> list[tuple[float, float]]:
    """Return the same for rough surfaces of 8 cells a shortest wave, over differences of the area."""
    found = []
    for seed in seeds:
        surface = rc.SelfAffineSurface(
            hurst=0.8, rms_slope=0.05, shortest=8e-6, longest=cells * 1e-6, rolloff=cells / 4 * 1e-6, seed=seed
        )
        grid = rc.Grid((cells, cells), cells * 1e-6)
        problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary="periodic")
        solution = problem.solve(approach=problem.solve(pressure=load * 0.05 * MODULUS).approach)
        exact = slope_by_difference(solution)
        found.append(tuple(solution.gradient(of, "load") / exact for of in ("area", "participation")))
    return found


def make_rows(draws: int = 8, seeds: tuple[int, ...] = (1, 2, 3)) -> list[list[str]]:
    rows = [["contact", "area, %", "participation, %"]]
    cases = {f"ball, radius of {cells} cells": slopes_of_ball(cells, draws) for cells in some_of((3, 6, 12), 0, 1)}
    cases |= {
        f"rough, p / (E* slope) = {load:g}": slopes_of_rough(load, seeds) for load in some_of((0.01, 0.05, 0.2), 1)
    }
    for name, found in cases.items():
        errors = 100 * (np.array(found) - 1)
        rows.append(
            [name, *(f"{low:+.1f} to {high:+.1f}" for low, high in zip(errors.min(0), errors.max(0), strict=True))]
        )
    return rows


@attrs.frozen(eq=False)
class Design:
    """A rough surface that is changed by smooth heights until its area follows a wanted law.

    Attributes
    ----------
    cells
        Cells along a side.
    """

    cells: int

    def smooth(self, field: np.ndarray) -> np.ndarray:
        """Return a field without its waves of fewer than about ten cells."""
        waves = np.hypot(np.fft.fftfreq(self.cells)[:, None], np.fft.rfftfreq(self.cells))
        return np.fft.irfft2(np.exp(-((10 * waves) ** 2)) * np.fft.rfft2(field), s=field.shape)

    def heights(self, change: np.ndarray) -> np.ndarray:
        """Return the heights after a change, m."""
        size = self.cells * 1e-6
        rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.02, shortest=8e-6, longest=size, seed=1)
        start = rough.heights(rc.Grid((self.cells, self.cells), size))
        return start + 1e-7 * self.smooth(change.reshape(start.shape))

    def solve(self, change: np.ndarray) -> tuple[rc.ContactSolution, ...]:
        """Return the contacts at all loads."""
        surface = rc.HeightMap(self.heights(change), size=self.cells * 1e-6, periodic=True)
        return rc.ContactProblem(rc.Body(surface, STEEL), boundary="periodic").sweep(pressure=PRESSURES).states

    def objective(self, change: np.ndarray, target: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the sum of the squared relative errors of the participation, and its gradient."""
        value, gradient = 0.0, np.zeros((self.cells, self.cells))
        for solution, goal in zip(self.solve(change), target, strict=True):
            ratio = participation(solution) / goal
            value += (ratio - 1) ** 2
            gradient += 2 * (ratio - 1) / (goal * solution.grid.area) * solution.gradient("participation")
        return value, 1e-7 * self.smooth(gradient).ravel()

    def run(self, rounds: int, steps: int) -> np.ndarray:
        """Return the change that gives the wanted areas: descents, and targets renewed by the areas in between."""
        change, target = np.zeros(self.cells**2), WANTED
        for _ in range(rounds):
            options = {"maxiter": steps}
            change = minimize(self.objective, change, target, jac=True, method="L-BFGS-B", options=options).x
            solutions = self.solve(change)
            target = WANTED * [participation(one) / one.area().fraction for one in solutions]
        return change


def participation(solution: rc.ContactSolution) -> float:
    """Return 9/8 (sum p)^2 / sum p^2 over the nominal area."""
    return float(9 / 8 * np.mean(solution.pressure) ** 2 / np.mean(solution.pressure**2))


@style()
def main(cells: int = 64, rounds: int = 12, steps: int = 5, folder: Path = FIGURES) -> None:
    design = Design(cells)
    before, change = np.zeros(cells**2), design.run(rounds, steps)
    figure = Figure(figsize=(13, 4), layout="constrained")
    slopes, laws, after = figure.subplots(1, 3)
    half = cells / 2
    extent = (-half, half, -half, half)
    solution = design.solve(before)[-1]
    gradient = solution.gradient("participation") / solution.grid.cell_area * 1e-6
    largest = np.percentile(np.abs(gradient), 99.5)
    image = slopes.imshow(gradient.T, origin="lower", extent=extent, cmap="RdBu_r", vmin=-largest, vmax=largest)
    figure.colorbar(image, ax=slopes, label="d(participation)/d(height), 1/µm")
    slopes.set(title=f"gradient at {PRESSURES[-1] / 1e6:g} MPa", xlabel="x, µm", ylabel="y, µm")
    laws.loglog(np.array(PRESSURES) / 1e6, 100 * WANTED, "-", color=LIGHT.ink, label="wanted")
    for name, heights, mark in (("before", before, "s"), ("after", change, "o")):
        areas = [one.area() for one in design.solve(heights)]
        fractions, errors = (
            100 * np.array(v)
            for v in zip(*((a.fraction, a.uncertainty / solution.grid.area) for a in areas), strict=True)
        )
        print(name, np.round(fractions, 2), np.round(errors, 2))
        laws.errorbar(np.array(PRESSURES) / 1e6, fractions, errors, fmt=mark, label=name)
    laws.set(xlabel="mean pressure, MPa", ylabel="area, % of nominal")
    laws.set_xticks(np.array(PRESSURES) / 1e6, [f"{pressure / 1e6:g}" for pressure in PRESSURES])
    laws.set_xticks([], minor=True)
    add_key(laws)
    laws.grid(True)
    image = after.imshow(1e6 * design.heights(change).T, origin="lower", extent=extent, cmap="cividis")
    figure.colorbar(image, ax=after, label="height, µm")
    after.contour(
        *solution.grid.x.T * 1e6,
        solution.grid.y[0] * 1e6,
        design.solve(change)[-1].contact.T,
        [0.5],
        colors="w",
        linewidths=0.8,
    )
    after.set(title="heights after, and the contact", xlabel="x, µm")
    figure.savefig(folder / "gradients.png", dpi=110)


LINES = (
    "ball, radius of 3 cells",
    "ball, radius of 12 cells",
    "rough, p / (E* slope) = 0.01",
    "rough, p / (E* slope) = 0.2",
)
TABLES = {"area-gradient": DocTable(make_rows, seconds=12, units=2, shown=pick(lines=LINES))}

if __name__ == "__main__":
    write_tables(TABLES)
    main()
