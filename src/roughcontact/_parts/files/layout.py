"""What separates the numbers of a text file, and their decimal mark: found from its first lines, or asked for."""

from __future__ import annotations

import re
from collections.abc import Sequence

import attrs

from roughcontact.errors import InputError

# The names of separators that are awkward to type, and how each is shown.
WORDS = {"tab": "\t", "blank": " "}
SEPARATORS = (",", ";", "\t", " ")
# What may separate fields, before it is known what does, and the part of a number with a decimal comma before that.
_FIELDS = re.compile(r"[\s,;]")
_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
# Fields of a point that was not measured; also what C libraries of Windows write for it.
_BAD = {"nan", "bad", "na", "n/a", "null", "none", "nodata", "no data", "invalid", "missing", "-", "inf", "infinity"}
_MARKED = re.compile(r"\*+|-{2,}|[-+]?(?:nan|inf(?:inity)?|1\.#\w+)", re.IGNORECASE)


# Lines of one comma, between digits.
_SINGLE = re.compile(r"(?:[-+]?[0-9]+,[0-9]+(?:\n|\Z))+")


def is_non_measured(word: str) -> bool:
    """Tell whether a field stands for a point that was not measured."""
    return not word or word.lower() in _BAD or _MARKED.fullmatch(word) is not None


def holds_heights(content: str) -> bool | None:
    """Tell whether a line holds heights; None if it may, because all its fields stand for points not measured.

    It does if it begins with a number or with a field of a point that was not measured, and has a number.
    """
    fields = _FIELDS.split(content)
    if all(map(is_non_measured, fields)):
        # A line of dashes is the rule below a title.
        return None if len(fields) > 1 else False
    first = fields[0]
    return bool(is_non_measured(first) or _NUMBER.fullmatch(first)) and any(map(_NUMBER.fullmatch, fields))


@attrs.frozen
class Layout:
    """The separator of the numbers, one of `SEPARATORS`, and their decimal mark.

    Blanks as a separator are any white space, and with decimal commas each number may be followed by a comma.
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
        """Tell whether a line ends with the separator."""
        return self.separator != " " and content.endswith(self.separator)


def find_layout(lines: Sequence[str], separator: str, decimal: str) -> Layout:
    """Return the layout of lines of heights; ``"auto"`` is found, what is not is kept.

    Raises
    ------
    InputError
        If commas may be decimal or separate numbers; the sentence names the options.
    """
    separator = WORDS.get(separator, separator)
    if separator == "auto":
        separator = _find_separator(lines, decimal)
    if decimal == "auto":
        text = "".join(lines)
        decimal = "," if separator != "," and "," in text and "." not in text else "."
    if separator == "," == decimal:
        raise InputError("a comma cannot both separate the numbers and be their decimal mark: give another separator=")
    return Layout(separator, decimal)


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
    """Return what separates numbers without points where there are commas, and perhaps blanks."""
    text = "\n".join(lines)
    inside = re.search(r"[0-9],[0-9]", text)
    beside = re.search(r", | ,", text)
    if not inside or (not beside and not _SINGLE.fullmatch(text) and " " not in text):
        return ","
    if not beside and " " in text:
        return " "
    found = "commas, some of them beside blanks," if beside else "one comma in each line"
    raise InputError(
        f"it has {found} and no points, so that the commas may be decimal or separate numbers: give decimal=',' or "
        "decimal='.'"
    )
