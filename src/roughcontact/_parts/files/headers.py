"""What the header of a text file states: sides, steps, unit, scale, non-measured values, counts, axes."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from typing import TypeAlias

import attrs

from roughcontact._parts.files.stated import Stated, metres
from roughcontact._parts.files.text import SHOWN_FACTOR
from roughcontact.errors import InputError

# A line "key: value", "key = value", "key<tab or ; or ,>value", or "key value", behind a mark of comments or none.
_MARKS = r"[\s#;%\\*/\"'>]*"
_KEY = r"([^\W\d][^\n:=：,;\t\"]{0,50}?)"
_LINES = (
    re.compile(rf"{_MARKS}{_KEY}[\"']?\s*[:=：]\s*(\S.{{0,120}}?)\s*", re.DOTALL),
    re.compile(rf"{_MARKS}{_KEY}[\"']?\s*[,;\t]\s*(\S.{{0,120}}?)\s*", re.DOTALL),
    re.compile(rf"{_MARKS}([^\W\d]\w{{0,40}})\s+(\S.{{0,80}}?)\s*", re.DOTALL),
)
# A title of heights, with their unit in brackets.
_TITLE = re.compile(
    r"(?i)[\s#;%\"]*(?:z|heights?|höhen?|hauteurs?|altitudes?|topography|topographie|elevation)[\w \-]*"
    r"(?:[\[(]([^\])]{1,12})[\])]|(?:/|\b(?:in|en)\b)\s*([^\W\d]{1,11}))[\s\";,]*"
)
# A title of depths, and words that say which way is positive; heights are positive outwards.
_DEPTHS = re.compile(
    r"(?i)[\s#;%\"]*(?:depths?|tiefen?|profondeurs?)\s*(?:[\[(/].*|\bin\b.*)?|.*\bpositive (?:is )?down.*"
    r"|.*\bdown\w* (?:is )?positive\b.*",
    re.DOTALL,
)
# What separates the items of one line: "dx = 2 um, dy = 3 um".
_ITEMS = re.compile(r"[,;]\s*(?=[\"']?[^\W\d][\w .\-]{0,30}[\"']?\s*[:=])")
# A title such as height_nm.
_JOINT_TITLE = re.compile(r"(?i)[\s#;%\"]*(?:z|heights?)_([^\W\d_]{1,4})[\s\";,]*")
_BRACKET = re.compile(r"\s*[\[(]([^\])]*)[\])]\s*")
_NUMBER = r"[-+]?(?:[0-9]+[.,]?[0-9]*|[.,][0-9]+)(?:[eE][-+]?[0-9]+)?"
_VALUE = re.compile(rf"({_NUMBER})\s*(.*)", re.DOTALL)
# What a number is of one cell for, behind the unit: "nm/pixel".
_PER_PIXEL = re.compile(r"(?i)\s*(?:/|per)\s*(?:pixel|px|pt|point)s?.*")
# Numbers of points along x and y, and of the lines of a table and the numbers in each.
_COUNTS = {
    "count x": r"nx|x ?pixels?|pixels x|x ?points|points x|x ?res|horizontal|horizont",
    "count y": r"ny|y ?pixels?|pixels y|y ?points|points y|y ?res|vertical|vertikal",
    "columns": r"points|n ?cols?|cols?|columns|(?:number|count) of columns|samps/line|spalten|anzahl (?:der )?spalten"
    r"|spaltenanzahl|points per line",
    "lines": r"n ?rows?|rows?|(?:number|count) of (?:rows|lines)|lines|zeilen|anzahl (?:der )?zeilen|zeilenanzahl",
}
# Sides, also in the languages of Gwyddion, and distances of points, along x, along y, and along both; the last words of
# the steps mean them only with a unit of length.
_SIDE = r"length|amplitude|real|range|size|image size|scan size|scan range"
_STEP = r"pixel ?size|pixel ?spacing|spacing|pitch|cell ?size|sampling(?: interval| step)?|pixelgröße|punktabstand"
_LOOSE_STEP = r"calibration|justierung|step ?size"
_AXIS_STEP = rf"{_STEP}|{_LOOSE_STEP}|scale|resolution|increment|step|pixel ?width|pixel ?height"
_WIDTH = r"width|breite|šířka|anchura|largeur|larghezza|largura|ширина|幅|폭"
_HEIGHT = r"height|höhe|výška|altura|hauteur|altezza|высота|高さ|높이"
_LENGTHS: dict[tuple[str, ...], str] = {
    ("side x",): rf"{_WIDTH}|x ?(?:{_SIDE})|(?:{_SIDE}) x",
    ("side y",): rf"{_HEIGHT}|y ?(?:{_SIDE})|(?:{_SIDE}) y",
    ("step x",): rf"dx|x ?(?:{_AXIS_STEP})|(?:{_AXIS_STEP}) x",
    ("step y",): rf"dy|y ?(?:{_AXIS_STEP})|(?:{_AXIS_STEP}) y",
    ("step x", "step y"): rf"{_STEP}|(?:xy|lateral) ?(?:{_STEP}|{_LOOSE_STEP})",
}
_NEEDS_UNIT = re.compile(rf"(?:xy|lateral) ?(?:{_LOOSE_STEP})")
# Keys of images, whose lines are those of y, downwards.
_OF_IMAGES = re.compile(
    rf"{_WIDTH}|{_HEIGHT}|[xy] ?pixels?|horizont(?:al)?|vertikal|vertical|[xy] amplitude|north|xll\w+"
)
# A sentence that states the unit of the heights, or of all lengths.
_SENTENCE = re.compile(
    r"(?i).*\b(heights?|z|values?|data|lengths|all(?: \w+)?|dimensions|coordinates|höhen?|werte|längen)\b[^\d:=]{0,30}?"
    r"\b(?:(?:are|is)\s+(?:\w+\s+){0,2}?in|in|are|is)\b(?: units of)?\s*[\[(]?([^\W\d]{1,11})\b.*",
    re.DOTALL,
)
_OF_ALL = ("lengths", "all", "dimensions", "coordinates", "längen")
# Words with a number behind them that may change what the numbers mean, anywhere in a line that is not understood.
_SUSPECT = re.compile(
    rf"(?i).*\b(?:scale(?! bar)|scaling|factor|multipl\w*|divide\w*|offset|lsb|bit2\w*|no ?data|missing|fill ?value"
    rf"|per count|counts? per|calibration(?! date))\b(?:[^0-9\n]{{0,20}}?\s|[:=])({_NUMBER})(?!\s*%|[\w:/])",
    re.DOTALL,
)
# What one step of integers is: "1 nm/digit", "1 count = 1 nm"; and a factor behind a word: "heights x 1000".
_SUSPECT_STEPS = re.compile(
    r"(?i).*(?:/|\bper\s+)\s*(?:digit|count|lsb|bit|dn|level)\b.*"
    r"|.*\b1 (?:digit|count|lsb|bit|dn|level)\s*(?:=|is)\s*\d.*|.*\b(?:heights?|values?|data|z)\s*[x×*]\s*10.*",
    re.DOTALL,
)
# The value of a key in letters of another encoding, whose bytes stand for themselves.
_UNIT_BEHIND = re.compile(r".*[\udc80-\udcff].*[:=]\s*([^\s:=]+)\s*", re.DOTALL)
_UNIT = (
    r"(?:value|data|heights?|z|exported image|map|vertical|höhen?|z ?wert) ?(?:units?|einheit)|units? (?:data|z)|units?"
    r"|einheit(?:en)?|jednotky hodnot|unités?|unità(?: valore)?|unidad(?:es)?(?: de valor)?|値の単位|값 단위"
    r"|единицы измерения"
)
_LATERAL_UNIT = r"(?:x|y|xy|lateral|length) ?units?|units? (?:x|y|xy)|lateral units?"
_NON_MEASURED = (
    r"no ?data(?: value)?|null(?: value)?|(?:missing|invalid|bad|void|blank|undefined|fill|filler) ?value|blank"
)
_CHANNEL = (
    r"(?:image |data )?channel(?: name)?|kanál|kanal|canal|canale|チャネル|채널|канал|output image data|image data"
)
# Channels of instruments without heights.
_OTHER_CHANNELS = re.compile(
    r"(?i).*\b(?:phase|deflection|friction|lateral force|current|potential|adhesion|modulus|dissipation|intensity|"
    r"colou?r|laser|amplitude error|error signal|magnetic)\b.*"
)
# Words of keys that change what the numbers mean, and the value by which each of them changes nothing.
_CHANGING = {
    re.compile(
        r"bit2\w*|.*\b(?:lsb|counts? per|per count|multiplier|conversion)\b.*|(?:(?:z|heights?|data|value) ?)?"
        r"(?:scale|factor|scaling|calibration|scale ?factor|calibration factor)|(?:z|heights?) ?(?:gain|sensitivity)"
        r"|(?:scale|factor) (?:data|z)|höhenfaktor|skalierung|faktor"
    ): 1.0,
    re.compile(r"(?:(?:z|heights?|data|value|add)[ _]?)?offset|offset (?:data|z)"): 0.0,
    re.compile(r"void ?pixels?|(?:missing|invalid|bad|void|undefined)(?: points| pixels| data)?"): 0.0,
}
# The number of a non-measured point where a grid of ESRI states none.
_ESRI_NON_MEASURED = -9999.0
_SPIP_UNIT = "nm"
_Sides: TypeAlias = tuple[float | None, float | None]


@attrs.define
class _Found:
    """What the lines of a header state, by the name of each item, and the line of it."""

    items: dict[str, tuple[float | str, str]] = attrs.field(factory=dict)
    not_understood: list[str] = attrs.field(factory=list)

    def add(self, name: str, value: float | str, line: str) -> None:
        """Keep an item; `InputError` if it is stated twice, with other values."""
        known = self.items.setdefault(name, (value, line))
        if known[0] != value and (_in_metres(known[0]) is None or _in_metres(known[0]) != _in_metres(value)):
            raise InputError(
                f"its header states {known[1].strip()[:60]!a} and {line.strip()[:60]!a}, which contradict each other, "
                "as where a second table or channel begins: keep the heights alone"
            )

    def text(self, name: str) -> str | None:
        value = self.items.get(name, (None, ""))[0]
        return value if isinstance(value, str) else None

    def number(self, name: str) -> float | None:
        value = self.items.get(name, (None, ""))[0]
        return value if isinstance(value, float) else None

    def count(self, name: str) -> int | None:
        value = self.number(name)
        return None if value is None else int(value)


def _in_metres(unit: float | str) -> float | None:
    return unit if isinstance(unit, float) else metres(unit)


def read_header(lines: Sequence[str]) -> Stated:
    """Return what a header states; `InputError` where its lines contradict each other."""
    found = _Found()
    for line in itertools.chain.from_iterable(map(_divide, lines)):
        if title := _TITLE.fullmatch(line):
            found.add("unit", (title[1] or title[2]).strip(), line)
            continue
        joint = _JOINT_TITLE.fullmatch(line)
        alone = joint[1] if joint else line.strip(' \t#;%"')
        if metres(alone) is not None:
            found.add("unit", alone, line)
            continue
        if factor := SHOWN_FACTOR.fullmatch(line):
            found.add("factor", float(factor[1]), line)
            continue
        before = len(found.items) + len(found.not_understood)
        for form in _LINES:
            if match := form.fullmatch(line):
                _read_line(found, match[1], match[2], line)
                break
        if len(found.items) + len(found.not_understood) == before:
            _read_sentence(found, line)
    return _combine(found)


def _divide(line: str) -> list[str]:
    """Return the items of a line that has several, as of JSON; else the line."""
    items = _ITEMS.split(line.strip(" \t{}#%"))
    return items if len(items) > 1 and all(re.search("[:=]", item) for item in items) else [line]


def _read_sentence(found: _Found, line: str) -> None:
    """Keep a unit that a sentence states, and a line that may change what the numbers mean."""
    sentence = _SENTENCE.fullmatch(line)
    if sentence and metres(sentence[2]) is not None:
        found.add("unit", sentence[2], line)
        if sentence[1].lower().startswith(_OF_ALL):
            found.add("length", sentence[2], line)
    elif _is_suspect(line):
        found.not_understood.append(line)


def _is_suspect(line: str) -> bool:
    """Return whether a line may change what the numbers mean."""
    suspect = _SUSPECT.match(line)
    has_factor = suspect is not None and float(suspect[1].replace(",", ".")) not in (0.0, 1.0)
    unit = _UNIT_BEHIND.fullmatch(line)
    has_unit = unit is not None and metres(unit[1]) is not None
    return has_factor or has_unit or any(form.fullmatch(line) for form in (_SUSPECT_STEPS, _DEPTHS))


def _read_line(found: _Found, key: str, value: str, line: str) -> None:
    bracket = _BRACKET.search(key)
    key = " ".join(re.split(r"[\s_\-.]+", _BRACKET.sub(" ", key).lower())).strip()
    value = re.sub(r"[\"']\s*[,;\t]\s*[\"']?|[\"']", " ", value).strip(" ;,\t")
    number = _VALUE.fullmatch(value)
    if re.fullmatch(_UNIT, key):
        length = None if number is None else metres(number[2])
        if number is None:
            found.add("unit", value.strip("()[] "), line)
        elif length is None:
            found.not_understood.append(line)
        else:
            found.add("unit", float(number[1].replace(",", ".")) * length, line)
    elif re.fullmatch(_LATERAL_UNIT, key):
        found.add("length", value.strip("()[] "), line)
    elif key == "file format":
        found.add(key, value, line)
        found.items["image"] = (1.0, line)
    elif re.fullmatch(_CHANNEL, key):
        found.add("channel", value, line)
    elif number is not None:
        unit = (_PER_PIXEL.sub("", number[2]) or (bracket[1] if bracket else "")).strip(" ()[]")
        _read_number(found, key, float(number[1].replace(",", ".")), unit, line)
    elif metres(value) is not None:
        # A unit of something, under a name that is not known.
        found.not_understood.append(line)


def _read_number(found: _Found, key: str, value: float, unit: str, line: str) -> None:
    """Keep what a line with a number states."""
    count = next((name for name, words in _COUNTS.items() if re.fullmatch(words, key)), None)
    if _OF_IMAGES.fullmatch(key):
        found.items["image"] = (1.0, line)
    if count is not None and not unit and value == int(value) and value > 0.0:
        found.add(count, value, line)
        return
    names = next((names for names, words in _LENGTHS.items() if re.fullmatch(words, key)), ())
    length = metres(unit)
    if names and (length is not None or (not unit and not _NEEDS_UNIT.fullmatch(key))):
        for name in names:
            found.add(name if length is not None else f"bare {name}", value * (length or 1.0), line)
    elif key in ("north", "south", "east", "west"):
        found.add(key, value, line)
    elif re.fullmatch(_NON_MEASURED, key):
        found.add("non measured", value, line)
    elif key in ("bit2nm", "multiplier", "scale data"):
        found.add("bit" if key == "bit2nm" else "factor", value, line)
    elif key in ("xllcorner", "xllcenter"):
        found.add("xllcorner", value, line)
    else:
        neutral = next((one for words, one in _CHANGING.items() if words.fullmatch(key)), None)
        # A scale of one nm/V is none of one; no offset is none in any unit.
        if neutral is not None and (value != neutral or (neutral != 0.0 and unit)) and "%" not in unit:
            found.not_understood.append(line)


def _find_lengths(found: _Found) -> tuple[_Sides, _Sides, str | float | None]:
    """Return the sides of the map and the distances of its points along x and y, and their unit."""
    pairs: list[_Sides] = []
    unit = found.text("length")
    if unit is None and not found.items.keys().isdisjoint(("bit", "file format")):
        unit = _SPIP_UNIT
    known = None if unit is None else metres(unit)
    for kind in ("side", "step"):
        bare = [found.number(f"bare {kind} {axis}") for axis in "xy"]
        stated = [found.number(f"{kind} {axis}") for axis in "xy"]
        if known is not None:
            stated = [
                one if one is not None or raw is None else raw * known for one, raw in zip(stated, bare, strict=True)
            ]
        pairs.append((stated[0], stated[1]))
        pairs.append((bare[0], bare[1]))
    edges = [found.number(name) for name in ("east", "west", "north", "south")]
    if None not in edges:
        east, west, north, south = (edge or 0.0 for edge in edges)
        return (east - west, north - south), (None, None), None
    side, bare_side, step, bare_step = pairs
    if None not in side or None not in step:
        return side, step, 1.0
    return bare_side, bare_step, unit


def _combine(found: _Found) -> Stated:
    nanoscope = any("exported image units" in line.lower() for _, line in found.items.values())
    channel = found.text("channel")
    unit = found.items.get("unit", (None, ""))[0]
    # The numbers that NanoScope exports are scaled already.
    not_understood = [line for line in found.not_understood if not (nanoscope and line.startswith("\\"))]
    if channel and unit is None and _OTHER_CHANNELS.fullmatch(channel):
        not_understood.append(found.items["channel"][1])
    factor = found.number("factor") or 1.0
    bit = found.number("bit")
    if bit is not None and (unit is None or _in_metres(unit) == metres(_SPIP_UNIT)):
        unit = _SPIP_UNIT
        factor *= bit
    elif bit is not None and bit != 1.0:
        not_understood.append(found.items["bit"][1])
    shape = (found.count("count x"), found.count("count y"))
    table = (found.count("lines"), found.count("columns"))
    size, steps, length = _find_lengths(found)
    is_image = "image" in found.items and (None not in shape or None not in table or None not in size)
    missing = found.number("non measured")
    if missing is None and found.number("xllcorner") is not None:
        missing = _ESRI_NON_MEASURED
    return Stated(
        unit=unit,
        factor=factor,
        non_measured=() if missing is None else (missing,),
        shape=shape,
        table=table,
        rows="y" if is_image or nanoscope else "",
        falling="y" if is_image else "",
        size=size,
        steps=steps,
        length=length,
        not_understood=tuple(not_understood),
    )
