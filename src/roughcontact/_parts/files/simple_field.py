"""Simple fields of Gwyddion: an image (.gsf) or points x y z (.gxyzf) of numbers behind a header in text.

The formats: Gwyddion user guide, *Simple Field Files* and *Simple XYZ Files*.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import attrs
import numpy as np

from roughcontact._parts.files.base import RawMap, SurfaceReader, require_memory_of_map
from roughcontact._parts.files.points import put_on_grid
from roughcontact._parts.files.stated import Stated, build_map, parse_number
from roughcontact.errors import InputError

# A line of the header; the bytes to a multiple of which zeros fill it; and its bytes at most.
_LINE = re.compile(r"\s*(\w+)\s*=\s*(.*?)\s*")
_ALIGNMENTS = {b"Gwyddion Simple Field 1.0\n": 4, b"Gwyddion XYZ Field 1.0\n": 8}
_MAX_HEADER_BYTES = 2**16
# Columns of points with one channel: x, y, z.
_COLUMNS = 3


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
        return _KINDS[mark](header, memoryview(data)[start:])


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


_KINDS: dict[bytes, Callable[[Mapping[str, str], memoryview], RawMap]] = dict(
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
