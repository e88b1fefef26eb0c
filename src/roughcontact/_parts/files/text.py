"""Height maps in text files, read line by line."""

from __future__ import annotations

import array
import codecs
import contextlib
import itertools
import math
import re
from collections.abc import Iterator
from pathlib import Path

import attrs
import numpy as np

from roughcontact._base.checks import Array
from roughcontact._parts.files.layout import Layout, find_layout, holds_heights, is_non_measured
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
# Lines of heights from which separator and decimal mark are found, and lines of a header that are kept.
_SAMPLE = 20
_HEADER = 1000
# A comment at the end of a line: the numbers of some C libraries hold the mark too, 1.#QNAN.
_COMMENT = re.compile(r"(?:^|(?<=[\s,;]))#.*", re.DOTALL)


@attrs.frozen(eq=False)
class Table:
    """The numbers of a text file, shape (rows, numbers in a row), NaN for an empty field, and the lines above them."""

    numbers: Array
    header: tuple[str, ...]


def read_table(path: Path, separator: str = "auto", decimal: str = "auto", skip_rows: int = 0) -> Table:
    """Return the numbers of a text file and its header.

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
            header: list[str] = []
            lines = _heights(enumerate(itertools.islice(text, skip_rows, None), skip_rows + 1), header)
            sample = list(itertools.islice(lines, _SAMPLE))
            if not sample:
                raise InputError(_nothing(header))
            layout = find_layout([content for _, content in sample], separator, decimal)
            numbers = _read_rows(itertools.chain(sample, lines), layout)
            _require_words(header, layout, numbers.shape[1])
            return Table(numbers, tuple(header))
    except UnicodeError:
        raise InputError(f"it begins like text in {encoding}, but is not: save it as plain text (UTF-8)") from None


def _nothing(header: list[str]) -> str:
    line = next((line.strip() for line in header if not line.startswith("#")), "")
    return f"it holds no numbers, and begins with {line[:_SHOWN]!a}" if line else "it holds no numbers"


def _heights(lines: Iterator[tuple[int, str]], header: list[str]) -> Iterator[tuple[int, str]]:
    """Yield the lines of heights with their places; those of words before the first go into the header."""
    begun = False
    waiting = list[tuple[int, str]]()
    for place, line in lines:
        content = _COMMENT.sub("", line).strip(" \r\n").replace('"', "")
        if "\0" in content:
            raise InputError("it is not text, although its name ends so: rename it, or save it as plain text (UTF-8)")
        holds = begun or (holds_heights(content) if content else False)
        if holds is False:
            # What looks like points that were not measured may be the rule below a title.
            waiting = waiting if not line.strip() else []
            header.extend([line.rstrip("\r\n")] if line.strip() and len(header) < _HEADER else [])
            continue
        waiting.extend([(place, content)] if content else [])
        if holds:
            yield from waiting
            begun = True
            waiting = []
    yield from waiting


def _read_rows(lines: Iterator[tuple[int, str]], layout: Layout) -> Array:
    numbers = array.array("d")
    columns = 0
    rows = 0
    ends = 0
    padded = 0
    for place, content in lines:
        # A line of tabs alone is a row without measured points, where tabs separate.
        if not content.strip() and layout.separator != "\t":
            continue
        row = _parse(content, layout, place)
        ended = layout.ends(content)
        columns = columns or len(row)
        # One separator at the end of a row, of some rows or of all, adds no point.
        if ended and len(row) == columns + 1:
            row.pop()
        elif not ended and len(row) == columns - 1 and ends == rows:
            row.append(math.nan)
            ended = True
            padded = place
        if len(row) != columns:
            raise InputError(
                f"line {place} has {len(row)} numbers, but the lines before it have {columns}: write nan for a point "
                "that was not measured; if those lines are a header, say how many lines with skip_rows="
            )
        numbers.extend(row)
        rows += 1
        ends = ends + ended
    if not rows:
        raise InputError("it holds no numbers")
    if padded and ends < rows:
        raise InputError(f"line {padded} has {columns - 1} numbers, but others have {columns}: write nan for its last")
    heights = np.frombuffer(numbers).reshape(rows, columns)
    return heights[:, :-1] if ends == rows else heights


def _require_words(header: list[str], layout: Layout, columns: int) -> None:
    """Refuse a line above the numbers that may be a row of them with a wrong first field."""
    for line in header:
        fields = layout.split(line.strip(" \r\n"))
        if line.startswith("#") or len(fields) != columns or columns < 3:
            continue
        if sum(_float(field) is not None for field in fields) > columns // 2:
            raise InputError(
                f"the line {line.strip()[:_SHOWN]!a} above its heights has as many fields as they have, most of them "
                "numbers: correct it, or skip the lines that are not heights with skip_rows="
            )


def _float(word: str) -> float | None:
    """Return the number, or None: Python also reads 1_000 and digits of other scripts."""
    try:
        return float(word) if word.isascii() and "_" not in word else None
    except ValueError:
        return None


def _parse(content: str, layout: Layout, place: int) -> array.array[float]:
    fields = layout.split(content)
    # What is too large for float64 is infinite to Python.
    if content.isascii() and "_" not in content:
        with contextlib.suppress(ValueError):
            row = array.array("d", map(float, fields))
            if not np.isinf(row).any():
                return row
    return array.array("d", (_number(field, layout, place) for field in fields))


def _number(field: str, layout: Layout, place: int) -> float:
    """Return the number in a field, NaN if the point was not measured."""
    word = field.strip()
    value = _float(word)
    if value is None:
        if is_non_measured(word):
            return math.nan
        other = "," if layout.decimal == "." else "."
        advice = f"give decimal={other!r} if that is its decimal mark" if other in word or " " in word else ""
        advice = advice or "lines above the heights that are not heights are skipped with skip_rows="
        raise InputError(
            f"line {place} holds {word[:_SHOWN]!a}, which is not a number: write numbers such as -1.5e-6, nan for a "
            f"point that was not measured, and comments behind #; {advice}"
        )
    if math.isinf(value) and word[-1].isdigit():
        raise InputError(f"line {place} holds {word[:_SHOWN]}, which is too large for a height in metres")
    return value
