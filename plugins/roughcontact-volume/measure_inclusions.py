"""Measure how often inclusions on a finer grid lie within the uncertainty of a coarse one.

``python measure_inclusions.py 40`` presses a ball on as many random inclusions, whose contrast, shape, Poisson's ratio,
place and boundary vary. It prints the errors over their uncertainties, and the fractions within one and two; some
minutes of one core.
"""

from __future__ import annotations

import sys

import numpy as np
import roughcontact as rc

from roughcontact_volume import Cuboid, Ellipsoid, Inclusion, Inclusions, Sphere, find_inclusion_answers
from roughcontact_volume.shapes import Shape

YOUNG, POISSON = 1e9, 0.3
# A Hertz contact of this radius, m, in a domain 3.5 radii wide.
CONTACT = 1e-4
BALL_RADIUS = 1e-2
FORCE = 4.0 * YOUNG / (1.0 - POISSON**2) * CONTACT**3 / (3.0 * BALL_RADIUS)
DOMAIN = 3.5
# Cells per radius of the contact, and of the reference.
CELLS = 8.0
REFERENCE_CELLS = 20.0
NAMES = ("approach", "peak_pressure", "von_mises")


def draw_case(seed: int) -> tuple[Inclusion, str]:
    """Return an inclusion and a boundary."""
    random = np.random.default_rng(seed)
    contrast = float(10.0 ** random.uniform(-0.85, 0.85))
    poisson = POISSON if random.integers(2) else float(random.uniform(0.25, 0.35))
    halves = random.uniform(0.25, 0.6, 3) * CONTACT
    kind = int(random.integers(3))
    shape: Shape = Sphere(halves[0])
    if kind == 1:
        shape = Ellipsoid(tuple(halves))
    elif kind == 2:
        shape = Cuboid(tuple(2.0 * halves))
    x, y = random.uniform(-0.4, 0.4, 2) * CONTACT
    depth = random.uniform(0.1, 0.6) * CONTACT + shape.half_lengths[2]
    boundary = ("free", "periodic")[int(random.integers(2))]
    return Inclusion(shape, contrast * YOUNG, poisson, centre=(x, y, depth)), boundary


def find_answers(inclusion: Inclusion, boundary: str, cells: float) -> dict[str, rc.Estimate]:
    """Return the answers on a grid of some cells per radius of the contact."""
    count = round(DOMAIN * cells)
    problem = rc.ContactProblem(
        rc.Body(rc.FlatSurface(), rc.Elastic(YOUNG, POISSON)),
        rc.Body(rc.ParaboloidSurface(BALL_RADIUS), rc.Rigid()),
        grid=rc.Grid((count, count), count / cells * CONTACT),
        boundary=boundary,
        laws=Inclusions(inclusion),
    )
    return find_inclusion_answers(problem.solve(force=FORCE)).estimates


def main(count: int) -> None:
    """Print the errors of random cases over their uncertainties."""
    errors = []
    for seed in range(count):
        inclusion, boundary = draw_case(seed)
        coarse, fine = (find_answers(inclusion, boundary, cells) for cells in (CELLS, REFERENCE_CELLS))
        row = [(coarse[name].value - fine[name].value) / coarse[name].uncertainty for name in NAMES]
        errors.append(row)
        relative = [coarse[name].uncertainty / coarse[name].value for name in NAMES]
        words = " ".join(f"{r:6.2f} of {u:.2%}" for r, u in zip(row, relative, strict=True))
        print(
            f"{seed:3d} {type(inclusion.shape).__name__:9s} {inclusion.young / YOUNG:5.2f} {boundary:8s} {words}",
            flush=True,
        )
    for factor in (1.0, 2.0):
        within = np.mean(np.abs(errors) <= factor, axis=0)
        print(f"within {factor:g}: " + ", ".join(f"{n} {w:.1%}" for n, w in zip(NAMES, within, strict=True)))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
