"""What to cite for a solution: this package, the paper that it starts from, and the methods that were used."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable

import attrs

# These are those of CITATION.cff (tests/test_html.py compares them); the year is that of the licence.
TITLE = "roughcontact"
AUTHORS = "The roughcontact developers"
YEAR = 2026
ADDRESS = "https://github.com/roughcontact/roughcontact"
PAPER = "A numerical-analytical approach to determining the real contact area of rough surface contact"
JOURNAL = "Tribology - Materials, Surfaces & Interfaces"
PAPER_YEAR = 2020
PAPER_DOI = "10.1080/17515831.2020.1720382"
# Where in a book a formula stands.
_PLACE = re.compile(r", (?:sections?|sec\.|eqs?\.) .*")
_HEAD = "References\n----------\n"
_DOI = re.compile(r"https://doi\.org/(10\.[^\s;,]+[^\s;,.)])")


@attrs.frozen
class Reference:
    """One thing to cite.

    Attributes
    ----------
    text
        The reference, without its address.
    address
        Where it is found.
    """

    text: str
    address: str


def list_references(version: str, parts: Iterable[object]) -> list[Reference]:
    """Return what to cite: the program, its paper, and what the docstrings of parts name with a DOI."""
    found = [
        Reference(f"{AUTHORS} ({YEAR}). {TITLE} {version} [software].", ADDRESS),
        Reference(f"{PAPER}. {JOURNAL} ({PAPER_YEAR}).", f"https://doi.org/{PAPER_DOI}"),
    ]
    for part in parts:
        found += _references_in(inspect.getdoc(type(part)) or "")
    return list({one.address: one for one in reversed(found)}.values())[::-1]


def write_bibtex(version: str) -> str:
    """Return the program as an entry of BibTeX."""
    fields = {"author": f"{{{AUTHORS}}}", "title": TITLE, "version": version, "year": YEAR, "url": ADDRESS}
    lines = "".join(f"  {name} = {{{value}}},\n" for name, value in fields.items())
    return f"@software{{{TITLE},\n{lines}}}"


def _references_in(docstring: str) -> list[Reference]:
    """Return the references of a docstring: what stands before each DOI in its section of references."""
    _, _, section = docstring.partition(_HEAD)
    found = []
    start = 0
    for doi in _DOI.finditer(section := section.partition("\n\n")[0]):
        text = _PLACE.sub("", " ".join(section[start : doi.start()].split()).strip(" ,;-"))
        found.append(Reference(f"{text}.", f"https://doi.org/{doi[1]}"))
        start = doi.end() + 1
    return found
