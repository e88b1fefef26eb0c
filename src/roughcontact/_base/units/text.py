"""Lines of text that fit a terminal."""

from __future__ import annotations

import re
import textwrap

# Width of what is printed, characters: that of a terminal as it opens, and of a page of mail or of a log.
WIDTH = 80
# Control characters, those that turn the direction of writing among them.
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
# What stands before the text of a line: blanks, and a label with two blanks or more behind it.
_LABEL = re.compile(r"\s*(?:\S(?:\S| (?! ))*\s{2,})?")

# A blank behind a number, before a unit, and behind the sign of an uncertainty; and the blank that is not broken.
_TOGETHER = re.compile(r"(?<=\d) (?=%|[fpnµmkMGT]?(?:m[23]?|Pa|N|s)\b|\+- )|(?<=\+-) ")
_NO_BREAK = "\N{NO-BREAK SPACE}"


def printable(text: str) -> str:
    """Return a text with the characters that a terminal obeys, such as escape, written as in Python's source."""
    return _CONTROL.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def fit(text: str) -> str:
    """Return a text with the lines that are too long wrapped, and continued under their own text."""
    lines = []
    for line in text.split("\n"):
        if len(line) <= WIDTH:
            lines.append(line)
            continue
        label = _LABEL.match(line)
        indent = " " * min(label.end() if label else 0, WIDTH // 2)
        # Neither a path nor the name of an option is broken, nor a number from its unit or its uncertainty.
        kept = _TOGETHER.sub(_NO_BREAK, line)
        lines += textwrap.wrap(kept, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines).replace(_NO_BREAK, " ")
