"""The first bytes of files: what cannot be a height map is refused before a reader searches all of it."""

from __future__ import annotations

from pathlib import Path

from roughcontact.errors import InputError

# Bytes that are looked at; no format begins with so many zeros.
_LOOKED_AT = 4096
# Formats by their endings, with what each file of them begins with; others have no beginning of their own.
_BEGINNINGS = {
    ".al3d": (b"AliconaImaging\0",),
    ".gwy": (b"GWYP",),
    ".opdx": (b"VCA DATA",),
    ".plux": (b"PK\3\4",),
    ".sur": (b"DIGITAL SURF", b"DSCOMPRESSED"),
    ".x3p": (b"PK\3\4",),
}
_PICTURES = {b"\x89PNG\r\n": "PNG", b"\xff\xd8\xff": "JPEG", b"GIF8": "GIF"}


def require_beginning(file: Path, name: str) -> None:
    """Raise `InputError` if the first bytes of a file are those of no height map.

    Parameters
    ----------
    file
        Where it lies.
    name
        The user's name for it.
    """
    with file.open("rb") as opened:
        head = opened.read(_LOOKED_AT)
    advice = "Export the heights again, as .x3p, .sur or a .csv table of numbers."
    for beginning, kind in _PICTURES.items():
        if head.startswith(beginning):
            raise InputError(
                f"The file {name} is a picture ({kind}), not a height map: its colours are no heights. {advice}"
            )
    if not head.strip(b"\0"):
        raise InputError(f"The file {name} begins with {len(head)} bytes of zero, so it is damaged. {advice}")
    ending = Path(name).suffix.lower()
    if not head.startswith(_BEGINNINGS.get(ending, b"")):
        raise InputError(
            f"The file {name} does not begin as {ending} files do: it is damaged, or has another format. {advice}"
        )
