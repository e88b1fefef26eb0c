"""The contact area of one surface against its magnification: ever shorter waves are added, the longer ones stay.

    python docs/studies/magnification.py

Prints a table, whose ends docs/use/maps.md has. The load is that of the roughness down to the longest cut-off; Persson
says erf(p sqrt(2) / (E* rms slope)), with the slope of each row.
"""

from __future__ import annotations

import math

import numpy as np

import roughcontact as rc

SIDE, CELLS = 128e-6, 8  # m; cells on the shortest wave
CUTOFFS = (16e-6, 8e-6, 4e-6, 2e-6, 1e-6)
STEEL = rc.Elastic(young=210e9, poisson=0.3)
PRESSURE = 50e6  # Pa


def rows(seed: int = 3) -> list[tuple[float, float, rc.Area]]:
    """Return shortest wavelength, m, rms slope and area for each cut-off."""
    found = []
    for shortest in CUTOFFS:
        surface = rc.SelfAffineSurface(
            hurst=0.8, rms_slope=0.02, rms_cutoff=CUTOFFS[0], longest=64e-6, shortest=shortest, seed=seed
        )
        grid = rc.Grid((CELLS * round(SIDE / shortest),) * 2, SIDE)
        solution = rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary="periodic").solve(pressure=PRESSURE)
        found.append((shortest, rms_slope(surface.heights(grid)), solution.area()))
    return found


def rms_slope(heights: rc.typing.Array) -> float:
    """Return the rms slope of periodic heights, by their spectrum."""
    count = len(heights)
    q = 2.0 * math.pi * np.fft.fftfreq(count, SIDE / count)
    power = np.abs(np.fft.fft2(heights, norm="forward")) ** 2
    return float(np.sqrt(np.sum(power * (q[:, np.newaxis] ** 2 + q**2))))


def main() -> None:
    """Print the table."""
    modulus = 210e9 / (1.0 - 0.3**2)
    print("| shortest wave, um | magnification | rms slope | area, % | Persson, % |\n|---|---|---|---|---|")
    for shortest, slope, area in rows():
        theory = math.erf(math.sqrt(2.0) * PRESSURE / (modulus * slope))
        value = f"{100 * area.fraction:.2f} ± {100 * area.uncertainty / area.value * area.fraction:.2f}"
        print(f"| {shortest * 1e6:g} | {64e-6 / shortest:g} | {slope:.4f} | {value} | {100 * theory:.2f} |")


if __name__ == "__main__":
    main()
