"""Files that hold no height map, known by their first or last bytes."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from roughcontact._base.archive import SEAL

_PICTURE = "export the heights themselves, as text or TIFF in 32-bit floating point"
_PAGE = "export the heights themselves, as text"
# The first bytes of files, what they are, and what to do.
_KINDS = {
    b"\x89PNG": ("a PNG picture", _PICTURE),
    b"\xff\xd8\xff": ("a JPEG picture", _PICTURE),
    b"GIF8": ("a GIF picture", _PICTURE),
    b"%PDF": ("a PDF document", _PAGE),
    b"<!doctype html": ("a page of HTML", _PAGE),
    b"<html": ("a page of HTML", _PAGE),
    b"<?xml": ("an XML document", _PAGE),
    b"<vtkfile": ("image data of VTK", _PAGE),
}
# What the files of an ending begin with; others have no beginning of their own.
_BEGINNINGS = {
    ".al3d": (b"aliconaimaging\0",),
    ".gwy": (b"gwyp",),
    ".opdx": (b"vca data",),
    ".plux": (b"pk\3\4",),
    ".sur": (b"digital surf", b"dscompressed"),
    ".x3p": (b"pk\3\4",),
}
# Bytes of a file that are looked at: an XML document names its kind in its second line, and no format begins with so
# many zeros.
_LOOKED_AT = 4096


def find_foreign(file: Path) -> str:
    """Return what a file is that holds no height map, and what to do; nothing if it is not known."""
    start = b""
    end = b""
    with contextlib.suppress(OSError), file.open("rb") as stream:
        start = stream.read(_LOOKED_AT).lstrip(b"\xef\xbb\xbf \t\r\n").lower()
        stream.seek(max(0, stream.seek(0, os.SEEK_END) - 2 * len(SEAL)))
        end = stream.read(2 * len(SEAL))
    if SEAL[:20] in end:
        return (
            f"it is a saved solution, not a height map: ContactSolution.load({file.name!r}) reads it, and the command "
            f"'roughcontact plot {file.name}' draws it"
        )
    if b"<vtkfile" in start:
        start = b"<vtkfile"
    # The files of some instruments, and numpy's, are archives too.
    if start.startswith(b"pk\x03\x04") and file.suffix.lower() == ".zip":
        return "it is a ZIP archive: unpack it first"
    for mark, (kind, advice) in _KINDS.items():
        if start.startswith(mark.lower()):
            return f"it is {kind}, not a height map: {advice}"
    if start and not start.strip(b"\0"):
        return f"it begins with {len(start)} bytes of zero, so that it is damaged: export the heights again"
    ending = file.suffix.lower()
    if not start.startswith(_BEGINNINGS.get(ending, b"")):
        return f"it does not begin as {ending} files do, so that it is damaged or has another format"
    return ""
