"""Whether the uncertainties of the quantities hold on the fresh classes: two tables for plus_minus.py.

python docs/studies/quantities.py [FOLDER]   # where area_classes.py keeps its solutions
"""

from __future__ import annotations

import math
import sys
from functools import partial
from pathlib import Path

from doc_tables import DocTable, show_none, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import area_classes
import quantity_classes

# What is stated of a quantity in a class: the 95th percentile of the errors, the fraction of them within two standard
# deviations, and the median uncertainty over the median error.
PARTS = ("error, %", "within two", "u/e")


def make_rows(folder: Path | None = None, unkind: bool = False) -> list[list[str]]:
    found = {
        name: quantity_classes.report(
            list(quantity_classes.UNKIND) if unkind else quantity_classes.list_classes(name), "fresh", name, folder
        )
        for name in quantity_classes.NAMES
    }
    rows = [["class", *(f"{name.replace('-', ' ')}: {part}" for name in found for part in PARTS)]]
    for name in (*quantity_classes.CLASSES, *quantity_classes.UNKIND):
        if not any(name in table for table in found.values()):
            continue
        cells = []
        for table in found.values():
            row = table.get(name)
            if row is None:
                cells += [""] * len(PARTS)
                continue
            ratio = "" if math.isnan(row["ratio"]) else f"{row['ratio']:.1f}"
            error = 100 * row["95 %"] if row["95 %"] > area_classes.DIGITS else 0.0
            cells += [f"{error:.2g}", f"{row['within 2']:.2f}", ratio]
        rows.append([name, *cells])
    return rows


def make_tables(folder: Path | None = None) -> dict[str, DocTable]:
    return {
        "quantities": DocTable(partial(make_rows, folder), seconds=900, shown=show_none),
        "quantities-unkind": DocTable(partial(make_rows, folder, unkind=True), seconds=90, shown=show_none),
    }


TABLES = make_tables()

if __name__ == "__main__":
    write_tables(make_tables(Path(sys.argv[1]) if len(sys.argv) > 1 else None))
