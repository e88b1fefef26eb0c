"""The tables of docs/understand/quantities.md: whether the uncertainties of the quantities hold on the fresh classes.

python docs/studies/quantities.py [FOLDER]   # where area_classes.py keeps its solutions
"""

from __future__ import annotations

import math
import sys
from functools import partial
from pathlib import Path

from doc_tables import DocTable, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import quantity_classes


def make_rows(folder: Path | None = None, unkind: bool = False) -> list[list[str]]:
    found = {
        name: quantity_classes.report(
            list(quantity_classes.UNKIND) if unkind else quantity_classes.list_classes(name), "fresh", name, folder
        )
        for name in quantity_classes.NAMES
    }
    rows = [["class", *(name.replace("-", " ") for name in found)]]
    for name in (*quantity_classes.CLASSES, *quantity_classes.UNKIND):
        if not any(name in table for table in found.values()):
            continue
        cells = []
        for table in found.values():
            row = table.get(name)
            if row is None:
                cells.append("")
                continue
            ratio = "-" if math.isnan(row["ratio"]) else f"{row['ratio']:.1f}"
            cells.append(f"{100 * row['95 %']:.2g}; {row['within 2']:.2f}; {ratio}")
        rows.append([name, *cells])
    return rows


def make_tables(folder: Path | None = None) -> dict[str, DocTable]:
    return {
        "quantities": DocTable(partial(make_rows, folder), seconds=900),
        "quantities-unkind": DocTable(partial(make_rows, folder, unkind=True), seconds=90),
    }


TABLES = make_tables()

if __name__ == "__main__":
    write_tables(make_tables(Path(sys.argv[1]) if len(sys.argv) > 1 else None))
