"""Height maps in text files: headers, separators, rows and columns beside the heights, and lists of points."""

from __future__ import annotations

import array
import codecs
import contextlib
import io
import itertools
import math
import re
from collections.abc import Iterator, Sequence

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.files.plain import FORTRAN_EXPONENT, NON_MEASURED_WORDS, read_plain
from roughcontact.errors import InputError, argument, either

# Separators by the names of those that are awkward to type.
WORDS = {"tab": "\t", "blank": " "}
SEPARATORS = (",", ";", "\t", " ")
# Possible separators of fields, and a number or its part before a decimal comma, before the layout is known.
_FIELD_SEPARATOR = re.compile(r"[\s,;]")
_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][-+]?[0-9]+)?")
# Fields of a non-measured point, also those of spreadsheets.
_NON_MEASURED = re.compile(
    rf"{NON_MEASURED_WORDS}|[-+]?(?:nan|inf(?:inity)?)|#(?:n/a|nv|num!|value!|div/0!|ref!)", re.IGNORECASE
)
# Lines with a single comma, between digits.
_SINGLE_COMMA_LINES = re.compile(r"(?:[-+]?[0-9]+,[0-9]+(?:\n|\Z))+")
# Minimum numbers of a margin: fewer may rise in equal steps by chance.
_MIN_MARGIN_NUMBERS = 8
# Rounding of printed positions in a margin, over the step.
_STEP_TOLERANCE = 0.01
# Decimals of printed positions at most, and their rounding in float64.
_MAX_POSITION_DECIMALS = 6
_DECIMAL_TOLERANCE = 1e-6
_COUNTING_MARGIN = "count"
_KEEP_ADVICE = f"if they are heights, save the map {either('with numpy.save', 'as .npy or .mat')}"
# Byte-order mark of each encoding; the longer ones first, because they begin with the shorter.
_BYTE_ORDER_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF32_LE: "utf-32",
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
# What separates names of columns.
_SEPARATED = re.compile(r"[,;\t]")
# Bytes that are not UTF-8.
_BYTES = re.compile("[\udc80-\udcff]")
# Bytes at the beginning from which the encoding is found, and those of numbers and letters.
_BEGINNING_BYTES = 64
_PRINTABLE = bytes(range(32, 127)) + b"\t\r\n"
# Characters of a wrong field or line that a message repeats.
_MAX_QUOTED_CHARACTERS = 40
# Lines of heights from which the layout is found, and lines of a header that are kept.
_SAMPLE_LINES = 20
_MAX_HEADER_LINES = 1000
# Rows of numbers of one length above a line of words from which that line is a footer.
_MIN_ROWS_ABOVE = 3
# A quoted field, one with a decimal comma, and what an instrument writes for a non-measured point.
_QUOTED = re.compile(r'"([^"]*)"')
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]*,[0-9]*(?:[eE][-+]?[0-9]+)?")
_NO_DATA = re.compile(r"\bno data\b", re.IGNORECASE)
# The minus sign of typography; and other marks than commas that separate thousands.
_MINUS = "\N{MINUS SIGN}"
_OTHER_THOUSANDS = re.compile("[-+]?[0-9]{1,3}(?:['\u2019\u202f\u00a0\u2009][0-9]{3})+(?:[.,][0-9]*)?")
# A number with commas that may separate thousands, and one without.
_THOUSANDS = re.compile(r"[-+]?[0-9]{1,3}(?:,[0-9]{3})+")
_WHOLE = re.compile(r"[-+]?[0-9]+")
# An exponent of Fortran.
_FORTRAN = re.compile(FORTRAN_EXPONENT)
# A factor that MATLAB shows above a matrix.
SHOWN_FACTOR = re.compile(r"\s*([0-9.]+e[-+][0-9]+) \*\s*")
# A comment at the end of a line, but not the mark in 1.#QNAN, nor an error of Excel.
_COMMENT = re.compile(r"(?:^|(?<=[\s,;]))#(?!n/a|nv\b|num!|value!|div/0!|ref!).*", re.DOTALL | re.IGNORECASE)


def is_non_measured(word: str) -> bool:
    """Return whether a field stands for a non-measured point."""
    return not word or _NON_MEASURED.fullmatch(word) is not None


def holds_heights(content: str) -> bool | None:
    """Return whether a line holds heights: it has a number, and begins with one or with a non-measured point.

    None: it may, because all its fields stand for non-measured points.
    """
    if SHOWN_FACTOR.fullmatch(content):
        return False
    fields = _FIELD_SEPARATOR.split(content)
    if all(map(is_non_measured, fields)):
        # A line of dashes is the rule below a title.
        return None if len(fields) > 1 else False
    first = fields[0]
    if is_non_measured(first) and not all(is_non_measured(one) or _NUMBER.fullmatch(one) for one in fields):
        # A line of a header, such as "Invalid data value: 9999".
        return False
    return bool(is_non_measured(first) or _NUMBER.fullmatch(first)) and any(map(_NUMBER.fullmatch, fields))


@attrs.frozen
class Layout:
    """The separator of the numbers, one of `SEPARATORS`, and their decimal mark.

    A blank as separator stands for any white space; then a comma may follow each number with a decimal comma.
    """

    separator: str
    decimal: str

    def split(self, content: str) -> list[str]:
        """Return the fields of a line, with decimal points."""
        if self.decimal == ",":
            if self.separator == " ":
                return [field.removesuffix(",").replace(",", ".") for field in content.split()]
            content = content.replace(",", ".")
        return content.split(None if self.separator == " " else self.separator)

    def ends(self, content: str) -> bool:
        """Return whether a line ends with the separator."""
        return self.separator != " " and content.endswith(self.separator)


def decode_latin(line: str) -> str:
    """Return a line whose bytes that are not UTF-8 are read as letters of Latin-1."""
    if line.isascii() or not _BYTES.search(line):
        return line
    return line.encode("utf-8", "surrogateescape").decode("latin-1")


def find_layout(lines: Sequence[str], separator: str, decimal: str) -> Layout:
    """Return the layout of lines of heights; what is given as ``"auto"`` is found.

    `InputError` if commas may be decimal or separate numbers; the message names the options.
    """
    separator = WORDS.get(separator, separator)
    given = decimal
    if separator == "auto":
        separator = _find_separator(lines, decimal)
    if decimal == "auto":
        text = "".join(lines)
        decimal = "," if separator != "," and "," in text and "." not in text else "."
    if decimal == "," and given == "auto":
        _refuse_thousands(lines, separator)
    if separator == "," == decimal:
        raise InputError(
            f"a comma cannot both separate the numbers and be their decimal mark: give another {argument('separator')}"
        )
    return Layout(separator, decimal)


def _refuse_thousands(lines: Sequence[str], separator: str) -> None:
    """Refuse commas that may separate thousands: three digits follow each, and other numbers have none."""
    fields = [one.strip() for line in lines for one in line.split(None if separator == " " else separator)]
    with_comma = [one.removesuffix(",") for one in fields if "," in one.removesuffix(",")]
    if with_comma and all(map(_THOUSANDS.fullmatch, with_comma)) and any(map(_WHOLE.fullmatch, fields)):
        raise InputError(
            f"it holds numbers such as {with_comma[0]} beside whole ones, so that the commas may separate thousands: "
            f"give {argument('decimal', ',')} if they are decimal, or write the numbers without separators of thousands"
        )


def _find_separator(lines: Sequence[str], decimal: str) -> str:
    # Blanks, and a single tab, at the end of a line separate nothing.
    stripped = [line.strip(" ") if line.count("\t") > 1 else line.strip() for line in lines]
    for mark in ";\t":
        if any(mark in line for line in stripped):
            return mark
    if decimal == "," or not any("," in line for line in stripped):
        return " "
    if decimal == "." or any("." in line for line in stripped):
        return ","
    return _judge_commas(stripped)


def _judge_commas(lines: Sequence[str]) -> str:
    """Return the separator of numbers without points in lines with commas."""
    text = "\n".join(lines)
    inside = re.search(r"[0-9],[0-9]", text)
    beside = re.search(r", | ,", text)
    if not inside or (not beside and not _SINGLE_COMMA_LINES.fullmatch(text) and " " not in text):
        return ","
    if not beside and " " in text:
        return " "
    found = "commas, some of them beside blanks," if beside else "one comma in each line"
    raise InputError(
        f"it has {found} and no points, so that the commas may be decimal or separate numbers: "
        + either(
            f"give {argument('decimal', ',')} or {argument('decimal', '.')}",
            "write decimals with points, or separate the numbers by semicolons",
        )
    )


def require_heights(table: Array) -> None:
    """Refuse a table, shape (rows, numbers in a row), that is a list, or has a margin of positions or counts.

    A margin is a first row or column that rises in equal steps, unlike the row or column beside it.
    """
    if min(table.shape) < 2:
        if table.size < _MIN_MARGIN_NUMBERS:
            return
        line = "column" if table.shape[1] < 2 else "row"
        raise InputError(
            f"its {table.size} numbers stand in one {line}, but a height map has a row for each x and a number for "
            f"each y: bring them into that shape{either(', as by numpy.loadtxt(path).reshape(nx, ny),')} and save "
            "them again"
        )
    # The corner, where there are both margins, belongs to neither.
    candidates = {
        "its first row and its first column": [_margin(side[0, 1:], side[1, 1:]) for side in (table, table.T)],
        "its first row": [_margin(table[0], table[1])],
        "its first column": [_margin(table[:, 0], table[:, 1])],
    }
    what = next((what for what, kinds in candidates.items() if all(kinds)), "")
    if not what:
        return
    skip = "save the heights without them"
    if what == "its first row":
        skip = either(f"skip them with {argument('skip_rows')}", "delete that row")
    found, advice = (
        ("count, as header and index of pandas do", either(", in pandas by to_csv(path, header=False, index=False)"))
        if set(candidates[what]) == {_COUNTING_MARGIN}
        else ("rise in equal steps, as places x and y do", f", and give {argument('size')}")
    )
    raise InputError(f"the numbers of {what} {found}, and are not heights: {skip}{advice}; {_KEEP_ADVICE}")


def _margin(line: Array, beside: Array) -> str:
    """Return ``"count"`` or ``"steps"`` if a line, unlike the one beside it, counts or has equal steps; else empty."""
    if not _is_even(line) or _is_even(beside):
        return ""
    return (
        _COUNTING_MARGIN if line[0] in (0.0, 1.0) and np.array_equal(line, line[0] + np.arange(line.size)) else "steps"
    )


def _is_even(line: Array) -> bool:
    """Return whether a line of enough numbers rises or falls in equal steps."""
    if line.size < _MIN_MARGIN_NUMBERS or not np.isfinite(line).all():
        return False
    # Numbers near the largest of float64 have no differences.
    with np.errstate(over="ignore", invalid="ignore"):
        step = (line[-1] - line[0]) / (line.size - 1)
        even = line[0] + step * np.arange(line.size)
        # Positions are printed with a few decimals, and each may be half of the last one off at both ends of a step.
        allowed = max(_STEP_TOLERANCE * abs(step), min(_find_rounding(line), 0.5 * abs(step)))
        return bool(step != 0.0 and np.abs(line - even).max() <= allowed)


def _find_rounding(line: Array) -> float:
    """Return the last decimal with which all numbers of a line are printed; zero if there are many."""
    for decimals in range(_MAX_POSITION_DECIMALS):
        scaled = line * 10.0**decimals
        if np.abs(scaled - np.rint(scaled)).max() < _DECIMAL_TOLERANCE:
            return float(10.0**-decimals)
    return 0.0


@attrs.frozen(eq=False)
class Table:
    """The numbers of a text file, shape (rows, numbers in a row), NaN for an empty field, and the lines above them.

    `blank` is the first line between the numbers that is blank, where not all lines are divided so; else None.
    """

    numbers: Array
    header: tuple[str, ...]
    blank: int | None = None


def read_table(data: bytes, separator: str = "auto", decimal: str = "auto", skip_rows: int = 0) -> Table:
    """Return the numbers in the bytes of a text file and its header; `InputError` if they are not a table of numbers.

    The message names the line.
    """
    encoding = next((name for mark, name in _BYTE_ORDER_MARKS.items() if data.startswith(mark)), "")
    encoding = encoding or _find_encoding(data[:_BEGINNING_BYTES])
    # Comments may be in any encoding.
    errors = "surrogateescape" if encoding.startswith("utf-8") else "strict"
    try:
        with io.TextIOWrapper(io.BytesIO(data), encoding=encoding, errors=errors) as text:
            header: list[str] = []
            lines = _heights(enumerate(itertools.islice(text, skip_rows, None), skip_rows + 1), header)
            sample = list(itertools.islice(lines, _SAMPLE_LINES))
            if not sample:
                raise InputError(_nothing(header))
            layout = find_layout([content for _, content in sample], separator, decimal)
            numbers = None
            blank = None
            if not layout.ends(sample[0][1]):
                numbers = read_plain(data, encoding, layout.separator, layout.decimal, sample[0][0])
            if numbers is None:
                numbers, blank = _read_rows(itertools.chain(sample, lines), layout)
            _require_words(header, layout, numbers.shape[1])
            return Table(numbers, tuple(header), blank)
    except UnicodeError:
        raise InputError(f"it begins like text in {encoding}, but is not: save it as plain text (UTF-8)") from None


def _find_encoding(start: bytes) -> str:
    """Return the encoding of a text without a byte-order mark: in UTF-16, each second byte of numbers is zero."""
    for zeros, others, name in ((start[1::2], start[::2], "utf-16-le"), (start[::2], start[1::2], "utf-16-be")):
        if zeros and not any(zeros) and not others.translate(None, _PRINTABLE):
            return name
    return "utf-8"


def _nothing(header: list[str]) -> str:
    line = next((line.strip() for line in header if not line.startswith("#")), "")
    return f"it holds no numbers, and begins with {line[:_MAX_QUOTED_CHARACTERS]!a}" if line else "it holds no numbers"


def _heights(lines: Iterator[tuple[int, str]], header: list[str]) -> Iterator[tuple[int, str]]:
    """Yield the lines of heights with their line numbers; lines of words before them go into the header."""
    begun = False
    comments: list[str] = []
    waiting = list[tuple[int, str]]()
    words = ""
    for place, line in lines:
        content = _clean(_COMMENT.sub("", line).strip(" \r\n"))
        if "\0" in content:
            raise InputError("it is not text, although its name ends so: rename it, or save it as plain text (UTF-8)")
        holds = begun or (holds_heights(content) if content else False)
        if begun and not content and line.strip(" \r\n"):
            # A comment between numbers, such as the name of the next channel.
            words = words or line.strip()
            comments.append(line.rstrip("\r\n"))
        elif begun and content and words:
            raise InputError(
                f"the line {words[:_MAX_QUOTED_CHARACTERS]!a} stands between its numbers, as where a second table or "
                "channel begins: keep the heights alone"
            )
        if holds is False:
            # A line that looks like non-measured points may be the rule below a title.
            waiting = waiting if not line.strip() else []
            header.extend([line.rstrip("\r\n")] if line.strip() and len(header) < _MAX_HEADER_LINES else [])
            continue
        waiting.extend([(place, content)] if content else [])
        if holds:
            yield from waiting
            begun = True
            waiting = []
    yield from waiting
    # Comments below the numbers state as much as those above them.
    header.extend(comments[:_MAX_HEADER_LINES])


def _clean(content: str) -> str:
    """Return a line with its quotation marks resolved, and the two words of a non-measured point as one."""
    if '"' in content:
        content = _QUOTED.sub(_unquote, content)
    content = content.replace(_MINUS, "-") if _MINUS in content else content
    return _NO_DATA.sub("nan", content) if "o" in content or "O" in content else content


def _unquote(quoted: re.Match[str]) -> str:
    """Return a quoted field; a comma in it does not separate, so that it is a decimal mark."""
    text = quoted[1]
    if "," not in text:
        return text
    if _DECIMAL_COMMA.fullmatch(text.strip()):
        return text.replace(",", ".")
    raise InputError(
        f"it holds {quoted[0][:_MAX_QUOTED_CHARACTERS]}, whose commas may separate thousands: write numbers without "
        "separators of thousands"
    )


def _read_rows(lines: Iterator[tuple[int, str]], layout: Layout) -> tuple[Array, int | None]:
    numbers = array.array("d")
    gaps: list[int] = []
    last = 0
    columns = 0
    rows = 0
    ends = 0
    padded = 0
    for place, content in lines:
        # A line of tabs alone is a row without measured points, where tabs separate.
        if not content.strip() and layout.separator != "\t":
            continue
        row = _parse(content, layout, place, rows)
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
                "that was not measured; if those lines are a header, "
                + either(f"say how many lines with {argument('skip_rows')}", "delete them")
            )
        gaps.extend([place - 1] if last and place > last + 1 else [])
        last = place
        numbers.extend(row)
        rows += 1
        ends = ends + ended
    if not rows:
        raise InputError("it holds no numbers")
    if padded and ends < rows:
        raise InputError(f"line {padded} has {columns - 1} numbers, but others have {columns}: write nan for its last")
    heights = np.frombuffer(numbers).reshape(rows, columns)
    return heights[:, :-1] if ends == rows else heights, gaps[0] if 0 < len(gaps) < rows - 1 else None


def _require_words(header: list[str], layout: Layout, columns: int) -> None:
    """Refuse a line of the header that may be a row of numbers with a wrong first field."""
    for line in header:
        fields = layout.split(line.strip(" \r\n"))
        if line.startswith("#") or len(fields) != columns or columns < 3:
            continue
        if sum(_float(field) is not None for field in fields) > columns // 2:
            raise InputError(
                f"the line {line.strip()[:_MAX_QUOTED_CHARACTERS]!a} above its heights has as many fields as they "
                "have, most of them numbers: correct it, or "
                + either(
                    f"skip the lines that are not heights with {argument('skip_rows')}",
                    "delete the lines that are not heights",
                )
            )


def require_no_index(header: Sequence[str], columns: int) -> None:
    """Refuse a table whose columns have names, but the first: it is an index, or places."""
    for line in header:
        first, *others = _SEPARATED.split(line.strip(" \r\n"))
        if not first.strip(' "') and len(others) == columns - 1 > 1 and all(one.strip(' "') for one in others):
            raise InputError(
                f"the line {line.strip()[:_MAX_QUOTED_CHARACTERS]!a} names all columns but the first, which is then no "
                "column of heights, but an index or places: save the heights without it"
            )


def _float(word: str) -> float | None:
    """Return the number, or None: Python also reads 1_000 and digits of other scripts, but not Fortran's 1.0D-03."""
    word = _FORTRAN.sub("e", word)
    try:
        return float(word) if word.isascii() and "_" not in word else None
    except ValueError:
        return None


def _parse(content: str, layout: Layout, place: int, rows: int) -> array.array[float]:
    fields = layout.split(content)
    # Python reads a number too large for float64 as infinite.
    if content.isascii() and "_" not in content:
        with contextlib.suppress(ValueError):
            row = array.array("d", map(float, fields))
            if not np.isinf(row).any():
                return row
    return array.array("d", (_number(field, layout, place, rows) for field in fields))


def _number(field: str, layout: Layout, place: int, rows: int) -> float:
    """Return the number in a field, NaN for a non-measured point; `rows` of numbers stand above it."""
    word = field.strip()
    value = _float(word)
    if value is None:
        if is_non_measured(word):
            return math.nan
        other = "," if layout.decimal == "." else "."
        named = f"give {argument('decimal', other)} if that is its decimal mark"
        advice = either(named, "write decimals with points") if other in word else ""
        if (advice and layout.decimal in word) or _OTHER_THOUSANDS.fullmatch(word):
            advice = "write numbers without separators of thousands"
        if not advice and rows >= _MIN_ROWS_ABOVE:
            advice = f"{rows} rows of numbers stand above it: if they are all, remove this line and those below it"
        advice = advice or either(
            f"lines above the heights that are not heights are skipped with {argument('skip_rows', place)}",
            "delete lines that are not heights",
        )
        raise InputError(
            f"line {place} holds {word[:_MAX_QUOTED_CHARACTERS]!a}, which is not a number: write numbers such as "
            f"-1.5e-6, nan for a point that was not measured, and comments behind #; {advice}"
        )
    if math.isinf(value) and word[-1].isdigit():
        raise InputError(
            f"line {place} holds {word[:_MAX_QUOTED_CHARACTERS]}, which is too large for a height in metres"
        )
    return value
