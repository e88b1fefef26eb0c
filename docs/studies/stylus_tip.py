"""What a stylus does to the area of a contact, and what is left after its tip is taken away from the map.

Rough surfaces of known heights are traced by a ball on half the cells, and restored.
python docs/studies/doc_tables.py stylus-tip stylus-answers writes the tables of docs/use/stylus.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeAlias

import attrs
import numpy as np
from doc_tables import DocTable, some_of

import roughcontact as rc
from roughcontact.typing import Array

Maps: TypeAlias = tuple[rc.HeightMap, rc.HeightMap]
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
    "extrapolated, %",
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
    blunter = press(restored.traced(2.0 * radius).restored(2.0 * radius)).area(uncertainty="model").value
    exact = np.abs(restored.values - true.values) < 0.01 * true.values.std()
    return [
        press(traced).area().value / area - 1.0,
        found.value / area - 1.0,
        (found.value + (found.value - blunter) / 3.0) / area - 1.0,
        found.certain_fraction,
        float(exact[solution.contact].mean()),
        found.uncertainty / found.value,
    ]


def make_rows() -> list[list[str]]:
    """Return the lines of the table: means over surfaces."""
    rows = [HEADING]
    for hurst, blunt in some_of(CASES, 1):
        means = 100.0 * np.mean([measure(hurst, blunt, seed) for seed in SEEDS], axis=0)
        areas = (f"{means[0]:+.0f}", f"{means[1]:+.1f}", f"{means[2]:+.1f}")
        rows.append([f"{hurst:g}", f"{blunt:g}", *areas, *(f"{one:.0f}" for one in means[3:5]), f"{means[5]:.1f}"])
    return rows


# Other answers: seeds, bluntness as above, loads, and separations of a film law over Sq.
SMALL = rc.Grid((128, 128), 0.5e-3)
ANSWER_SEEDS = (51, 52)
BLUNT = (0.7, 1.5, 3.0)
LOADS = (100e6, 400e6)  # Pa
SEPARATIONS = (0.5, 0.75, 1.0, 1.5, 2.0)
SIDE = SMALL.size[0]
WAVES = {"shortest": SIDE / 16, "longest": SIDE / 4}


def make_honed(grid: rc.Grid, seed: int) -> Array:
    """Return a nearly smooth plateau with grooves as deep as their walls go on."""
    plateau = rc.SelfAffineSurface(hurst=0.5, rms_height=0.05e-6, seed=seed, **WAVES)
    grooves = rc.SelfAffineSurface(hurst=0.8, rms_height=0.5e-6, peklenik=4.0, seed=seed + 1000, **WAVES)
    heights: Array = np.minimum(plateau.heights(grid), grooves.heights(grid) + 0.4e-6)
    return heights


def spectrum(**changed: float) -> Callable[[rc.Grid, int], Array]:
    """Return heights on a grid by their seed."""
    kind = rc.NonGaussianSurface if "skewness" in changed else rc.SelfAffineSurface
    given = {"hurst": 0.8, "rms_height": 0.5e-6, **WAVES, **changed}
    return lambda grid, seed: kind(**given, seed=seed).heights(grid)


# By their group in the table; no constant has seen this draw.
SURFACES = {
    "isotropic, lay": (spectrum(hurst=0.5), spectrum(peklenik=4.0)),
    "skewed": (spectrum(skewness=-1.0, kurtosis=4.5),),
    "honed": (make_honed,),
}
ANSWERS = {
    "contact area": lambda one: one.area(),
    "maximum pressure": lambda one: one.peak_pressure(),
    "approach": lambda one: one.response("approach"),
    "stiffness, conductance": lambda one: one.stiffness(),
    "patches": lambda one: one.response("patches"),
    "mean gap": lambda one: one.response("mean-gap"),
    "leakage": lambda one: one.leakage(viscosity=1e-3, pressure_drop=1e5),
}
COLUMNS = {"pressure of a film law": ("asperity_pressure",), "its phi_xx, phi_yy": ("phi_xx", "phi_yy")}


@attrs.frozen
class Compared:
    """An answer on a restored map: error and uncertainty over that of the surface, and whether anything warns."""

    error: float
    stated: float
    warned: bool


def trace_and_restore(make: Callable[[rc.Grid, int], Array], seed: int, blunt: float) -> Maps:
    """Return a surface as a map, and what is restored of it."""
    finer = rc.HeightMap(make(rc.Grid([FINE * n for n in SMALL.shape], SIDE), seed), SIDE, periodic=True)
    true = rc.HeightMap(finer.values[::FINE, ::FINE], SIDE, periodic=True)
    laplacian = sum(np.roll(true.values, way, axis) for way in (1, -1) for axis in (0, 1)) - 4.0 * true.values
    radius = blunt * SMALL.spacing[0] ** 2 / float(np.std(laplacian))
    traced = rc.HeightMap(finer.traced(radius).values[::FINE, ::FINE], SIDE, periodic=True)
    return true, traced.restored(radius)


def compare_answers(maps: Maps) -> Iterator[tuple[str, Compared]]:
    """Yield each answer of both maps at all loads and separations by its name."""
    problems = [rc.ContactProblem(rc.Body(one, STEEL), boundary="periodic", threads=1) for one in maps]
    for load in LOADS:
        true, found = (problem.solve(pressure=load) for problem in problems)
        for name, ask in ANSWERS.items():
            exact, one = ask(true), ask(found)
            if exact.value:
                warned = bool(one.warnings or found.warnings)
                yield name, Compared(one.value / exact.value - 1.0, one.uncertainty / exact.value, warned)
    rms = [float(np.std(one.values)) for one in maps]
    true, found = (
        rc.film_law(problem, [one * rms[1] / own for one in SEPARATIONS], sampling=False)
        for problem, own in zip(problems, rms, strict=True)
    )
    for name, columns in COLUMNS.items():
        for column in columns:
            exact, one = true[column], found[column]
            for row in np.flatnonzero(exact.values > 0.0):
                error, stated = one.values[row] / exact.values[row] - 1.0, one.uncertainties[row] / exact.values[row]
                yield name, Compared(float(error), float(stated), bool(found.warnings))


def make_answer_rows() -> list[list[str]]:
    """Return the lines of the table of all answers."""
    rows = [["answer", "surfaces", "errors", "median error, %", "stated, %", "within two", "above 10 %, no warning"]]
    found: dict[tuple[str, str], list[Compared]] = {}
    groups = some_of(list(SURFACES), 1)
    for group in groups:
        for surface in SURFACES[group]:
            for seed in ANSWER_SEEDS:
                for blunt in BLUNT:
                    for name, one in compare_answers(trace_and_restore(surface, seed, blunt)):
                        found.setdefault((name, group), []).append(one)
    for name in (*ANSWERS, *COLUMNS):
        for group in groups:
            several = found[name, group]
            errors = np.abs([one.error for one in several])
            stated = np.array([one.stated for one in several])
            silent = sum(error > 0.1 and not one.warned for error, one in zip(errors, several, strict=True))
            medians = (f"{100.0 * np.median(one):.2g}" for one in (errors, stated))
            inside = f"{100.0 * np.mean(errors <= 2.0 * stated):.0f} %"
            rows.append([name, group, str(errors.size), *medians, inside, str(silent)])
    return rows


TABLES = {
    "stylus-tip": DocTable(make_rows, seconds=18),
    "stylus-answers": DocTable(make_answer_rows, seconds=25),
}
