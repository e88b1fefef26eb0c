"""Runs: as many at a time as there are cores, the others in a queue."""

from __future__ import annotations

import re
import secrets
import shutil
import statistics
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from roughcontact.errors import InputError
from roughcontact.faces import available_threads

from roughcontact_app.pool import Pool
from roughcontact_app.process import TaskEnded, Worker
from roughcontact_app.settings import Settings

# Runs that are kept, and runs that may wait.
_KEPT = 20
_WAITING = 20
# Names of files that a process may offer.
_FILE = re.compile(r"[a-z0-9-]{1,60}\.(?:csv|gif|html|json|npz|png|txt)")
# Seconds after which a run is long: another process is made ready meanwhile.
_LONG = 2.0
# Runs whose times correct the forecast.
_REMEMBERED = 9
ENDED = ("done", "failed", "cancelled")


class Job:
    """One run: its number, its settings, what is known of it, and the process that does it."""

    def __init__(self, number: int, settings: Settings, task: dict[str, Any], folder: Path):
        self.id = folder.name
        self.settings = settings
        self.task = task
        self.folder = folder
        self.number = number
        self.worker: Worker | None = None
        self.future: Future[None] | None = None
        # Held by whoever has one of its files written.
        self.writing = threading.Lock()
        self._change = threading.Condition(threading.RLock())
        self._version = 0
        self._state: dict[str, Any] = {"phase": "waiting", "fraction": 0.0, "text": "", "error": ""}
        self._state |= {"answers": [], "warnings": [], "outputs": [], "notes": []}
        self._made: set[str] = set()
        self._begun = self._ended = 0.0

    @property
    def phase(self) -> str:
        """Where the run stands: waiting, starting, preparing, solving, drawing, done, failed or cancelled."""
        return str(self._state["phase"])

    @property
    def seconds(self) -> float:
        """How long it has been running, or ran."""
        return (self._ended or time.monotonic()) - self._begun if self._begun else 0.0

    def describe(self) -> dict[str, Any]:
        """Return what the page shows of this run; its version changes with its phase."""
        with self._change:
            return {**self._state, **self.name(), "seconds": self.seconds, "version": self._version}

    def name(self) -> dict[str, Any]:
        """Return by what people tell this run from others."""
        answers = self._state["answers"]
        numbers = {one["name"]: one["text"] for answer in answers[-1:] for one in answer["quantities"]}
        if len(answers) > 1:
            numbers = {"load": f"{answers[-1]['load']}, the last of {len(answers)}", **numbers}
        known = {"id": self.id, "number": self.number, "phase": self.phase, "settings": dict(self.settings)}
        return {**known, "numbers": numbers}

    def update(self, event: dict[str, Any]) -> None:
        """Take note of a message of the process."""
        with self._change:
            if self.phase in ENDED:
                return
            self._made |= {event.pop("made")} if "made" in event else set()
            if "outputs" in event:
                event["outputs"] = [one for one in event["outputs"] if _FILE.fullmatch(one["file"])]
            before = self.phase
            self._state |= event
            if event.get("phase") == "starting":
                self._begun = time.monotonic()
            if self.phase in ENDED:
                self._ended = time.monotonic()
            self._version += self.phase != before
            self._change.notify_all()

    def cancel(self) -> None:
        """End it, whatever it does."""
        # Its worker has no other task before this is done.
        with self._change:
            if self.phase not in ENDED:
                self.update({"phase": "cancelled", "text": "Cancelled."})
                if self.worker is not None:
                    self.worker.close()

    def assign(self, worker: Worker | None) -> bool:
        """Take a worker, or give it up; return whether the run goes on."""
        with self._change:
            self.worker = worker
            return self.phase not in ENDED

    def wait_past(self, version: int, patience: float) -> None:
        """Wait for another version than one that is known, for some seconds at most."""
        with self._change:
            self._change.wait_for(lambda: self._version != version or self.phase in ENDED, patience)

    def offers(self, name: str) -> bool:
        """Return whether a file may be asked for."""
        with self._change:
            return any(output["file"] == name for output in self._state["outputs"])

    def wait_for_file(self, name: str, patience: float) -> bool:
        """Return whether a file has been written, once it has been or the run has ended, or after some seconds."""
        with self._change:
            self._change.wait_for(lambda: name in self._made or self.phase in ENDED, patience)
            return name in self._made

    def note_file(self, name: str) -> None:
        """Take note that a file has been written after the run."""
        with self._change:
            self._made.add(name)


class Jobs:
    """All runs of this server.

    Parameters
    ----------
    folder
        Where each has a folder.
    slots
        Number of runs at a time; None: one a core.
    patience
        Seconds that writing a file may take.
    """

    def __init__(self, folder: Path, slots: int | None = None, patience: float = 120.0):
        self._folder = folder
        self._patience = patience
        self._lock = threading.Lock()
        self.slots = slots or available_threads()
        self._threads = ThreadPoolExecutor(self.slots, thread_name_prefix="run")
        self._jobs: dict[str, Job] = {}
        self._started = 0
        self._ratios: list[float] = []
        # As many files are written beside the runs.
        self._writing = threading.Semaphore(self.slots)
        self._pool = Pool(2 * self.slots, self.slots)

    def prepare(self) -> None:
        """Start the process of the next run."""
        self._pool.prepare()

    @property
    def calibration(self) -> float:
        """Median of measured times over forecasts of the last runs; 1 before the first."""
        return statistics.median(self._ratios) if self._ratios else 1.0

    def add(self, settings: Settings, make_task: Callable[[Path], dict[str, Any]]) -> Job:
        """Return a new run, which starts when there is a core for it; `make_task` is given its folder."""
        with self._lock:
            if sum(job.phase == "waiting" for job in self._jobs.values()) >= _WAITING:
                raise InputError(f"The queue is full, {_WAITING} runs are waiting: cancel some, or wait for them.")
            folder = self._folder / secrets.token_hex(12)
            folder.mkdir(mode=0o700)
            self._started += 1
            job = Job(self._started, settings, make_task(folder), folder)
            self._jobs[job.id] = job
            self._forget_oldest()
            job.future = self._threads.submit(self._run, job)
        return job

    def find(self, name: str) -> Job | None:
        """Return the run of that name, if there is one."""
        with self._lock:
            return self._jobs.get(name)

    def list_names(self) -> list[dict[str, Any]]:
        """Return all runs that are kept, in the order of their starts: see `Job.name`."""
        with self._lock:
            return [job.name() for job in self._jobs.values()]

    def describe(self, job: Job) -> dict[str, Any]:
        """Return what the page shows of a run, with the number of those before it in the queue."""
        found = job.describe()
        if found["phase"] == "waiting":
            with self._lock:
                before = [other.phase for other in self._jobs.values()]
                place = list(self._jobs).index(job.id) if job.id in self._jobs else 0
            ahead = before[:place].count("waiting")
            running = sum(phase not in (*ENDED, "waiting") for phase in before)
            found["text"] = f"Waiting: {running} running, one a core, and {ahead} before this one in the queue."
        return found

    def write_file(self, job: Job, name: str) -> Path:
        """Return where a file that a run offers lies; it is written when it is first asked for.

        Raises
        ------
        TaskEnded
            With the reason if it cannot be written.
        """
        path = job.folder / name
        late = f"took more than {self._patience:g} s and was ended: make it in a script."
        with job.writing:
            if job.wait_for_file(name, self._patience):
                return path
            if job.phase not in ENDED:
                raise TaskEnded("This run is not solved yet: try it again later.")
            with self._writing, self._pool.lend(job.id, self._patience) as worker:
                task = {**job.task, "kind": "file", "file": name}
                worker.do(task, self._patience, late=f"Writing {name} {late}")
            job.note_file(name)
        return path

    def cancel(self, job: Job) -> None:
        """End a run, whatever it does."""
        job.cancel()
        if job.future is not None:
            job.future.cancel()

    def close(self) -> None:
        """End all runs."""
        for job in list(self._jobs.values()):
            self.cancel(job)
        self._pool.close()
        self._threads.shutdown(cancel_futures=True)

    def _run(self, job: Job) -> None:
        job.update({"phase": "starting", "text": "Starting a process for it."})
        try:
            with self._pool.lend(job.id) as worker:
                try:
                    if job.assign(worker):
                        result = worker.do(job.task, on_event=lambda event: self._note(job, event))
                        job.update({"phase": "done", "fraction": 1.0, "text": "Done.", "notes": result["notes"]})
                finally:
                    job.assign(None)
        except TaskEnded as ended:
            job.update({"phase": "failed", "error": str(ended), "text": "Failed."})
        finally:
            self.prepare()

    def _note(self, job: Job, event: dict[str, Any]) -> None:
        ratio = event.pop("ratio", None)
        if ratio is not None:
            self._ratios = [*self._ratios[1 - _REMEMBERED :], float(ratio)]
        job.update(event)
        if job.seconds > _LONG:
            self.prepare()

    def _forget_oldest(self) -> None:
        ended = [job for job in self._jobs.values() if job.phase in ENDED]
        for job in ended[: max(0, len(self._jobs) - _KEPT)]:
            del self._jobs[job.id]
            shutil.rmtree(job.folder, ignore_errors=True)
