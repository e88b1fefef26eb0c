"""Sentences about arguments of functions, in the words of the command line."""

from __future__ import annotations

import re
from collections.abc import Iterable

# What an argument may be followed by in a sentence: both sides, a text or a number; not in calls, as of numpy.savez.
_VALUE = r"(?P<value>\((?:x, y|[-+.e0-9, ]+)\)(?:, m\b)?|'[^']*'|-?[0-9]+(?:\.[0-9]+)?(?:e-?[0-9]+)?)?(?=[\s,.;:)]|$)"
# "size=(x, y), m (on the command line --size)": what stands in brackets is the option.
_ASIDE = re.compile(r"\s*\(on the command line (?P<option>--[^()]*)\)")
# What advice says in Python, by what the command line says instead.
_ADVICE = {
    "surface.detrend('plane'), on the command line --detrend plane": "--detrend plane",
    "or boundary='free'": "or --boundary free",
    "give a hardness (ElasticPerfectlyPlastic, on the command line --hardness)": "give --hardness",
    "5 µm is 5e-6, 210 GPa is 210e9;": "write 5um, 210GPa;",
    "unit= (on the command line --unit)": "--unit",
    "with non_measured='keep'": "with --non-measured keep",
    " (rc.beyond_resolution gives the range of areas)": "",
    "solver='spectral-gradient'": "--solver spectral-gradient",
}
# Lines may have been broken at each blank and behind each hyphen of a phrase.
_PHRASES = {
    re.compile(re.escape(phrase).replace(r"\ ", r"\s+").replace(r"\-", r"\-\s*")): words
    for phrase, words in _ADVICE.items()
}
# Arguments that are lengths.
_LENGTHS = ("size", "unit")


def name_options(sentence: str, names: Iterable[str]) -> str:
    """Return a sentence in which arguments such as ``skip_rows=2`` are options, ``--skip-rows 2``.

    `names` are those of the arguments that are options of the command.
    """
    known = "|".join(map(re.escape, names))
    argument = re.compile(rf"(?<![\w.])(?P<name>{known})={_VALUE}")
    aside = re.compile(argument.pattern + _ASIDE.pattern)
    sentence = aside.sub(lambda found: found["option"] if " " in found["option"] else _option(found), sentence)
    return _ASIDE.sub("", argument.sub(_option, sentence)) if argument.search(sentence) else sentence


def name_advice(text: str) -> str:
    """Return results and their warnings, wrapped or not, with options in place of the phrases of Python."""
    for phrase, words in _PHRASES.items():
        text = phrase.sub(words, text)
    return text


def _option(found: re.Match[str]) -> str:
    name = found["name"]
    value = found["value"] or ""
    words = value if value[:1] == "'" and not value.strip("'").isalpha() else value.strip("'")
    if value.startswith("("):
        words = value.removesuffix(", m").strip("()").replace(",", "").replace("x y", "X Y")
    if name in _LENGTHS:
        words = re.sub(r"[0-9]+(?:\.[0-9]*)?(?:[eE]-?[0-9]+)?", r"\g<0>m", words)
    return f"--{name.replace('_', '-')} {words}".rstrip()
