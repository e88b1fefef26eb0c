"""Sentences that name arguments as data, so that each face spells them: ``skip_rows=2``, ``--skip-rows 2``, a control.

A sentence is written as any other; an argument in it is written by `argument`, and advice that only some faces can
follow by `either`. Both return a text with marks, which `Sentence` reads: nobody sees them.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from typing import NamedTuple

# Characters for private use, which no sentence has, between which the parts of a mark stand.
_BEGIN = "\ue000"
_END = "\ue001"
_CHOOSE = "\ue002"
_OTHERWISE = "\ue003"
_CHOSEN = "\ue004"
_ARGUMENT = re.compile(f"{_BEGIN}([^{_BEGIN}-{_CHOSEN}]*){_END}")
_EITHER = re.compile(f"{_CHOOSE}([^{_OTHERWISE}{_CHOSEN}]*){_OTHERWISE}([^{_CHOSEN}]*){_CHOSEN}")

# Types of a value that is meant.
_PLAIN = (str, int, float)


class Argument(NamedTuple):
    """An argument, as a sentence names it: its name, the values that are meant, if any, their unit, and a call for it.

    The call is what Python says where it has no such argument.
    """

    name: str
    values: tuple[str | float, ...] = ()
    unit: str = ""
    call: str = ""

    def __str__(self) -> str:
        """Return it as Python writes it; words of several values, such as x and y, stand for numbers."""
        if self.call or not self.values:
            return self.call or f"{self.name}="
        if len(self.values) == 1:
            (one,) = self.values
            return f"{self.name}={repr(one) if isinstance(one, str) else write_number(one)}"
        shown = f"{self.name}=({', '.join(one if isinstance(one, str) else write_number(one) for one in self.values)})"
        return f"{shown}, {self.unit}" if self.unit and isinstance(self.values[0], str) else shown


def write_number(value: float) -> str:
    """Return a number with as few digits as state it exactly."""
    short = f"{value:.12g}"
    return short if float(short) == value else repr(value)


# Returns an argument as a face spells it; empty where the face has no such field.
Spell = Callable[[Argument], str]


def argument(name: str, *values: str | float, unit: str = "", call: str = "") -> str:
    """Return an argument for a sentence.

    Parameters
    ----------
    name
        Its name.
    *values
        The value that is meant; two values, or the words that stand for them, for a pair.
    unit
        Unit of its numbers.
    call
        What Python says in its place, where faces alone have such a field.
    """
    return f"{_BEGIN}{json.dumps([name, values, unit, call])}{_END}"


def either(advice: str, otherwise: str = "") -> str:
    """Return advice for a sentence, and what is said in its place where a face has not the arguments that it names.

    Advice that names none is for scripts: a face that spells arguments in its own way says the other.
    """
    return f"{_CHOOSE}{advice}{_OTHERWISE}{otherwise}{_CHOSEN}"


class Sentence(str):
    """A text as Python says it, whose arguments other faces spell in their way; made from a text with marks."""

    __slots__ = ("marked",)
    marked: str

    def __new__(cls, text: str) -> Sentence:
        """Return the sentence of a text with marks, or of one without."""
        marked = text.marked if isinstance(text, Sentence) else str(text)
        made = super().__new__(cls, _spell(marked, str, scripts=True))
        made.marked = marked
        return made

    def spell(self, spell: Spell, *, scripts: bool = False) -> str:
        """Return the text as a face says it, to whose readers advice for `scripts` is of use or not."""
        return _spell(self.marked, spell, scripts=scripts)

    def __reduce__(self) -> tuple[type[Sentence], tuple[str]]:
        return Sentence, (self.marked,)


def _spell(marked: str, spell: Spell, *, scripts: bool) -> str:
    if _BEGIN not in marked and _CHOOSE not in marked:
        return marked

    def choose(found: re.Match[str]) -> str:
        named = [one for one in map(_read, _ARGUMENT.finditer(found[1])) if one is not None]
        return found[1] if (all(map(spell, named)) if named else scripts) else found[2]

    def write(found: re.Match[str]) -> str:
        one = _read(found)
        return found[0] if one is None else spell(one) or str(one)

    return _ARGUMENT.sub(write, _EITHER.sub(choose, marked))


def _read(found: re.Match[str]) -> Argument | None:
    """Return the argument of a mark; None of what only looks like one, as a file may be named."""
    try:
        name, values, unit, call = json.loads(found[1])
        is_known = isinstance(values, list) and all(isinstance(one, _PLAIN) for one in (name, unit, call, *values))
    except (TypeError, ValueError):
        return None
    return Argument(str(name), tuple(values), str(unit), str(call)) if is_known else None
