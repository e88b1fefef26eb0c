"""Elements of HTML, in which every text is escaped."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

# Units raised to a power, behind their number, and the sign of an uncertainty, as the project prints them in ASCII.
_RAISED = re.compile(r"(?<=[ (])([nµm]?m)([23])\b")
_POWERS = {"2": "²", "3": "³"}
# Control characters that no HTML page may hold, whatever a file is called.
_FORBIDDEN = re.compile(r"[^\t\n\r\x20-\x7e\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def escape(text: object) -> str:
    """Return a text in which nothing is an element; characters that HTML does not allow become question marks."""
    return html.escape(_FORBIDDEN.sub("?", str(text)))


def quantity(text: str) -> str:
    """Return the words of `si` and `with_spread`, escaped, with the signs of print."""
    raised = _RAISED.sub(lambda found: found[1] + _POWERS[found[2]], text.replace("+-", "±"))
    return escape(raised)


def tag(name: str, **attributes: str) -> str:
    """Return the tag that begins an element; ``class_`` stands for its class."""
    given = "".join(f' {key.rstrip("_")}="{escape(value)}"' for key, value in attributes.items())
    return f"<{name}{given}>"


def element(name: str, content: str, **attributes: str) -> str:
    """Return an element around what is HTML already."""
    return f"{tag(name, **attributes)}{content}</{name}>"


def section(title: str, *content: str, **attributes: str) -> str:
    """Return a part of the page under its heading."""
    return element("section", "\n".join([element("h2", escape(title)), *content]), **attributes) + "\n"


def table(rows: Mapping[str, str], caption: str, cell: Mapping[str, str] = MappingProxyType({}), **given: str) -> str:
    """Return a table of names, which are escaped, beside contents, which are HTML already; attributes of its cells."""
    body = "\n".join(
        element("tr", element("th", escape(name), scope="row", **cell) + element("td", content, **cell))
        for name, content in rows.items()
    )
    return element("table", element("caption", escape(caption)) + element("tbody", body), **given)


def grid(head: Sequence[str], rows: Iterable[Sequence[str]], caption: str) -> str:
    """Return a table of texts under their names; the first of each row names it."""
    names = "".join(element("th", escape(name), scope="col") for name in head)
    body = "\n".join(
        element(
            "tr", element("th", quantity(first), scope="row") + "".join(element("td", quantity(one)) for one in cells)
        )
        for first, *cells in rows
    )
    shown = element("thead", element("tr", names)) + element("tbody", body)
    return element("div", element("table", element("caption", escape(caption)) + shown), class_="grid")


def items(texts: Iterable[str], **attributes: str) -> str:
    """Return a list of texts, each escaped."""
    return element("ul", "".join(element("li", escape(text)) for text in texts), **attributes)
