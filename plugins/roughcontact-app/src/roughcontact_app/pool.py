"""Processes for runs and their files: a few, lent to one task at a time, started ahead and used again."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator

from roughcontact_app.process import TaskEnded, Worker

# Bytes of memory above which a process that has done its task is ended.
_MOST_MEMORY = 2**30


class Pool:
    """Workers; what each holds of the last run that it had is used again where that is asked for.

    Parameters
    ----------
    most
        Number of those that work at a time.
    kept
        Number of those that are kept when nothing is done.
    """

    def __init__(self, most: int, kept: int):
        self._most = most
        self._kept = kept
        self._change = threading.Condition()
        self._all: set[Worker] = set()
        # That which was used last is the last one.
        self._idle: list[Worker] = []
        self._closed = False

    def prepare(self) -> None:
        """Have a process ready for the next run, unless all work."""
        with self._change:
            if not self._idle and len(self._all) < self._most and not self._closed:
                self._idle.append(self._make())
            ready = self._idle[-1:]
        for worker in ready:
            worker.start()

    @contextlib.contextmanager
    def lend(self, run: str, patience: float | None = None) -> Iterator[Worker]:
        """Lend the worker that holds a run, or else another one; wait for some seconds if all work.

        Raises
        ------
        TaskEnded
            If all still work then, or the pool is closed.
        """
        with self._change:
            self._change.wait_for(lambda: self._idle or len(self._all) < self._most or self._closed, patience)
            if self._closed:
                raise TaskEnded("This was cancelled.")
            holding = [worker for worker in self._idle if worker.held == run]
            if not self._idle and len(self._all) >= self._most:
                raise TaskEnded("All processes have much to do: try it again later.")
            worker = holding[0] if holding else self._idle[-1] if self._idle else self._make()
            if worker in self._idle:
                self._idle.remove(worker)
        worker.held = run
        try:
            yield worker
        finally:
            self._take_back(worker)

    def close(self) -> None:
        """End all processes for good."""
        with self._change:
            self._closed = True
            workers = [*self._all]
            self._change.notify_all()
        for worker in workers:
            worker.close()

    def _make(self) -> Worker:
        worker = Worker(is_warm=True)
        self._all.add(worker)
        return worker

    def _take_back(self, worker: Worker) -> None:
        if worker.memory > _MOST_MEMORY:
            worker.end()
        with self._change:
            if worker.is_closed:
                self._all.discard(worker)
            else:
                self._idle.append(worker)
            surplus = self._idle[: -self._kept]
            del self._idle[: -self._kept]
            self._all.difference_update(surplus)
            self._change.notify()
        for one in surplus:
            one.close()
