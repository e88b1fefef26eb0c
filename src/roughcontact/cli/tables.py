"""Tables on the terminal and in files."""

from __future__ import annotations

import csv
from itertools import zip_longest
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table as RichTable

from roughcontact.paper import Table


def show(table: Table, console: Console) -> None:
    """Print a table."""
    view = RichTable(title=table.title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD)
    for column in table.columns:
        view.add_column(column, justify="right")
    several = len({row[0] for row in table.rows}) < len(table.rows)
    for row, following in zip_longest(table.rows, table.rows[1:]):
        # A line between loads that have several rows.
        view.add_row(*row, end_section=several and following is not None and following[0] != row[0])
    console.print()
    console.print(view)
    for note in table.notes:
        console.print(f"   {note}", highlight=False)


def write(table: Table, folder: Path) -> None:
    """Write a table as a CSV file."""
    with (folder / f"{table.name}.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([table.columns, *table.rows])
