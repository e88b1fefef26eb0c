"""The reader interface, and files that hold no height map."""

from __future__ import annotations

import abc
import contextlib
import math
import os
import re
from pathlib import Path

import attrs
import numpy as np

from roughcontact._base.archive import SEAL
from roughcontact._base.arrays import Array, Pair, RealArray
from roughcontact._base.checks import Part, choice
from roughcontact._base.machine import require_memory
from roughcontact._base.registry import Registry
from roughcontact._base.units import outlined
from roughcontact.errors import InputError, either

_PICTURE_ADVICE = "export the heights themselves, as text or TIFF in 32-bit floating point"
_DOCUMENT_ADVICE = "export the heights themselves, as text"
_POINTS_ADVICE = "export the heights on a regular grid, as text x y z"
_GRID_ADVICE = "export it as text x y z, or as a grid of ESRI or Surfer"
_PACKED_ADVICE = "unpack it first"
GRIDDATA_ADVICE = either(", as by scipy.interpolate.griddata")
SAVE_ADVICE = either(
    "write the heights with numpy.savez(path, heights=heights, size=(lx, ly))", "write one row of text for each x"
)
# The first bytes of files without heights, letters in lower case, their kind, and advice.
_FOREIGN_KINDS: dict[bytes | tuple[bytes, ...], tuple[str, str]] = {
    b"\x89png": ("a PNG picture", _PICTURE_ADVICE),
    (b"\xff\xd8\xff", b"\0\0\0\x0cjp  "): ("a JPEG picture", _PICTURE_ADVICE),
    b"gif8": ("a GIF picture", _PICTURE_ADVICE),
    b"8bps": ("a picture of Photoshop", _PICTURE_ADVICE),
    b"riff": ("a picture or a film", _PICTURE_ADVICE),
    b"%pdf": ("a PDF document", _DOCUMENT_ADVICE),
    b"{\\rtf": ("a text with its layout (RTF)", _DOCUMENT_ADVICE),
    (b"<!doctype html", b"<html"): ("a page of HTML", _DOCUMENT_ADVICE),
    b"<?xml": ("an XML document", _DOCUMENT_ADVICE),
    b"<vtkfile": ("image data of VTK", _DOCUMENT_ADVICE),
    b"# vtk datafile": ("data of VTK", _DOCUMENT_ADVICE),
    (b"ply\n", b"ply\r\n"): ("a cloud of points in PLY", _POINTS_ADVICE),
    b"lasf": ("a cloud of points in LAS", _POINTS_ADVICE),
    b"astm-e57": ("a cloud of points in E57", _POINTS_ADVICE),
    (b"# .pcd", b"version .7"): ("a cloud of points in PCD", _POINTS_ADVICE),
    b"simple  =": ("an image in FITS", _PICTURE_ADVICE),
    b"\x76\x2f\x31\x01": ("a picture in OpenEXR", _PICTURE_ADVICE),
    b"nrrd0": ("an image in NRRD", _PICTURE_ADVICE),
    b"objecttype = image": ("an image in MetaImage", _PICTURE_ADVICE),
    b"fsasci": ("a grid of CPS-3", _GRID_ADVICE),
    b"exp  0": ("a file in the interchange format of ArcInfo", _GRID_ADVICE),
    b'{"': ("a text in JSON", SAVE_ADVICE),
    b"{{": ("a list of Mathematica", 'export it as a table: Export["map.csv", heights]'),
    b"par1": ("a table in Parquet", _DOCUMENT_ADVICE),
    b"sqlite format": ("a data base of SQLite", _DOCUMENT_ADVICE),
    b"dscompressed": ("a compressed file of MountainsMap", "save it without compression, or export it as text"),
    b"\x1f\x8b": ("compressed by gzip", "unpack it first (gunzip)"),
    b"bzh": ("compressed by bzip2", _PACKED_ADVICE),
    b"\xfd7zxz": ("compressed by xz", _PACKED_ADVICE),
    b"7z\xbc\xaf": ("a 7z archive", _PACKED_ADVICE),
    b"rar!": ("a RAR archive", _PACKED_ADVICE),
    b"\x28\xb5\x2f\xfd": ("compressed by Zstandard", _PACKED_ADVICE),
}
# Lines near the beginning of texts that are not read.
_FOREIGN_LINES = {
    re.compile(rb"\A-996(?:\s+\S+){3}\s*\n(?:\s*\S+){4}\s*\n(?:\s*\S+){4}\s*\n\s*0(?:\s+0){6}\s"): (
        "a grid of Irap",
        _GRID_ADVICE,
    ),
    re.compile(rb"(?m)^@[^\n]*,\s*grid\s*,[^\n]*$"): ("a grid of ZMAP+", _GRID_ADVICE),
    re.compile(rb"(?ms)^#points\s*\n\s*\d+.*^#grid\s*$"): ("a grid in the Grid eXchange Format (GXF)", _GRID_ADVICE),
    re.compile(rb"\Ap[25]\s+(?:#[^\n]*\n\s*)?\d+\s+\d+\s+\d+\s"): ("a picture (PGM)", _PICTURE_ADVICE),
    re.compile(rb"\Apf\s+\d+\s+\d+\s+[-+.0-9]+\s"): ("a picture (PFM)", _PICTURE_ADVICE),
    re.compile(rb"\A0\s+section\s"): ("a drawing in DXF", _POINTS_ADVICE),
    re.compile(rb"(?m)^eor\s*$"): ("a file of ISO 5436-2 (SMD)", "export the heights as X3P, SDF, or text x y z"),
    re.compile(rb"(?m)^v [-+.0-9e]+ [-+.0-9e]+ [-+.0-9e]+\s*$"): ("a mesh in OBJ", _POINTS_ADVICE),
}
# Endings of files without heights that have no first bytes of their own.
_FOREIGN_ENDINGS = {
    ".bmp": ("a picture of Windows", _PICTURE_ADVICE),
    ".xls": ("a workbook of an office program", "save the sheet of its heights as CSV"),
    ".doc": ("a document of an office program", _DOCUMENT_ADVICE),
    ".stl": ("a mesh in STL", _POINTS_ADVICE),
    ".obj": ("a mesh in OBJ", _POINTS_ADVICE),
    ".e57": ("a cloud of points in E57", _POINTS_ADVICE),
    ".pkl": ("an object of Python, which may do anything when it is read", "save the heights with numpy.save"),
    ".pickle": ("an object of Python, which may do anything when it is read", "save the heights with numpy.save"),
    ".h5-jpk": ("a file of JPK whose numbers have a scale that is not read", "export its heights as .jpk, or as text"),
}
# First members of ZIP archives by which office programs are known, and the place of their names.
_OFFICE_MEMBERS = (b"[content_types].xml", b"_rels/", b"xl/", b"word/", b"docprops/", b"mimetypeapplication/vnd.oasis")
_NAME_IN_ZIP = 30
# The first bytes of files by their ending; other formats have none of their own.
_BEGINNINGS = {
    ".al3d": (b"aliconaimaging\0",),
    ".gwy": (b"gwyp",),
    ".npy": (b"\x93numpy",),
    ".opdx": (b"vca data",),
    ".plux": (b"pk\3\4",),
    ".sur": (b"digital surf", b"dscompressed"),
    ".x3p": (b"pk\3\4",),
}
# Bytes of a file that are inspected: an XML document names its kind in its second line, and no format begins with so
# many zeros.
_INSPECTED_BYTES = 4096


@attrs.frozen(eq=False)
class RawMap:
    """A height map as it stands in a file.

    Attributes
    ----------
    heights
        Heights, shape (nx, ny), indexed [x, y], m; NaN at non-measured points.
    size
        Sides of the domain (x, y), m; None if the file does not state it.
    periodic
        Whether the map repeats beyond its border.
    metric
        Whether the heights are known to be in metres.
    hint
        Hints in the file at its size, in words, where it does not state it; for the message that asks for the size.
    needs_unit
        Whether the heights are in an unknown unit, which must be given, as in images.
    needs_rows
        Whether the file does not say if it has a row for each x or for each y; a row for each x is assumed.
    steps
        Distances of its points along x and y, in a unit that it does not state; None where it states none.
    rows
        In words, what a line of the file is: one x, or one y; empty where it has no lines.
    partial
        Distances of its points along x and y, m, where it states one of them alone; else None twice.
    unit
        Unit of the heights that the file states, m, already applied; None where it states none.
    unit_hint
        What in the file may state the unit of the heights, in its own words, where it is not understood; else empty.
    """

    heights: Array = attrs.field(repr=outlined)
    size: Pair | None = None
    periodic: bool = False
    metric: bool = False
    hint: str = ""
    needs_unit: bool = False
    needs_rows: bool = False
    steps: Pair | None = None
    rows: str = ""
    partial: tuple[float | None, float | None] = (None, None)
    unit: float | None = None
    unit_hint: str = ""


def check_rows(value: str) -> str:
    """Return the axis along which a file has its rows, ``"x"``, ``"y"`` or ``"auto"``, or raise `InputError`."""
    return choice(value, "The axis of the rows in a file", ("auto", "x", "y"))


def require_memory_of_map(size: float) -> None:
    """Refuse a map of so many bytes if there is too little memory for it."""
    require_memory(size, "it", "cut it, or write it with fewer points")


def shape_numbers(numbers: RealArray, shape: tuple[int, int]) -> RealArray:
    """Return the numbers of a file as so many rows and columns; `InputError` if it holds others than it states."""
    if min(shape) < 1 or numbers.size != math.prod(shape):
        raise InputError(f"it states {shape[1]} x {shape[0]} points, but holds {numbers.size} numbers: it is damaged")
    return numbers.reshape(shape)


def turn_up(heights: Array, falling: str) -> Array:
    """Return heights, indexed [x, y], with rising places along the axes, such as ``"y"``, along which they fall."""
    flips = tuple(slice(None, None, -1 if axis in falling else 1) for axis in "xy")
    return np.ascontiguousarray(heights[flips])


def name_rows(rows: str, line: str = "a line of the file", *, assumed: bool = False, downwards: bool = False) -> str:
    """Return in words what a line of a file is."""
    return f"{line} is one {rows}{', downwards' if downwards else ''}{' (assumed: rows= says it)' if assumed else ''}"


class SurfaceReader(Part, abc.ABC):
    """A reader of one kind of file. Subclass it and register it in ``roughcontact.readers``.

    Its fields, if it has any, are options that `read_surface` accepts by their names; each has a default.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> class Raw16(rc.SurfaceReader):
    ...     suffixes = frozenset({".raw16"})
    ...
    ...     def read(self, path):
    ...         heights = np.fromfile(path, dtype="<i2").reshape(512, 512) * 1e-9
    ...         return rc.typing.RawMap(heights, size=(1e-3, 1e-3), metric=True)
    >>> isinstance(Raw16(), rc.SurfaceReader)
    True
    """

    @property
    @abc.abstractmethod
    def suffixes(self) -> frozenset[str]:
        """The endings of the file names that it reads, lower case, with the dot."""

    @abc.abstractmethod
    def read(self, path: Path) -> RawMap:
        """Return the map in SI units; any error is reported by `read_surface` with the name of the file."""


readers = Registry(SurfaceReader, "surface reader", "roughcontact.readers")


def find_foreign(file: Path) -> str:
    """Return the kind of a file without a height map, with advice; empty if the kind is not known."""
    start = b""
    end = b""
    with contextlib.suppress(OSError), file.open("rb") as stream:
        start = stream.read(_INSPECTED_BYTES).lstrip(b"\xef\xbb\xbf \t\r\n").lower()
        stream.seek(max(0, stream.seek(0, os.SEEK_END) - 2 * len(SEAL)))
        end = stream.read(2 * len(SEAL))
    if SEAL[:20] in end:
        return (
            f"it is a saved solution, not a height map: {either(f'ContactSolution.load({file.name!r}) reads it, and ')}"
            f"the command 'roughcontact plot {file.name}' draws it"
        )
    if b"<vtkfile" in start:
        start = b"<vtkfile"
    ending = file.suffix.lower()
    # The files of some instruments, and numpy's, are archives too.
    if start.startswith(b"pk\x03\x04"):
        if start[_NAME_IN_ZIP:].startswith(_OFFICE_MEMBERS):
            return "it is a document of an office program: save the sheet of its heights as CSV"
        if ending == ".zip":
            return "it is a ZIP archive: unpack it first"
    begun = (found for mark, found in _FOREIGN_KINDS.items() if start.startswith(mark))
    if foreign := _FOREIGN_ENDINGS.get(ending) or next(begun, None):
        kind, advice = foreign
        return f"it is {kind}, not a height map: {advice}"
    for words, (kind, advice) in _FOREIGN_LINES.items():
        if words.search(start):
            return f"it is {kind}, which is not read: {advice}"
    if start and not start.strip(b"\0"):
        return f"it begins with {len(start)} bytes of zero, so that it is damaged: export the heights again"
    if not start.startswith(_BEGINNINGS.get(ending, b"")):
        return f"it does not begin as {ending} files do, so that it is damaged or has another format"
    return ""
