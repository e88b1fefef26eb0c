"""Binary grids: Surfer's of version 6 (DSBB) and 7 (DSRB), and Gwyddion's simple fields.

A simple field is an image (.gsf) or points x y z (.gxyzf) of numbers behind a header in text. The formats: Gwyddion
user guide, *Simple Field Files* and *Simple XYZ Files*. Surfer's grids in text are read with other texts.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Mapping
from pathlib import Path

import attrs
import numpy as np

from roughcontact._base.arrays import RealArray
from roughcontact._parts.files.base import RawMap, SurfaceReader, require_memory_of_map, shape_numbers
from roughcontact._parts.files.points import put_on_grid
from roughcontact._parts.files.stated import Stated, build_map, parse_number
from roughcontact.errors import InputError

# The value of a point without data in version 6; version 7 states its own.
_BLANK = 1.70141e38
# Version 6: numbers of points along x and y, ranges of x, y and z.
_HEAD_6 = struct.Struct("<4xhh6d")
# Version 7: sections of a mark, a length and the content. That of the grid: numbers of rows and columns, the first
# point, the steps along x and y, the range of z, a rotation, and the value of a point without data.
_SECTION = struct.Struct("<4sI")
_GRID = struct.Struct("<II8d")
_MAX_SECTIONS = 100
# A line of the header; the bytes to a multiple of which zeros fill it; and its bytes at most.
_LINE = re.compile(r"\s*(\w+)\s*=\s*(.*?)\s*")
_ALIGNMENTS = {b"Gwyddion Simple Field 1.0\n": 4, b"Gwyddion XYZ Field 1.0\n": 8}
_MAX_HEADER_BYTES = 2**16
# Columns of points with one channel: x, y, z.
_COLUMNS = 3


@attrs.frozen
class SurferReader(SurfaceReader):
    """A binary grid of Surfer, whose rows are those of y; it is known by its first bytes.

    Its unit of length is not stated: size and unit must be given.
    """

    suffixes = frozenset[str]()

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        size = path.stat().st_size
        require_memory_of_map(4.0 * size)
        data = path.read_bytes()
        kind = data[:4]
        if kind not in _SURFER_VERSIONS:
            raise InputError("it does not begin as grids of Surfer do (DSBB or DSRB): export it as text x y z")
        numbers, stated = _SURFER_VERSIONS[kind](data)
        return build_map(numbers, stated, line="a row of the grid", needs_unit=True)


def _read_6(data: bytes) -> tuple[RealArray, Stated]:
    if len(data) < _HEAD_6.size:
        raise InputError("its head is incomplete")
    columns, rows, x0, x1, y0, y1, *_ = _HEAD_6.unpack_from(data)
    rest = memoryview(data)[_HEAD_6.size :]
    numbers = np.frombuffer(rest[: len(rest) // 4 * 4], "<f4")
    return _shape(numbers, columns, rows), _describe(columns, rows, (x1 - x0, y1 - y0))


def _read_7(data: bytes) -> tuple[RealArray, Stated]:
    sections: dict[bytes, memoryview] = {}
    view = memoryview(data)
    place = 0
    for _ in range(_MAX_SECTIONS):
        if place + _SECTION.size > len(data):
            break
        mark, length = _SECTION.unpack_from(data, place)
        place += _SECTION.size
        if place + length > len(data):
            raise InputError(f"a part of it declares {length} bytes, but has {len(data) - place}: it is damaged")
        if mark in sections:
            raise InputError("it holds more than one grid")
        sections[mark] = view[place : place + length]
        place += length
    grid = sections.get(b"GRID", view[:0])
    if len(grid) < _GRID.size or b"DATA" not in sections:
        raise InputError("it holds no grid")
    rows, columns, _, _, dx, dy, _, _, rotation, blank = _GRID.unpack_from(grid)
    if rotation:
        raise InputError(f"its grid is turned by {rotation:g}, which is not read")
    content = sections[b"DATA"]
    numbers = np.frombuffer(content[: len(content) // 8 * 8], "<f8")
    stated = _describe(columns, rows, (dx * (columns - 1), dy * (rows - 1)))
    return _shape(numbers, columns, rows), attrs.evolve(stated, non_measured=(blank,))


def _shape(numbers: RealArray, columns: int, rows: int) -> RealArray:
    # The NaN of a damaged file may be a signalling one.
    with np.errstate(invalid="ignore"):
        values = shape_numbers(numbers, (rows, columns)).astype(np.float64)
    # The blank value and all above it are points without data.
    values[values >= _BLANK * (1.0 - 1e-6)] = math.nan
    return values


def _describe(columns: int, rows: int, ranges: tuple[float, float]) -> Stated:
    """Return what is stated by the distances of the first and the last points."""
    if not all(math.isfinite(one) and one > 0.0 for one in ranges) or min(columns, rows) < 2:
        raise InputError(f"its sides are {ranges[0]:g} and {ranges[1]:g}, which must be positive")
    return Stated(rows="y", steps=(ranges[0] / (columns - 1), ranges[1] / (rows - 1)))


_SURFER_VERSIONS = {b"DSBB": _read_6, b"DSRB": _read_7}


@attrs.frozen
class SimpleFieldReader(SurfaceReader):
    """A field that Gwyddion exports as .gsf, or points on a regular grid as .gxyzf; it states units and sides."""

    suffixes = frozenset({".gsf", ".gxyzf"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(4.0 * path.stat().st_size)
        data = path.read_bytes()
        mark = next((mark for mark in _ALIGNMENTS if data.startswith(mark)), None)
        if mark is None:
            raise InputError("it does not begin as the simple fields of Gwyddion do: it is damaged")
        end = data.find(b"\0", 0, _MAX_HEADER_BYTES)
        if end < 0:
            raise InputError("its header does not end: it is damaged")
        lines = data[len(mark) : end].decode("utf-8", "replace").splitlines()
        header = {found[1]: found[2] for line in lines if (found := _LINE.fullmatch(line))}
        start = (end // _ALIGNMENTS[mark] + 1) * _ALIGNMENTS[mark]
        return _FIELD_KINDS[mark](header, memoryview(data)[start:])


def _read_image(header: Mapping[str, str], data: memoryview) -> RawMap:
    rows, columns = (_read_count(header, name) for name in ("YRes", "XRes"))
    image = _read_numbers(data, "<f4", (rows, columns))
    has_sides = "XReal" in header and "YReal" in header
    stated = Stated(
        rows="y",
        falling="y",
        unit=header.get("ZUnits") or None,
        size=(parse_number(header["XReal"], "XReal"), parse_number(header["YReal"], "YReal"))
        if has_sides
        else (None, None),
        length=header.get("XYUnits") or None,
    )
    return build_map(image, stated, line="a line of the image", needs_unit=True)


def _read_points(header: Mapping[str, str], data: memoryview) -> RawMap:
    channels = _read_count(header, "NChannels")
    if channels != 1:
        raise InputError(f"it holds {channels} channels: export its heights alone")
    points = _read_numbers(data, "<f8", (_read_count(header, "NPoints"), _COLUMNS))
    grid = put_on_grid(points)
    stated = Stated(
        rows="x",
        unit=header.get("ZUnits1") or header.get("ZUnits") or None,
        steps=grid.steps or (None, None),
        length=header.get("XYUnits") or None,
    )
    return attrs.evolve(build_map(grid.heights, stated, needs_unit=True), rows="")


_FIELD_KINDS: dict[bytes, Callable[[Mapping[str, str], memoryview], RawMap]] = dict(
    zip(_ALIGNMENTS, (_read_image, _read_points), strict=True)
)


def _read_count(header: Mapping[str, str], name: str) -> int:
    text = header.get(name, "")
    if not text.isdecimal() or int(text) < 1:
        raise InputError(f"its {name} is {text[:20]!a}, which is not a number of points")
    return int(text)


def _read_numbers(data: memoryview, kind: str, shape: tuple[int, int]) -> np.ndarray:
    needed = shape[0] * shape[1] * np.dtype(kind).itemsize
    if len(data) != needed:
        raise InputError(f"it declares {needed} bytes of numbers, but holds {len(data)}: it is damaged")
    return np.frombuffer(data, kind).reshape(shape)
