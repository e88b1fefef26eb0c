"""The processes of one page, so that a file that is slow to read holds up no other."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

from roughcontact_app.process import TaskEnded, Worker


class Page:
    """What reads and plans for one page: a process for the files that it sends, another for all else.

    Parameters
    ----------
    folder
        Where its pictures are written.
    patience
        Seconds that a task may take.
    """

    def __init__(self, folder: Path, patience: float):
        folder.mkdir(mode=0o700)
        self.folder = folder
        self._patience = patience
        # One change of the form after the other: the process keeps the last surface.
        self._maker = Worker()
        self.making = threading.RLock()
        self._inspector = Worker()
        self._lock = threading.Lock()
        self._is_inspecting = False

    def start(self) -> None:
        """Start the processes, so that the first tasks need not wait for them."""
        self._maker.start()
        self._inspector.start()

    def make(self, task: dict[str, Any], what: str) -> dict[str, Any]:
        """Return the result of a task, after those before it; `what` begins the sentence if it takes too long."""
        with self.making:
            return self._maker.do(
                task, self._patience, late=f"{what} {self._late}: choose fewer cells, or solve it in a script."
            )

    def inspect(self, task: dict[str, Any], name: str) -> dict[str, Any]:
        """Return the facts of a file; one that is still being read is given up for it."""
        with self._lock:
            if self._is_inspecting:
                # The former reading finds that it is no longer the last one.
                former = self._inspector
                self._inspector = Worker()
                former.close()
            inspector = self._inspector
            self._is_inspecting = True
        advice = "check that it is a height map, or read it with roughcontact.read_surface in a script."
        try:
            return inspector.do(task, self._patience, late=f"Reading the file {name} {self._late}: {advice}")
        except TaskEnded as ended:
            if inspector is self._inspector:
                raise
            raise TaskEnded(f"Reading {name} was stopped, since another file was chosen.") from ended
        finally:
            with self._lock:
                self._is_inspecting = self._is_inspecting and inspector is not self._inspector

    def close(self) -> None:
        """End its processes for good."""
        self._maker.close()
        self._inspector.close()

    @property
    def _late(self) -> str:
        return f"took more than {self._patience:g} s and was ended"
