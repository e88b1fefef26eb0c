"""What paths over time and over sliding distance cost by their accuracy, a table of docs/understand/memory.md.

    python docs/studies/path_costs.py

A rough surface creeps over five decades of time; another one wears by a fiftieth and by half of its rms height in the
mean; and a ball creeps as Lee and Radok say.
"""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np
from doc_tables import DocTable, some_of, write_tables

import roughcontact as rc
from roughcontact.results import LoadPath

ACCURACIES = (1e-2, 3e-3, 1e-3)
# Accuracy of the paths that the others are compared with.
STRICT = 1e-4
SLOPE = 0.1
SOFT = rc.Elastic(1.0, 0.0)
DECADES = (0.0, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0)


@attrs.frozen
class Course:
    """A path by its accuracy, one of its contacts without a start, and the fields that are compared with right ones."""

    follow: Callable[..., LoadPath]
    cold: rc.ContactSolution
    read: Callable[[LoadPath], np.ndarray]
    right: np.ndarray


def rough(cells: int, material: rc.Material, **others: object) -> rc.ContactProblem:
    """Return a periodic self-affine surface with 8 cells in its shortest wave against a rigid flat."""
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=SLOPE, shortest=8.0, longest=float(cells), rolloff=cells / 8, seed=1
    )
    grid = rc.Grid((cells, cells), float(cells))
    return rc.ContactProblem(rc.Body(surface, material), grid=grid, boundary="periodic", threads=1, **others)


def creep() -> Course:
    """Return the creep of a surface whose modulus falls to a sixth, under a load."""
    load = {"pressure": 0.45 * SLOPE}
    problem = rough(256, rc.Viscoelastic([1.0, 2.5, 2.5], [1.0, 30.0], 0.0))

    def follow(accuracy: float, **others: object) -> LoadPath:
        return problem.path(**load, time=DECADES, accuracy=accuracy, **others)

    right = follow(STRICT).approach
    return Course(follow, problem.solve(**load), lambda path: path.approach / right, np.ones(right.size))


def wear(depth: float) -> Course:
    """Return the wear of a surface by a mean depth, over its rms height."""
    cells = 128
    load = {"pressure": 0.1 * SLOPE}
    problem = rough(cells, SOFT, laws=rc.Archard(1.0))
    distance = depth * float(problem.body.heights(problem.grid).std()) / load["pressure"]
    fresh = problem.solve(**load)

    def follow(accuracy: float, **others: object) -> LoadPath:
        return problem.path(**load, sliding=[0.0, distance], accuracy=accuracy, **others)

    def read(path: LoadPath) -> np.ndarray:
        return path[-1].initial_gap - fresh.initial_gap

    right = read(follow(STRICT))
    return Course(follow, fresh, lambda path: read(path) / np.ptp(right), right / np.ptp(right))


def ball() -> Course:
    """Return the creep of a ball, against the closed form: the cube of the radius grows as the compliance."""
    cells = 16
    first = cells / 6.0 ** (1.0 / 3.0)
    count = 2 * cells + 9
    body = rc.Body(rc.ParaboloidSurface(1e3), rc.Viscoelastic([1.0, 5.0], [1.0], 0.0))
    problem = rc.ContactProblem(body, grid=rc.Grid((count, count), float(count)), threads=1)
    force = 4.0 / 3.0 * 6.0 * first**3 / 1e3

    def follow(accuracy: float, **others: object) -> LoadPath:
        return problem.path(force=force, time=DECADES, accuracy=accuracy, **others)

    right = first**2 / 1e3 * (6.0 - 5.0 * np.exp(-np.array(DECADES) / 6.0)) ** (2.0 / 3.0)
    return Course(follow, problem.solve(force=force), lambda path: path.approach / right, np.ones(right.size))


CASES = {
    "creep, rough, 256 x 256": creep,
    "wear, rough, 128 x 128, .02 rms": lambda: wear(0.02),
    "wear, rough, 128 x 128, .5 rms": lambda: wear(0.5),
    "creep, ball, 16 cells": ball,
}


def make_rows() -> list[list[str]]:
    """Return a line for each path and accuracy."""
    rows = [["path", "accuracy", "increments", "products", "in solves without a start", "error, %"]]
    for name in some_of(list(CASES), 1, 3):
        course = CASES[name]()
        for accuracy in some_of(ACCURACIES, 0, 2):
            products: list[int] = []
            path = course.follow(accuracy, on_increment=lambda state: products.append(state.convolutions))
            error = 100.0 * float(np.abs(course.read(path) - course.right).max())
            cold = sum(products) / course.cold.convolutions
            rows.append([name, f"{accuracy:g}", f"{len(products)}", f"{sum(products)}", f"{cold:.1f}", f"{error:.2g}"])
    return rows


# Refused increments, at most one of 50 here, are not counted. Other machines may differ by an iteration.
TABLES = {"path-costs": DocTable(make_rows, seconds=20, units=5)}

if __name__ == "__main__":
    write_tables(TABLES)
