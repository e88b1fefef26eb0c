"""What the header of a text file states, used or refused: sides, unit, scale, non-measured value, axes."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

import attrs

from roughcontact._base.arrays import Array, Pair
from roughcontact.errors import InputError

# Metres in units of length; the two letters for micro, and its byte in Latin-1, read as UTF-8.
_METRES_PER_UNIT = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "pm": 1e-12, "Å": 1e-10}
_METRES_PER_UNIT |= {"micron": 1e-6, "microns": 1e-6, "inch": 0.0254, "~m": 1e-6, "ang": 1e-10, "angstrom": 1e-10}
_MICRO = str.maketrans({"µ": "u", "μ": "u", "\udcb5": "u"})
# A line "key: value" or "key = value", and one "key value", with a mark of comments before it or without.
_NUMBER = r"[-+]?(?:[0-9]+[.,]?[0-9]*|[.,][0-9]+)(?:[eE][-+]?[0-9]+)?"
_LENGTH = re.compile(rf"({_NUMBER})\s*([^\s\d.,+\-]\S{{0,7}})\s*")
_LINE = re.compile(r"[\s#;\\*]*([A-Za-z][\w .\-/()]{0,40}?)\s*[:=]\s*(\S.{0,80}?)\s*")
_PLAIN_LINE = re.compile(r"[\s#;\\*]*([A-Za-z]\w{0,40})\s+(\S.{0,80}?)\s*")
# Words of keys that change what the numbers mean: a line with one that is not understood is refused.
_CHANGING_WORDS = re.compile(
    r"(?i)(bit2|no[_ ]?data|null|missing|fill[_ ]?value|z[-_ ]?(?:scale|factor|offset)|scale[_ ]?factor|lsb|"
    r"counts? per|per count)"
)
# Characters of a line that a message repeats.
_MAX_QUOTED_CHARACTERS = 60


def metres(unit: str) -> float | None:
    """Return the metres in a unit such as µm; None if it is not a known unit of length."""
    return _METRES_PER_UNIT.get(unit.translate(_MICRO), _METRES_PER_UNIT.get(unit.translate(_MICRO).lower()))


@attrs.frozen(kw_only=True)
class Stated:
    """What a header states; None where it does not.

    Attributes
    ----------
    size
        Sides (x, y) of the map, m.
    unit
        Unit of the heights, m.
    shape
        Numbers of columns and rows.
    non_measured
        The number that stands for a non-measured point.
    is_image
        Whether its rows are those of an image: y, downwards.
    step
        Sides of the cells, in a unit that is not stated.
    """

    size: Pair | None = None
    unit: float | None = None
    shape: tuple[int | None, int | None] = (None, None)
    non_measured: float | None = None
    is_image: bool = False
    step: float | None = None


def read_header(lines: Sequence[str]) -> Stated:
    """Return what a header states; `InputError` where it states what changes the numbers and is not understood."""
    found: dict[str, object] = {}
    for line in lines:
        match = _LINE.fullmatch(line) or _PLAIN_LINE.fullmatch(line)
        if match is None:
            continue
        key = " ".join(re.split(r"[\s_\-]+", match[1].lower())).strip()
        reader = next((read for names, read in _KEYS.items() if key in names), None)
        if reader is not None:
            found |= reader(match[2], line)
        elif _CHANGING_WORDS.search(match[1]) and re.match(_NUMBER, match[2]):
            raise _not_understood(line)
    return _combine(found)


def _combine(found: Mapping[str, object]) -> Stated:
    numbers = {name: value for name, value in found.items() if isinstance(value, (int, float))}
    width, height = (numbers.get(name) for name in ("width", "height"))
    columns, rows = (int(numbers[name]) if name in numbers else None for name in ("columns", "rows"))
    return Stated(
        size=(width, height) if width and height else None,
        unit=numbers.get("unit"),
        shape=(columns, rows),
        non_measured=numbers.get("non_measured"),
        is_image=bool(width and height) or (columns is not None and rows is not None),
        step=numbers.get("step"),
    )


def _not_understood(line: str) -> InputError:
    return InputError(
        f"its header states {line.strip()[:_MAX_QUOTED_CHARACTERS]!a}, which changes what its numbers mean and is not "
        "understood: write the heights themselves, with nan for points that were not measured, and omit that line"
    )


def _read_number(text: str, line: str) -> float:
    match = re.match(_NUMBER, text)
    if match is None:
        raise _not_understood(line)
    return float(match[0].replace(",", "."))


def _side(name: str, unit: str = "") -> Callable[[str, str], dict[str, object]]:
    """Return the reader of a side of the map; a number alone is in a unit that its program implies, or says nothing."""

    def read(text: str, line: str) -> dict[str, object]:
        match = _LENGTH.fullmatch(text)
        length = metres(match[2] if match else unit)
        return {} if length is None else {name: _read_number(text, line) * length}

    return read


def _number_of(name: str) -> Callable[[str, str], dict[str, object]]:
    return lambda text, line: {name: _read_number(text, line)}


def _read_unit(text: str, line: str) -> dict[str, object]:
    unit = metres(text.strip().strip("()[]"))
    if unit is None:
        raise InputError(f"its header states values in {text.strip()!a}, which is not a known unit of length")
    return {"unit": unit}


def _read_bits(text: str, line: str) -> dict[str, object]:
    """Return the unit of heights in steps of so many nanometres (SPIP)."""
    return {"unit": 1e-9 * _read_number(text, line)}


def _read_non_measured(text: str, line: str) -> dict[str, object]:
    # A word is one of those that stand for a non-measured point anyway.
    return {"non_measured": _read_number(text, line)} if re.match(_NUMBER, text) else {}


# Keys of Gwyddion, NanoScope, SPIP, and the grids of ESRI and GRASS, and what they state.
_KEYS: dict[tuple[str, ...], Callable[[str, str], dict[str, object]]] = {
    ("width",): _side("width"),
    ("height",): _side("height"),
    ("x length",): _side("width", "nm"),
    ("y length",): _side("height", "nm"),
    ("value units", "exported image units", "z unit", "z units", "height unit", "height units"): _read_unit,
    ("bit2nm",): _read_bits,
    ("ncols", "cols", "x pixels"): _number_of("columns"),
    ("nrows", "rows", "y pixels"): _number_of("rows"),
    ("cellsize",): _number_of("step"),
    ("nodata value", "nodata", "null"): _read_non_measured,
}


def apply_non_measured(heights: Array, stated: Stated) -> Array:
    """Return heights with NaN where the header says that a point was not measured."""
    if stated.non_measured is None:
        return heights
    heights = heights.copy()
    heights[heights == stated.non_measured] = float("nan")
    return heights
