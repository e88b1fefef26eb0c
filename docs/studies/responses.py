"""Whether the uncertainties of the responses hold on contacts of unkind geometry: a table for plus_minus.py.

python docs/studies/responses.py
"""

from __future__ import annotations

import sys
from pathlib import Path

from doc_tables import DocTable, show_none, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import response_classes

SPLITS = ("tuned", "held-out")
# What is kept of a class, by the words of `response_classes.report`.
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


TABLES = {"responses": DocTable(make_rows, seconds=250, shown=show_none)}

if __name__ == "__main__":
    write_tables(TABLES)
