"""``roughcontact paper --pairs``: section 3.2 of the paper, on a stand-in for its unpublished maps."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from roughcontact.cli.tables import show, write
from roughcontact.paper import printed
from roughcontact.paper.pair_figures import draw_pairs
from roughcontact.paper.pairs import FORCES, STATES, PairCase, pair_tables, run_pair
from roughcontact.paper.stand_in import fresh, worn
from roughcontact.problem import ContactProblem
from roughcontact.running_in import RunIn


def run(options: argparse.Namespace) -> None:
    """Make both pairs, solve all cases, print the tables, and write CSV files, figures and the run-in maps."""
    console = Console()
    folder = Path(options.output)
    folder.mkdir(parents=True, exist_ok=True)
    grids = printed.GRIDS if options.full else printed.GRIDS[:-1]
    maps = folder / f"run-in-{grids[-1]}.npz"
    pairs = _pairs(grids[-1], maps, console)
    cases = _solve(pairs, grids, console)
    tables = pair_tables(cases)
    for table in tables:
        show(table, console)
        write(table, folder)
    pictures = draw_pairs(pairs, cases, folder)
    names = ", ".join([*(f"{table.name}.csv" for table in tables), *(path.name for path in pictures), maps.name])
    console.print(f"\nWritten to {folder}: {names}", highlight=False)
    if not options.full:
        console.print("Maps and grid of 2048 x 2048 cells are left out; --full takes them.")


def _pairs(cells: int, maps: Path, console: Console) -> dict[str, ContactProblem]:
    before = fresh(cells)

    after = worn(before, maps, lambda result: console.print(_said(result), highlight=False))
    return dict(zip(STATES, (before, after), strict=True))


def _said(result: RunIn) -> str:
    last = result.cycles[-1]
    return f"running in, place {len(result.cycles)}: {last.volume * 1e18:.3g} um3 flattened"


def _solve(pairs: dict[str, ContactProblem], grids: tuple[int, ...], console: Console) -> list[PairCase]:
    todo = [(state, force, cells) for state in STATES for force in FORCES for cells in grids]
    with Progress(console=console, disable=not console.is_terminal, transient=True) as progress:
        bar = progress.add_task("solving", total=sum(cells**2 for *_, cells in todo))
        cases = []
        for state, force, cells in todo:
            progress.update(bar, description=f"{state}, {force:g} N on {cells} x {cells}")
            cases.append(run_pair(state, pairs[state], force, cells))
            progress.advance(bar, cells**2)
    return cases
