"""Elements of HTML, in which every text is escaped, and how a report looks."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

# Units raised to a power, behind their number, and the sign of an uncertainty, as the project prints them in ASCII.
_RAISED_UNIT = re.compile(r"(?<=[ (])([nµm]?m)([23])\b")
_POWERS = {"2": "²", "3": "³"}
# Control characters that no HTML page may hold, whatever a file is called.
_FORBIDDEN = re.compile(r"[^\t\n\r\x20-\x7e\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
CSS = """
:root { color-scheme: light dark; --ink: #1b1f24; --soft: #57606a; --paper: #ffffff; --line: #d0d7de; --box: #f3f5f7;
  --good: #116329; --bad: #a40e26; --unsure: #7d4e00; --link: #0550ae; }
@media screen and (prefers-color-scheme: dark) { :root { --ink: #e6edf3; --soft: #9da7b3; --paper: #0d1117;
  --line: #3d444d; --box: #161b22; --good: #56d364; --bad: #ff8f88; --unsure: #e3b341; --link: #79b8ff; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 70rem; padding: 1rem; background: var(--paper); color: var(--ink);
  font: 1rem/1.45 system-ui, "Segoe UI", "Noto Sans", sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 1.5rem; line-height: 1.2; margin: 0 0 .25rem; }
h2 { font-size: 1.1rem; margin: 1.5rem 0 .4rem; }
p, ul { margin: .3rem 0; }
a { color: var(--link); }
.scene { color: var(--soft); }
.verdict { border-left: .35rem solid var(--good); padding: .3rem .7rem; background: var(--box); }
.verdict strong { color: var(--good); }
.failed { border-color: var(--bad); }
.failed strong { color: var(--bad); }
.warnings { border-left: .35rem solid var(--unsure); padding: .3rem .7rem; background: var(--box); }
.warnings h3 { font-size: 1rem; margin: 0; color: var(--unsure); }
.warnings ul { padding-left: 1.2rem; }
table { border-collapse: collapse; width: 100%; }
caption { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); }
th, td { text-align: left; vertical-align: top; padding: .2rem .6rem .2rem 0; border-bottom: 1px solid var(--line); }
th { font-weight: 600; width: 11rem; }
.answer { font-size: 1.15rem; }
.answer tr:first-child td { font-size: 1.5rem; line-height: 1.25; }
.grid { overflow-x: auto; overflow-wrap: normal; font-size: .8rem; }
.grid th { width: auto; } .grid th, .grid td { white-space: nowrap; } .grid thead th { white-space: normal; }
.note { color: var(--soft); font-size: .9rem; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 20rem), 1fr)); gap: 1rem; }
figure { margin: 0; } figure:only-child { max-width: 32rem; }
figure img { width: 100%; height: auto; display: block; background: #ffffff; border-radius: .25rem; }
figcaption { color: var(--soft); font-size: .85rem; }
code, pre { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: .85rem; }
pre { white-space: pre-wrap; background: var(--box); border: 1px solid var(--line); padding: .6rem; margin: .3rem 0; }
@media (max-width: 32rem) { th, td { display: block; width: auto; border: 0; padding: .1rem 0; }
  tr { display: block; border-bottom: 1px solid var(--line); padding: .25rem 0; } tbody, table { display: block; }
  .grid table { display: table; } .grid tbody { display: table-row-group; } .grid tr { display: table-row; }
  .grid th, .grid td { display: table-cell; padding: .2rem .6rem .2rem 0; border-bottom: 1px solid var(--line); } }
@page { size: A4; margin: 11mm; }
@media print {
  :root { color-scheme: light; }
  body { max-width: none; padding: 0; font-size: 7.6pt; line-height: 1.28; }
  h1 { font-size: 13pt; } h2 { font-size: 9.5pt; margin: 5pt 0 1.5pt; break-after: avoid; }
  table.answer { font-size: 9pt; } .answer tr:first-child td { font-size: 12pt; }
  th, td { padding: 1pt 5pt 1pt 0; } th { width: 30mm; }
  .grid { overflow: visible; font-size: 7pt; } .grid th { width: auto; }
  code, pre { font-size: 6.6pt; } pre { padding: 3pt; line-height: 1.2; } figcaption, .note { font-size: 6.8pt; }
  .figures { grid-template-columns: repeat(auto-fit, minmax(46mm, 1fr)); gap: 2mm; } figure { break-inside: avoid; }
  tr, .verdict, .warnings { break-inside: avoid; }
  section { break-inside: avoid; } section.pictures { break-inside: auto; }
  .columns { display: grid; grid-template-columns: 2fr 1fr; gap: 6mm; } .columns section:last-child th { width: 18mm; }
  a { color: inherit; text-decoration: none; }
}
"""


def escape(text: object) -> str:
    """Return a text with its HTML escaped; characters that HTML does not allow become question marks."""
    return html.escape(_FORBIDDEN.sub("?", str(text)))


def quantity(text: str) -> str:
    """Return the words of `si` and `with_spread`, escaped, with the signs of print."""
    raised = _RAISED_UNIT.sub(lambda found: found[1] + _POWERS[found[2]], text.replace("+-", "±"))
    return escape(raised)


def tag(name: str, **attributes: str) -> str:
    """Return the tag that begins an element; ``class_`` stands for its class."""
    given = "".join(f' {key.rstrip("_")}="{escape(value)}"' for key, value in attributes.items())
    return f"<{name}{given}>"


def element(name: str, content: str, **attributes: str) -> str:
    """Return an element around content that is HTML already."""
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
