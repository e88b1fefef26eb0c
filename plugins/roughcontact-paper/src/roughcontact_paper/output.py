"""Tables on the terminal and in files, figures in files, and a progress bar."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import attrs
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator
from rich.console import Console
from rich.markup import escape
from rich.padding import Padding
from rich.progress import Progress
from roughcontact.typing import Table, replacing

from roughcontact_paper import published

Case = TypeVar("Case")

# Resolution of the figures, dots per inch.
_DPI = 150


@attrs.frozen
class PaperTable:
    """A table of the paper.

    Attributes
    ----------
    name, title
        File name without ending, and heading.
    cells
        A text for each column in every row.
    notes
        Sentences below the table.
    keys
        How many of the first columns begin each block of a table that is wider than the terminal.
    """

    name: str
    title: str
    cells: Table
    notes: tuple[str, ...] = ()
    keys: int = 2


def show_table(table: PaperTable, console: Console) -> None:
    """Print a table, folded to the width of a terminal; it is whole in a file and on a pipe."""
    text = table.cells.to_text(width=console.width if console.is_terminal else None, keys=table.keys)
    console.print(f"\n[bold]{escape(table.title)}[/bold]\n")
    console.print(text, markup=False, highlight=False, soft_wrap=True)
    console.print()
    for note in table.notes:
        console.print(Padding(note, (0, 0, 0, 3)), highlight=False)


def write_results(tables: Iterable[PaperTable], figures: Mapping[str, Figure], folder: Path) -> list[str]:
    """Write tables as CSV files and figures as PNG files; return the names of the files."""
    names = []
    for table in tables:
        names.append(f"{table.name}.csv")
        table.cells.to_csv(folder / names[-1])
    for name, figure in figures.items():
        names.append(f"{name}.png")
        content = io.BytesIO()
        figure.savefig(content, dpi=_DPI, format="png")
        with replacing(folder / names[-1]) as partial:
            partial.write_bytes(content.getvalue())
    return names


def solve_all(
    todo: Sequence[tuple[str, int, Callable[[], Case]]],
    console: Console,
) -> list[Case]:
    """Return the results of solves, each given by a description, its cells along a side and a function."""
    with Progress(console=console, disable=not console.is_terminal, transient=True) as progress:
        # The time of a solve is about proportional to its cells.
        bar = progress.add_task("solving", total=sum(cells**2 for _, cells, _ in todo))
        cases = []
        for description, cells, solve in todo:
            progress.update(bar, description=description)
            cases.append(solve())
            progress.advance(bar, cells**2)
    return cases


def label_grids(axes: Axes) -> None:
    """Make the x axis that of the paper's grids."""
    axes.set_xscale("log", base=2)
    axes.xaxis.set_major_locator(FixedLocator(published.GRIDS))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xticklabels([str(cells) for cells in published.GRIDS])
    axes.set_xlabel("cells along a side")
