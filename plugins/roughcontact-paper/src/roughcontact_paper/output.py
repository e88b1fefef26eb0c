"""Tables on the terminal and in files, figures in files, and a progress bar."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import TypeVar

import attrs
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator
from rich import box
from rich.console import Console
from rich.padding import Padding
from rich.progress import Progress
from rich.table import Table as RichTable
from roughcontact.typing import replacing

from roughcontact_paper import published

Case = TypeVar("Case")

# Resolution of the figures, dots per inch.
_DPI = 150


@attrs.frozen
class Table:
    """A table of text cells.

    Attributes
    ----------
    name, title
        File name without ending, and heading.
    columns, rows
        Column headings, and a text for each of them in every row.
    notes
        Sentences below the table.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()


def show_table(table: Table, console: Console) -> None:
    """Print a table."""
    view = RichTable(
        title=table.title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, show_edge=False, padding=0
    )
    widths = [
        max(*(len(row[k]) for row in table.rows), *(len(word) for word in column.split()))
        for k, column in enumerate(table.columns)
    ]
    for column, width in zip(table.columns, widths, strict=True):
        view.add_column(column, justify="right", width=width)
    # A narrow terminal wraps lines rather than losing digits.
    console.width = max(console.width, sum(widths) + len(widths) - 1)
    several = len({row[0] for row in table.rows}) < len(table.rows)
    for row, following in zip_longest(table.rows, table.rows[1:]):
        # A line between loads that have several rows.
        view.add_row(*row, end_section=several and following is not None and following[0] != row[0])
    console.print()
    console.print(view)
    console.print()
    for note in table.notes:
        console.print(Padding(note, (0, 0, 0, 3)), highlight=False)


def write_results(tables: Iterable[Table], figures: Mapping[str, Figure], folder: Path) -> list[str]:
    """Write tables as CSV files and figures as PNG files; return the names of the files."""
    names = []
    for table in tables:
        names.append(f"{table.name}.csv")
        with replacing(folder / names[-1]) as partial, partial.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([table.columns, *table.rows])
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
