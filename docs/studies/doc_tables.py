"""Tables of the pages: written by the scripts of this folder, compared with them by tests/pages/test_doc_tables.py.

    python docs/studies/doc_tables.py                  # the tables, their pages and their scripts
    python docs/studies/doc_tables.py NAME [NAME ...]  # compute these again and write them to their pages

In a page, or in several, a table stands between two comments:

    <!-- table: capped-ball, by docs/studies/capped_ball.py -->
    <!-- end of table -->

Its script has TABLES = {"capped-ball": DocTable(make_rows, seconds=20)}, where make_rows() returns lines of cells,
the heading first. All of them are kept in docs/tables/capped-ball.csv. A page shows what a reader needs to decide
something: DocTable(..., shown=pick(columns=["N", "error, %"])) leaves the others to that file, to which the page links.
With shown=show_none a figure of the page shows what the table holds, and nothing stands between the comments.

Where all lines take long, `some_of` names in make_rows() the cases that the tests compute again.
"""

from __future__ import annotations

import contextlib
import csv
import importlib
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from pathlib import Path
from typing import TypeVar

import attrs

ROOT = Path(__file__).resolve().parent.parent.parent
STORE = ROOT / "docs" / "tables"
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted(ROOT.glob("plugins/*/README.md"))]
MARKED = re.compile(
    r"<!-- table: (?P<name>[\w-]+), by (?P<script>[\w./-]+\.py) -->\n(?P<text>.*?)<!-- end of table -->", re.S
)
NUMBER = re.compile(r"[-+]?\d+(?:\.(?P<decimals>\d+))?(?:e(?P<exponent>[-+]?\d+))?")

Rows = Sequence[Sequence[str]]
T = TypeVar("T")
_IS_SOME = ContextVar("is_some", default=False)


@attrs.frozen
class DocTable:
    """A table of the pages: the function that computes its lines of cells, and how it is compared.

    Attributes
    ----------
    rows
        Returns the lines, each a list of cells; the first one is the heading.
    seconds
        CPU time of all lines. Computed again by the slow tests up to 60 s, with the cases of `some_of`, else by hand.
    timed
        Headings of columns that hold times, or depend on the machine: not compared.
    units
        By how much a number may differ from the stored one, in units of its last digit.
    shown
        Returns those of the stored lines and cells that the pages show, such as `pick` and `gather`; all by default.
    """

    rows: Callable[[], Rows]
    seconds: float
    timed: tuple[str, ...] = ()
    units: float = 1.0
    shown: Callable[[Rows], Rows] = list


def some_of(cases: Sequence[T], *places: int) -> Sequence[T]:
    """Return the cases of a table; inside `computing_some` only those at the places, at least one of each kind.

    Where draws follow one another, the places are the first ones. Rounds that a time is the median of are cases too.
    """
    return [cases[place] for place in places] if _IS_SOME.get() else cases


@contextlib.contextmanager
def computing_some() -> Iterator[None]:
    """Compute tables with the cases of `some_of` alone inside the context."""
    token = _IS_SOME.set(True)
    try:
        yield
    finally:
        _IS_SOME.reset(token)


def pick(columns: Sequence[str] = (), lines: Sequence[str] = ()) -> Callable[[Rows], Rows]:
    """Return a choice of columns by their headings, and of lines by how they begin, their cells joined by `; `."""

    def choose(rows: Rows) -> Rows:
        heading, *others = rows
        places = [heading.index(name) for name in columns] or range(len(heading))
        kept = [
            row for row in others if not lines or any(f"{'; '.join(row)}; ".startswith(f"{line}; ") for line in lines)
        ]
        return [[row[k] for k in places] for row in (heading, *kept)]

    return choose


def gather(groups: Mapping[str, Sequence[str]], columns: Mapping[str, str]) -> Callable[[Rows], Rows]:
    """Return a line for each group of lines, given by their first cells, with the range of each column over them.

    `columns` has the headings of the page by those of the file, that of the groups first.
    """

    def choose(rows: Rows) -> Rows:
        first, *others = columns
        by_name = {row[0]: dict(zip(rows[0], row, strict=True)) for row in rows[1:]}
        lines = [
            [name, *(span([by_name[member][column] for member in members]) for column in others)]
            for name, members in groups.items()
        ]
        return [[columns[first], *(columns[column] for column in others)], *lines]

    return choose


def show_none(rows: Rows) -> Rows:
    """Return no lines, for a table that a figure of its page shows."""
    return []


def span(cells: Sequence[str]) -> str:
    """Return the smallest and the largest of cells that hold one number each; empty ones do not count."""
    filled = sorted((cell for cell in cells if cell), key=lambda cell: float(cell.split()[0]))
    if not filled:
        return ""
    low, high = filled[0], filled[-1]
    return high if low == high else f"{low.split()[0]} to {high}"


def format_rows(rows: Rows) -> str:
    """Return the lines as a table of Markdown; nothing without lines."""
    if not rows:
        return ""
    heading, *lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([heading, "|---" * len(rows[0]) + "|", *lines])


def find_tables() -> dict[str, tuple[str, list[Path]]]:
    """Return the script and the pages of each table, by its name."""
    found: dict[str, tuple[str, list[Path]]] = {}
    for page in PAGES:
        for match in MARKED.finditer(page.read_text(encoding="utf-8")):
            script, pages = found.setdefault(match["name"], (match["script"], []))
            if script != match["script"]:
                raise SystemExit(f"table {match['name']}: {page.name} names another script than {pages[0].name}")
            pages.append(page)
    return found


def load_table(name: str) -> DocTable:
    """Return a table from its script."""
    script = ROOT / find_tables()[name][0]
    for folder in (script.parent, *ROOT.glob("plugins/*/src")):
        if str(folder) not in sys.path:
            sys.path.insert(0, str(folder))
    table: DocTable = importlib.import_module(script.stem).TABLES[name]
    return table


def write(name: str, rows: Rows, quiet: bool = False, shown: Callable[[Rows], Rows] = list) -> None:
    """Keep the lines of a table in its file, write those that are shown to its pages, and print all."""
    marked = find_tables()
    if name not in marked:
        raise SystemExit(f"no page has a table {name!r}; there are {', '.join(sorted(marked))}")
    STORE.mkdir(exist_ok=True)
    with (STORE / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)
    for page in marked[name][1]:
        text = page.read_text(encoding="utf-8")
        page.write_text(MARKED.sub(lambda match: _renew(match, name, shown(rows)), text), encoding="utf-8")
    if not quiet:
        print(f"{name}: written to {', '.join(page.name for page in marked[name][1])}\n{format_rows(rows)}")


def _renew(match: re.Match[str], name: str, rows: Rows) -> str:
    if match["name"] != name:
        return match[0]
    text = f"\n{format_rows(rows)}\n\n" if rows else ""
    return f"<!-- table: {name}, by {match['script']} -->\n{text}<!-- end of table -->"


def read(name: str) -> list[list[str]]:
    """Return the stored lines of a table."""
    with (STORE / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def compare(rows: Rows, stored: Rows, table: DocTable) -> list[str]:
    """Return a sentence for each cell in which computed and stored lines differ by more than the table allows."""
    if [len(row) for row in rows] != [len(row) for row in stored]:
        return [f"{len(rows)} lines, stored are {len(stored)}, or their cells differ in number"]
    skipped = {k for k, heading in enumerate(stored[0]) if heading in table.timed}
    return [
        f"line {i}, {stored[0][k]!r}: {cell!r}, stored is {kept!r}"
        for i, (row, old) in enumerate(zip(rows, stored, strict=True))
        for k, (cell, kept) in enumerate(zip(row, old, strict=True))
        if k not in skipped and not _alike(cell, kept, table.units)
    ]


def compare_some(rows: Rows, stored: Rows, table: DocTable) -> list[str]:
    """Return the sentences of `compare` for lines and columns that `computing_some` has left of a table.

    A line stands for the stored one, behind those of the lines before, from which it differs in the fewest cells.
    """
    if not rows[1:]:
        return ["no line was computed"]
    columns = [k for k, heading in enumerate(stored[0]) if heading in rows[0]]
    kept = [[row[k] for k in columns] for row in stored]
    sentences = compare(rows[:1], kept[:1], table)
    place = 1
    for row in rows[1:]:
        found = [compare([rows[0], row], [kept[0], old], table) for old in kept[place:]]
        if not found:
            return [*sentences, f"{row} is behind the last stored line"]
        nearest = min(found, key=len)
        sentences += nearest
        place += found.index(nearest) + 1
    return sentences


def _alike(cell: str, kept: str, units: float) -> bool:
    """Whether the texts agree and the numbers differ by no more than some units of their last digit."""
    if NUMBER.sub("#", cell) != NUMBER.sub("#", kept):
        return False
    for one, other in zip(NUMBER.finditer(cell), NUMBER.finditer(kept), strict=True):
        unit = max(10.0 ** (int(m["exponent"] or 0) - len(m["decimals"] or "")) for m in (one, other))
        if abs(float(one[0]) - float(other[0])) > (units + 1e-6) * unit:
            return False
    return True


def main(names: Sequence[str]) -> None:
    """List the tables, or compute some again."""
    if not names:
        for name, (script, pages) in sorted(find_tables().items()):
            print(f"{name:24} {script:40} {', '.join(str(page.relative_to(ROOT)) for page in pages)}")
    for name in names:
        table = load_table(name)
        write(name, table.rows(), shown=table.shown)


def write_tables(tables: Mapping[str, DocTable]) -> None:
    """Compute all tables of a script and write them."""
    for name, table in tables.items():
        write(name, table.rows(), shown=table.shown)


if __name__ == "__main__":
    main(sys.argv[1:])
