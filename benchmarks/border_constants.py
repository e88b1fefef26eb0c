"""What a free border does to a rough surface: the threshold of the warning of edge contact.

    python benchmarks/border_constants.py

For each mean pressure over E* rms slope: the fraction of the load on contacts that reach the border, the fraction
of the surfaces whose maximum pressure lies on a cell of the border, and the changes of the maximum pressure and of the
area against the periodic boundary; medians over surfaces; two minutes.
"""

from __future__ import annotations

import numpy as np

import roughcontact as rc
from roughcontact._solve.solution.plausibility import find_contact

STEEL = rc.Elastic(young=200e9, poisson=0.3)
SLOPE, PITCH = 0.05, 1e-6
SURFACES = {128: 12, 256: 6}


def solve(cells: int, longest: float, seed: int, load: float) -> tuple[rc.ContactSolution, rc.ContactSolution]:
    """Return the solutions on a free and on a periodic boundary; lengths in cells."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=SLOPE, shortest=8 * PITCH, longest=longest * PITCH, seed=seed)
    grid = rc.Grid((cells, cells), cells * PITCH)
    body = rc.Body(surface, STEEL)
    pressure = load * SLOPE / STEEL.compliance
    free, periodic = (
        rc.ContactProblem(body, grid=grid, boundary=boundary).solve(pressure=pressure)
        for boundary in ("free", "periodic")
    )
    return free, periodic


def measure(cells: int, longest: float, seed: int, load: float) -> tuple[float, bool, float, float]:
    """Return the fraction at the border, whether the maximum pressure lies there, and the changes, of one surface."""
    free, periodic = solve(cells, longest, seed, load)
    place = np.unravel_index(free.pressure.argmax(), free.pressure.shape)
    fraction = next(finding.value for finding in find_contact(free, ()) if finding.rule == "edge contact")
    peak = float(free.pressure.max() / periodic.pressure.max()) - 1.0
    area = free.area().value / periodic.area().value - 1.0
    return fraction, bool({0, cells - 1} & set(place)), peak, area


def cut_ball(radius: float, cells: int = 128) -> tuple[float, float]:
    """Return the mean pressure at the border over the nominal one and the error of the area, of a ball.

    `radius` is Hertz's radius of contact over half the side.
    """
    side = cells * PITCH
    true, ball = 0.5 * radius * side, 10.0 * side
    force = 4.0 * true**3 / (3.0 * ball * STEEL.compliance)
    grid = rc.Grid((cells, cells), side)
    solution = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(ball), STEEL), grid=grid).solve(force=force)
    border = np.ones(grid.shape, dtype=bool)
    border[1:-1, 1:-1] = False
    mean = float(solution.pressure[border].mean() / solution.pressure.mean())
    return mean, solution.area().value / (np.pi * true**2) - 1.0


def main() -> None:
    """Print both tables."""
    print(
        "| radius of contact over half the side | mean pressure at the border over the nominal | area |\n|---|---|---|"
    )
    for radius in (0.95, 1.0, 1.05, 1.1, 1.2, 1.4):
        mean, area = cut_ball(radius)
        print(f"| {radius} | {mean:.2f} | {100 * area:+.1f} % |")
    print("| cells | longest wave | load | on contacts at the border | maximum there | pressure | area |")
    print("|---|---|---|---|---|---|---|")
    for cells, longest in ((128, 32), (128, 64), (256, 32)):
        for load in (0.01, 0.03, 0.1, 0.3, 1.0):
            rows = [measure(cells, longest, seed, load) for seed in range(SURFACES[cells])]
            fraction, _, peak, area = np.median(rows, axis=0)
            there = np.mean([row[1] for row in rows])
            print(
                f"| {cells} | {longest} | {load} | {100 * fraction:.0f} % | {100 * there:.0f} % "
                f"| {100 * peak:+.0f} % | {100 * area:+.1f} % |",
                flush=True,
            )


if __name__ == "__main__":
    main()
