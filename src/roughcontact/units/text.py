"""Lines of text that fit a terminal."""

from __future__ import annotations

import re
import textwrap

# Width of what is printed, characters: that of a terminal as it opens, and of a page of mail or of a log.
WIDTH = 80
# What stands before the text of a line: blanks, and a label with two blanks or more behind it.
_LABEL = re.compile(r"\s*(?:\S(?:\S| (?! ))*\s{2,})?")


def fit(text: str) -> str:
    """Return a text with the lines that are too long wrapped, and continued under their own text."""
    lines = []
    for line in text.split("\n"):
        if len(line) <= WIDTH:
            lines.append(line)
            continue
        label = _LABEL.match(line)
        indent = " " * min(label.end() if label else 0, WIDTH // 2)
        # Neither a path nor the name of an option is broken.
        lines += textwrap.wrap(line, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines)
