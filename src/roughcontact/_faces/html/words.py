"""Texts as HTML may hold them, with the signs of print."""

from __future__ import annotations

import html
import re

# Units raised to a power, behind their number, and the sign of an uncertainty, as the project prints them in ASCII.
_RAISED_UNIT = re.compile(r"(?<=[ (])([nµm]?m)([23])\b")
_POWERS = {"2": "²", "3": "³"}
# Control characters that no HTML page may hold, whatever a file is called.
_FORBIDDEN = re.compile(r"[^\t\n\r\x20-\x7e\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def allowed(text: str) -> str:
    """Return a text whose characters that HTML does not allow have become question marks."""
    return _FORBIDDEN.sub("?", text)


def escape(text: object) -> str:
    """Return a text with its HTML escaped, for what is shown without templates; see `allowed`."""
    return html.escape(allowed(str(text)))


def typeset(text: str) -> str:
    """Return the words of `si` and `with_spread` with the signs of print."""
    return _RAISED_UNIT.sub(lambda found: found[1] + _POWERS[found[2]], text.replace("+-", "±"))
