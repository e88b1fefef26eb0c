"""Whether the stated uncertainties of all answers hold, on machined and on smooth surfaces, judged apart.

    python benchmarks/stated_uncertainties.py --draw 301 --count 24 --references FILE [--dear 6] [--feature layer]
        [--kinds edged] [--answers area,approach] [--ways model,auto] [--worst]

Contacts are those of `edged_classes.py` by the number of the draw: take a new one when constants have been set. Each is
solved on its grid and on cells a half and a quarter as long; the finest is true within half of the last step. Values
that still change by more than 20 % there have no true one. A pressure grows if the largest of the cells rises by more
than 4 % at both refinements: it has no maximum, and is not judged. True values are kept in the file.

Prints for each kind, and for smooth and edged kinds together, how many pressures grow and are found unbounded, and for
each answer and way of its uncertainty: the errors, those within two standard deviations, the median uncertainty over
the median error, the largest error over its uncertainty, errors above 10 % without a warning, and how many are warned,
in brackets of contacts with four cells or more in the shortest wave.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import attrs
import numpy as np
from edged_classes import EDGED, FEATURES, SMOOTH, Case, draw_cases

import roughcontact as rc
from roughcontact.errors import InputError

GROWTH = 0.04
MAX_CHANGE = 0.2
UNWARNED = 0.1
RESOLVED = 4.0


def _respond(name: str, **arguments: object) -> Callable[[rc.ContactSolution], rc.Estimate]:
    return lambda solution: solution.response(rc.responses.create(name, **arguments))


CHEAP: dict[str, Callable[[rc.ContactSolution], rc.Estimate]] = {
    "area": lambda solution: solution.area(),
    **{name: _respond(name) for name in ("peak-pressure", "perimeter", "approach", "mean-gap", "stiffness")},
}
DEAR: dict[str, Callable[[rc.ContactSolution], rc.Estimate]] = {
    "tangential": _respond("tangential-stiffness"),
    "conductance": _respond("conductance", conductivity=1.0),
    "leakage x": _respond("leakage", axis=0, viscosity=1.0, pressure_drop=1.0),
    "leakage y": _respond("leakage", axis=1, viscosity=1.0, pressure_drop=1.0),
    "von Mises": lambda solution: solution.stress().maximum,
    "shear": lambda solution: solution.stress().maximum_shear,
}
ASKED = {**CHEAP, **DEAR}


class References:
    """The largest cells and the answers on both finer grids, kept in a file with a line for each contact."""

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._known: dict[str, dict[str, list[float]]] = {}
        for line in path.read_text().splitlines() if path and path.exists() else ():
            label, found = json.loads(line)
            self._known.setdefault(label, {}).update(found)

    def find(self, case: Case, answers: Sequence[str]) -> dict[str, list[float]]:
        """Return the largest cells, and (finer, finest, its uncertainty) of each answer that the contact has."""
        known = self._known.setdefault(case.label, {})
        missing = [name for name in ("top", *answers) if name not in known]
        if missing:
            solutions = [case.solve(refinement) for refinement in (2, 4)]
            found = {"top": [float(one.pressure.max()) for one in solutions]}
            for name in missing:
                if name != "top":
                    finer, finest = (ask(one, name) for one in solutions)
                    found[name] = [finer.value, finest.value, finest.uncertainty] if finer and finest else []
            known.update(found)
            if self._path:
                with self._path.open("a", encoding="utf-8") as file:
                    file.write(json.dumps([case.label, found]) + "\n")
        return known


def ask(solution: rc.ContactSolution, answer: str) -> rc.Estimate | None:
    """Return an answer; None if the contact has none."""
    try:
        return ASKED[answer](solution)
    except InputError:
        return None


class Error(NamedTuple):
    """Of an answer, relative: the error, the stated uncertainty, their ratio, and whether the answer is warned.

    The ratio is that of the error beyond two standard deviations of the true value.
    """

    error: float
    stated: float
    ratio: float
    warned: bool


class Judged(NamedTuple):
    """A contact: whether its pressure grows, was found unbounded and was flagged, and cells in the shortest wave.

    The errors are by the name of an answer that has a true value, and the way its uncertainty is found.
    """

    case: Case
    grows: bool
    unbounded: bool
    flagged: bool
    wave_cells: float
    errors: dict[tuple[str, str], Error]


def judge(case: Case, answers: Sequence[str], ways: Sequence[str], references: References) -> Judged:
    """Solve a contact and return what its answers err by."""
    first = case.solve()
    true = references.find(case, answers)
    tops = [float(first.pressure.max()), *true["top"]]
    grows = tops[1] > (1.0 + GROWTH) * tops[0] and tops[2] > (1.0 + GROWTH) * tops[1]
    errors = {}
    for way in ways:
        solution = attrs.evolve(first, uncertainty=way)
        for answer in answers:
            error = _find_error(solution, answer, true[answer])
            if error and not (answer == "peak-pressure" and grows):
                errors[answer, way] = error
    try:
        flags = first.response("flags")
        unbounded, flagged = flags.unbounded, flags.unresolved
    except InputError:
        unbounded = flagged = False
    return Judged(case, grows, unbounded, flagged, case.count_wave_cells(), errors)


def _find_error(solution: rc.ContactSolution, answer: str, true: Sequence[float]) -> Error | None:
    if not true:
        return None
    finer, finest, uncertainty = true
    found = ask(solution, answer)
    if found is None or finest <= 0.0 or not abs(finest - finer) <= MAX_CHANGE * finest:
        return None
    unsure = 0.5 * max(abs(finest - finer), uncertainty) / finest
    error, stated = abs(found.value / finest - 1.0), found.uncertainty / finest
    beyond = max(error - 2.0 * unsure, 0.0)
    return Error(error, stated, beyond / stated if stated > 0.0 else math.inf * beyond if beyond else 0.0,
                 bool(found.warnings))  # fmt: skip


def judge_kinds(
    kinds: Sequence[str], draw: int, count: int, answers: Sequence[str], ways: Sequence[str] = ("auto",),
    references: Path | None = None, feature: str = "", dear: int = 0,
) -> dict[str, list[Judged]]:  # fmt: skip
    """Return the contacts of each kind; of the answers in `DEAR`, the first so many."""
    known = References(references)
    return {
        kind: [
            judge(case, [name for name in answers if name not in DEAR or number < dear], ways, known)
            for number, case in enumerate(draw_cases(kind, draw, count, feature))
        ]
        for kind in kinds
    }


# --- tables -----------------------------------------------------------------------------------------------------------


def count_unbounded(rows: Sequence[Judged]) -> tuple[int, int, int, int]:
    """Return how many pressures grow and are found, and how many others there are and are found by mistake."""
    grow, still = ([row.unbounded for row in rows if row.grows is grows] for grows in (True, False))
    return len(grow), sum(grow), len(still), sum(still)


class Coverage(NamedTuple):
    """Of the errors of an answer: their number, the fraction within two, and others named in the heading."""

    count: int
    within: float = math.nan
    ratio: float = math.nan
    largest: float = math.nan
    unwarned: int = 0
    warned: float = math.nan
    warned_resolved: float = math.nan


def cover(rows: Sequence[Judged], answer: str, way: str) -> Coverage:
    """Return how the uncertainties of an answer hold."""
    having = [row for row in rows if (answer, way) in row.errors]
    found = [row.errors[answer, way] for row in having]
    if not found:
        return Coverage(0)
    errors, stated, ratios, warned = (np.array(column, dtype=float) for column in zip(*found, strict=True))
    resolved = np.array([row.wave_cells >= RESOLVED for row in having])
    return Coverage(
        len(found),
        float(np.mean(ratios <= 2.0)),
        float(np.median(stated)) / max(float(np.median(errors)), 1e-12),
        float(ratios.max()),
        int(np.count_nonzero((errors > UNWARNED) & (warned == 0.0))),
        float(np.mean(warned)),
        float(np.mean(warned[resolved])) if resolved.any() else math.nan,
    )


def print_rows(title: str, rows: Sequence[Judged], answers: Sequence[str], ways: Sequence[str], worst: bool) -> None:
    """Print how the uncertainties of some contacts hold."""
    grow, found, still, false = count_unbounded(rows)
    print(
        f"{title}: {len(rows)} contacts, {np.mean([row.flagged for row in rows]):.0%} by two grids; "
        f"unbounded: {found} of {grow} that grow, {false} of {still} others"
    )
    for answer in answers:
        for way in ways:
            one = cover(rows, answer, way)
            if one.count:
                print(
                    f"  {answer:14}{way:6}{one.count:4} {one.within:5.0%} u/e {one.ratio:5.1f}, largest e/u "
                    f"{one.largest:5.1f}, unwarned {one.unwarned:3}, "
                    f"warned {one.warned:4.0%} [{one.warned_resolved:4.0%}]"
                )
    for row in rows if worst else ():
        off = [f"{' '.join(key)} {e.error:.2%} +- {e.stated:.2%}" for key, e in row.errors.items() if e.ratio > 2.0]
        if off or row.grows is not row.unbounded:
            print(f"    {row.case.label} {row.case.cells} {row.case.boundary}: grows {row.grows}, {'; '.join(off)}")


def print_groups(
    found: dict[str, list[Judged]], answers: Sequence[str], ways: Sequence[str], worst: bool = False
) -> None:
    """Print each kind, and the smooth and the edged ones together."""
    for title, kinds in (("SMOOTH", SMOOTH), ("EDGED", EDGED)):
        members = {kind: found[kind] for kind in kinds if found.get(kind)}
        for kind, rows in members.items():
            print_rows(kind, rows, answers, ways, worst)
        if members:
            print_rows(title, [row for rows in members.values() for row in rows], answers, ways, worst=False)


def main(arguments: Sequence[str] | None = None) -> None:
    """Judge the contacts that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kinds", default="all", help=f"edged, smooth, all, or of {', '.join((*EDGED, *SMOOTH))}")
    parser.add_argument("--answers", default=",".join(ASKED))
    parser.add_argument("--ways", default="auto", help="of model, auto and two grids, with commas")
    parser.add_argument("--draw", type=int, default=1)
    parser.add_argument("--count", type=int, default=8, help="contacts of each kind")
    parser.add_argument("--dear", type=int, default=4, help="contacts with all answers")
    parser.add_argument("--feature", default="", choices=("", *FEATURES))
    parser.add_argument("--references", type=Path, help="file of the true values")
    parser.add_argument("--worst", action="store_true", help="list what was missed")
    options = parser.parse_args(arguments)
    answers, ways = options.answers.split(","), options.ways.split(",")
    groups = {"edged": list(EDGED), "smooth": list(SMOOTH), "all": [*EDGED, *SMOOTH]}
    kinds = groups.get(options.kinds) or options.kinds.split(",")
    found = judge_kinds(
        kinds, options.draw, options.count, answers, ways, options.references, options.feature, options.dear
    )
    print_groups(found, answers, ways, options.worst)


if __name__ == "__main__":
    main()
