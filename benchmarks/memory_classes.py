"""Errors and uncertainties of answers on surfaces that loads before have changed, against finer grids.

    python benchmarks/memory_classes.py [--kinds light-wear,flattened] [--draw 1] [--count 16] [--references FILE]

A contact is one of the smooth surfaces of `edged_classes.py` on a grid, with a boundary and a load, drawn from the
number of the draw, and a history: it creeps, is loaded and unloaded in steps while it creeps, wears, is flattened and
unloaded, or moves over another surface. True values are those of the same surfaces and history on cells a quarter as
long. The table is that of `stated_uncertainties.py`; constants may see the draws below 100.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import attrs
import numpy as np
import stated_uncertainties as judged
from edged_classes import ELASTIC, POISSON, SMOOTH, Case, draw_case, generator, log_uniform

import roughcontact as rc
from roughcontact.results import LoadPath

ANSWERS = tuple(judged.CHEAP)
# Parts of the modulus that relax, and times of its two terms, s.
TIMES = (1.0, 30.0)
# Depth of the wear under the contact over the approach of the fresh surfaces.
DEPTHS = {"light-wear": (0.02, 0.15), "heavy-wear": (0.3, 1.5)}
STEPS = 4


@attrs.frozen
class ChangedCase:
    """A contact at the end of a history of a kind, which its label tells; see `Case`."""

    case: Case
    kind: str
    label: str

    @property
    def cells(self) -> tuple[int, int]:
        """Return the cells of the coarsest grid."""
        return self.case.cells

    @property
    def boundary(self) -> str | tuple[str, str]:
        """Return what lies beyond the border."""
        return self.case.boundary

    def count_wave_cells(self) -> float:
        """Return the cells of the grid in the shortest wave of the fresh surface."""
        return self.case.count_wave_cells()

    def solve(self, refinement: int = 1) -> rc.ContactSolution:
        """Return the last state on cells so many times as short."""
        return HISTORIES[self.kind](generator(self.label), self.case, refinement)[-1]


def change(case: Case, refinement: int, material: rc.Material, **others: object) -> rc.ContactProblem:
    """Return the problem of a case with another material of the body."""
    problem = case.problem(refinement)
    return attrs.evolve(problem, body=attrs.evolve(problem.body, material=material), **others)


def relaxing(random: np.random.Generator) -> rc.Viscoelastic:
    """Return a material whose modulus falls from that of the others to a tenth or four tenths."""
    whole, left, part = ELASTIC.young, random.uniform(0.1, 0.4), random.uniform(0.2, 0.8)
    moduli = (whole * left, whole * (1.0 - left) * part, whole * (1.0 - left) * (1.0 - part))
    return rc.Viscoelastic(list(moduli), list(TIMES), POISSON)


def yielding(random: np.random.Generator, fresh: rc.ContactSolution) -> rc.ElasticPerfectlyPlastic:
    hardness = random.uniform(0.3, 0.8) * float(fresh.pressure.max())
    return rc.ElasticPerfectlyPlastic(ELASTIC.young, POISSON, hardness=hardness)


def creep(random: np.random.Generator, case: Case, refinement: int) -> LoadPath:
    """Follow a load that acts for one of five decades of time."""
    problem = change(case, refinement, relaxing(random))
    return problem.path(pressure=case.pressure, time=[0.0, log_uniform(random, 0.03, 300.0)])


def step(random: np.random.Generator, case: Case, refinement: int) -> LoadPath:
    """Follow a load that acts for a time, rises or falls at once, and acts for another time or not."""
    problem = change(case, refinement, relaxing(random))
    factor, time = log_uniform(random, 1.5, 4.0), log_uniform(random, 0.3, 30.0)
    first, last = (1.0, factor) if random.random() < 0.5 else (factor, 1.0)
    after = log_uniform(random, 0.03, 3.0) if random.random() < 0.5 else 0.0
    loads, times = [first, first, last, last], [0.0, time, time, time + after]
    return problem.path(pressure=[case.pressure * load for load in loads], time=times)


def wear(kind: str) -> Callable[[np.random.Generator, Case, int], LoadPath]:
    def follow(random: np.random.Generator, case: Case, refinement: int) -> LoadPath:
        fresh = case.solve()
        depth = log_uniform(random, *DEPTHS[kind]) * fresh.approach
        of = "body" if random.random() < 0.5 else "counterbody"
        problem = change(case, refinement, ELASTIC, laws=rc.Archard(1.0, of=of))
        distance = depth * float(fresh.contact.mean()) / case.pressure
        return problem.path(pressure=case.pressure, sliding=[0.0, distance])

    return follow


def flatten(random: np.random.Generator, case: Case, refinement: int) -> LoadPath:
    """Follow a load that flattens, and falls, or is taken off and comes back in part."""
    problem = change(case, refinement, yielding(random, case.solve()))
    part = random.uniform(0.1, 0.95)
    loads = ([1.0, part], [1.0, 0.0, part], [0.6, 1.0, 0.5 * part, part])[int(random.integers(3))]
    return problem.path(pressure=[case.pressure * load for load in loads])


def move(random: np.random.Generator, case: Case, refinement: int) -> LoadPath:
    """Follow a surface that moves over another one; one of them wears, yields or relaxes."""
    other = attrs.evolve(case, surface=SMOOTH[case.label.split()[0]](random))
    counterbody = rc.Body(other.problem(refinement).body.surface, ELASTIC)
    both = attrs.evolve(case.problem(), counterbody=rc.Body(other.problem().body.surface, ELASTIC))
    fresh = both.solve(pressure=case.pressure)
    cells = random.integers(1, 5, 2)
    shifts = [tuple(int(refinement * number * n) for n in cells) for number in range(STEPS)]
    law = int(random.integers(3))
    if law == 0:
        distance = float(np.hypot(*(cells * both.plan.grid.spacing))) * (STEPS - 1)
        depth = log_uniform(random, 0.02, 0.5) * fresh.approach
        rate = depth * float(fresh.contact.mean()) / (case.pressure * distance)
        of = "body" if random.random() < 0.5 else "counterbody"
        problem = change(case, refinement, ELASTIC, counterbody=counterbody, laws=rc.Archard(rate, of=of))
        return problem.path(pressure=case.pressure, shift=shifts)
    if law == 1:
        problem = change(case, refinement, yielding(random, fresh), counterbody=counterbody)
        return problem.path(pressure=case.pressure, shift=shifts)
    problem = change(case, refinement, relaxing(random), counterbody=counterbody)
    return problem.path(pressure=case.pressure, shift=shifts, time=list(np.linspace(0.0, 3.0, STEPS)))


HISTORIES = {
    "creep": creep,
    "steps of load": step,
    "light-wear": wear("light-wear"),
    "heavy-wear": wear("heavy-wear"),
    "flattened": flatten,
    "moving": move,
}


def draw_cases(kind: str, draw: int, count: int) -> Iterator[ChangedCase]:
    """Yield contacts of a kind of history, on the surfaces in turn; those that move repeat beyond the border."""
    for number in range(count):
        surface = list(SMOOTH)[number % len(SMOOTH)]
        found = (draw_case(surface, draw, number + 1000 * trial) for trial in range(1000))
        case = next(one for one in found if kind != "moving" or one.boundary == "periodic")
        yield ChangedCase(case, kind, f"{kind} {case.label}")


def judge_kinds(
    kinds: Sequence[str], draw: int, count: int, references: Path | None = None
) -> dict[str, list[judged.Judged]]:
    """Return the contacts of each kind; see `stated_uncertainties.judge`."""
    known = judged.References(references)
    return {
        kind: [judged.judge(case, ANSWERS, ["model"], known) for case in draw_cases(kind, draw, count)]
        for kind in kinds
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Judge the contacts that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kinds", default=",".join(HISTORIES))
    parser.add_argument("--draw", type=int, default=1)
    parser.add_argument("--count", type=int, default=16, help="contacts of each kind")
    parser.add_argument("--references", type=Path, help="file of the true values")
    parser.add_argument("--worst", action="store_true", help="list what was missed")
    options = parser.parse_args(arguments)
    for kind in options.kinds.split(","):
        rows = judge_kinds([kind], options.draw, options.count, options.references)[kind]
        judged.print_rows(kind, rows, ANSWERS, ["model"], options.worst)


if __name__ == "__main__":
    main()
