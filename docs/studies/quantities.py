"""The table of docs/quantities.md: whether the uncertainties of the quantities hold on the fresh classes.

python docs/studies/quantities.py [FOLDER]   # where area_classes.py keeps its solutions
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from doc_tables import DocTable, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import quantity_classes


def make_rows(folder: Path | None = None) -> list[list[str]]:
    found = {
        name: quantity_classes.report(quantity_classes.list_classes(name), "fresh", name, folder)
        for name in quantity_classes.NAMES
    }
    rows = [["class", *(name.replace("-", " ") for name in found)]]
    for name in dict.fromkeys(name for table in found.values() for name in table):
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


TABLES = {"quantities": DocTable(make_rows, seconds=900)}

if __name__ == "__main__":
    place = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    write_tables({"quantities": DocTable(lambda: make_rows(place), seconds=900)})
