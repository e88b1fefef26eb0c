"""Binary grids of Surfer, of version 6 (DSBB) and 7 (DSRB); those in text are read with other texts."""

from __future__ import annotations

import math
import struct
from pathlib import Path

import attrs
import numpy as np

from roughcontact._base.arrays import RealArray
from roughcontact._parts.files.base import RawMap, SurfaceReader, require_memory_of_map
from roughcontact._parts.files.stated import Stated, build_map
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
        if kind not in _KINDS:
            raise InputError("it does not begin as grids of Surfer do (DSBB or DSRB): export it as text x y z")
        numbers, stated = _KINDS[kind](data)
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
    if min(columns, rows) < 2 or columns * rows != numbers.size:
        raise InputError(f"it declares {columns} x {rows} points, but holds {numbers.size}: it is damaged")
    # The NaN of a damaged file may be a signalling one.
    with np.errstate(invalid="ignore"):
        values = numbers.reshape(rows, columns).astype(np.float64)
    # The blank value and all above it are points without data.
    values[values >= _BLANK * (1.0 - 1e-6)] = math.nan
    return values


def _describe(columns: int, rows: int, ranges: tuple[float, float]) -> Stated:
    """Return what is stated by the distances of the first and the last points."""
    if not all(math.isfinite(one) and one > 0.0 for one in ranges) or min(columns, rows) < 2:
        raise InputError(f"its sides are {ranges[0]:g} and {ranges[1]:g}, which must be positive")
    return Stated(rows="y", steps=(ranges[0] / (columns - 1), ranges[1] / (rows - 1)))


_KINDS = {b"DSBB": _read_6, b"DSRB": _read_7}
