"""How often a cold solve of surfaces that attract each other leaps over a stable state, and its products.

    python benchmarks/adhesion_branches.py [--first 0] [--count 120]

Rough surfaces in cells of 1 : 1 to 3 : 1, periodic and free, under four laws of cohesive lengths of 1.3 to 5 cells, at
no load or a pressing one; and Johnson's waves of period 1 at no load. Right is the smallest state of equilibrium, found
by `Majorise`, whose contact only grows. E* = 1 GPa of the rough surfaces, 1 Pa of the waves.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

import roughcontact as rc

MODULUS = 1e9
SLOPE = 0.1
CELL = 1e-8
LARGEST = 64  # cells along a side
DIFFERS = 0.02  # areas that are other states, over the smaller one
FEWEST = 2e-4  # ... and of nominal


class Case(NamedTuple):
    """The arguments of a problem, and its mean pressure."""

    arguments: dict[str, Any]
    pressure: float
    label: str


def make_laws(work: float, steepest: float) -> tuple[rc.Interaction, ...]:
    """Return laws of a work of adhesion and a maximum slope; the last takes the shortest range of the grid."""
    smoothing = 0.3
    return (
        rc.Exponential(work, math.sqrt(work / steepest)),
        rc.Dugdale(work, math.sqrt(4.0 * smoothing * work * steepest / math.pi), smoothing=smoothing),
        rc.VanDerWaals(work, math.sqrt(6.0 * work / steepest)),
        rc.ShortRange(work),
    )


def draw_rough(seed: int) -> Case:
    """Draw a rough surface, a law, a boundary and a load."""
    random = np.random.default_rng([seed, 77])
    sides = ((1, 1), (1, 1), (1, 3), (3, 1), (2, 1))[random.integers(5)]
    shape = [int(n) for n in random.integers(LARGEST // 2, LARGEST + 1, 2)]
    size = (shape[0] * sides[0] * CELL, shape[1] * sides[1] * CELL)
    cell = max(sides) * CELL
    shortest = min(cell * math.exp(random.uniform(math.log(6.0), math.log(14.0))), 0.5 * max(size))
    surface = rc.SelfAffineSurface(
        hurst=random.uniform(0.4, 0.95), rms_slope=SLOPE, shortest=shortest,
        longest=max(max(size) / random.uniform(1.0, 3.0), 1.3 * shortest), seed=int(random.integers(2**31)),
    )  # fmt: skip
    cells = math.exp(random.uniform(math.log(1.3), math.log(5.0)))
    work = math.exp(random.uniform(math.log(0.01), math.log(0.25))) * 0.3 * SLOPE**2 * shortest * MODULUS
    law = make_laws(work, MODULUS / (cells * cell))[random.integers(4)]
    boundary = ("periodic", "periodic", "free")[random.integers(3)]
    pressing = math.exp(random.uniform(math.log(1e-3), math.log(0.1))) * 0.5 * SLOPE * MODULUS
    pressure = (0.0, 0.0, pressing)[random.integers(3)]
    arguments = {
        "body": rc.Body(surface, rc.Elastic(MODULUS, 0.0)), "grid": rc.Grid((shape[0], shape[1]), size),
        "boundary": boundary, "adhesion": law, "threads": 1,
    }  # fmt: skip
    return Case(arguments, pressure, f"{seed}: {shape[0]} x {shape[1]} of {sides}, {boundary}, {type(law).__name__}")


def make_waves() -> Iterator[Case]:
    """Yield Johnson's waves, their crests between the cells in several places."""
    for cells in (48, 160):
        for alpha in (0.25, 0.42, 0.48, 0.51, 0.54):
            for place in (0.2, 0.5):
                amplitude = 0.02
                heights = amplitude * np.cos(2.0 * np.pi * (np.arange(cells) + place) / cells)
                surface = rc.HeightMap(np.repeat(heights[:, None], 4, axis=1), (1.0, 4.0 / cells), periodic=True)
                law = rc.ShortRange(0.5 * (alpha * math.pi * amplitude) ** 2)
                arguments = {"body": rc.Body(surface, rc.Elastic(1.0, 0.0)), "boundary": "periodic", "adhesion": law}
                yield Case(arguments, 0.0, f"wave: {cells} cells, alpha {alpha}, {place}")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the states that were leapt over, and how many they are."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=120)
    options = parser.parse_args(arguments)
    rough = [draw_rough(seed) for seed in range(options.first, options.first + options.count)]
    for name, cases in (("rough", rough), ("waves", list(make_waves()))):
        leaps = products = 0
        for case in cases:
            found, smallest = (
                rc.ContactProblem(**case.arguments, **solver).solve(pressure=case.pressure, throw=False)
                for solver in ({}, {"solver": "majorise"})
            )
            areas = float(found.contact.mean()), float(smallest.contact.mean())
            products += found.convolutions
            if smallest.status.success and abs(areas[0] - areas[1]) > DIFFERS * areas[1] + FEWEST:
                leaps += 1
                print(f"{case.label}: {areas[0]:.4f} for {areas[1]:.4f}")
        print(f"{name}: {leaps} of {len(cases)} on another state, {products} products")


if __name__ == "__main__":
    main()
