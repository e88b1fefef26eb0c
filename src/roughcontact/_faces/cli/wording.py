"""Sentences about arguments of functions, in the words of the command line."""

from __future__ import annotations

import re
from collections.abc import Iterable

# What an argument may be followed by in a sentence: both sides, a text or a number; not in calls, as of numpy.savez.
_VALUE = r"(?P<value>\((?:x, y|[-+.e0-9, ]+)\)(?:, m\b)?|'[^']*'|-?[0-9]+(?:\.[0-9]+)?(?:e-?[0-9]+)?)?(?=[\s,.;:)]|$)"
# "size=(x, y), m (on the command line --size)": what stands in brackets is the option.
_ASIDE = re.compile(r"\s*\(on the command line (?P<option>--[^()]*)\)")
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


def _option(found: re.Match[str]) -> str:
    name = found["name"]
    value = found["value"] or ""
    words = value if value[:1] == "'" and not value.strip("'").isalpha() else value.strip("'")
    if value.startswith("("):
        words = value.removesuffix(", m").strip("()").replace(",", "").replace("x y", "X Y")
    if name in _LENGTHS:
        words = re.sub(r"[0-9]+(?:\.[0-9]*)?(?:[eE]-?[0-9]+)?", r"\g<0>m", words)
    return f"--{name.replace('_', '-')} {words}".rstrip()
