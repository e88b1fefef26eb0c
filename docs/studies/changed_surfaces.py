"""Whether the uncertainties hold on surfaces that loads have changed, a table of docs/understand/memory.md.

python docs/studies/changed_surfaces.py [FILE]   # where the true values are kept
"""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

from doc_tables import DocTable, pick, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import memory_classes
import stated_uncertainties as judged

# A draw that no constant has seen, and contacts of each kind.
DRAW = 87263
COUNT = 16
NAMES = {"peak-pressure": "maximum pressure", "mean-gap": "mean gap"}


ANSWERS = [NAMES.get(answer, answer) for answer in memory_classes.ANSWERS]


def make_rows(references: Path | None = None) -> list[list[str]]:
    """Return a line for each history: of each answer the contacts within two standard deviations, and u/e."""
    rows = [["history", *(heading for answer in ANSWERS for heading in (answer, f"{answer}, u/e"))]]
    found = memory_classes.judge_kinds(list(memory_classes.HISTORIES), DRAW, COUNT, references)
    for kind, contacts in found.items():
        judgements = [judged.cover(contacts, answer, "model") for answer in memory_classes.ANSWERS]
        rows.append([kind.replace("-", " "), *(cell for one in judgements for cell in describe(one))])
    return rows


def describe(found: judged.Coverage) -> tuple[str, str]:
    """Return how many contacts are within two standard deviations, and the median uncertainty over the error."""
    if not found.count:
        return "", ""
    return f"{round(found.within * found.count)} of {found.count}", f"{found.ratio:.1f}"


def make_tables(references: Path | None = None) -> dict[str, DocTable]:
    shown = pick(["history", *ANSWERS])
    return {"changed-surfaces": DocTable(partial(make_rows, references), seconds=250, shown=shown)}


TABLES = make_tables()

if __name__ == "__main__":
    write_tables(make_tables(Path(sys.argv[1]) if len(sys.argv) > 1 else None))
