"""Tables of results: for pandas, xarray, CSV files and notebooks."""

from __future__ import annotations

import csv
import html
import math
import os
from collections.abc import Mapping, Sequence
from typing import Any, TextIO

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.units import si
from roughcontact.errors import MissingPackage

# Rows that a notebook shows: the first and the last ones of a longer table.
_SHOWN = 20


@attrs.frozen(eq=False)
class Table:
    """Columns of one length by name.

    Attributes
    ----------
    columns
        Numbers, texts or None, as many in each column as there are rows.
    units
        SI units of the columns that have one, by their names; empty for a ratio.
    """

    columns: Mapping[str, Sequence[Any] | checks.RealArray]
    units: Mapping[str, str] = attrs.Factory(dict)

    def to_pandas(self) -> Any:
        """Return a `pandas.DataFrame` with the units in ``frame.attrs["units"]``."""
        try:
            import pandas
        except ImportError:
            raise MissingPackage("A data frame needs the package pandas: pip install 'roughcontact[table]'.") from None
        frame = pandas.DataFrame(
            {name: np.array(one) if isinstance(one, np.ndarray) else list(one) for name, one in self.columns.items()}
        )
        frame.attrs["units"] = dict(self.units)
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
        writer = csv.writer(file)
        writer.writerow(f"{name} [{self.units[name] or 1}]" if name in self.units else name for name in self.columns)
        # Numbers of numpy would be written with the name of their type.
        writer.writerows(
            [value.item() if isinstance(value, np.generic) else value for value in row]
            for row in zip(*self.columns.values(), strict=True)
        )

    def to_html(self, *notes: str) -> str:
        """Return notes and a table of HTML for a notebook, with SI prefixes; of many rows the first and the last."""
        rows = list(zip(*self.columns.values(), strict=True))
        shown: list[Sequence[str]] = [
            [self._cell(*pair) for pair in zip(self.columns, row, strict=True)] for row in rows
        ]
        if len(rows) > _SHOWN:
            half = _SHOWN // 2
            between = [f"... {len(rows) - 2 * half} more", *[""] * (len(self.columns) - 1)]
            shown = [*shown[:half], between, *shown[-half:]]
        lines = [_row(self.columns, "th"), *(_row(cells, "td") for cells in shown)]
        above = "".join(f"<div>{html.escape(note)}</div>" for note in notes)
        return f"{above}<table>{''.join(lines)}</table>"

    def _cell(self, name: str, value: object) -> str:
        if isinstance(value, (float, np.floating)):
            unit = self.units.get(name, "")
            if math.isnan(value):
                return "-"
            return si(float(value), unit) if unit else f"{value:.4g}"
        return "" if value is None else str(value)


def _row(cells: Any, tag: str) -> str:
    return "<tr>" + "".join(f"<{tag}>{html.escape(str(cell))}</{tag}>" for cell in cells) + "</tr>"


def make_dataset(variables: Mapping[str, Any], places: Mapping[str, Any], notes: Mapping[str, Any]) -> Any:
    """Return an `xarray.Dataset` of variables, coordinates and attributes; `MissingPackage` without xarray."""
    try:
        import xarray
    except ImportError:
        raise MissingPackage("Datasets need the package xarray: pip install 'roughcontact[store]'.") from None
    return xarray.Dataset(variables, coords=places, attrs=notes)
