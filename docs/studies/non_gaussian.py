"""What skewness does to a contact at a given separation, on surfaces of one spectrum.

python docs/studies/doc_tables.py non-gaussian writes the table of docs/use/non_gaussian.md.
"""

from __future__ import annotations

import numpy as np
from doc_tables import DocTable, some_of

import roughcontact as rc

GRID = rc.Grid((128, 128), 1e-3)
STEEL = rc.Elastic(young=210e9, poisson=0.3)
RMS_HEIGHT = 1e-6  # m
SEEDS = (1, 2, 3, 4)
CASES = [(1.0, 5.0), (0.0, 3.0), (-1.0, 5.0), (-2.0, 9.0)]
SEPARATIONS = (2.0, 1.0)
HEADING = [
    "Ssk",
    "Sku",
    "Ssk found",
    "Sku found",
    "rms slope",
    *(f"pressure at H = {one:g}, MPa" for one in SEPARATIONS),
]


def measure(skewness: float, kurtosis: float, seed: int) -> list[float]:
    """Return the numbers of a row for one surface: 4 cells on the shortest wave, 4 of the longest in the domain."""
    side = GRID.size[0]
    surface = rc.NonGaussianSurface(
        hurst=0.8,
        rms_height=RMS_HEIGHT,
        shortest=side / 32,
        longest=side / 4,
        skewness=skewness,
        kurtosis=kurtosis,
        seed=seed,
    )
    heights = surface.heights(GRID)
    found = rc.reference.roughness(heights, GRID)
    pressures = []
    for separation in SEPARATIONS:
        approach = float(heights.max()) - separation * RMS_HEIGHT
        problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=GRID, boundary="periodic")
        pressures.append(problem.solve(approach=approach).mean_pressure if approach > 0.0 else 0.0)
    return [found.skewness, found.kurtosis, found.rms_slope.value, *(1e-6 * one for one in pressures)]


def make_rows() -> list[list[str]]:
    """Return the lines of the table: means over surfaces."""
    rows = [HEADING]
    for skewness, kurtosis in some_of(CASES, 2):
        numbers = np.mean([measure(skewness, kurtosis, seed) for seed in SEEDS], axis=0)
        rows.append([f"{skewness:g}", f"{kurtosis:g}", *(f"{one + 0.0:.2f}" for one in np.round(numbers[:2], 2))])
        rows[-1] += [f"{one:.3g}" for one in numbers[2:]]
    return rows


TABLES = {"non-gaussian": DocTable(make_rows, seconds=6, units=2)}
