"""The tables of docs/use/responses.md: whether the uncertainties of the quantities hold on the fresh classes.

python docs/studies/quantities.py [FOLDER]   # where area_classes.py keeps its solutions
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from doc_tables import DocTable, gather, span, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import area_classes
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
            error = 100 * row["95 %"] if row["95 %"] > area_classes.DIGITS else 0.0
            cells.append(f"{error:.2g}; {row['within 2']:.2f}; {ratio}")
        rows.append([name, *cells])
    return rows


# The lines of the page, and those of the second table.
CONTACTS = {
    "waves": ("wave-whole", "wave-random", "wave-other"),
    "balls, ellipses": ("ball-centred", "ball-random", "ellipse-centred", "ellipse-random"),
    "rough": ("rough-light", "rough-middle", "rough-heavy"),
    "rough with a lay": (
        *("lay-light", "lay-middle", "lay-heavy"),
        *("lay-turned-light", "lay-turned-middle", "lay-turned-heavy"),
    ),
    "strips": ("strips-axis", "strips-45", "strips-1:2"),
    "with a hardness": ("capped-rough", "capped-ball", "capped-punch"),
    "after running in": ("run-in-half", "run-in-own"),
    "cones, cubic tips": ("cone", "cubic"),
    "cut by a free border": ("border",),
    "filled points": ("holes-filled",),
    "blurred, interpolated maps": ("map-blurred", "map-upsampled"),
}
UNKIND_CONTACTS = {
    "balls and paraboloids": ("long-domain", "long-cells", "slender", "holes-outside", "blobs-outside"),
    "tips r^n, n from 1 to 1.5": ("tip-1", "tip-1.5"),
    "tips r^n, n from 2 to 4": ("tip-2", "tip-3", "tip-4"),
    "oblique strips on long cells": ("strips-unkind",),
    "lines": ("lines",),
}
# The columns of the page.
COLUMNS = {
    "class": "contact",
    "peak pressure": "maximum pressure",
    **{name: name for name in ("perimeter", "approach", "mean gap")},
}


def join(cells: Sequence[str]) -> str:
    """Return the range of the errors of some cells and their smallest fraction within two standard deviations."""
    filled = [cell.split("; ") for cell in cells if cell]
    if not filled:
        return ""
    return f"{span([error for error, _, _ in filled])}; {min(float(within) for _, within, _ in filled):.2f}"


def make_tables(folder: Path | None = None) -> dict[str, DocTable]:
    return {
        "quantities": DocTable(partial(make_rows, folder), seconds=900, shown=gather(CONTACTS, COLUMNS, join)),
        "quantities-unkind": DocTable(
            partial(make_rows, folder, unkind=True), seconds=90, shown=gather(UNKIND_CONTACTS, COLUMNS, join)
        ),
    }


TABLES = make_tables()

if __name__ == "__main__":
    write_tables(make_tables(Path(sys.argv[1]) if len(sys.argv) > 1 else None))
