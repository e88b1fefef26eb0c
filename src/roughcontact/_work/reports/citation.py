"""What to cite: the program, the paper that it starts from, and the methods of a contact."""

from __future__ import annotations

import inspect
import re
import string
import unicodedata
from collections.abc import Iterable, Iterator
from typing import Any

import attrs

from roughcontact._base.checks import Part, choice
from roughcontact._base.registry import registries
from roughcontact._base.units import PlainText
from roughcontact._solve.problem import ContactProblem, problem_of
from roughcontact._solve.problem import Path as StatePath
from roughcontact._solve.solution import DEFAULT_AREA, ContactSolution, areas, versions
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# As in CITATION.cff (tests/package/test_unit_citation.py compares them); the year as in the licence.
TITLE = "roughcontact"
AUTHORS = "The roughcontact developers"
YEAR = 2026
ADDRESS = "https://github.com/roughcontact/roughcontact"
PAPER = "A numerical-analytical approach to determining the real contact area of rough surface contact"
JOURNAL = "Tribology - Materials, Surfaces & Interfaces"
PAPER_YEAR = 2020
PAPER_DOI = "10.1080/17515831.2020.1720382"
# Where in a book a formula stands.
_PLACE_IN_BOOK = re.compile(r", (?:sections?|sec\.|eqs?\.|ch\.|chapters?) .*")
_SECTION = re.compile(r"^References\n-+\n(.*?)(?=\n\n\w+\n-+\n|\Z)", re.DOTALL | re.MULTILINE)
_DOI_ADDRESS = "https://doi.org/"
_DOI = re.compile(r"https://doi\.org/(10\.[^\s;,]+[^\s;,.)])")
# A remark behind the reference before.
_REMARK = re.compile(r"^\([^)]*\)\s*")
# An article, of authors, journal, volume, year and pages; and a book.
_ARTICLE = re.compile(r"(.+), ([^,]+?) (\d+)(?:\(\w+\))? \((\d{4})\) ([\w-]+)")
_BOOK = re.compile(r"(.+), ([^,]+) \((\d{4})\)")
_YEAR = re.compile(r"\((\d{4})\)")
_OTHERS = " et al."


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


@guarded
def cite(*used: object, style: str = "text") -> str:
    """Return what to cite: this program, the paper that it starts from, and the methods that were used.

    Parameters
    ----------
    *used
        What was used: solutions, paths, problems, parts, their classes or registered names, such as ``"hertz"``. Of
        a solution these are its kernel, convolver and solver, its materials, surfaces and laws, and the default area.
        Their references are those of their docstrings that have a DOI.
    style
        ``"text"``, a line for each reference, or ``"bibtex"``.

    Raises
    ------
    InputError
        If there is no part of a name, or something else is given.

    Examples
    --------
    >>> import roughcontact as rc
    >>> print(rc.cite(rc.Love()).splitlines()[2])
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420. https://doi.org/10.1098/rsta.1929.0009
    >>> print(rc.cite("polonsky-keer", style="bibtex").split("@")[-1])
    article{polonsky1999,
      author = {Polonsky and Keer},
      journal = {Wear},
      volume = {231},
      year = {1999},
      pages = {206--219},
      doi = {10.1016/S0043-1648(99)00113-1},
    }
    """
    choice(style, "The style of references", ("text", "bibtex"))
    made = versions()[TITLE]
    references = list_references(made, [part for one in used for part in _list_parts(one)])
    if style == "text":
        return PlainText("\n".join(f"{one.text} {one.address}" for one in references))
    _, paper, *methods = references
    return PlainText("\n\n".join([write_bibtex(made), _write_paper(paper), *_write_entries(methods)]))


def list_references(version: str, parts: Iterable[object]) -> list[Reference]:
    """Return the references to cite: the program, its paper, and the DOIs in the docstrings of parts or classes."""
    listed = [
        Reference(f"{AUTHORS} ({YEAR}). {TITLE} {version} [software].", ADDRESS),
        Reference(f"{PAPER}. {JOURNAL} ({PAPER_YEAR}).", f"{_DOI_ADDRESS}{PAPER_DOI}"),
    ]
    for part in parts:
        listed += _references_in(inspect.getdoc(part if isinstance(part, type) else type(part)) or "")
    found: dict[str, Reference] = {}
    for one in listed:
        found.setdefault(one.address, one)
    return list(found.values())


def write_bibtex(version: str) -> str:
    """Return the program as an entry of BibTeX."""
    fields = {"author": f"{{{AUTHORS}}}", "title": TITLE, "version": version, "year": str(YEAR), "url": ADDRESS}
    return _write_entry("software", TITLE, fields)


def _list_parts(used: object) -> list[object]:
    """Return the parts of what was used, or the classes of a name."""
    if isinstance(used, StatePath):
        used = used.states[0]
    if isinstance(used, ContactSolution):
        used = problem_of(used)
    if isinstance(used, ContactProblem):
        # What it is solved by comes before what it is made of.
        return [*_walk(used.plan), *_walk(used), areas.resolve(DEFAULT_AREA)]
    if isinstance(used, str):
        known = registries().values()
        named: list[object] = [registry[used] for registry in known if used in registry]
        if not named:
            raise InputError.unknown("part", used, {name for registry in known for name in registry})
        return named
    if isinstance(used, type) and issubclass(used, Part):
        return [used]
    if isinstance(used, Part):
        return list(_walk(used))
    raise InputError.about("What is cited", used, "a solution, a path, a problem, a part, its class or its name")


def _walk(value: object) -> Iterator[object]:
    """Yield a part and the parts that are its fields."""
    if isinstance(value, Part):
        yield value
    cls: type[Any] = type(value)
    if attrs.has(cls):
        for field in attrs.fields(cls):
            inner = getattr(value, field.name)
            for one in inner if isinstance(inner, tuple) else (inner,):
                yield from _walk(one)


def _references_in(docstring: str) -> list[Reference]:
    """Return the references of a docstring: the text before each DOI in its section of references."""
    section = _SECTION.search(docstring)
    found = []
    for paragraph in section[1].split("\n\n") if section else ():
        start = 0
        for doi in _DOI.finditer(paragraph):
            text = _REMARK.sub("", " ".join(paragraph[start : doi.start()].split()).strip(" ,;-"))
            found.append(Reference(f"{_PLACE_IN_BOOK.sub('', text)}.", f"{_DOI_ADDRESS}{doi[1]}"))
            start = doi.end() + 1
    return found


def _write_paper(paper: Reference) -> str:
    fields = {"title": PAPER, "journal": JOURNAL, "year": str(PAPER_YEAR), "doi": PAPER_DOI}
    return _write_entry("article", f"{TITLE}-paper", fields)


def _write_entries(references: Iterable[Reference]) -> Iterator[str]:
    """Yield an entry of BibTeX for each reference, with keys such as ``love1929``, of which none is twice."""
    taken: dict[str, int] = {}
    for one in references:
        text = one.text.rstrip(".")
        doi = one.address.removeprefix(_DOI_ADDRESS)
        article = _ARTICLE.fullmatch(text)
        book = _BOOK.fullmatch(text)
        if article is not None:
            names, journal, volume, year, pages = article.groups()
            kind = "article"
            fields = {"journal": journal, "volume": volume, "year": year, "pages": pages.replace("-", "--")}
        elif book is not None:
            names, title, year = book.groups()
            kind = "book"
            fields = {"title": title, "year": year}
        else:
            names = text.partition(",")[0]
            stated = _YEAR.search(text)
            year = stated[1] if stated else ""
            kind = "misc"
            fields = {"note": text, **({"year": year} if year else {})}
        key = f"{_plain(re.split(', | and ', names)[0])}{year}"
        taken[key] = taken.get(key, 0) + 1
        suffix = string.ascii_lowercase[taken[key] - 1] if taken[key] > 1 else ""
        yield _write_entry(kind, f"{key}{suffix}", {"author": _write_authors(names), **fields, "doi": doi})


def _write_authors(names: str) -> str:
    is_short = names.endswith(_OTHERS)
    authors = re.split(r", | and ", names.removesuffix(_OTHERS))
    return " and ".join([*authors, *(["others"] if is_short else [])])


def _plain(name: str) -> str:
    """Return a name in lower case, without accents and signs, for a key."""
    letters = unicodedata.normalize("NFKD", name.removesuffix(_OTHERS)).lower()
    return "".join(letter for letter in letters if letter in string.ascii_lowercase)


def _write_entry(kind: str, key: str, fields: dict[str, str]) -> str:
    lines = "".join(f"  {name} = {{{value.replace('&', chr(92) + '&')}}},\n" for name, value in fields.items())
    return f"@{kind}{{{key},\n{lines}}}"
