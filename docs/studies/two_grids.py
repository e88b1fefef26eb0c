"""The tables of docs/understand/edges.md on machined surfaces: flags, and uncertainties by a model and by two grids."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

from doc_tables import DocTable, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import stated_uncertainties as judged
from edged_classes import EDGED, SMOOTH

# A draw that no constant has seen, and contacts of each kind.
DRAW = 102
COUNT = 24
ANSWERS = tuple(judged.CHEAP)
GROUPS = {"smooth": SMOOTH, "machined": EDGED}
WAYS = {"model": "model", "auto": "default", "two grids": "two grids"}


@lru_cache(maxsize=1)
def judge() -> Mapping[str, list[judged.Judged]]:
    """Return all contacts by their group."""
    found = {}
    for name, kinds in GROUPS.items():
        rows = judged.judge_kinds(list(kinds), DRAW, COUNT, ANSWERS, list(WAYS))
        found[name] = [row for kind in rows.values() for row in kind]
    return found


def make_flags() -> list[list[str]]:
    heading = ["surfaces", "contacts", "pressure grows", "of these found", "others", "of these called unbounded"]
    rows = ((name, len(group), *judged.count_unbounded(group)) for name, group in judge().items())
    return [heading, *([str(cell) for cell in row] for row in rows)]


def make_coverage() -> list[list[str]]:
    heading = [
        "answer",
        "surfaces",
        "errors",
        *(f"{what}, {name}" for name in WAYS.values() for what in ("within two", "u/e")),
    ]
    rows = [heading]
    for answer in ANSWERS:
        for group, contacts in judge().items():
            cells = [judged.cover(contacts, answer, way) for way in WAYS]
            numbers = [text for one in cells for text in (f"{100 * one.within:.0f} %", f"{one.ratio:.1f}")]
            rows.append([answer.replace("-", " "), group, str(cells[0].count), *numbers])
    return rows


TABLES = {"flags": DocTable(make_flags, seconds=200), "two-grids": DocTable(make_coverage, seconds=200)}

if __name__ == "__main__":
    write_tables(TABLES)
