"""What a stylus does to the area of a contact, and what is left after its tip is taken away from the map.

Rough surfaces of known heights are traced by a ball on half the cells, and restored.
python docs/studies/doc_tables.py stylus-tip writes the table of docs/use/stylus.md.
"""

from __future__ import annotations

import numpy as np
from doc_tables import DocTable, some_of

import roughcontact as rc

GRID = rc.Grid((256, 256), 1e-3)
STEEL = rc.Elastic(young=210e9, poisson=0.3)
PRESSURE = 100e6  # Pa
SEEDS = (1, 2)
FINE = 2  # cells of the traced surface in one of the map
# Hurst exponent, and radius of the tip times the rms of the Laplacian of the heights.
CASES = [(hurst, blunt) for hurst in (0.8, 0.3) for blunt in (0.5, 1.0, 2.0, 3.0)]
HEADING = [
    "Hurst exponent",
    "R times rms of z_xx + z_yy",
    "area of the map, %",
    "area of the restored map, %",
    "contact certain, %",
    "contact within 1 % of Sq, %",
    "stated uncertainty, %",
]


def press(heights: rc.HeightMap) -> rc.ContactSolution:
    """Return the contact of a map with a rigid flat."""
    return rc.ContactProblem(rc.Body(heights, STEEL), boundary="periodic").solve(pressure=PRESSURE)


def measure(hurst: float, blunt: float, seed: int) -> list[float]:
    """Return the numbers of a row for one surface: 8 cells on the shortest wave, 4 of the longest in the domain."""
    side = GRID.size[0]
    surface = rc.SelfAffineSurface(hurst=hurst, rms_height=1e-6, shortest=side / 32, longest=side / 4, seed=seed)
    finer = rc.HeightMap(surface.heights(rc.Grid((256 * FINE, 256 * FINE), side)), side, periodic=True)
    true = rc.HeightMap(finer.values[::FINE, ::FINE], side, periodic=True)
    laplacian = sum(np.roll(true.values, way, axis) for way in (1, -1) for axis in (0, 1)) - 4.0 * true.values
    radius = blunt * GRID.spacing[0] ** 2 / float(np.std(laplacian))
    traced = rc.HeightMap(finer.traced(radius).values[::FINE, ::FINE], side, periodic=True)
    restored = traced.restored(radius)
    area = press(true).area().value
    solution = press(restored)
    found = solution.area(uncertainty="model")
    exact = np.abs(restored.values - true.values) < 0.01 * true.values.std()
    return [
        press(traced).area().value / area - 1.0,
        found.value / area - 1.0,
        found.certain_fraction,
        float(exact[solution.contact].mean()),
        found.uncertainty / found.value,
    ]


def make_rows() -> list[list[str]]:
    """Return the lines of the table: means over surfaces."""
    rows = [HEADING]
    for hurst, blunt in some_of(CASES, 1):
        means = 100.0 * np.mean([measure(hurst, blunt, seed) for seed in SEEDS], axis=0)
        areas = (f"{means[0]:+.0f}", f"{means[1]:+.1f}")
        rows.append([f"{hurst:g}", f"{blunt:g}", *areas, *(f"{one:.0f}" for one in means[2:4]), f"{means[4]:.1f}"])
    return rows


TABLES = {"stylus-tip": DocTable(make_rows, seconds=12)}
