"""Files .x3p of ISO 5436-2 (ISO 25178-72): a description in XML and heights, in a ZIP archive."""

from __future__ import annotations

import hashlib
import itertools
import math
import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.files.base import RawMap, SurfaceReader, name_rows, require_memory_of_map
from roughcontact._parts.files.bounds import require_bounded_archive
from roughcontact._parts.files.stated import parse_number
from roughcontact.errors import InputError

# Types of numbers by their letter: integers of 16 and 32 bits, floating-point numbers of 32 and 64.
_TYPES = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}
# Largest element of a stated rotation that is none.
_ROTATION_TOLERANCE = 1e-6
# A checksum by MD5; some programs write none, or a place-holder.
_DIGEST = re.compile(r"(?!0{32})[0-9a-f]{32}")


@attrs.frozen
class X3pReader(SurfaceReader):
    """A surface in .x3p of ISO 5436-2.

    Its points are regular along x and y, its heights numbers of any type, in a file of the archive or in the
    description. Points that are marked as invalid, or not finite, are non-measured.

    References
    ----------
    ISO 25178-72:2017
    """

    suffixes = frozenset({".x3p"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        try:
            require_bounded_archive(path)
            with zipfile.ZipFile(path) as archive:
                return _read_surface(archive)
        except zipfile.BadZipFile as error:
            raise InputError(f"its archive is damaged ({error})") from None


def _read_surface(archive: zipfile.ZipFile) -> RawMap:
    names = [name for name in archive.namelist() if name.rsplit("/", 1)[-1].lower() == "main.xml"]
    if len(names) != 1:
        raise InputError(f"it must hold one description main.xml, but holds {len(names)}")
    root = _parse(archive, names[0])
    steps = [_find_step(root, axis) for axis in "XY"]
    _require_unturned(root)
    sizes = [int(_find_number(root, f"Size{axis}", 1.0)) for axis in "XYZ"]
    if sizes[2] != 1 or min(sizes[:2]) < 2:
        raise InputError(f"it holds {' x '.join(map(str, sizes))} points, which are not one surface")
    count = sizes[0] * sizes[1]
    require_memory_of_map(16.0 * count)
    folder = names[0].rpartition("/")[0]
    values = _read_heights(archive, root, folder, count)
    scale = _find_number(root, "Axes/CZ/Increment", 1.0)
    heights = values * scale + _find_number(root, "Axes/CZ/Offset", 0.0)
    heights[~np.isfinite(heights)] = np.nan
    if valid := _find_text(root, "ValidPointsLink"):
        bits = np.frombuffer(_read_member(archive, folder, valid, (count + 7) // 8), np.uint8)
        heights[np.unpackbits(bits, bitorder="little")[:count] == 0] = np.nan
    # x runs fastest.
    image = heights.reshape(sizes[1], sizes[0])
    return RawMap(
        np.ascontiguousarray(image.T),
        (sizes[0] * steps[0], sizes[1] * steps[1]),
        metric=True,
        rows=name_rows("y"),
    )


def _parse(archive: zipfile.ZipFile, name: str) -> ElementTree.Element:
    text = archive.read(name)
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise InputError("its description defines entities, which no surface needs: it is not read")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise InputError(f"its description is not XML ({error})") from None
    for element in root.iter():
        element.tag = str(element.tag).rpartition("}")[2]
    return root


def _find_text(root: ElementTree.Element, path: str) -> str:
    return (root.findtext(f".//{path}") or "").strip()


def _find_number(root: ElementTree.Element, path: str, default: float) -> float:
    text = _find_text(root, path)
    return parse_number(text, path.rpartition("/")[2]) if text else default


def _find_step(root: ElementTree.Element, axis: str) -> float:
    """Return the distance of the points along an axis, m."""
    if _find_text(root, f"Axes/C{axis}/AxisType").upper() == "A":
        raise InputError(f"its {axis.lower()} are absolute positions: export it with regular points")
    step = _find_number(root, f"Axes/C{axis}/Increment", 0.0)
    if not step > 0.0:
        raise InputError(f"it does not state the distance of its points along {axis.lower()}")
    return step


def _require_unturned(root: ElementTree.Element) -> None:
    """Refuse a surface whose axes are stated to be turned."""
    for row, column in itertools.product(range(1, 4), repeat=2):
        one = float(row == column)
        if abs(_find_number(root, f"Rotation/r{row}{column}", one) - one) > _ROTATION_TOLERANCE:
            raise InputError("it states a rotation of its axes, which is not read: export it without rotation")


def _read_heights(archive: zipfile.ZipFile, root: ElementTree.Element, folder: str, count: int) -> Array:
    """Return the numbers of all points, shape (count,), NaN where the description has an empty one."""
    if link := _find_text(root, "PointDataLink"):
        letter = (_find_text(root, "Axes/CZ/DataType") or "D").upper()
        if letter not in _TYPES:
            raise InputError(f"its heights are of the type {letter[:20]!a}, which is not one of {', '.join(_TYPES)}")
        dtype = np.dtype(_TYPES[letter])
        data = _read_member(archive, folder, link, count * dtype.itemsize)
        _require_digest(root, data)
        return np.frombuffer(data, dtype=dtype).astype(np.float64)
    data_list = root.find(".//DataList")
    if data_list is None:
        raise InputError("it holds no heights")
    words = [(datum.text or "").split(";")[-1].strip() for datum in data_list.iter("Datum")]
    if len(words) != count:
        raise InputError(f"it states {count} points, but lists {len(words)}")
    try:
        return np.array([float(word) if word else math.nan for word in words])
    except ValueError as error:
        raise InputError(f"a height in its description is not a number ({error})") from None


def _require_digest(root: ElementTree.Element, data: bytes) -> None:
    """Refuse heights that are not those of the checksum, where the description has one."""
    stated = _find_text(root, "MD5ChecksumPointData").lower()
    if _DIGEST.fullmatch(stated) and stated != hashlib.md5(data, usedforsecurity=False).hexdigest():
        raise InputError("its heights are not those of its checksum: it is damaged")


def _read_member(archive: zipfile.ZipFile, folder: str, name: str, size: int) -> bytes:
    """Return the bytes of a member beside the description, or of that name anywhere."""
    wanted = [f"{folder}/{name}" if folder else name]
    wanted += [one for one in archive.namelist() if one.rsplit("/", 1)[-1] == name.rsplit("/", 1)[-1]]
    found = next((one for one in wanted if one in archive.namelist()), None)
    if found is None:
        raise InputError(f"its description names {name[:40]!a}, which is not in the archive")
    if archive.getinfo(found).file_size < size:
        raise InputError(f"{name[:40]!a} in it has {archive.getinfo(found).file_size} bytes, but {size} are stated")
    return archive.read(found)[:size]
