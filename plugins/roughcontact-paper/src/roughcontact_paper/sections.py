"""Both sections of the paper, from the solves to the files."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from rich.console import Console
from roughcontact.results import RunIn

from roughcontact_paper import published
from roughcontact_paper.output import show_table, solve_all, write_results
from roughcontact_paper.pair_figures import draw_pair_figures
from roughcontact_paper.pair_tables import FORCES, STATES, solve_pair, tabulate_pairs
from roughcontact_paper.synthetic_pair import new_pair, run_in_pair
from roughcontact_paper.wave import solve_wave
from roughcontact_paper.wave_figures import draw_wave_figures
from roughcontact_paper.wave_tables import remarks, tabulate_waves


def recompute_wave(folder: Path, grids: tuple[int, ...]) -> None:
    """Section 3.1: write Tables 1 to 3 and Figures 3 to 6."""
    console = Console()
    cases = solve_all(
        [
            (f"{load} MPa on {cells} x {cells}", cells, partial(solve_wave, cells, load))
            for load in published.LOADS
            for cells in grids
        ],
        console,
    )
    tables = tabulate_waves(cases)
    for table in tables:
        show_table(table, console)
    console.print("\n[bold]Errors in the print[/bold]")
    for remark in remarks():
        console.print(f" - {remark}", highlight=False)
    names = write_results(tables, draw_wave_figures(cases), folder)
    console.print(f"\nWritten to {folder}: {', '.join(names)}", highlight=False)


def recompute_pair(folder: Path, grids: tuple[int, ...]) -> None:
    """Section 3.2 on the synthetic pair: write Tables 4 and 5, Figures 8 to 13 and the run-in height maps."""
    console = Console()
    maps = folder / f"run-in-{grids[-1]}.npz"

    def report(result: RunIn) -> None:
        flattened = f"{1e18 * result.cycles[-1].volume:.3g} um3 flattened"
        console.print(f"running in, cycle {len(result.cycles)} of a round: {flattened}", highlight=False)

    before = new_pair(grids[-1])
    pairs = dict(zip(STATES, (before, run_in_pair(before, maps, report)), strict=True))
    cases = solve_all(
        [
            (
                f"{state}, {force:g} N on {cells} x {cells}",
                cells,
                partial(solve_pair, state, pairs[state], force, cells),
            )
            for state in STATES
            for force in FORCES
            for cells in grids
        ],
        console,
    )
    tables = tabulate_pairs(cases)
    for table in tables:
        show_table(table, console)
    names = [*write_results(tables, draw_pair_figures(pairs, cases), folder), maps.name]
    console.print(f"\nWritten to {folder}: {', '.join(names)}", highlight=False)
