"""Sentences of the library in the words of the page: controls instead of arguments, and units with prefixes."""

from __future__ import annotations

import re

from roughcontact.units import si

_CONTROLS = {
    "surface.detrend('plane'), on the command line --detrend plane": "'Form that is removed: plane'",
    "give a hardness (ElasticPerfectlyPlastic, on the command line --hardness)": "fill in 'Hardness'",
    "Lengths are in m and moduli in Pa: 5 µm is 5e-6, 210 GPa is 210e9; for heights of a file in another unit give "
    "unit= (on the command line --unit)": "Check the units that are chosen beside the numbers, and those of the file",
    "use a surface that repeats, or boundary='free'": "use a surface that repeats, or choose that nothing is beyond "
    "the border",
    "give decimal=',' or decimal='.'": "write decimals with points, or separate the numbers by semicolons",
    ", or a ParaboloidSurface": " or a larger radius",
    "Say which it is: rows='y', or rows='x'": "Choose which it is beside 'Rows of the file'",
    "with non_measured='keep'": "with 'Non-measured points'",
    "leaves the range of float64 beside": "is out of all proportion to",
}
_NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
# A number in an SI unit; the unit behind what is allowed; and a number without one at the end of the sentence.
_PLAIN = re.compile(rf"(?<![\w.])({_NUMBER}) (m|Pa|N)\b")
_ALLOWED = re.compile(r" \((m|Pa|N)\)(?=, but got)")
_GOT = re.compile(rf"(?<=but got )({_NUMBER})(?=\.(?:\s|$))")
# Numbers between which units have a prefix that people know.
_SMALLEST, _LARGEST = 1e-15, 1e15


def in_words_of_page(text: str) -> str:
    """Return a sentence of the library with the controls of the page and prefixes of units."""
    for words, control in _CONTROLS.items():
        text = text.replace(words, control)
    stated = {*_ALLOWED.findall(text), *(unit for _, unit in _PLAIN.findall(text))}
    text = _PLAIN.sub(lambda found: _prefixed(found[0], float(found[1]), found[2]), _ALLOWED.sub("", text))
    if len(stated) != 1:
        return text
    (unit,) = stated
    return _GOT.sub(lambda found: _prefixed(found[0], float(found[1]), unit), text)


def _prefixed(text: str, value: float, unit: str) -> str:
    """Return a number with a prefix that people know, or its text where there is none."""
    return text if value and not _SMALLEST <= abs(value) < _LARGEST else si(value, unit)


def end_sentence(text: str) -> str:
    """Return a text with a capital letter and a full stop."""
    return f"{text[0].upper()}{text[1:].rstrip('.')}."
