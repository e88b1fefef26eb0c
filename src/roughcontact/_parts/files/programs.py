"""Text files whose numbers stand in an order of their own: Surfer, SDF, Zygo, Wyko and Igor."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.files.base import RawMap, shape_numbers
from roughcontact._parts.files.points import put_on_grid
from roughcontact._parts.files.stated import Stated, build_map
from roughcontact.errors import InputError

# Bytes at the beginning in which a program is looked for.
_BEGINNING_BYTES = 64
# Words for non-measured points of these programs.
_WORDS = re.compile(r"(?i)\b(?:no data|bad|nan)\b")
# Numbers from which Surfer means a point without data (1.70141e38), and Zygo one of phase and of light.
_SURFER_BLANK = 1.7e38
_ZYGO_INVALID_PHASE = 2147483640
# Steps of the phase in one order of interference, by the number that Zygo writes for its resolution.
_ZYGO_RESOLUTIONS = {0: 4096, 1: 32768, 2: 131072}
# Lines of Zygo's header, and the maximum of its lines.
_ZYGO_ORIGIN = 3
_ZYGO_OPTICS = 7
_ZYGO_PHASE = 10
_MAX_HEADER_LINES = 60


def read_program(data: bytes, rows: str) -> RawMap | None:
    """Return the map in the text of one of these programs; None if it is of none of them."""
    start = data[:_BEGINNING_BYTES]
    reader = next((read for mark, read in _READERS.items() if start.lstrip().startswith(mark)), None)
    if reader is None:
        return None
    text = data.decode("latin-1").lstrip()
    lines = text.splitlines()
    if lines[0].count(",") > 1:
        # Saved again as CSV.
        lines = text.replace(",", "\t").replace('"', "").splitlines()
    try:
        return reader(lines, rows)
    except (ValueError, IndexError, KeyError, StopIteration) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"it begins as {lines[0][:40]!a} does, but does not go on so: it is damaged") from None


def _read_numbers(lines: list[str], shape: tuple[int, int]) -> Array:
    """Return the numbers in lines, in any division of lines, NaN for a point without data."""
    text = _WORDS.sub("nan", "\n".join(lines))
    return shape_numbers(np.array(text.split(), dtype=np.float64), shape)


def _read_surfer(lines: list[str], rows: str) -> RawMap:
    """Return a grid of Surfer (DSAA): lines of growing y, which may be wrapped."""
    columns, count = map(int, lines[1].split())
    (west, east), (south, north) = (map(float, line.split()) for line in lines[2:4])
    numbers = _read_numbers(lines[5:], (count, columns))
    numbers[numbers >= _SURFER_BLANK] = np.nan
    steps = ((east - west) / (columns - 1), (north - south) / (count - 1))
    return build_map(numbers, Stated(rows="y", steps=steps), rows=rows)


def _read_sdf(lines: list[str], rows: str) -> RawMap:
    """Return a surface of ISO 25178-71 in text; its lengths are in metres."""
    ends = [place for place, line in enumerate(lines) if line.strip().startswith("*")]
    stated = dict(re.split(r"\s*=\s*", line.strip(), maxsplit=1) for line in lines[1 : ends[0]] if "=" in line)
    stated = {name.lower(): value for name, value in stated.items()}
    if int(stated.get("compression", "0") or 0):
        raise InputError("its numbers are compressed: export it without compression")
    shape = (int(stated["numprofiles"]), int(stated["numpoints"]))
    numbers = _read_numbers(lines[ends[0] + 1 : ends[1] if len(ends) > 1 else None], shape)
    steps = (float(stated["xscale"]), float(stated["yscale"]))
    factor = float(stated["zscale"])
    return build_map(numbers, Stated(rows="y", unit=1.0, factor=factor, steps=steps, length=1.0), rows=rows)


def _divide_zygo(lines: list[str]) -> list[list[str]]:
    """Return the parts of a file of Zygo between its lines of one mark #."""
    marks = [place for place, line in enumerate(lines) if line.strip() == "#"]
    if not marks or marks[0] > _MAX_HEADER_LINES:
        raise InputError("it has no line # behind its header: it is damaged")
    ends = [*marks, len(lines)]
    return [lines[0 : marks[0]], *(lines[a + 1 : b] for a, b in itertools.pairwise(ends))]


def _read_zygo_resolution(header: list[str]) -> tuple[float | None, float | None]:
    """Return the distance of points, m, twice; None where the camera was not calibrated."""
    step = float(header[_ZYGO_OPTICS].split()[6])
    return (step, step) if step > 0.0 else (None, None)


def _read_zygo(lines: list[str], rows: str) -> RawMap:
    """Return the phase in an ASCII file of Zygo, as heights: lines of an image, y downwards."""
    header, *parts = _divide_zygo(lines)
    _, _, columns, count = map(int, header[_ZYGO_ORIGIN].split()[:4])
    numbers = _read_numbers(parts[1], (count, columns))
    numbers[numbers >= _ZYGO_INVALID_PHASE] = np.nan
    optics = header[_ZYGO_OPTICS].split()
    scale, wavelength, obliquity = (float(optics[place]) for place in (1, 2, 4))
    orders = _ZYGO_RESOLUTIONS[int(header[_ZYGO_PHASE].split()[0])]
    stated = Stated(
        rows="y",
        falling="y",
        unit=1.0,
        factor=scale * wavelength * obliquity / orders,
        steps=_read_zygo_resolution(header),
        length=1.0,
    )
    return build_map(numbers, stated, rows=rows)


def _read_zygo_points(lines: list[str], rows: str) -> RawMap:
    """Return the points of a list of Zygo: column, row and height, whose unit a setting chooses."""
    header, points, *_ = _divide_zygo(lines)
    fields = np.array(_WORDS.sub("nan", "\n".join(points)).split(), dtype=np.float64)
    heights = put_on_grid(fields.reshape(-1, 3)).heights
    stated = Stated(rows="x", falling="y", steps=_read_zygo_resolution(header), length=1.0)
    found = build_map(heights, stated, needs_unit=True)
    return attrs.evolve(found, rows="its y are counted downwards")


def _read_wyko(lines: list[str], rows: str) -> RawMap:
    """Return the heights in an ASCII file of Wyko: a line for each x."""
    fields = [line.split() for line in lines[:_MAX_HEADER_LINES]]
    start = next(place for place, words in enumerate(fields) if words[:1] == ["RAW_DATA"])
    stated = {words[0]: words[-1] for words in fields[1:start] if len(words) > 1}
    sizes = {words[0]: int(words[2]) for words in fields[1:3]}
    numbers = _read_numbers(lines[start + 1 : start + 1 + sizes["X"]], (sizes["X"], sizes["Y"]))
    # The second number of the first line says whether the numbers are nanometres, or parts of the wavelength.
    in_nanometres = lines[0].split()[-2] == "1"
    factor = 1.0 if in_nanometres else float(stated["Wavelength"]) / float(stated["Mult"])
    step = 1e-3 * float(stated["Pixel_size"])
    steps = (step, step * float(stated.get("Aspect", 1.0)))
    return build_map(numbers, Stated(rows="x", unit="nm", factor=factor, steps=steps, length=1.0), rows=rows)


def _read_igor(lines: list[str], rows: str) -> RawMap:
    """Return the wave in a text file of Igor: a line for each index of its rows, which are x."""
    waves = [line for line in lines if line.lstrip().upper().startswith("WAVES")]
    if len(waves) != 1:
        raise InputError(f"it holds {len(waves)} waves: export the one of heights alone")
    count = re.search(r"/N=\((\d+),\s*(\d+)\)", waves[0])
    if count is None:
        raise InputError(f"its wave {waves[0].strip()[:40]!a} has not two dimensions")
    words = [line.strip().upper() for line in lines]
    start = words.index("BEGIN")
    end = words.index("END")
    numbers = _read_numbers(lines[start + 1 : end], (int(count[1]), int(count[2])))
    scales = {}
    for found in re.finditer(
        r'SetScale(/[IP])?\s*([xyd])\s*,?\s*([^,]+),\s*([^,]+),\s*"([^"]*)"', "\n".join(lines[end:])
    ):
        kind, axis, first, second, unit = found.groups()
        points = int(count[1 if axis == "x" else 2])
        # /P gives the step, /I the last point, and no flag the end of the last point's cell.
        steps_there = points - 1 if kind == "/I" else points
        step = float(second) if kind == "/P" else (float(second) - float(first)) / steps_there
        scales[axis] = (step, unit)
    steps = [scales[axis][0] if axis in scales else None for axis in "xy"]
    return build_map(
        numbers,
        Stated(
            rows="x",
            unit=scales.get("d", (0.0, ""))[1] or None,
            steps=(steps[0], steps[1]),
            length=scales.get("x", (0.0, ""))[1] or None,
        ),
        rows=rows,
    )


# What a file of each of them begins with.
_READERS: dict[bytes, Callable[[list[str], str], RawMap]] = {
    b"DSAA": _read_surfer,
    b"aISO-": _read_sdf,
    b"aBCR-": _read_sdf,
    b"Zygo ASCII Data File": _read_zygo,
    b"Zygo XYZ Data File": _read_zygo_points,
    b"Wyko ASCII Data File": _read_wyko,
    b"IGOR": _read_igor,
}
