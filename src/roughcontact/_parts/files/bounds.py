"""What a binary file declares, against its bytes: looked at before anybody allocates it."""

from __future__ import annotations

import math
import mmap
import re
import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any

from roughcontact._base.archive import bound_expansion, require_expansion
from roughcontact.errors import InputError

# Bytes to which arrays may expand, plus a multiple of the file: heights deflate by 1 to 2, zeros by 1000; and the same
# of texts, whose digits deflate by 2 to 20, and of images.
ARRAYS = (2**21, 20)
TEXT_OR_IMAGE = (2**22, 50)
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
# Members of a file of HDF5, with those of its groups, that are looked at.
_MAX_MEMBERS = 10_000
# A heap of texts in HDF5: its head is mark, version and size, at a multiple of eight bytes; then come objects, each
# with a head of number, references, nothing and size. And the mark of types that h5py would make of any bytes.
_HEAP = re.compile(rb"GCOL\x01\x00\x00\x00")
_HEAP_HEAD = struct.Struct("<8xQ")
_OBJECT_HEAD = struct.Struct("<HH4xQ")
_PYTHON_TYPE = b"NUMPY:"
# Endings of descriptions in the archives of instruments, and their maximum bytes: parsed XML takes twenty times more.
_DESCRIPTION_ENDINGS = (".xml", ".txt")
_MAX_DESCRIPTION_BYTES = 2**22
# First bytes of compound files of Windows, in which MountainsMap keeps deflated blocks; the heads of such blocks; and
# the bytes that are inflated at a time.
_COMPOUND = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_DEFLATED = re.compile(rb"\x78[\x01\x5e\x9c\xda]")
_BLOCK = 2**16


def require_room(
    needed: float, size: int, what: str = "its arrays are larger", bound: tuple[int, int] = ARRAYS
) -> None:
    """Refuse so many bytes, of which `what` tells, if a file of `size` bytes cannot hold them."""
    if needed > bound_expansion(size, bound):
        raise InputError(f"{what} than a file of {size} bytes can hold")


def require_bounded(path: Path) -> None:
    """Refuse a file that expands to far more than its bytes: a foreign reader would not check the memory."""
    require_bounded_archive(path)
    if begins_with(path, HDF5_SIGNATURE):
        _require_bounded_hdf5(path)
    elif begins_with(path, _COMPOUND):
        _require_bounded_blocks(path)


def require_bounded_archive(path: Path) -> None:
    """Refuse an archive that expands to far more than its bytes: its reader would not check the memory."""
    with path.open("rb") as file:
        if not zipfile.is_zipfile(file):
            return
        with zipfile.ZipFile(file) as archive:
            require_expansion(archive, path.stat().st_size, "export it without compression", deflated=True)
            texts = [
                member.file_size
                for member in archive.infolist()
                if member.filename.lower().endswith(_DESCRIPTION_ENDINGS)
            ]
    if max(texts, default=0) > _MAX_DESCRIPTION_BYTES:
        raise InputError(
            f"a description in it has {max(texts)} bytes, more than {_MAX_DESCRIPTION_BYTES}: it is damaged"
        )


def begins_with(path: Path, mark: bytes) -> bool:
    """Return whether a file has these first bytes, whatever its ending."""
    with path.open("rb") as stream:
        return stream.read(len(mark)) == mark


def require_sound_hdf5(path: Path) -> None:
    """Refuse HDF5 whose heap of texts would be searched for ever, or whose bytes would become objects of Python."""
    with path.open("rb") as stream:
        if not path.stat().st_size:
            return
        with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            if data.find(_PYTHON_TYPE) >= 0:
                raise InputError("it holds objects of Python, which are not read: write the heights alone")
            for found in _HEAP.finditer(data):
                if not _is_sound(data, found.start()):
                    raise InputError("its texts are damaged: write it again")


def _is_sound(data: mmap.mmap, place: int) -> bool:
    """Return whether a heap is stepped through to its end."""
    if place + _HEAP_HEAD.size > len(data):
        return False
    (size,) = _HEAP_HEAD.unpack_from(data, place)
    end = place + size
    place += _HEAP_HEAD.size
    if end > len(data):
        return False
    while place + _OBJECT_HEAD.size <= end:
        number, _, length = _OBJECT_HEAD.unpack_from(data, place)
        # What is free, number 0, counts its head too.
        step = _OBJECT_HEAD.size + -(-length // 8) * 8 if number else length
        if not 0 < step <= end - place:
            return False
        place += step
    return True


def _require_bounded_hdf5(path: Path) -> None:
    """Refuse an HDF5 file whose arrays, of any kind and dimension, are larger than it can hold.

    Foreign libraries make them before they look: a file of 10 kB may declare gigabytes that nobody has written.
    """
    try:
        import h5py
    except ImportError:
        return
    require_sound_hdf5(path)
    with path.open("rb") as stream, h5py.File(stream, "r") as file:
        arrays = [item for item in list_members(file, _MAX_MEMBERS).values() if isinstance(item, h5py.Dataset)]
        needed = sum(math.prod(item.shape or ()) * item.dtype.itemsize for item in arrays)
    require_room(needed, path.stat().st_size)


def list_members(file: Any, most: int) -> dict[str, Any]:
    """Return the groups, arrays and types that stand in a file of HDF5, each once, by their paths.

    `InputError` if they are too many.
    """
    found: dict[str, Any] = {}

    def keep(name: str, item: Any) -> bool | None:
        found[name] = item
        # Any value but None ends the visit.
        return True if len(found) > most else None

    file.visititems(keep)
    if len(found) > most:
        raise InputError(f"it has more than {most} members: write the heights alone")
    return found


def _require_bounded_blocks(path: Path) -> None:
    """Refuse a compound file whose deflated blocks expand to far more than its bytes."""
    data = memoryview(path.read_bytes())
    left = bound_expansion(len(data), ARRAYS)
    for head in _DEFLATED.finditer(data):
        left -= _count_inflated(data[head.start() :], left)
        if left < 0:
            raise InputError(f"its blocks expand to more than a file of {len(data)} bytes can hold")


def _count_inflated(data: memoryview, most: int) -> int:
    """Return the bytes to which a deflated block expands, up to somewhat more than a limit; 0 if it is none."""
    stream = zlib.decompressobj()
    count = 0
    rest: bytes | memoryview = data[:_BLOCK]
    place = len(rest)
    try:
        while not stream.eof and count <= most and (rest or place < len(data)):
            if not rest:
                rest = data[place : place + _BLOCK]
                place += len(rest)
            count += len(stream.decompress(rest, _BLOCK))
            rest = stream.unconsumed_tail
    except zlib.error:
        # What is not a block after some thousand bytes expands for a reader, too, but no further.
        return count if count > most else 0
    return count
