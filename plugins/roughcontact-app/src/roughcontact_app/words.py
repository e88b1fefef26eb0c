"""Sentences of the library in the words of the page: controls instead of arguments, and units with prefixes."""

from __future__ import annotations

import re
from collections.abc import Callable

from roughcontact.typing import si

_CONTROLS = {
    "or take Elastic materials": "or leave the hardness empty",
    "Give displacement= instead, or call problem.slide(...)": "Give a smaller tangential force",
    ": leave it to substeps='auto'": "",
    "give decimal=',' or decimal='.'": "write decimals with points, or separate the numbers by semicolons",
    ", or a ParaboloidSurface": " or a larger radius",
    "Say which it is: rows='y', or rows='x'": "Choose which it is beside 'Rows of the file'",
    "with non_measured='keep'": "with 'Non-measured points'",
    "leaves the range of float64 beside": "is out of all proportion to",
    ", as by numpy.loadtxt(path).reshape(nx, ny),": "",
    ", in pandas by to_csv(path, header=False, index=False)": "",
    ", and give size=": ", and fill in both sides",
    "save the map with numpy.save": "save the map as .npy or .mat",
    "say how many lines with skip_rows=": "delete them",
    "skip the lines that are not heights with skip_rows=": "delete the lines that are not heights",
    "skip them with skip_rows=": "delete that row",
    ", as by scipy.interpolate.griddata": "",
    "write the heights with numpy.savez(path, heights=heights, size=(lx, ly))": "write one row for each x",
    "do not overlap with an offset of": "do not overlap with a shift of",
    "float64": "double precision",
    "float32": "single precision",
}
# What holds a name or a number of the file, of a shape or of a part of the solve, and what the page says instead.
_PATTERNS: dict[re.Pattern[str], str | Callable[[re.Match[str]], str]] = {
    re.compile(r"ContactSolution\.load\(.*?\) reads it, and the command"): "the command",
    re.compile(r"lines above the heights that are not .*removed"): "delete lines that are not heights",
    re.compile(r"give decimal='.' if that is its decimal mark"): "write decimals with points",
    re.compile(r"\b(got|shape) \((\d+(?:, \d+)*),?\)"): lambda found: f"{found[1]} {found[2].replace(', ', ' x ')}",
    re.compile(r"(?<=[ ,])([A-Z][A-Za-z]+)\(((?:\w+=[^()]+)?)\)"): lambda found: _name_part(found[1], found[2]),
}
_NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
# A number in an SI unit; the unit behind what is allowed; and a number without one at the end of the sentence.
_PLAIN = re.compile(rf"(?<![\w.])({_NUMBER}) (m|Pa|N)\b")
_ALLOWED = re.compile(r" \((m|Pa|N)\)(?=, but got)")
_GOT = re.compile(rf"(?<=but got )({_NUMBER})(?=\.(?:\s|$))")
# Numbers between which units have a prefix that people know.
_SMALLEST = 1e-15
_LARGEST = 1e15


def in_words_of_page(text: str) -> str:
    """Return a sentence of the library with the controls of the page and prefixes of units."""
    for words, control in _CONTROLS.items():
        text = text.replace(words, control)
    for pattern, told in _PATTERNS.items():
        text = pattern.sub(told, text)
    stated = {*_ALLOWED.findall(text), *(unit for _, unit in _PLAIN.findall(text))}
    text = _PLAIN.sub(lambda found: _prefixed(found[0], float(found[1]), found[2]), _ALLOWED.sub("", text))
    if len(stated) != 1:
        return text
    (unit,) = stated
    return _GOT.sub(lambda found: _prefixed(found[0], float(found[1]), unit), text)


def _name_part(name: str, fields: str) -> str:
    """Return what Python prints of a part of the solve as words: its name, and its fields with their values."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    return ", ".join([words, *fields.replace("_", " ").replace("=", " ").split(", ")]).rstrip(", ")


def _prefixed(text: str, value: float, unit: str) -> str:
    """Return a number with a prefix that people know, or its text where there is none."""
    return text if value and not _SMALLEST <= abs(value) < _LARGEST else si(value, unit)


def end_sentence(text: str) -> str:
    """Return a text with a capital letter and a full stop."""
    return f"{text[0].upper()}{text[1:].rstrip('.')}."
