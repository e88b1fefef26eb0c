"""The tables of docs/understand/edges.md on machined surfaces: flags, and uncertainties by a model and by two grids."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

from doc_tables import DocTable, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import edged_classes

# A draw that no constant has seen, and contacts of each kind.
DRAW = 102
COUNT = 12
ANSWERS = (*edged_classes.ANSWERS, "stiffness")
GROUPS = {"smooth": edged_classes.SMOOTH, "machined": edged_classes.EDGED}


@lru_cache(maxsize=1)
def judge() -> Mapping[str, list[edged_classes.Judged]]:
    """Return all contacts by their group."""
    found = {}
    for name, kinds in GROUPS.items():
        rows = edged_classes.judge_kinds(list(kinds), DRAW, COUNT, ANSWERS)
        found[name] = [row for kind in rows.values() for row in kind]
    return found


def make_flags() -> list[list[str]]:
    heading = ["surfaces", "contacts", "pressure grows", "of these found", "others", "of these called unbounded"]
    rows = ((name, len(group), *edged_classes.count_unbounded(group)) for name, group in judge().items())
    return [heading, *([str(cell) for cell in row] for row in rows)]


def make_coverage() -> list[list[str]]:
    names = {"model": "model", "auto": "default", "two grids": "two grids"}
    heading = [
        "answer",
        "surfaces",
        "errors",
        *(f"{what}, {name}" for name in names.values() for what in ("within two", "u/e")),
    ]
    rows = [heading]
    for answer in ANSWERS:
        for group, contacts in judge().items():
            cells = [edged_classes.cover(contacts, answer, name) for name in names]
            numbers = [text for _, within, ratio in cells for text in (f"{100 * within:.0f} %", f"{ratio:.1f}")]
            rows.append([answer.replace("-", " "), group, str(cells[0][0]), *numbers])
    return rows


TABLES = {"flags": DocTable(make_flags, seconds=100), "two-grids": DocTable(make_coverage, seconds=100)}

if __name__ == "__main__":
    write_tables(TABLES)
