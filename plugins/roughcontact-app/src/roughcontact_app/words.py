"""Sentences of the library on the page: controls in the place of arguments."""

from __future__ import annotations

from roughcontact.errors import Argument, InputError, Sentence

# What the page calls the controls of arguments.
_CONTROLS = {
    "adhesion": "'Adhesion'",
    "approach": "an approach",
    "boundary": "'Beyond the border of the domain'",
    "force": "a force",
    "friction": "'Coefficient of friction'",
    "laws": "'Laws by which the surfaces change'",
    "non_measured": "'Non-measured points'",
    "pressure": "a mean pressure",
    "rows": "'Rows of the file'",
    "size": "both sides of the map",
    "sliding": "'Sliding distances'",
    "time": "'Times'",
    "unit": "'Unit of the heights'",
}
# Those whose values the page writes as a script does.
_WITH_VALUES = ("boundary", "non_measured", "rows")


def in_words_of_page(told: str | Exception) -> str:
    """Return a sentence of the library with the controls of the page."""
    return Sentence(told.marked if isinstance(told, InputError) else str(told)).spell(_spell_control)


def _spell_control(one: Argument) -> str:
    values = one.values if one.name in _WITH_VALUES else ()
    return " ".join(map(str, (_CONTROLS[one.name], *values))) if one.name in _CONTROLS else ""


def end_sentence(text: str) -> str:
    """Return a text with a capital letter and a full stop."""
    return f"{text[0].upper()}{text[1:].rstrip('.')}."
