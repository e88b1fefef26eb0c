"""Tables, and the base of results, whose texts, files and pages are written here once."""

from __future__ import annotations

import abc
import csv
import html
import math
import os
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, TextIO, overload

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.arrays import RealArray
from roughcontact._base.registry import find_view
from roughcontact._base.units import WIDTH, Estimate, fit, scale_column, si, write_column
from roughcontact.errors import InputError, requiring

# Rows that are printed, and that a notebook shows: the first and the last ones of a longer table.
_MAX_PRINTED_ROWS = 40
_MAX_HTML_ROWS = 20
# Blanks between two columns of a text.
_COLUMN_GAP = "  "
# Typographic signs, and what stands for them in plain text.
_ASCII = str.maketrans({"±": "+-", "²": "2", "³": "3"})


@attrs.frozen(eq=False)
class Table:
    """Columns of one length by name: numbers, texts and estimates, for people and for programs.

    In a file or a data frame an estimate takes two columns, ``area`` and ``area_uncertainty``. In text it has the
    digits that its uncertainty allows, and the unit of the column stands in the heading.

    Attributes
    ----------
    columns
        Numbers, texts, `Estimate` or None, as many in each column as there are rows.
    units
        SI units of columns of numbers by name, empty for ratios; estimates have their own.
    left
        Names of the columns that a text aligns at the left.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.typing import Table
    >>> areas = [rc.Estimate(2.13e-10, 4e-12, "m2"), rc.Estimate(1.058e-9, 1.5e-11, "m2")]
    >>> table = Table({"load": [1.0, 5.0], "area": areas}, {"load": "N"})
    >>> print(table.to_text())
    load     area, µm2
     1 N  213.0 +- 4.0
     5 N    1058 +- 15
    """

    columns: Mapping[str, Sequence[Any] | RealArray] = attrs.field()
    units: Mapping[str, str] = attrs.Factory(dict)
    left: Collection[str] = ()

    @columns.validator
    def _check_lengths(self, attribute: Any, columns: Mapping[str, Sequence[Any] | RealArray]) -> None:
        lengths = {name: len(column) for name, column in columns.items()}
        if len(set(lengths.values())) > 1:
            raise InputError.about("The lengths of the columns", lengths, "one length for all")

    @classmethod
    def from_rows(
        cls,
        names: Sequence[str],
        rows: Iterable[Sequence[Any]],
        left: Collection[str] = (),
    ) -> Table:
        """Return the table of rows, each with one cell for every name."""
        if len(set(names)) < len(names):
            raise InputError.about("The names of the columns", list(names), "names that differ from each other")
        cells = list(rows)
        return cls({name: [row[place] for row in cells] for place, name in enumerate(names)}, left=left)

    def to_pandas(self) -> Any:
        """Return a `pandas.DataFrame` with the units in ``frame.attrs["units"]``."""
        with requiring("A data frame needs the package pandas: pip install 'roughcontact[table]'."):
            import pandas
        columns, units = self._separate()
        frame = pandas.DataFrame(
            {name: np.array(one) if isinstance(one, np.ndarray) else list(one) for name, one in columns.items()}
        )
        frame.attrs["units"] = units
        return frame

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write a CSV file with all digits, the units in the heading; completely or not at all."""
        with (
            replacing(checks.path(path, "The table")) as partial,
            partial.open("w", newline="", encoding="utf-8") as file,
        ):
            self.write(file)

    def write(self, file: TextIO) -> None:
        """Write the lines of `to_csv` to an open file."""
        columns, units = self._separate()
        writer = csv.writer(file)
        writer.writerow(f"{name} [{units[name] or 1}]" if name in units else name for name in columns)
        # Numbers of numpy would be written with the name of their type.
        writer.writerows(
            [value.item() if isinstance(value, np.generic) else value for value in row]
            for row in zip(*columns.values(), strict=True)
        )

    def to_text(self, width: int | None = WIDTH, keys: int = 1, max_rows: int | None = None) -> str:
        """Return the table as aligned lines.

        Parameters
        ----------
        width
            Characters of a line. A wider table is folded: blocks of whole columns stand below each other, and each
            begins with the first columns. None: it is never folded.
        keys
            How many of the first columns begin each block.
        max_rows
            Of more rows only the first and the last are shown, with the number of those between; None: all.
        """
        headings, rows = self.to_cells(max_rows)
        lines = [[cell.translate(_ASCII) for cell in line] for line in (headings, *rows)]
        widths = [max(len(line[place]) for line in lines) for place in range(len(headings))]
        justify = [str.ljust if name in self.left else str.rjust for name in self.columns]
        blocks = [
            [
                _COLUMN_GAP.join(justify[place](line[place], widths[place]) for place in places).rstrip()
                for line in lines
            ]
            for places in _fold(widths, keys, width)
        ]
        return "\n\n".join("\n".join(block) for block in blocks)

    def to_markdown(self) -> str:
        """Return the table as Markdown."""
        headings, rows = self.to_cells()
        rule = "|".join("---" if name in self.left else "---:" for name in self.columns)
        lines = (f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in rows)
        return "\n".join([f"| {' | '.join(headings)} |", f"|{rule}|", *lines])

    def to_html(self, *notes: str) -> str:
        """Return notes and the table as HTML for a notebook; of many rows the first and the last."""
        headings, rows = self.to_cells(_MAX_HTML_ROWS)
        lines = [_row(headings, "th"), *(_row(cells, "td") for cells in rows)]
        above = "".join(f"<div>{html.escape(note)}</div>" for note in notes)
        return f"{above}<table>{''.join(lines)}</table>"

    def to_cells(self, max_rows: int | None = None) -> tuple[list[str], list[list[str]]]:
        """Return the texts of headings and rows; see `to_text` for `max_rows`."""
        written = [self._write_column(name) for name in self.columns]
        rows = [list(row) for row in zip(*(cells for _, cells in written), strict=True)]
        if max_rows is not None and len(rows) > max_rows:
            half = max_rows // 2
            between = [f"... {len(rows) - 2 * half} more", *[""] * (len(written) - 1)]
            rows = [*rows[:half], between, *rows[-half:]]
        return [heading for heading, _ in written], rows

    def _write_column(self, name: str) -> tuple[str, list[str]]:
        """Return the heading of a column and its cells."""
        column = self.columns[name]
        estimates = [cell for cell in column if isinstance(cell, Estimate)]
        if not estimates:
            return name, [self._write_cell(name, cell) for cell in column]
        heading = name
        if len({one.unit for one in estimates}) == 1:
            numbers, unit = scale_column(estimates)
            heading += f", {unit}" if unit else ""
        else:
            numbers = [write_column([one])[0] for one in estimates]
        texts = iter(numbers)
        return heading, [next(texts) if isinstance(cell, Estimate) else self._write_cell(name, cell) for cell in column]

    def _write_cell(self, name: str, value: object) -> str:
        if isinstance(value, (float, np.floating)):
            unit = self.units.get(name, "")
            if math.isnan(value):
                return "-"
            return si(float(value), unit) if unit else f"{value:.4g}"
        return "" if value is None else str(value)

    def _separate(self) -> tuple[dict[str, Any], dict[str, str]]:
        """Return the columns, with values and uncertainties of estimates in columns of their own, and their units."""
        columns: dict[str, Any] = {}
        units: dict[str, str] = {}
        for name, column in self.columns.items():
            found = [cell if isinstance(cell, Estimate) else None for cell in column]
            known = list(dict.fromkeys(one.unit for one in found if one is not None))
            if not known:
                columns[name] = column
                units |= {name: self.units[name]} if name in self.units else {}
                continue
            columns[name] = [None if one is None else one.value for one in found]
            columns[f"{name}_uncertainty"] = [None if one is None else one.uncertainty for one in found]
            if len(known) == 1:
                units |= dict.fromkeys((name, f"{name}_uncertainty"), known[0])
            else:
                columns[f"{name}_unit"] = [None if one is None else one.unit for one in found]
        return columns, units


def _fold(widths: Sequence[int], keys: int, width: int | None) -> list[list[int]]:
    """Return the columns of each block: the first ones, and as many others as fit into the width."""
    first = list(range(min(keys, len(widths))))
    blocks: list[list[int]] = [[]]
    for place in range(len(first), len(widths)):
        wanted = [*first, *blocks[-1], place]
        needed = sum(widths[one] for one in wanted) + len(_COLUMN_GAP) * (len(wanted) - 1)
        if blocks[-1] and width is not None and needed > width:
            blocks.append([])
        blocks[-1].append(place)
    return [[*first, *block] for block in blocks]


def _row(cells: Iterable[str], tag: str) -> str:
    return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"


def make_dataset(variables: Mapping[str, Any], places: Mapping[str, Any], notes: Mapping[str, Any]) -> Any:
    """Return an `xarray.Dataset` of variables, coordinates and attributes; `MissingPackage` without xarray."""
    with requiring("Datasets need the package xarray: pip install 'roughcontact[store]'."):
        import xarray
    return xarray.Dataset(variables, coords=places, attrs=notes)


class Result:
    """What is returned, as a page and in a notebook."""

    __slots__ = ()

    @overload
    def to_html(self, path: None = None) -> str: ...

    @overload
    def to_html(self, path: str | os.PathLike[str]) -> None: ...

    def to_html(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """Return a report, one page of HTML that opens without a network, or write it to a file if a path is given.

        It needs the extra ``report``. Of several states, the page has all in a table and one in detail: that of the
        largest load, or the last of a path with friction.
        """
        return page_or_file(lambda: find_view("page")(self), path)

    def _repr_html_(self) -> str:
        shown: str = find_view("notebook")(self)
        return shown


class TableResult(Result, abc.ABC):
    """What is returned as rows: a table for programs, and one for people, with sentences above and below it."""

    __slots__ = ()

    @abc.abstractmethod
    def table(self) -> Table:
        """Return all rows, in SI units, with all digits; see `roughcontact.typing.Table`."""

    def to_pandas(self) -> Any:
        """Return the `table` as a `pandas.DataFrame`, in the units of ``frame.attrs["units"]`` (extra ``table``)."""
        return self.table().to_pandas()

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the `table` to a CSV file, completely or not at all; an existing file is replaced.

        It has all digits, in the units of its heading, as ``force [N]``.
        """
        self.table().to_csv(path)

    def short_table(self) -> Table:
        """Return the rows for people, which texts and pages show."""
        return self.table()

    def _list_head(self) -> Sequence[str]:
        """Return what stands above the rows."""
        return ()

    def _list_results(self) -> Mapping[str, str]:
        """Return the numbers of all rows together, by their names."""
        return {}

    def _list_notes(self) -> Sequence[str]:
        """Return what stands below the rows."""
        return ()

    @property
    def _keys(self) -> int:
        """How many of the first columns begin each block of a table wider than a line."""
        return 1

    def _list_warnings(self) -> Sequence[str]:
        return getattr(self, "warnings", ())

    def __str__(self) -> str:
        head = self._list_head()
        results = self._list_results()
        width = max(map(len, results), default=0) + 2
        above = [*head, ""] if head else []
        below = [f"{name:<{width}}{text}" for name, text in results.items()]
        below += [*self._list_notes(), *(f"warning: {text}" for text in self._list_warnings())]
        if head and below:
            below.insert(0, "")
        return "\n".join([*map(fit, above), self._write_rows(), *map(fit, below)])

    def _write_rows(self) -> str:
        """Return the rows as text."""
        return self.short_table().to_text(keys=self._keys, max_rows=_MAX_PRINTED_ROWS)

    def _repr_html_(self) -> str:
        results = [f"{name}: {text}" for name, text in self._list_results().items()]
        warnings = [f"Warning: {text}" for text in self._list_warnings()]
        return self.short_table().to_html(*self._list_head(), *results, *self._list_notes(), *warnings)


def page_or_file(make: Callable[[], Any], path: str | os.PathLike[str] | None) -> str | None:
    """Return the text of a page, or write it to a file and return None."""
    target = None if path is None else checks.path(path, "The report")
    text: str = make()
    if target is None:
        return text
    with replacing(target) as partial:
        partial.write_text(text, encoding="utf-8")
    return None
