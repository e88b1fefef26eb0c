"""The table of docs/use/responses.md: whether the uncertainties of the responses hold on contacts of unkind geometry.

python docs/studies/responses.py
"""

from __future__ import annotations

import sys
from pathlib import Path

from doc_tables import DocTable, gather, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import response_classes

SPLITS = ("tuned", "held-out")
# What is shown of a class, by the words of `response_classes.report`.
PARTS = {
    "median error": "median error",
    "median uncertainty": "median uncertainty",
    "largest error without a warning": "unwarned",
    "within two": "within 2",
    "warned": "warned",
}


def make_rows() -> list[list[str]]:
    found = {split: response_classes.report(list(response_classes.CLASSES), split) for split in SPLITS}
    rows = [["class", *(f"{split}: {part}, %" for split in SPLITS for part in PARTS)]]
    for name in response_classes.CLASSES:
        row = [name]
        for split in SPLITS:
            judged = found[split][name]
            row += [f"{float(f'{100 * judged[key]:.2g}'):g}" for key in PARTS.values()]
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
COLUMNS = {"class": "response"} | {f"held-out: {part}, %": f"{part}, %" for part in PARTS}

TABLES = {"responses": DocTable(make_rows, seconds=250, shown=gather(CONTACTS, COLUMNS))}

if __name__ == "__main__":
    write_tables(TABLES)
