"""The private folder of a session, and what killed sessions have left of theirs."""

from __future__ import annotations

import contextlib
import os
import platform
import shutil
import tempfile
from pathlib import Path
from typing import IO

try:
    import fcntl
except ImportError:  # Windows: folders of killed sessions stay
    fcntl = None  # type: ignore[assignment]

_PREFIX = "roughcontact-app-"
_LOCK = "lock"


class PrivateFolder:
    """A new folder for this user alone (mode 700); those of sessions that were killed are removed at its start.

    Its lock file is open, and locked, while this process lives, however that ends.
    """

    def __init__(self) -> None:
        _remove_abandoned(Path(tempfile.gettempdir()))
        self._temporary = tempfile.TemporaryDirectory(prefix=_PREFIX, ignore_cleanup_errors=True)
        self.path = Path(self._temporary.name)
        self._lock = self._write_lock()

    def close(self) -> None:
        """Remove the folder."""
        self._lock.close()
        self._temporary.cleanup()

    def _write_lock(self) -> IO[str]:
        new = self.path / f"{_LOCK}.new"
        lock = new.open("x")
        lock.write(platform.node())
        lock.flush()
        with contextlib.suppress(OSError):
            if fcntl is not None:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                # It has its name only now: what has that name, but is not locked, is of a dead process.
                new.rename(self.path / _LOCK)
        return lock


def _remove_abandoned(parent: Path) -> None:
    """Remove the folders of this user's sessions on this machine that live no more."""
    if fcntl is None:
        return
    for folder in parent.glob(f"{_PREFIX}*"):
        # What another user has put there under such a name is neither opened nor followed.
        with contextlib.suppress(OSError):
            if folder.lstat().st_uid != os.getuid():
                continue
            with (folder / _LOCK).open("r+") as lock:
                if lock.read() == platform.node():
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    shutil.rmtree(folder, ignore_errors=True)
