"""Arrays of .mat files: MATLAB's level 5 (as `save -v6`, `-v7` and scipy write it) and, by h5py, 7.3.

Level 5 is read here and not by scipy.io, which allocates whatever a file declares and builds any object: only real
two-dimensional arrays of numbers are read. The format: MathWorks, *MAT-File Format*, 2019.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Pair, RealArray
from roughcontact._parts.files.base import RawMap, SurfaceReader, check_rows, put_x_first, require_memory_of_map
from roughcontact.errors import InputError, MissingPackage

# Bytes to which compressed arrays may expand, plus a multiple of the file: heights deflate by 1 to 2, zeros by 1000.
_EXPANSION_ALLOWANCE = 2**21
_MAX_EXPANSION_RATIO = 20
# Bytes of the head of a file, and maximum bytes of the name of an array.
_HEAD_BYTES = 128
_MAX_NAME_BYTES = 64
# Types of data by number: integers and floats of MATLAB.
_NUMBER_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
# Element types of an array with its head, and of a deflated one.
_MATRIX_ELEMENT = 14
_COMPRESSED_ELEMENT = 15
# Numeric classes of arrays, double (6) to uint64 (15), and the flags of complex and of logical arrays.
_NUMERIC_CLASSES = range(6, 16)
_COMPLEX_FLAG = 0x0800
_LOGICAL_FLAG = 0x0200
# Arrays that give the sides of a map, and the longest side of one, m.
_SIZE_NAMES = ("size", "lx", "ly", "dx", "dy")
_MAX_SIDE = 1.0
# The signature of HDF5, behind the head of a file by MATLAB.
_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
# Filters of HDF5 that MATLAB uses: deflate and shuffle.
_MATLAB_FILTERS = {1, 2}


def read_mat(path: Path) -> dict[str, RealArray]:
    """Return the real two-dimensional arrays of numbers in a .mat file by name, shape (rows, columns).

    `InputError` if it is damaged or of another kind; `MissingPackage` if it is of version 7.3 and h5py is missing.
    """
    with path.open("rb") as file:
        start = file.read(_HEAD_BYTES)
        if (
            start.startswith(_HDF5_SIGNATURE)
            or file.read(len(_HDF5_SIGNATURE)) == _HDF5_SIGNATURE
            or b"MATLAB 7.3" in start[:20]
        ):
            return _read_hdf5(path)
        file.seek(len(start))
        data = file.read()
    if start[126:128] not in (b"IM", b"MI"):
        raise InputError("it is not a .mat file of level 5 or 7.3: save it with save('map.mat', 'heights', '-v7')")
    order = "<" if start[126:128] == b"IM" else ">"
    arrays: dict[str, RealArray] = {}
    # Bytes for all arrays together.
    left = _EXPANSION_ALLOWANCE + _MAX_EXPANSION_RATIO * len(data)
    for kind, content in _elements(data, order):
        if kind == _COMPRESSED_ELEMENT:
            content = _inflate(content, order, left)
            left -= len(content)
        elif kind != _MATRIX_ELEMENT:
            continue
        arrays |= _read_matrix(content, order)
    return arrays


def _elements(data: bytes | memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Yield the type and the content of each data element, which are aligned to 8 bytes unless compressed."""
    view = memoryview(data)
    place = 0
    while place + 8 <= len(view):
        kind, size = struct.unpack_from(f"{order}II", view, place)
        if kind >> 16:
            # The tag itself holds up to four bytes.
            size = kind >> 16
            kind &= 0xFFFF
            start = place + 4
            end = place + 8
        else:
            start = place + 8
            end = start + size
        if start + size > min(end, len(view)):
            raise InputError(f"an element of type {kind} declares {size} bytes, more than it has: it is damaged")
        yield kind, view[start : start + size]
        place = end if kind == _COMPRESSED_ELEMENT else -(-end // 8) * 8


def _inflate(content: memoryview, order: str, most: int) -> memoryview:
    """Return the matrix in a compressed element."""
    stream = zlib.decompressobj()
    data = stream.decompress(content, most)
    if stream.unconsumed_tail or not stream.eof:
        raise InputError(f"an array of it is damaged, or expands to more than {most} bytes: save it with '-v6'")
    (kind, inner), *_ = [*_elements(data, order), (0, memoryview(b""))]
    return inner if kind == _MATRIX_ELEMENT else memoryview(b"")


def _read_matrix(content: memoryview, order: str) -> dict[str, RealArray]:
    """Return an array by its name, or nothing if it is of another kind."""
    parts = _elements(content, order)
    flags, dimensions, name, numbers = (next(parts, (0, memoryview(b""))) for _ in range(4))
    if len(flags[1]) != 8 or len(dimensions[1]) != 8 or len(name[1]) > _MAX_NAME_BYTES:
        return {}
    (flag,) = struct.unpack_from(f"{order}I", flags[1])
    shape = struct.unpack(f"{order}ii", dimensions[1])
    if (
        flag & 0xFF not in _NUMERIC_CLASSES
        or flag & (_COMPLEX_FLAG | _LOGICAL_FLAG)
        or min(shape) < 1
        or numbers[0] not in _NUMBER_TYPES
    ):
        return {}
    text = bytes(name[1]).decode("ascii", "replace")
    kind = np.dtype(f"{order}{_NUMBER_TYPES[numbers[0]]}")
    if len(numbers[1]) != math.prod(shape) * kind.itemsize:
        raise InputError(
            f"its array {text!a} declares {shape[0]} x {shape[1]} numbers, but holds others: it is damaged"
        )
    # By columns, as Fortran keeps arrays.
    return {text: np.frombuffer(numbers[1], dtype=kind).reshape(shape, order="F")}


def _read_hdf5(path: Path) -> dict[str, RealArray]:
    try:
        import h5py
    except ImportError:
        raise MissingPackage(
            "A .mat file of version 7.3 needs the package h5py: pip install 'roughcontact[store]', or save it with "
            "save(file, 'heights', '-v7')."
        ) from None
    arrays: dict[str, RealArray] = {}
    size = path.stat().st_size
    left = _EXPANSION_ALLOWANCE + _MAX_EXPANSION_RATIO * size
    with path.open("rb") as stream, h5py.File(stream, "r") as file:
        for name in file:
            link = file.get(name, getlink=True)
            item = file[name] if isinstance(link, h5py.HardLink) else None
            if not isinstance(item, h5py.Dataset) or len(item.shape) != 2 or not _is_plain(item, h5py):
                continue
            left -= math.prod(item.shape) * item.dtype.itemsize
            if left < 0:
                raise InputError(f"its arrays are larger than a file of {size} bytes can hold")
            # HDF5 lists the dimensions of MATLAB backwards.
            arrays[str(name)] = np.asarray(item[()]).T
    return arrays


def _is_plain(item: Any, h5py: Any) -> bool:
    """Return whether an item is an array of numbers inside the file; other items are not read."""
    if item.id.get_type().get_class() not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT) or item.dtype.kind not in "iuf":
        return False
    stored = item.id.get_create_plist()
    filters = {stored.get_filter(number)[0] for number in range(stored.get_nfilters())}
    is_inside = stored.get_layout() in (h5py.h5d.COMPACT, h5py.h5d.CONTIGUOUS, h5py.h5d.CHUNKED)
    return is_inside and not stored.get_external_count() and filters <= _MATLAB_FILTERS


def _find_size(arrays: dict[str, RealArray], shape: tuple[int, int]) -> tuple[Pair | None, str]:
    """Return the sides of a map, m, from `size`, `lx` and `ly`, or the pitch `dx` and `dy`; and these in words."""
    known = {name: arrays[name].ravel().astype(np.float64).tolist() for name in _SIZE_NAMES if name in arrays}
    known = {name: values for name, values in known.items() if len(values) <= 2}
    words = ", ".join(f"its {name} is {' x '.join(f'{value:g}' for value in values)}" for name, values in known.items())
    sides = known.get("size") or [*known.get("lx", []), *known.get("ly", [])]
    if not sides and "dx" in known:
        sides = [shape[0] * known["dx"][0], shape[1] * known.get("dy", known["dx"])[0]]
    if len(sides) == 1 and shape[0] == shape[1]:
        sides = 2 * sides
    # A side of more than a metre is in another unit.
    if len(sides) != 2 or not all(0.0 < side <= _MAX_SIDE for side in sides):
        return None, words
    return (sides[0], sides[1]), words


def _variable(value: str | None) -> str | None:
    if value is not None and (not isinstance(value, str) or not value):
        raise InputError.about("The variable in a .mat file", value, "the name of an array in it")
    return value


@attrs.frozen
class MatReader(SurfaceReader):
    """``save('map.mat', 'heights', 'size')``: an array of numbers in a .mat file of MATLAB or scipy, first index x.

    The sides of the map are read from `size`, from `lx` and `ly`, or by the pitch from `dx` and `dy`, where there are
    such in metres. Version 7.3 needs h5py.

    Parameters
    ----------
    variable
        Name of the array; by default `heights`, or the only array of numbers with two dimensions.
    rows
        ``"x"`` or ``"y"``: the axis of the first index, the smallest first; by default x. MATLAB's `meshgrid` makes a
        row for each y.
    """

    variable: str | None = attrs.field(default=None, converter=_variable)
    rows: str = attrs.field(default="auto", converter=check_rows)

    @property
    def suffixes(self) -> frozenset[str]:
        """Mat."""
        return frozenset({".mat"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(2.0 * path.stat().st_size)
        arrays = read_mat(path)
        maps = {name: array for name, array in arrays.items() if min(array.shape) > 1}
        name = self.variable or ("heights" if "heights" in maps else min(maps, default=""))
        if name not in maps or (self.variable is None and name != "heights" and len(maps) > 1):
            found = ", ".join(sorted(maps)) or "none"
            raise InputError(
                "its array of heights is not known: give variable= with its name; its real arrays of two dimensions "
                f"are: {found:.200}"
            )
        heights = put_x_first(np.array(maps[name], dtype=np.float64, order="C"), self.rows)
        size, words = _find_size(arrays, (heights.shape[0], heights.shape[1]))
        return RawMap(heights, size, hint=words, needs_rows=self.rows == "auto")
