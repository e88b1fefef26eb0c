"""What the header of a text file states: sides, steps, unit, scale, non-measured values, counts, axes."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from typing import TypeAlias

import attrs

from roughcontact._parts.files.stated import Stated, in_metres, metres, names_unit
from roughcontact._parts.files.text import SHOWN_FACTOR, decode_latin
from roughcontact.errors import InputError

# A line "key: value", "key = value", "key<tab or ; or ,>value", or "key value", behind a mark of comments or none.
_MARKS = r"[\W_]*"
_KEY = r"([^\W\d][^\n:=：,;\t\"]{0,50}?)"
_LINES = (
    re.compile(rf"{_MARKS}{_KEY}[\"']?\s*[:=：]\s*(\S.{{0,120}}?)\s*", re.DOTALL),
    re.compile(rf"{_MARKS}{_KEY}[\"']?\s*(?:[;\t]|(?<![0-9]),|,(?![0-9]))\s*(\S.{{0,120}}?)\s*", re.DOTALL),
    re.compile(rf"{_MARKS}([^\W\d]\w{{0,40}})\s+(\S.{{0,80}}?)\s*", re.DOTALL),
)
# A title of heights, with their unit in brackets.
_TITLE = re.compile(
    rf"(?i){_MARKS}(?:z|heights?|höhen?|hauteurs?|altitudes?|topography|topographie|elevation|高さ|高度|высота)[\w \-]*"
    r"(?:[\[(]([^\])]{1,12})[\])]|(?:/|\b(?:in|en)\b)\s*([^\W\d]{1,11}))[\s\";,]*"
)
# A title of depths, and words that say which way is positive; heights are positive outwards.
_DEPTHS = re.compile(
    rf"(?i){_MARKS}(?:depths?|tiefen?|profondeurs?)\s*(?:[\[(/].*|\bin\b.*)?|.*\bpositive (?:is )?down.*"
    r"|.*\bdown\w* (?:is )?positive\b.*",
    re.DOTALL,
)
# What separates the items of one line: "dx = 2 um, dy = 3 um", or "Points: 9 Lines: 14".
_ITEMS = re.compile(r"[,;]\s*(?=[\"']?[^\W\d][\w .\-]{0,30}[\"']?\s*[:=])|\s+(?=[^\W\d]\w{0,20}\s?[:=]\s?[-+.0-9])")
# A title such as height_nm.
_JOINT_TITLE = re.compile(rf"(?i){_MARKS}(?:z|heights?)_([^\W\d_]{{1,12}})[\s\";,]*")
_BRACKET = re.compile(r"\s*[\[(]([^\])]*)[\])]\s*")
_NUMBER = r"[-+]?(?:[0-9]+[.,]?[0-9]*|[.,][0-9]+)(?:[eE][-+]?[0-9]+)?"
_VALUE = re.compile(rf"({_NUMBER})\s*(.*)", re.DOTALL)
# What a number is of one cell for, behind the unit: "nm/pixel".
_PER_PIXEL = re.compile(r"(?i)\s*(?:/|per)\s*(?:pixel|px|pt|point)s?.*")
# Numbers of points along x and y, and of the lines of a table and the numbers in each.
_POINTS = r"(?:pixels?|points?|samples?|lines?|px|pts|(?:mess|bild)?punkte)"
_NUMBER_OF = r"(?:(?:num(?:ber)?|count|no|n) (?:of )?)?"
_COUNTS = {
    "count x": rf"nx|x ?{_POINTS}|{_NUMBER_OF}{_POINTS} (?:in |along )?x|{_NUMBER_OF}x ?{_POINTS}|x ?res|horizontal"
    r"|horizont|(?:image|map|data|picture|pixel) ?width",
    "count y": rf"ny|y ?{_POINTS}|{_NUMBER_OF}{_POINTS} (?:in |along )?y|{_NUMBER_OF}y ?{_POINTS}|y ?res|vertical"
    r"|vertikal|(?:image|map|data|picture|pixel) ?height",
    "columns": r"(?:scan )?points|n ?cols?|cols?|columns|(?:number|count) of columns|samps/line|spalten"
    rf"|anzahl (?:der )?spalten|spaltenanzahl|{_POINTS} per line",
    "lines": r"n ?rows?|rows?|(?:number|count) of (?:rows|lines)|(?:scan )?lines|zeilen|anzahl (?:der )?zeilen"
    r"|zeilenanzahl",
}
# Sides, also in the languages of Gwyddion, and distances of points, along x, along y, and along both; the last words of
# the steps mean them only with a unit of length.
_SIDE = r"length|amplitude|real|range|size|dim(?:ension)?|axis|image size|scan size|scan range"
_STEP = (
    r"pixel ?size|pixel ?spacing|pixel ?pitch|spacing|pitch|cell ?size|sampling(?: interval| step| distance)?"
    r"|pixelgröße|(?:punkt)?abstand"
)
_LOOSE_STEP = r"calibration|justierung|step ?size"
_AXIS_STEP = rf"{_STEP}|{_LOOSE_STEP}|scale|resolution|increment|step|pixel ?width|pixel ?height"
_WIDTH = r"width|breite|šířka|anchura|largeur|larghezza|largura|ширина|幅|폭"
_HEIGHT = r"height|höhe|výška|altura|hauteur|altezza|высота|高さ|높이"
_LENGTHS: dict[tuple[str, ...], str] = {
    ("side x",): rf"{_WIDTH}|x ?(?:{_SIDE})|(?:{_SIDE}) x|fast (?:axis |scan )?(?:length|size)|scan width",
    ("side y",): rf"{_HEIGHT}|y ?(?:{_SIDE})|(?:{_SIDE}) y|slow (?:axis |scan )?(?:length|size)|scan height",
    ("step x",): rf"dx|x ?(?:{_AXIS_STEP})|(?:{_AXIS_STEP}) x",
    ("step y",): rf"dy|y ?(?:{_AXIS_STEP})|(?:{_AXIS_STEP}) y",
    ("step x", "step y"): rf"{_STEP}|(?:xy|lateral) ?(?:{_STEP}|{_LOOSE_STEP})",
}
_NEEDS_UNIT = re.compile(rf"(?:xy|lateral) ?(?:{_LOOSE_STEP})|[xy] ?axis")
# Keys of images, whose lines are those of y, downwards.
_OF_IMAGES = re.compile(
    rf"{_WIDTH}|{_HEIGHT}|(?:image|map|data|picture|pixel) ?(?:width|height)|{_NUMBER_OF}[xy] ?pixels?"
    rf"|{_NUMBER_OF}pixels? (?:in )?[xy]"
    r"|horizont(?:al)?|vertikal|vertical|[xy] amplitude|north|xll ?\w+"
)
# Two numbers with their units, along x and y ("195 um x 30 um", "[15, 5]"), and the keys of such, by that of one axis;
# and the unit of one axis ("x=mm").
_PAIR = re.compile(
    rf"[\[(]?\s*({_NUMBER})\s*((?!x\b|by\b)[^\W\d_]{{0,10}})\s*(?:[x×*;]|,\s|by|\s)\s*"
    rf"({_NUMBER})\s*([^\W\d_]{{0,10}})\s*[\])]?"
)
_PAIRS = {
    "size": rf"(?:{_SIDE})|field of view|fov|area|dimensions|extent|lateral size|measur\w+ (?:area|field)",
    "spacing": rf"{_STEP}|(?:xy|lateral) (?:{_AXIS_STEP})",
    "pixels": r"(?:image |lateral )?resolution|pixels|points|number of (?:pixels|points)",
}
_UNIT_OF_AXIS = re.compile(r"(?i)[{\s]*([xyz])\s*[:=]\s*([^\W\d]{1,12})[}\s]*")
# A number of points behind a side ("18 um, 9 points"), and the unit of a number of points ("9 pixels").
_OF_POINTS = re.compile(rf"(.*?)[,;(]\s*([0-9]+)\s*{_POINTS}\b.*")
_UNIT_OF_POINTS = re.compile(rf"{_POINTS}|rows?|columns?")
# The range of the heights and their extremes, which tell their unit; and words that say that they are turned over, with
# those that say that they are not.
_EXTENTS = {
    "range": re.compile(r"z ?(?:amplitude|range|length|span|size)|(?:amplitude|range|span) z|(?:height|data) range"),
    "largest": re.compile(r"max(?:imum)? ?(?:z|heights?|value)|(?:z|heights?|value) ?max(?:imum)?"),
    "smallest": re.compile(r"min(?:imum)? ?(?:z|heights?|value)|(?:z|heights?|value) ?min(?:imum)?"),
}
_TURNED = re.compile(
    r"(?:z |heights? |data )?(?:invert(?:ed)?|inversion|flip(?:ped)?|mirror(?:ed)?|reversed)(?: z| heights?)?"
)
_NOT_TURNED = frozenset({"no", "off", "false", "none", "0", "0.0", "nein", "non", "not", "unknown", "n/a"})
# A sentence that states the unit of the heights, or of all lengths.
_SENTENCE = re.compile(
    r"(?i).*\b(heights?|z|values?|data|lengths|all(?: \w+)?|dimensions|coordinates|höhen?|werte|längen)\b[^\d:=]{0,30}?"
    r"\b(?:(?:are|is)\s+(?:\w+\s+){0,2}?in|in|are|is)\b(?: units of)?\s*[\[(]?([^\W\d]{1,11})\b.*",
    re.DOTALL,
)
# A unit with a factor: "values in units of 10 nm".
_MULTIPLE = re.compile(
    rf"(?i).*\b(?:heights?|z|values?|data|numbers?)\b[^\d:=]{{0,30}}?\b(?:in|are|is)\b(?: units? of)?\s*({_NUMBER})\s*"
    r"(nm|µm|um|mm|pm|Å)\W*",
    re.DOTALL,
)
_OF_ALL = ("lengths", "all", "dimensions", "coordinates", "längen")
# Words with a number behind them that may change what the numbers mean, anywhere in a line that is not understood.
_SUSPECT = re.compile(
    rf"(?i).*\b(?:scale(?! bar)|scaling|factor|multipl\w*|divide\w*|offset|lsb|bit2\w*|no ?data|missing|fill ?value"
    rf"|per count|counts? per|(?<!date of )calibration(?! date))\b"
    rf"(?:[^0-9\n]{{0,20}}?\s|[:=])({_NUMBER})(?!\s*%|[\w:/])",
    re.DOTALL,
)
# What one step of integers is: "1 nm/digit", "1 count = 1 nm"; and a factor behind a word: "heights x 1000".
_SUSPECT_STEPS = re.compile(
    r"(?i).*(?:/|\bper\s+)\s*(?:digit|count|lsb|bit|dn|level)\b.*"
    r"|.*\b1 (?:digit|count|lsb|bit|dn|level)\s*(?:=|is)\s*\d.*"
    r"|.*\b(?:heights?|values?|data|z|raw|counts?|digits?|bits?|numbers?)\s*[x×*/]\s*\.?\d.*",
    re.DOTALL,
)
# The value of a key in letters of another encoding, whose bytes are read as those of Latin-1.
_UNIT_BEHIND = re.compile(r".*[\x80-\xff].*[:=,;\t]\s*\"?([^\s:=,;\"]+)\"?\s*", re.DOTALL)
_UNIT = (
    r"(?:value|data|heights?|z|exported image|map|vertical|höhen?|z ?wert) ?(?:units?|einheit)|units? (?:data|z)|units?"
    r"|einheit(?:en)?(?: z)?|jednotky hodnot|unités?(?: z)?|unità(?: valore| z)?|unidad(?:es)?(?: de valor| z)?"
    r"|(?:値の)?単位|单位|(?:값 )?단위|единицы(?: измерения)?"
)
_LATERAL_UNIT = r"(?:x|y|xy|lateral|length) ?units?|units? (?:x|y|xy)|lateral units?"
_NO_POINT = r"(?:no ?data|null|missing|invalid|bad|void|blank|undefined|fill|filler|masked|unmeasured|not measured)"
_NON_MEASURED = (
    r"no ?data|null|blank|fehlwert|ungültiger wert|valeur manquante"
    rf"|{_NO_POINT}(?: ?data| pixels?| points?)? ?value"
)
# A sentence that states it: "invalid points are set to 0".
_NON_MEASURED_SENTENCE = re.compile(
    rf"(?i).*\b{_NO_POINT}\b[^0-9\n]*\b(?:set to|replaced (?:by|with)|given as|marked (?:by|as|with)|written as)\s+"
    rf"({_NUMBER})\W*",
    re.DOTALL,
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
        r"|(?:scale|factor) (?:data|z)|höhenfaktor|skalierung|faktor|(?:(?:z|vertical) )?exaggeration"
        r"|(?:z|vertical) magnification"
    ): 1.0,
    re.compile(r"(?:(?:z|heights?|data|value|add)[ _]?)?offset|offset (?:data|z)"): 0.0,
    re.compile(
        r"ungültige?(?: punkte)?|fehlende? punkte|void ?pixels?"
        r"|(?:missing|invalid|bad|void|undefined)(?: points| pixels| data)?"
    ): 0.0,
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
    unit_hint: str = ""

    def add(self, name: str, value: float | str, line: str) -> None:
        """Keep an item; `InputError` if it is stated twice, with other values."""
        known = self.items.setdefault(name, (value, line))
        if known[0] != value and (in_metres(known[0]) is None or in_metres(known[0]) != in_metres(value)):
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

    def pair(self, name: str) -> _Sides:
        return self.number(f"{name} x"), self.number(f"{name} y")

    def count(self, name: str) -> int | None:
        value = self.number(name)
        return None if value is None else int(value)


def _float(text: str) -> float:
    """Return a number, with a decimal point or a comma."""
    return float(text.replace(",", "."))


def read_header(lines: Sequence[str]) -> Stated:
    """Return what a header states; `InputError` where its lines contradict each other."""
    found = _Found()
    for line in itertools.chain.from_iterable(_divide(decode_latin(line)) for line in lines):
        if title := _TITLE.fullmatch(line):
            found.add("unit", (title[1] or title[2]).strip(), line)
            continue
        joint = _JOINT_TITLE.fullmatch(line)
        alone = joint[1] if joint else line.strip(' \t#;%"!/')
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
    mark = _NON_MEASURED_SENTENCE.fullmatch(line)
    sentence = _SENTENCE.fullmatch(line)
    if mark:
        found.add("non measured", _float(mark[1]), line)
    elif sentence and metres(sentence[2]) is not None:
        found.add("unit", sentence[2], line)
        if sentence[1].lower().startswith(_OF_ALL):
            found.add("length", sentence[2], line)
    elif multiple := _MULTIPLE.fullmatch(line):
        found.add("unit", _float(multiple[1]) * (metres(multiple[2]) or math.nan), line)
    elif _is_suspect(line):
        found.not_understood.append(line)
    elif names_unit(line):
        found.unit_hint = found.unit_hint or line


def _is_suspect(line: str) -> bool:
    """Return whether a line may change what the numbers mean."""
    suspect = _SUSPECT.match(line)
    has_factor = suspect is not None and _float(suspect[1]) not in (0.0, 1.0)
    unit = _UNIT_BEHIND.fullmatch(line)
    has_unit = unit is not None and metres(unit[1]) is not None
    return has_factor or has_unit or any(form.fullmatch(line) for form in (_SUSPECT_STEPS, _DEPTHS))


def _read_line(found: _Found, key: str, value: str, line: str) -> None:
    bracket = _BRACKET.search(key)
    # "ScanSizeX" is three words.
    key = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", _BRACKET.sub(" ", key))
    key = " ".join(re.split(r"[\s_\-.]+", key.lower())).strip()
    value = re.sub(r"[\"']\s*[,;\t]\s*[\"']?|[\"']", " ", value).strip(" ;,\t")
    number = _VALUE.fullmatch(value)
    if of_axis := _UNIT_OF_AXIS.fullmatch(value if key in ("unit", "units") else f"{key}={value}"):
        found.add("unit" if of_axis[1].lower() == "z" else "length", of_axis[2], line)
    elif (pair := _PAIR.fullmatch(value)) and not (metres(pair[2]) and _UNIT_OF_POINTS.fullmatch(pair[4].lower())):
        _read_pair(found, key, pair, bracket[1] if bracket else "", line)
    elif re.fullmatch(_UNIT, key):
        length = None if number is None else metres(number[2])
        if number is None:
            # A row of units has one for each column.
            words = value.strip("()[] ").split()
            found.add("unit", words[0] if len({*words}) == 1 else value.strip("()[] "), line)
        elif length is None:
            found.not_understood.append(line)
        else:
            found.add("unit", _float(number[1]) * length, line)
    elif re.fullmatch(_LATERAL_UNIT, key):
        found.add("length", value.strip("()[] "), line)
    elif key == "file format":
        found.add(key, value, line)
        found.items["image"] = (1.0, line)
    elif re.fullmatch(_CHANNEL, key):
        found.add("channel", value, line)
    elif _TURNED.fullmatch(key):
        found.not_understood.extend([] if value.lower() in _NOT_TURNED else [line])
    elif number is not None:
        rest = _PER_PIXEL.sub("", number[2])
        if points := _OF_POINTS.fullmatch(rest):
            _read_number(found, key, float(points[2]), "points", line)
            rest = points[1]
        unit = (rest.strip(" ,;") or (bracket[1] if bracket else "")).strip(" ()[]")
        words = key.split()
        if not unit and len(words) > 1 and names_unit(words[-1]):
            # "x_spacing_mm"
            unit = words.pop()
            key = " ".join(words)
        _read_number(found, key, _float(number[1]), unit, line)
    elif metres(value) is not None:
        # A unit of something, under a name that is not known.
        found.not_understood.append(line)


def _read_pair(found: _Found, key: str, pair: re.Match[str], unit: str, line: str) -> None:
    """Keep what a line with two numbers states: sides, distances or numbers of points along x and y."""
    kind = next((kind for kind, words in _PAIRS.items() if re.fullmatch(words, key)), None)
    if kind is None:
        if _is_suspect(line):
            found.not_understood.append(line)
        return
    last = pair[4].strip(" ,;()[]") or unit
    for axis, value, own in (("x", pair[1], pair[2].strip(" ,;()[]") or last), ("y", pair[3], last)):
        _read_number(found, f"{axis} {kind}", _float(value), own, line)


def _read_number(found: _Found, key: str, value: float, unit: str, line: str) -> None:
    """Keep what a line with a number states."""
    count = next((name for name, words in _COUNTS.items() if re.fullmatch(words, key)), None)
    names = next((names for names, words in _LENGTHS.items() if re.fullmatch(words, key)), ())
    if _OF_IMAGES.fullmatch(key):
        found.items["image"] = (1.0, line)
    if _UNIT_OF_POINTS.fullmatch(unit.lower()) and (names[:1] or ("",))[0].startswith("side"):
        count = names[0].replace("side", "count")
        unit = ""
    if count is not None and not unit and value == int(value) and value > 0.0:
        found.add(count, value, line)
        return
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
    elif key.replace(" ", "") in ("xllcorner", "xllcenter"):
        found.add("xllcorner", value, line)
    elif length is not None and (extent := next((one for one, words in _EXTENTS.items() if words.fullmatch(key)), "")):
        found.add(extent, value * length, line)
        found.items.setdefault("unit of extent", (unit, line))
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
    known = in_metres(unit)
    for kind in ("side", "step"):
        bare = found.pair(f"bare {kind}")
        x, y = (
            one if one is not None or known is None or raw is None else raw * known
            for one, raw in zip(found.pair(kind), bare, strict=True)
        )
        pairs += [(x, y), bare]
    edges = [found.number(name) for name in ("east", "west", "north", "south")]
    if None not in edges:
        east, west, north, south = (edge or 0.0 for edge in edges)
        return (east - west, north - south), (None, None), None
    side, bare_side, step, bare_step = pairs
    if None not in side or None not in step or (bare_side == bare_step == (None, None) and step != (None, None)):
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
    if bit is not None and (unit is None or in_metres(unit) == metres(_SPIP_UNIT)):
        unit = _SPIP_UNIT
        factor *= bit
    elif bit is not None and bit != 1.0:
        not_understood.append(found.items["bit"][1])
    shape = (found.count("count x"), found.count("count y"))
    table = (found.count("lines"), found.count("columns"))
    size, steps, length = _find_lengths(found)
    if length == 1.0 and shape == (None, None) and None not in (*found.pair("bare side"), *steps):
        # Beside distances with a unit, sides without one are numbers of points.
        shape = (found.count("bare side x"), found.count("bare side y"))
    is_image = "image" in found.items and (None not in shape or None not in table or None not in size)
    extent = next((what for what in _EXTENTS if what in found.items), None)
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
        extent=None if extent is None else (extent, found.number(extent) or 0.0, found.items["unit of extent"][0]),
        not_understood=tuple(not_understood),
        unit_hint=found.unit_hint,
    )
