"""The table of docs/use/responses.md: whether the uncertainties of the responses hold on contacts of unkind geometry.

python docs/studies/responses.py
"""

from __future__ import annotations

import sys
from pathlib import Path

from doc_tables import DocTable, pick, write_tables

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


# The columns of the page.
SHOWN = ("class", "held-out: error, %", "held-out: within 2, %", "held-out: warned, %")
TABLES = {"responses": DocTable(make_rows, seconds=250, shown=pick(SHOWN))}

if __name__ == "__main__":
    write_tables(TABLES)
