"""``roughcontact paper``: recompute section 3.1 of the paper."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from roughcontact.cli.tables import show, write
from roughcontact.paper import Case, all_tables, printed, remarks, run_case
from roughcontact.paper.figures import draw_all


def run(options: argparse.Namespace) -> None:
    """Solve all cases, print the tables, and write CSV files and figures."""
    console = Console()
    folder = Path(options.output)
    folder.mkdir(parents=True, exist_ok=True)
    grids = printed.GRIDS if options.full else printed.GRIDS[:-1]
    cases = _solve(grids, console)
    for table in all_tables(cases):
        show(table, console)
        write(table, folder)
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
