"""The files that the page has sent, in a private folder under names of the server's."""

from __future__ import annotations

import contextlib
import hashlib
import re
import secrets
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import attrs
from roughcontact import readers
from roughcontact.errors import InputError, RoughContactError
from roughcontact.solving import available_memory
from roughcontact.typing import binary

# Bytes of one file, and of all together; larger maps are for a script.
_LARGEST = 1 << 29
_LARGEST_SUM = 1 << 31
# Fraction of the memory that a file may be: it is read into float64 and transformed.
_OF_MEMORY = 0.25
# Characters of a name that are shown.
_SHOWN = 100
# Seconds in which a file of the largest size must have come; it is sent on one machine.
_PATIENCE = 300.0
# Endings of instruments' files, which no reader claims; any other is read without an ending.
_INSTRUMENTS = frozenset(
    re.findall(
        r"\.\w+",
        ".al3d .asd .bcr .bcrf .di .dzi .frt .gwy .h5 .hgt .ibw .jpk .lext .map .mat .mi .mnt .nanoscope .nc .nid .nms "
        ".opd .opdx .oir .os3d .plu .plux .poir .ps .sdf .spm .stp .sur .top .vk3 .vk4 .vk6 .vk7 .x3p .xyz .zmg .zon",
    )
)


@attrs.frozen
class StoredFile:
    """A file as the server keeps it: its digest (SHA-256), where it lies, the user's name for it, and its bytes."""

    digest: str
    path: Path
    name: str
    size: int


class PartialFile:
    """A file that is being received: where it lies, the user's name for it, and the bytes that it will have."""

    def __init__(self, file: IO[bytes], path: Path, name: str, size: int):
        self._file = file
        self.path = path
        self.name = name
        self.size = size
        self._left = size
        self._digest = hashlib.sha256()
        self._end = time.monotonic() + _PATIENCE

    def write(self, block: bytes) -> None:
        """Add bytes, or raise `InputError` if they come too late or are too many."""
        if time.monotonic() > self._end:
            raise InputError(f"The file did not come within {_PATIENCE:g} s: send it again.")
        self._left -= len(block)
        if self._left < 0:
            raise InputError("The file goes on beyond its stated length: send it again.")
        self._digest.update(block)
        self._file.write(block)

    def close(self) -> str:
        """Return the digest, or raise `InputError` if the file has ended early."""
        self._file.close()
        if self._left:
            raise InputError(f"The file ended {self._left} bytes before its stated length: send it again.")
        return self._digest.hexdigest()


class Uploads:
    """Files by their digests; the oldest are removed when there are too many bytes."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._lock = threading.Lock()
        self._files: dict[str, StoredFile] = {}

    @property
    def limit(self) -> int:
        """Bytes that a file may have here and now."""
        available = available_memory()
        return _LARGEST if available is None else min(_LARGEST, int(_OF_MEMORY * available))

    def require_size(self, size: int) -> None:
        """Raise `InputError` if a file of so many bytes is too large."""
        if not size:
            raise InputError("The file is empty: choose another, or export it again.")
        if size > self.limit:
            raise InputError(
                f"A file may have at most {binary(self.limit)} here, but this one has {binary(size)}: "
                "larger maps are for a script."
            )

    @contextlib.contextmanager
    def begin(self, size: int, name: str) -> Iterator[PartialFile]:
        """Give a file of so many bytes that is being received; it goes unless it is kept by `finish`."""
        path = self._folder / f"{secrets.token_hex(8)}.partial"
        try:
            with path.open("xb") as file:
                yield PartialFile(file, path, shown_name(name), size)
        finally:
            path.unlink(missing_ok=True)

    def finish(self, partial: PartialFile) -> StoredFile:
        """Return the file whose bytes have come.

        Raises
        ------
        InputError
            If it ended early.
        """
        digest = partial.close()
        path = self._folder / f"{digest[:16]}{_known_ending(partial.name)}"
        with self._lock:
            partial.path.replace(path)
            before = self._files.pop(digest, None)
            if before is not None and before.path != path:
                before.path.unlink(missing_ok=True)
            self._files[digest] = StoredFile(digest, path, partial.name, partial.size)
            self._remove_oldest()
            return self._files[digest]

    def find(self, digest: str) -> StoredFile | None:
        """Return the file with a digest, if it is here."""
        with self._lock:
            return self._files.get(digest)

    def _remove_oldest(self) -> None:
        while sum(file.size for file in self._files.values()) > _LARGEST_SUM:
            oldest = next(iter(self._files))
            self._files.pop(oldest).path.unlink(missing_ok=True)


def shown_name(name: str) -> str:
    """Return the part of a client's file name that is shown: printable, without folders, and not too long."""
    last = name.replace("\\", "/").rpartition("/")[2]
    return "".join(letter for letter in last if letter.isprintable())[-_SHOWN:].strip() or "map"


def known_endings() -> list[str]:
    """Return the endings of files that a reader may know, with the dot."""
    found = set(_INSTRUMENTS)
    for name in readers:
        with contextlib.suppress(RoughContactError):
            found |= readers.create(name).suffixes
    return sorted(found)


def _known_ending(name: str) -> str:
    """Return the known ending that a name has: a text of the server's, never of the client's; empty if none."""
    given = Path(name).suffix.lower()
    return next((ending for ending in known_endings() if ending == given), "")
