"""The tables of docs/use/responses.md: whether the uncertainties of the quantities hold on the fresh classes.

python docs/studies/quantities.py [FOLDER]   # where area_classes.py keeps its solutions
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from doc_tables import DocTable, Rows, span, write_tables

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
QUANTITIES = {
    "peak pressure": "maximum pressure",
    **{name: name for name in ("perimeter", "approach", "mean gap")},
}


def show(contacts: Mapping[str, Sequence[str]], rows: Rows) -> Rows:
    """Return a line for groups of classes: the range of the errors, and the smallest fraction within two, %."""
    by_name = {row[0]: dict(zip(rows[0], row, strict=True)) for row in rows[1:]}
    shown = [["contact", *(f"{name}, %" for name in QUANTITIES.values()), "within two, %"]]
    for contact, classes in contacts.items():
        errors = [span([by_name[name][f"{one}: error, %"] for name in classes]) for one in QUANTITIES]
        fractions = [by_name[name][f"{one}: within two"] for name in classes for one in QUANTITIES]
        shown.append([contact, *errors, f"{100 * min(float(one) for one in fractions if one):.0f}"])
    return shown


def make_tables(folder: Path | None = None) -> dict[str, DocTable]:
    return {
        "quantities": DocTable(partial(make_rows, folder), seconds=900, shown=partial(show, CONTACTS)),
        "quantities-unkind": DocTable(
            partial(make_rows, folder, unkind=True), seconds=90, shown=partial(show, UNKIND_CONTACTS)
        ),
    }


TABLES = make_tables()

if __name__ == "__main__":
    write_tables(make_tables(Path(sys.argv[1]) if len(sys.argv) > 1 else None))
