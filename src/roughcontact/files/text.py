"""Height maps in text files, read line by line."""

from __future__ import annotations

import array
import codecs
import contextlib
import math
from pathlib import Path
from typing import TextIO

import numpy as np

from roughcontact.checks import Array
from roughcontact.errors import InputError

# What stands at the beginning of a file in each encoding; the longer one first, because it begins with the shorter.
_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF32_LE: "utf-32",
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
# Characters of a wrong field or line that are shown.
_SHOWN = 40


def read_table(path: Path) -> Array:
    """Return the numbers of a text file, shape (rows, numbers in a row), NaN for an empty field.

    Raises
    ------
    InputError
        If it is not a table of numbers; the sentence gives the line.
    """
    with path.open("rb") as file:
        start = file.read(4)
    encoding = next((name for mark, name in _MARKS.items() if start.startswith(mark)), "utf-8")
    # Comments may be in any encoding.
    errors = "surrogateescape" if encoding.startswith("utf-8") else "strict"
    try:
        with path.open(encoding=encoding, errors=errors) as text:
            return _read_rows(text)
    except UnicodeError:
        raise InputError(f"it begins like text in {encoding}, but is not: save it as plain text (UTF-8)") from None


def _read_rows(text: TextIO) -> Array:
    numbers = array.array("d")
    separator, columns, rows, ends = "", 0, 0, 0
    for place, line in enumerate(text, 1):
        content = line.partition("#")[0].strip(" \r\n")
        # A line of tabs alone is a row without measured points, where tabs separate.
        if not content or (not content.strip() and rows and separator != "\t"):
            continue
        if "\0" in content:
            raise InputError("it is not text, although its name ends so: rename it, or save it as plain text (UTF-8)")
        separator = _separator(content, separator, place)
        row = _parse(content, separator, place)
        columns = columns or len(row)
        if len(row) != columns:
            raise InputError(
                f"line {place} has {len(row)} numbers, but the lines before it have {columns}: write nan for a point "
                "that was not measured"
            )
        numbers.extend(row)
        rows, ends = rows + 1, ends + bool(separator and content.endswith(separator))
    if not rows:
        raise InputError("it holds no numbers")
    heights = np.frombuffer(numbers).reshape(rows, columns)
    return heights[:, :-1] if ends == rows else heights


def _separator(content: str, before: str, place: int) -> str:
    """Return what separates the numbers of a line: a mark, or nothing where blanks do."""
    marks = {mark for mark in ",;\t" if mark in (content.strip() or content)} | ({before} if before else set())
    if len(marks) > 1:
        raise InputError(
            f"it uses {' and '.join(map(repr, sorted(marks)))} up to line {place}; only one may separate numbers, and "
            "they have a decimal point, not a comma"
        )
    return marks.pop() if marks else ""


def _parse(content: str, separator: str, place: int) -> array.array[float]:
    fields = content.split(separator or None)
    # Python also reads 1_000 and digits of other scripts, and takes what is too large for infinite.
    if content.isascii() and "_" not in content:
        with contextlib.suppress(ValueError):
            row = array.array("d", map(float, fields))
            if not np.isinf(row).any():
                return row
    return array.array("d", (_number(field, separator, place) for field in fields))


def _number(field: str, separator: str, place: int) -> float:
    """Return the number in a field, NaN if it is empty."""
    word = field.strip()
    if not word:
        return math.nan
    try:
        value = float(word) if word.isascii() and "_" not in word else None
    except ValueError:
        value = None
    if value is None:
        comma = "; if its commas are decimal, replace them by points" if separator == "," and " " in word else ""
        raise InputError(
            f"line {place} holds {word[:_SHOWN]!a}, which is not a number{comma}: write numbers such as -1.5e-6, "
            "and begin lines of text with #"
        )
    if math.isinf(value) and word[-1].isdigit():
        raise InputError(f"line {place} holds {word[:_SHOWN]}, which is too large for a height in metres")
    return value
