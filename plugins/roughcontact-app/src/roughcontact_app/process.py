"""A process that does tasks for the server, so that none of them can hold it up or take it down."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import threading
import time
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from roughcontact.errors import ContactWarning
from roughcontact.errors.door import translated
from roughcontact.faces import limit_address_space

from roughcontact_app.forking import CONTEXT

# Bytes of one message: answers and plans are thousands.
_LONGEST = 4_000_000
# Seconds for which the end of a process waits that is just being started.
_PATIENCE = 0.2


class TaskEnded(Exception):
    """A task did not come to its result: the text is a sentence for the user, beside the wrong setting, if known."""

    def __init__(self, sentence: str, setting: str = ""):
        super().__init__(sentence)
        self.setting = setting


class Worker:
    """A process that does one task after the other; it is started by the first.

    Parameters
    ----------
    is_warm
        Whether it solves a small contact when it starts, so that its first run need not wait for what that loads.

    Attributes
    ----------
    held
        The run whose solution it may hold; empty if there is none.
    memory
        Bytes that it had in use after its last task; 0 where the system does not say so.
    """

    def __init__(self, is_warm: bool = False) -> None:
        self._is_warm = is_warm
        self.held = ""
        self.memory = 0
        self._lock = threading.Lock()
        self._process: Any = None
        self._pipe: Connection | None = None
        self.is_closed = False

    def start(self) -> None:
        """Start the process, so that the first task need not wait for it."""
        with contextlib.suppress(TaskEnded, OSError):
            self._started()

    def do(
        self,
        task: dict[str, Any],
        limit: float | None = None,
        on_event: Callable[[dict[str, Any]], None] | None = None,
        late: str = "",
    ) -> dict[str, Any]:
        """Return the result of a task.

        Parameters
        ----------
        task
            What `roughcontact_app.work.run` takes.
        limit
            Seconds after which the process is ended; None: as long as it takes.
        on_event
            Called with each message on the way.
        late
            The sentence for the user if it takes longer.

        Raises
        ------
        TaskEnded
            With the sentence of an error of the task, or if the process ended or took too long.
        """
        end = None if limit is None else time.monotonic() + limit
        try:
            pipe = self._started()
            pipe.send_bytes(json.dumps(task).encode())
            while True:
                if end is not None and not pipe.poll(max(0.0, end - time.monotonic())):
                    self.end()
                    raise TaskEnded(late)
                message = json.loads(pipe.recv_bytes(_LONGEST))
                self.memory = message.get("memory", 0)
                if "result" in message:
                    result: dict[str, Any] = message["result"]
                    return result
                if "error" in message:
                    raise TaskEnded(str(message["error"]), str(message["setting"]))
                if on_event is not None:
                    on_event(message["event"])
        except (EOFError, OSError, ValueError):
            self.end()
            raise TaskEnded("The process that did this ended before its time; memory may have run out.") from None

    def end(self) -> None:
        """End the process, whatever it does: its task raises `TaskEnded`, the next one starts another."""
        with self._lock:
            self._end()

    def close(self) -> None:
        """End the process for good."""
        self.is_closed = True
        # Whoever is just starting it ends it.
        if self._lock.acquire(timeout=_PATIENCE):
            try:
                self._end()
            finally:
                self._lock.release()

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
        self._process = None
        self.memory = 0

    def _started(self) -> Connection:
        with self._lock:
            if not self.is_closed and (self._process is None or self._pipe is None or not self._process.is_alive()):
                self._pipe, theirs = CONTEXT.Pipe()
                process = CONTEXT.Process(target=_serve, args=(theirs, self._is_warm), daemon=True)
                process.start()
                self._process = process
                theirs.close()
            if self.is_closed or self._pipe is None:
                self._end()
                raise TaskEnded("This was cancelled.")
            return self._pipe


def _serve(pipe: Connection, is_warm: bool) -> None:
    """Do the tasks that come through the pipe; runs in the process of a `Worker`."""
    # Ctrl-C in the terminal is for the server, which then ends its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # The page says what an answer warns of.
    warnings.simplefilter("ignore", ContactWarning)
    tasks: queue.Queue[bytes] = queue.Queue()
    threading.Thread(target=_receive, args=(pipe, tasks), daemon=True).start()
    from roughcontact_app.ready import work

    if is_warm:
        # What is wrong here is said of the first run.
        with contextlib.suppress(Exception):
            work.warm_up()
    while True:
        task = json.loads(tasks.get())
        # A file may expand to more than its reader tells beforehand.
        limit_address_space(most=task.get("memory"))
        try:
            message: dict[str, Any] = {"result": work.run(task, lambda event: _send(pipe, {"event": event}))}
        # Whatever a file or a plug-in does becomes a sentence.
        except Exception as error:
            known = translated(error, "The task")
            message = {"error": str(known), "setting": getattr(error, "setting", "")}
        _send(pipe, message | {"memory": _count_bytes()})


def _count_bytes() -> int:
    """Return the memory that this process has in use; 0 where the system does not say so."""
    with contextlib.suppress(OSError, ValueError):
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return 0


def _receive(pipe: Connection, tasks: queue.Queue[bytes]) -> None:
    """Queue what comes through the pipe; when the server is gone, end this process, whatever it does."""
    while True:
        try:
            tasks.put(pipe.recv_bytes())
        except (EOFError, OSError):
            os._exit(1)


def _send(pipe: Connection, message: dict[str, Any]) -> None:
    # Numbers that JSON does not know would stop the page from reading the others.
    pipe.send_bytes(json.dumps(message, allow_nan=False).encode())
