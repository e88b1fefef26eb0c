"""List phrases that a reader would stumble over: `python .ci/phrases.py [FILE ...]`, by default in every text.

Prints file, line, phrase and what to say instead; the exit status is 1 if there is any. One idea has one word,
and that is the field's own where it has one (Johnson, *Contact Mechanics*; ISO 25178-2).
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
PLACES = ("src", "plugins", "docs", "benchmarks", "tests", ".github", "paper", "recipe", "*.md", "CITATION.cff")
# What lists the phrases itself.
EXCEPT = ("tests/house/test_phrases.py",)

# What is banned, as a regular expression, and what to say instead. A blank stands for any white space or a new line of
# a comment; a word is banned within names too, such as left_out.
PHRASES = {
    r"(?<!here\s)is no (?!longer|more|less|fewer|other)[a-z]\w*": "is not a",
    r"goes on (there|with)": "continues, repeats periodically",
    r"asked again": "is not deterministic",
    r"what (it|they) took": "cost",
    r"what (came|comes) out": "results",
    r"after a journey": "survives pickling",
    r"speaks? against": "no warnings",
    r"(hang|hangs|hung) together": "connected",
    r"(goes|go) with waves": "the shortest waves have ... cells",
    r"bears? the load|bearable": "carries the load, admissible",
    r"how far (it|they) may be off": "error bound",
    r"(stand-in|standin|stand_in)": "synthetic",
    r"at a approach": "at an approach",
    r"(is|are|was|were|be|been) told(?! apart)|tells of": "is given, says",
    r"undeformed": "initial gap",
    r"relief": "peak-to-valley height",
    r"doubts?": "warning",
    r"permanent sets?|PermanentSet": "flattening model",
    r"left[_\s]out|leaves?[_\s]out|leaving out": "omitted",
    r"(pressure|a|the|no|one) caps?": "pressure limit, hardness",
    r"few_cells": "area_std",
    r"(?-i:Offers[A-Z][a-z]+|Told|Holed|Gridded)": "Supports..., or a default of the base class",
    r"(height )?map('s)? holes?|holes? in (a|the) (height )?maps?": "non-measured points",
    r"greatest": "maximum, largest",
    r"(?<!at[_\s])least(?![-_\s]squares)": "minimum, smallest",
    r"(the|a|its|this) share|shares? of": "fraction",
    r"(its|their|the|this|that|a) bars?": "uncertainty, error bar",
    r"wholes|((?<!as\s)a|one|each|every) whole(?=[.,;:)])": "contact patch",
    r"cascades?": "nested iteration",
    r"(pieces?|spots?) of contact": "contact patch",
}


def pattern(phrase: str) -> re.Pattern[str]:
    """Compile a phrase that is not part of a longer word; underscores and hyphens end a word."""
    return re.compile(r"(?<![A-Za-z])(?:" + phrase.replace(" ", r"[\s#]+") + r")(?![A-Za-z])", re.IGNORECASE)


BANNED = [(pattern(phrase), say) for phrase, say in PHRASES.items()]


def find(text: str) -> Iterator[tuple[int, str, str]]:
    """Line, phrase and what to say instead, in the order of the text."""
    hits = [(match.start(), match[0], say) for banned, say in BANNED for match in banned.finditer(text)]
    for start, phrase, say in sorted(hits):
        yield text.count("\n", 0, start) + 1, " ".join(phrase.split()), say


def texts() -> list[Path]:
    """Every text of the repository that people read."""
    paths = [path for place in PLACES for path in ROOT.glob(place)]
    files = [file for path in paths for file in (path.rglob("*") if path.is_dir() else [path])]
    kinds = {".py", ".md", ".rst", ".cff", ".yml", ".yaml", ".toml"}
    return sorted(f for f in files if f.suffix in kinds and not {"_build", "build"} & set(f.parts))


def main(names: list[str]) -> int:
    """Print the phrases of the files; 1 if there is any."""
    count = 0
    for path in [Path(name).resolve() for name in names] or texts():
        shown = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else path.as_posix()
        if shown in EXCEPT:
            continue
        for line, phrase, say in find(path.read_text(encoding="utf-8")):
            print(f"{shown}:{line}: {phrase!r}: {say}")
            count += 1
    return int(count > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
