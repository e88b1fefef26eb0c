"""Whether the uncertainty of the area holds: the fresh classes of benchmarks/area_classes.py.

Writes a table that docs/studies/plus_minus.py draws; the solutions are kept in a folder (15 minutes at first, then
one).

    python docs/studies/area_uncertainty.py [FOLDER]
"""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

from doc_tables import DocTable, show_none, write_tables

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import area_classes


def make_rows(folder: str | None = None) -> list[list[str]]:
    heading = [
        "class",
        "cases",
        "error, rms, %",
        "95 %, %",
        "median, %",
        "uncertainty, median, %",
        "within 1",
        "within 2",
    ]
    rows = [heading]
    place = Path(folder) if folder else None
    for name in area_classes.CLASSES:
        found = area_classes.judge([row[:3] for row in area_classes.estimate(name, "fresh", "blend", place)])
        parts = ("rms", "95 %", "median error", "median uncertainty")
        held = [f"{100 * found[key]:.0f} %" for key in ("within 1", "within 2")]
        rows.append([name, str(found["n"]), *(f"{100 * found[key]:.3g}" for key in parts), *held])
        print(" | ".join(rows[-1]), flush=True)
    return rows


TABLES = {"area-classes": DocTable(make_rows, seconds=900, shown=show_none)}

if __name__ == "__main__":
    folder = sys.argv[1] if len(sys.argv) > 1 else None
    write_tables({"area-classes": DocTable(partial(make_rows, folder), seconds=900, shown=show_none)})
