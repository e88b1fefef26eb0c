"""The table of docs/use/responses.md: whether the uncertainties of the responses hold on contacts of unkind geometry.

python docs/studies/responses.py
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from doc_tables import DocTable, gather, span, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import response_classes

SPLITS = ("tuned", "held-out")


def make_rows() -> list[list[str]]:
    found = {split: response_classes.report(list(response_classes.CLASSES), split) for split in SPLITS}
    rows = [["class", *(f"{split}: {part}" for split in SPLITS for part in ("error, %", "within 2, %", "warned, %"))]]
    for name in response_classes.CLASSES:
        row = [name]
        for split in SPLITS:
            judged = found[split][name]
            sizes = (f"{100 * judged[part]:.2g}" for part in ("median error", "median uncertainty", "unwarned"))
            row += [" / ".join(sizes), f"{100 * judged['within 2']:.0f}", f"{100 * judged['warned']:.0f}"]
        rows.append(row)
    return rows


# The lines and columns of the page.
CONTACTS = {
    "balls, ellipses: stiffness, conductance": (
        "stiffness-hertz",
        "tangential-hertz",
        "conductance-hertz",
        "film-hertz",
    ),
    "balls, ellipses: partial slip": ("partial-slip-hertz",),
    "balls, ellipses: stress, first yield": ("stress-hertz", "first-yield-hertz"),
    "rough: stiffness, conductance": (
        "stiffness-rough",
        "tangential-rough",
        "unlike-rough",
        "conductance-rough",
        "film-rough",
    ),
    "rough: partial slip": ("partial-slip-rough",),
    "rough: stress": ("stress-rough",),
    "rough: first yield": ("first-yield-rough",),
    "leakage, open gaps": ("leakage-open",),
    "leakage, tight gaps": ("leakage-tight",),
}
COLUMNS = {
    "class": "response",
    "held-out: error, %": "error, %",
    "held-out: within 2, %": "within two, %",
    "held-out: warned, %": "warned, %",
}


def join(cells: Sequence[str]) -> str:
    """Return the largest of each part of cells of several numbers, and the range of single ones."""
    if "/" not in cells[0]:
        return span(cells)
    return " / ".join(max(part, key=float) for part in zip(*(cell.split(" / ") for cell in cells), strict=True))


TABLES = {"responses": DocTable(make_rows, seconds=250, shown=gather(CONTACTS, COLUMNS, join))}

if __name__ == "__main__":
    write_tables(TABLES)
