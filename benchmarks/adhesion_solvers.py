"""Random adhesive contacts by `GapDescent` and by `Majorise`: the same contact, to the cell.

    python benchmarks/adhesion_solvers.py [number of scenes] [first seed]

The scenes are those of `adhesion_problems.py` whose cohesive length has two cells or more. Both solvers start from the
contact without adhesion. Where contacts differ, both are solved again with a smaller tolerance, and the line says by
how many cells of how many, which state has the lower energy, and by how much of the scale of the energy.
"""

from __future__ import annotations

import collections
import sys
from typing import NamedTuple

import numpy as np
from adhesion_problems import LOAD, displace, judge, make_problem

from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solvers import Outcome, Task
from roughcontact._solve.solvers.adhesive import GapDescent, Majorise

RESOLVED = 2.0
TOLERANCE = 1e-6
# Errors of the gap over the scale, as the judge finds them, over the tolerance.
ALLOWED = 5.0


class Agreement(NamedTuple):
    """What two solvers found: statuses, cells of both contacts, cells that differ, and the difference of the energies.

    The energy, that of `Majorise` minus that of `GapDescent`, is over the work of adhesion of the cells that touch or
    attract each other; positive: `GapDescent` found the lower state.
    """

    statuses: tuple[str, str]
    cells: tuple[int, int]
    different: int
    energy: float
    certified: tuple[bool, bool]


def find_energy(convolution: PreparedConvolution, task: Task, outcome: Outcome) -> float:
    """Return the energy of a state, that of a given load and of a pressure limit included, per cell area."""
    assert task.interaction is not None
    displacement = displace(convolution, outcome.pressure)
    contact = np.maximum(outcome.pressure + outcome.tension, 0.0)
    saturated = outcome.pressure >= task.pressure_limit
    gap = displacement + task.initial_gap
    approach = task.approach
    if approach is None:
        elastic = np.where(saturated, 0.0, contact)
        approach = float((elastic * gap).sum() / elastic.sum()) if elastic.any() else float(gap.min())
    gap = gap - approach
    attraction = task.interaction.energy(np.maximum(gap, 0.0).astype(np.float64)).sum()
    pressed = float((np.where(saturated, np.maximum(-gap, 0.0), 0.0) * outcome.pressure).sum())
    load = 0.0 if task.mean_pressure is None else task.mean_pressure * gap.size * approach
    return float(0.5 * (outcome.pressure * displacement).sum() + attraction + pressed - load)


def is_certified(convolution: PreparedConvolution, task: Task, outcome: Outcome, tolerance: float) -> bool:
    """Return whether the judge in extended precision finds an outcome true."""
    if not outcome.status.success:
        return False
    errors = judge(convolution, task, outcome)
    return errors["gap"] <= ALLOWED * tolerance and errors["load"] <= LOAD and errors["bounds"] <= 0.0


def compare_solvers(seed: int, tolerance: float = TOLERANCE) -> Agreement:
    """Return what both solvers find for the scene of a seed."""
    convolution, task, _ = make_problem(seed)
    outcomes = [solver(tolerance).solve(convolution, task) for solver in (GapDescent, Majorise)]
    statuses = tuple(outcome.status.name for outcome in outcomes)
    if not all(outcome.status.success for outcome in outcomes):
        return Agreement(statuses, (0, 0), 0, 0.0, (False, False))
    touching = [outcome.pressure + outcome.tension > 0.0 for outcome in outcomes]
    first, second = (find_energy(convolution, task, outcome) for outcome in outcomes)
    attracted = outcomes[0].tension > 0.01 * outcomes[0].tension.max()
    released = float(
        np.broadcast_to(-task.interaction.energy(np.zeros(attracted.shape)), attracted.shape)[attracted].sum()
    )
    return Agreement(
        statuses,
        (int(touching[0].sum()), int(touching[1].sum())),
        int(np.count_nonzero(touching[0] != touching[1])),
        (second - first) / max(released, 1e-300),
        tuple(is_certified(convolution, task, outcome, tolerance) for outcome in outcomes),
    )


def find_seeds(number: int, first: int) -> list[int]:
    """Return the seeds of scenes whose law the cells resolve."""
    seeds: list[int] = []
    while len(seeds) < number:
        if make_problem(first)[2]["cells"] >= RESOLVED:
            seeds.append(first)
        first += 1
    return seeds


def main(number: int = 200, first: int = 0) -> None:
    """Print a line for each scene whose contacts differ, or that is not certified, and the counts."""
    counts: collections.Counter[str] = collections.Counter()
    for seed in find_seeds(number, first):
        found = compare_solvers(seed)
        again = ""
        if found.different:
            finer = compare_solvers(seed, 0.01 * TOLERANCE)
            again = f"; at a hundredth of the tolerance {finer.different}, {finer.energy:+.1e}, {finer.statuses}"
        name = (
            "/".join(found.statuses)
            if "CONVERGED" not in set(found.statuses) or len(set(found.statuses)) > 1
            else ("same" if not found.different else "differ")
        )
        counts[name] += 1
        if name != "same" or not all(found.certified):
            about = ", ".join(str(value) for value in make_problem(seed)[2].values())
            print(
                f"{seed}: {found.statuses}, {found.different} of {found.cells} cells, energy {found.energy:+.1e}, "
                f"certified {found.certified}{again}: {about}",
                flush=True,
            )
    print(dict(counts))


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:3]))
