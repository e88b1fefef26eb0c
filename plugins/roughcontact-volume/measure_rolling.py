"""Residual stress below a track along which a ball rolls, of flats that had one before: a table of the README.

python plugins/roughcontact-volume/measure_rolling.py
"""

from __future__ import annotations

import numpy as np
import roughcontact as rc

from roughcontact_volume import FindResidualStress, Plastic, ResidualStress

YOUNG, POISSON, LIMIT, RADIUS = 210e9, 0.3, 1e9, 1e-3
# Radius of the contact, m, and force, N, at which it first yields without a residual stress.
FIRST_RADIUS = np.pi * 1.6 * LIMIT * RADIUS * (1.0 - POISSON**2) / (2.0 * YOUNG)
FIRST_FORCE = 2.0 / 3.0 * np.pi * FIRST_RADIUS**2 * 1.6 * LIMIT
CELLS, PASSES = 4, 2
CASES = ((-0.6, 2.0), (0.0, 2.0), (0.5, 2.0), (-0.6, 10.0), (0.0, 10.0), (0.5, 10.0))


def roll(stress: float, force: float) -> rc.results.LoadPath:
    """Return two passes and the lifting of a ball, of a stress over the yield stress, held to 1.5 contact radii."""
    radius = FIRST_RADIUS * force ** (1.0 / 3.0)
    by_depth = ResidualStress(np.array([0.0, 1.5, 3.0]) * radius, np.array([stress, stress, 0.0]) * LIMIT)
    flat = rc.Body(rc.FlatSurface(), Plastic(YOUNG, POISSON, LIMIT, accuracy=0.2, residual=by_depth))
    grid = rc.Grid((10 * CELLS, 5 * CELLS), (10.0 * radius, 5.0 * radius))
    problem = rc.ContactProblem(flat, rc.Body(rc.ParaboloidSurface(RADIUS), rc.Rigid()), grid=grid, boundary="periodic")
    track = [(cells, 0) for cells in range(-3 * CELLS, 3 * CELLS + 1, 2)]
    shift = track * PASSES + track[-1:]
    return problem.path(force=[force * FIRST_FORCE] * (len(shift) - 1) + [0.0], shift=shift)


def main() -> None:
    """Print a row for each flat and load."""
    words = ("before / Y", "load / that of first yield", "near the surface", "at half a radius", "at a radius")
    print(f"| {' | '.join(words)} | plastic work, nJ |")
    print("| --- | --- | --- | --- | --- | --- |")
    for stress, force in CASES:
        path = roll(stress, force)
        radius = FIRST_RADIUS * force ** (1.0 / 3.0)
        profile = path[-1].response(FindResidualStress(depth=2.0 * radius)).find_profile().columns
        found = np.interp(np.array([0.0, 0.5, 1.0]) * radius, profile["depth"], profile["xx"]) / LIMIT
        work = path[-1].added[0].numbers["plastic_work"][0]
        print(
            f"| {stress:+.1f} | {force:g} | {' | '.join(f'{one:+.2f}' for one in found)} | {work * 1e9:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
