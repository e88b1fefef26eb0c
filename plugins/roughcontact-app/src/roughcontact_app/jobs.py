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

from roughcontact_app.process import TaskEnded, Worker
from roughcontact_app.settings import Settings

# Runs that are kept, and runs that may wait.
_KEPT = 20
_WAITING = 20
# Names of files that a process may offer.
_FILE = re.compile(r"[a-z0-9-]{1,60}\.(?:csv|gif|html|npz|png)")
# Runs whose times correct the forecast.
_REMEMBERED = 9
ENDED = ("done", "failed", "cancelled")


class Job:
    """One run: its number, its settings, what is known of it, and the process that does it."""

    def __init__(self, number: int, settings: Settings, task: dict[str, Any], folder: Path, worker: Worker):
        self.id = folder.name
        self.settings = settings
        self.task = task
        self.folder = folder
        self.number = number
        self.worker = worker
        self.future: Future[None] | None = None
        self._lock = threading.Lock()
        self._state: dict[str, Any] = {"phase": "waiting", "fraction": 0.0, "text": "", "error": ""}
        self._state |= {"answers": [], "warnings": [], "outputs": [], "notes": []}
        self._begun = self._ended = 0.0

    @property
    def phase(self) -> str:
        """Where the run stands: waiting, starting, preparing, solving, drawing, done, failed or cancelled."""
        return str(self._state["phase"])

    def describe(self) -> dict[str, Any]:
        """Return what the page shows of this run."""
        with self._lock:
            seconds = (self._ended or time.monotonic()) - self._begun if self._begun else 0.0
            return {**self._state, **self.name(), "seconds": seconds}

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
        with self._lock:
            if self._state["phase"] in ENDED:
                return
            if "role" in event:
                if _FILE.fullmatch(event["file"]):
                    self._state["outputs"] = [*self._state["outputs"], event]
                return
            self._state |= event
            if event.get("phase") == "starting":
                self._begun = time.monotonic()
            if event.get("phase") in ENDED:
                self._ended = time.monotonic()

    def file(self, name: str) -> Path | None:
        """Return where one of its files lies, if it has written that."""
        offered = [output["file"] for output in self.describe()["outputs"]]
        return self.folder / name if name in offered else None


class Jobs:
    """All runs of this server."""

    def __init__(self, folder: Path, slots: int | None = None):
        self._folder = folder
        self._lock = threading.Lock()
        self.slots = slots or available_threads()
        self._pool = ThreadPoolExecutor(self.slots, thread_name_prefix="run")
        self._jobs: dict[str, Job] = {}
        self._started = 0
        self._ratios: list[float] = []
        # Started ahead: a process takes a second or two to import what it needs.
        self._spare = Worker()

    def prepare(self) -> None:
        """Start the process of the next run."""
        self._spare.start()

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
            job = Job(self._started, settings, make_task(folder), folder, self._spare)
            self._spare = Worker()
            self._jobs[job.id] = job
            self._forget_oldest()
            job.future = self._pool.submit(self._run, job)
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

    def cancel(self, job: Job) -> None:
        """End a run, whatever it does."""
        job.update({"phase": "cancelled", "text": "Cancelled."})
        if job.future is not None:
            job.future.cancel()
        job.worker.close()

    def close(self) -> None:
        """End all runs."""
        for job in list(self._jobs.values()):
            self.cancel(job)
        self._spare.close()
        self._pool.shutdown(cancel_futures=True)

    def _run(self, job: Job) -> None:
        job.update({"phase": "starting", "text": "Starting a process for it."})
        try:
            result = job.worker.do(job.task, on_event=lambda event: self._note(job, event))
            job.update({"phase": "done", "fraction": 1.0, "text": "Done.", "notes": result["notes"]})
        except TaskEnded as ended:
            job.update({"phase": "failed", "error": str(ended), "text": "Failed."})
        finally:
            job.worker.close()
            self.prepare()

    def _note(self, job: Job, event: dict[str, Any]) -> None:
        ratio = event.pop("ratio", None)
        if ratio is not None:
            self._ratios = [*self._ratios[1 - _REMEMBERED :], float(ratio)]
        job.update(event)

    def _forget_oldest(self) -> None:
        ended = [job for job in self._jobs.values() if job.phase in ENDED]
        for job in ended[: max(0, len(self._jobs) - _KEPT)]:
            del self._jobs[job.id]
            shutil.rmtree(job.folder, ignore_errors=True)
