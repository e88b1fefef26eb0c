"""The table of docs/trust/compare.md: what the scripts of that page print.

python docs/studies/compare_with_us.py
"""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

from doc_tables import DocTable, write_tables

PAGE = Path(__file__).parent.parent / "trust" / "compare.md"
HEADING = ["contact", "quantity", "roughcontact", "closed form or theory"]


def make_rows() -> list[list[str]]:
    rows = [HEADING]
    for block in re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.S | re.M):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(block, PAGE.name, "exec"), {})
        rows += [line.split("; ") for line in printed.getvalue().splitlines()]
    return rows


TABLES = {"compare-with-us": DocTable(make_rows, seconds=12)}

if __name__ == "__main__":
    write_tables(TABLES)
