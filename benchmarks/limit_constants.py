"""Constants of contacts at a pressure limit, measured on spheres.

    python benchmarks/limit_constants.py [--write] [number of spheres of each overload]

Prints the growth of the contact by the overload (Hertz's maximum pressure over the limit) and the error of the traced
edge beside `roughcontact._answers.areas.calibration`, and writes the table of the former; half a minute.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import roughcontact as rc
from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.edges import trace_edges

RADIUS = 1e4  # of the spheres, in cells; their modulus is one
LARGE = 40.0  # cells: radius of the elastic contact whose traced area counts as true


def press(radius: float, overload: float, rng: np.random.Generator) -> rc.ContactSolution:
    """Return the contact of a sphere whose elastic contact has this radius, in cells."""
    cells = 2 * int(1.5 * radius * np.sqrt(max(1.0, 0.7 * overload)) + 6)
    material = rc.ElasticPerfectlyPlastic(1.0, 0.0, hardness=2.0 * radius / (np.pi * RADIUS * overload))
    sphere = rc.ParaboloidSurface(RADIUS, center=tuple(rng.random(2) - 0.5))
    problem = rc.ContactProblem(rc.Body(sphere, material), grid=rc.Grid((cells, cells), float(cells)))
    return problem.solve(force=4.0 * radius**3 / (3.0 * RADIUS))


def measure(count: int = 8) -> tuple[np.ndarray, float]:
    """Return the growth at each overload of the table, and the rms error of half-saturated edges, in cells."""
    rng, growth, errors = np.random.default_rng(0), [], []
    for overload in calibration.PLASTIC_GROWTH[0]:
        large = press(LARGE, overload, rng)
        growth.append(large.area("level-set").value / (np.pi * LARGE**2))
        for radius in rng.uniform(4.0, 14.0, size=count) if 1.7 <= overload <= 2.2 else ():
            edges = trace_edges(press(radius, overload, rng))
            errors.append((edges.area.sum() - growth[-1] * np.pi * radius**2) / edges.strip.sum())
    return np.array(growth), float(np.sqrt(np.mean(np.square(errors))))


if __name__ == "__main__":
    arguments = sys.argv[1:]
    growth, error = measure(*(int(word) for word in arguments if word != "--write"))
    table = np.stack((calibration.PLASTIC_GROWTH[0], growth), axis=1)
    for (overload, stated), value in zip(calibration.PLASTIC_GROWTH.T, growth, strict=True):
        print(f"PLASTIC_GROWTH at {overload:4}  {value:.4f}   in use: {stated}")
    print(f"SATURATED_POSITION_STD (rms) {error:.4f}   in use: {calibration.SATURATED_POSITION_STD}")
    if "--write" in arguments:
        # Elastic contacts do not grow, and those that flow everywhere grow as the overload.
        table[[0, -1], 1] = 1.0, 2.0 * table[-1, 0] / 3.0
        file = Path(calibration.__file__).with_name("plastic_growth.csv")
        header = f"overload, growth; no unit; by benchmarks/{Path(__file__).name}"
        np.savetxt(file, table, ("%.2f", "%.4f"), ", ", header=header)
