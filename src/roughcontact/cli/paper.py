"""``roughcontact paper``: recompute the paper."""

from __future__ import annotations

import argparse
import csv
from itertools import zip_longest
from pathlib import Path

from rich import box
from rich.console import Console
from rich.progress import Progress
from rich.table import Table as RichTable

from roughcontact.paper import Case, Table, all_tables, printed, remarks, run_case
from roughcontact.paper.figures import draw_all


def run(options: argparse.Namespace) -> None:
    """Solve all cases, print the tables, and write CSV files and figures."""
    console = Console()
    folder = Path(options.output)
    folder.mkdir(parents=True, exist_ok=True)
    grids = printed.GRIDS if options.full else printed.GRIDS[:-1]
    cases = _solve(grids, console)
    for table in all_tables(cases):
        _show(table, console)
        _write(table, folder)
    console.print("\n[bold]Where the print is wrong[/bold]")
    for remark in remarks():
        console.print(f" - {remark}", highlight=False)
    pictures = draw_all(cases, folder)
    names = ", ".join(path.name for path in pictures)
    console.print(f"\nWritten to {folder}: table1.csv, table2.csv, table3.csv, {names}", highlight=False)
    if not options.full:
        console.print("The grid of 2048 x 2048 cells is left out; --full adds it.")


def _solve(grids: tuple[int, ...], console: Console) -> list[Case]:
    todo = [(load, cells) for load in printed.LOADS for cells in grids]
    # A case costs about as much as its cells; the bar counts them, so that its estimate of time holds.
    with Progress(console=console, disable=not console.is_terminal, transient=True) as progress:
        bar = progress.add_task("solving", total=sum(cells**2 for _, cells in todo))
        cases = []
        for load, cells in todo:
            progress.update(bar, description=f"{load} MPa on {cells} x {cells}")
            cases.append(run_case(cells, load))
            progress.advance(bar, cells**2)
    return cases


def _show(table: Table, console: Console) -> None:
    view = RichTable(title=table.title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD)
    for column in table.columns:
        view.add_column(column, justify="right")
    several = len(table.rows) > len(printed.LOADS)
    for row, following in zip_longest(table.rows, table.rows[1:]):
        # A line between loads that have several rows.
        view.add_row(*row, end_section=several and following is not None and following[0] != row[0])
    console.print()
    console.print(view)
    for note in table.notes:
        console.print(f"   {note}", highlight=False)


def _write(table: Table, folder: Path) -> None:
    with (folder / f"{table.name}.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([table.columns, *table.rows])
