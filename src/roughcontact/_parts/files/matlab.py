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

import attrs
import numpy as np

from roughcontact._base.archive import bound_expansion
from roughcontact._base.arrays import RealArray
from roughcontact._parts.files.base import RawMap, require_memory_of_map
from roughcontact._parts.files.bounds import ARRAYS, HDF5_SIGNATURE
from roughcontact._parts.files.hdf5 import MAX_TEXT_BYTES, read_hdf5
from roughcontact._parts.files.named import CHANGING_NAMES, STATING_NAMES, NamedArray, NamedArrayReader, choose_map
from roughcontact.errors import InputError

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
# Classes of cells, structures and objects.
_NO_ARRAYS = (1, 2, 3)
# The class of texts, and the encodings of their letters by the type of data; that of UTF-8 has no order of bytes.
_CHAR_CLASS = 4
_UTF_8 = 16
_TEXT_ENCODINGS = {4: "utf-16", _UTF_8: "utf-8", 17: "utf-16"}


def read_mat(path: Path) -> tuple[dict[str, NamedArray], dict[str, str]]:
    """Return the real two-dimensional arrays of numbers in a .mat file, shape (rows, columns), and its texts, by name.

    `InputError` if it is damaged or of another kind; `MissingPackage` if it is of version 7.3 and h5py is missing.
    """
    with path.open("rb") as file:
        start = file.read(_HEAD_BYTES)
        if start.startswith(HDF5_SIGNATURE) or b"MATLAB 7.3" in start[:20]:
            # HDF5 lists the dimensions of MATLAB backwards.
            found, texts = read_hdf5(path)
            return {name: NamedArray(one.values.T, one.attributes) for name, one in found.items()}, texts
        data = file.read()
    if start[126:128] not in (b"IM", b"MI"):
        raise InputError("it is not a .mat file of level 5 or 7.3: save it with save('map.mat', 'heights', '-v7')")
    order = "<" if start[126:128] == b"IM" else ">"
    arrays: dict[str, NamedArray] = {}
    texts = {}
    # Bytes for all arrays together.
    left = bound_expansion(len(data), ARRAYS)
    for kind, content in _elements(data, order):
        if kind == _COMPRESSED_ELEMENT:
            content = _inflate(content, order, left)
            left -= len(content)
        elif kind != _MATRIX_ELEMENT:
            continue
        for name, one in _read_matrix(content, order).items():
            if isinstance(one, str):
                texts[name] = one
            else:
                arrays[name] = NamedArray(one)
    return arrays, texts


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


def _read_matrix(content: memoryview, order: str) -> dict[str, RealArray | str]:
    """Return an array, or a text, by its name, or nothing if it is of another kind."""
    parts = _elements(content, order)
    flags, dimensions, name, numbers = (next(parts, (0, memoryview(b""))) for _ in range(4))
    if len(flags[1]) != 8 or len(dimensions[1]) != 8 or len(name[1]) > _MAX_NAME_BYTES:
        return {}
    (flag,) = struct.unpack_from(f"{order}I", flags[1])
    shape = struct.unpack(f"{order}ii", dimensions[1])
    text = bytes(name[1]).decode("ascii", "replace")
    if flag & 0xFF in _NO_ARRAYS and text in STATING_NAMES:
        raise InputError(f"its {text!a} is a cell or a structure, which is not read: save it as a number or a text")
    if flag & 0xFF == _CHAR_CLASS and shape[0] == 1:
        return _read_letters(text, numbers, order)
    is_mask = bool(flag & _LOGICAL_FLAG)
    if (
        flag & 0xFF not in _NUMERIC_CLASSES
        or flag & _COMPLEX_FLAG
        or (is_mask and text.lower() not in CHANGING_NAMES)
        or min(shape) < 1
        or numbers[0] not in _NUMBER_TYPES
    ):
        return {}
    kind = np.dtype(f"{order}{_NUMBER_TYPES[numbers[0]]}")
    if len(numbers[1]) != math.prod(shape) * kind.itemsize:
        raise InputError(
            f"its array {text!a} declares {shape[0]} x {shape[1]} numbers, but holds others: it is damaged"
        )
    # By columns, as Fortran keeps arrays.
    return {text: np.frombuffer(numbers[1], dtype=kind).reshape(shape, order="F")}


def _read_letters(name: str, letters: tuple[int, memoryview], order: str) -> dict[str, RealArray | str]:
    """Return a short text by its name, or nothing if it is of another kind."""
    kind, data = letters
    if kind not in _TEXT_ENCODINGS or len(data) > MAX_TEXT_BYTES:
        return {}
    encoding = _TEXT_ENCODINGS[kind] + ({"<": "-le", ">": "-be"}[order] if kind != _UTF_8 else "")
    return {name: bytes(data).decode(encoding, "replace").strip("\0 ")}


@attrs.frozen
class MatReader(NamedArrayReader):
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
    no_data
        The number that stands for a non-measured point, or ``"none"``; one that looks so is asked about.
    """

    suffixes = frozenset({".mat"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(2.0 * path.stat().st_size)
        return choose_map(*read_mat(path), self)
