"""Rows and columns beside the heights of a table: their numbers, as pandas writes them, or the places x and y."""

from __future__ import annotations

import numpy as np

from roughcontact._base.checks import Array
from roughcontact.errors import InputError

# Fewer numbers are not looked at: they may rise in equal steps by chance.
_FEWEST = 8
# Part of a step by which a place may differ from its own: rounding of printed places.
_OFF = 0.01
_COUNT = "count"
_KEEP = "if they are heights, save the map with numpy.save"


def require_heights(table: Array) -> None:
    """Refuse a table, shape (rows, numbers in a row), that is a list, or has more than heights.

    A margin, its first row or column, rises in equal steps, and the row or column beside it does not.

    Raises
    ------
    InputError
        If the table has a margin, or many numbers in one row or column; the sentence says how to save it.
    """
    if min(table.shape) < 2 and table.size >= _FEWEST:
        line = "column" if table.shape[1] < 2 else "row"
        raise InputError(
            f"its {table.size} numbers stand in one {line}, but a height map has a row for each x and a number for "
            "each y: bring them into that shape, as by numpy.loadtxt(path).reshape(nx, ny), and save them again"
        )
    if min(table.shape) < 2:
        return
    # The corner, where there are both margins, belongs to neither.
    row, column = (_margin(side[0, 1:], side[1, 1:]) for side in (table, table.T))
    if row and column:
        what = "its first row and its first column"
        counts = row == column == _COUNT
    elif row := _margin(table[0], table[1]):
        what = "its first row"
        counts = row == _COUNT
    elif column := _margin(table[:, 0], table[:, 1]):
        what = "its first column"
        counts = column == _COUNT
    else:
        return
    skip = "skip them with skip_rows=" if what == "its first row" else "save the heights without them"
    found, advice = (
        ("count, as header and index of pandas do", ", in pandas by to_csv(path, header=False, index=False)")
        if counts
        else ("rise in equal steps, as places x and y do", ", and give size=")
    )
    raise InputError(f"the numbers of {what} {found}, and are not heights: {skip}{advice}; {_KEEP}")


def _margin(line: Array, beside: Array) -> str:
    """Return whether a line counts or has equal steps; nothing if it has none, or the line beside it has some."""
    if not _is_even(line) or _is_even(beside):
        return ""
    return _COUNT if line[0] in (0.0, 1.0) and np.array_equal(line, line[0] + np.arange(line.size)) else "steps"


def _is_even(line: Array) -> bool:
    """Tell whether a line of enough numbers rises or falls in equal steps."""
    if line.size < _FEWEST or not np.isfinite(line).all():
        return False
    # Numbers near the largest of float64 have no differences.
    with np.errstate(over="ignore", invalid="ignore"):
        step = (line[-1] - line[0]) / (line.size - 1)
        even = line[0] + step * np.arange(line.size)
        return bool(step != 0.0 and np.abs(line - even).max() <= _OFF * abs(step))
