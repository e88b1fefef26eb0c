"""The processes of one page, so that a file that is slow to read holds up no other."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

from roughcontact_app.process import TaskEnded, Worker


class Page:
    """What reads and plans for one page: a process for the file of each body, another for all else.

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
        # The problem that was planned last; empty if there is none.
        self.planned = ""
        self._lock = threading.Lock()
        self._idle = [Worker()]
        # What reads the file of a body, by its name.
        self._reading: dict[str, Worker] = {}

    def start(self) -> None:
        """Start the processes, so that the first tasks need not wait for them."""
        self._maker.start()
        for inspector in self._idle:
            inspector.start()

    def make(self, task: dict[str, Any], what: str) -> dict[str, Any]:
        """Return the result of a task, after those before it; `what` begins the sentence if it takes too long."""
        with self.making:
            return self._maker.do(
                task, self._patience, late=f"{what} {self._late}: choose fewer cells, or solve it in a script."
            )

    def inspect(self, task: dict[str, Any], name: str, body: str) -> dict[str, Any]:
        """Return the facts of a file for a body; one that is still being read for it is given up."""
        with self._lock:
            former = self._reading.get(body)
            inspector = self._idle.pop() if self._idle else Worker()
            self._reading[body] = inspector
        if former is not None:
            # The former reading finds that it is no longer the last one.
            former.close()
        advice = "check that it is a height map, or read it with roughcontact.read_surface in a script."
        try:
            return inspector.do(task, self._patience, late=f"Reading the file {name} {self._late}: {advice}")
        except TaskEnded as ended:
            if inspector is self._reading.get(body):
                raise
            raise TaskEnded(f"Reading {name} was stopped, since another file was chosen.") from ended
        finally:
            with self._lock:
                if inspector is self._reading.get(body):
                    del self._reading[body]
                    self._idle.append(inspector)

    def close(self) -> None:
        """End its processes for good."""
        with self._lock:
            inspectors = [*self._idle, *self._reading.values()]
        for worker in (self._maker, *inspectors):
            worker.close()

    @property
    def _late(self) -> str:
        return f"took more than {self._patience:g} s and was ended"
