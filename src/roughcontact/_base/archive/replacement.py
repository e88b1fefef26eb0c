"""Files that are written completely or not at all, and what killed processes leave of them."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import platform
import re
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

from roughcontact.errors import InputError, NotWritten, RoughContactError

# Characters of a file's name in that of its unfinished one: systems allow 255 bytes, UTF-8 takes up to 4 for each.
_NAMED = 40
_PARTIAL = re.compile(r"\..+\.(?P<machine>[0-9a-f]{8})-(?P<pid>\d+)\.[0-9a-f]{12}\.partial", re.DOTALL)
# Seconds, a week: the age at which an unfinished file is stale if its process cannot be seen from this machine.
_STALE = 604800.0


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str], *, flush: bool = True) -> Iterator[Path]:
    """Give the name of a file beside the one to be written, which takes its place on the disk when all has gone well.

    Its content is on the disk before it has its name. Without `flush` the name itself may be lost when the power
    fails, until another file in the folder is flushed.

    Raises
    ------
    InputError
        If there is no such folder, or the name is that of something else than a file.
    NotWritten
        If the disk is full or refuses; what was there before is unchanged.
    """
    target = Path(path)
    partial = target.parent / f".{target.name[:_NAMED]}.{_machine()}-{os.getpid()}.{uuid.uuid4().hex[:12]}.partial"
    try:
        if "\0" in target.name or not target.parent.is_dir():
            raise InputError(f"There is no folder {str(target.parent)!r} to write {target.name!r} into.")
        if target.exists() and not target.is_file():
            raise InputError(f"There is something else than a file at {str(target)!r}: give another name.")
        _remove_stale_once(os.path.abspath(target.parent))
        yield partial
        with partial.open("r+b") as file:
            os.fsync(file.fileno())
        partial.replace(target)
        if flush:
            _flush_names(target.parent)
    except BaseException as error:
        with contextlib.suppress(OSError, ValueError):
            partial.unlink()
        if isinstance(error, OSError) and not isinstance(error, RoughContactError):
            raise NotWritten(error.errno, error.strerror or str(error), str(target)) from error
        raise


def remove_stale(folder: str | os.PathLike[str]) -> None:
    """Remove the unfinished files of `replacing` whose process was killed; those of a running process stay."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            owner = _PARTIAL.fullmatch(entry.name)
            with contextlib.suppress(OSError):
                if owner and entry.is_file(follow_symlinks=False) and _is_stale(entry, owner["machine"], owner["pid"]):
                    os.unlink(entry.path)


# A folder of a long study has thousands of names: they are read once by each process.
_remove_stale_once = functools.cache(remove_stale)


def _is_stale(entry: os.DirEntry[str], machine: str, pid: str) -> bool:
    if machine == _machine() and os.name == "posix":
        return _has_ended(int(pid))
    return time.time() - entry.stat(follow_symlinks=False).st_mtime > _STALE


def _has_ended(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except (PermissionError, OverflowError):
        return False
    with contextlib.suppress(OSError):
        # Killed, but nobody has waited for it, as in a container without an init process.
        return Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()[:1] == ["Z"]
    return False


@functools.cache
def _machine() -> str:
    """Return digits for this machine since it was started, and for the container whose processes are seen."""
    known = [platform.node()]
    with contextlib.suppress(OSError):
        known += [Path("/proc/sys/kernel/random/boot_id").read_text(), os.readlink("/proc/self/ns/pid")]
    return hashlib.sha256("".join(known).encode()).hexdigest()[:8]


def _flush_names(folder: Path) -> None:
    """Write the names in a folder to the disk, where the system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
