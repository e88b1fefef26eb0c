"""Studies of many small contacts: contacts a second by several processes or threads, and thousands of records.

    python benchmarks/many_contacts.py rates [contacts]   # area, peak and stiffness on 64 and 128 cells a side
    python benchmarks/many_contacts.py kills [contacts]   # area on 32 cells a side, killed twice

`rates` runs equal studies by turns in one process, two threads and two processes, by numpy alone and, where the plug-in
is there, compiled, and prints the most contacts a second of `ROUNDS`.

`kills` prints the CPU time of a record in each twentieth of a study whose process is killed twice, after a random
number of records and a random time; the time in which the next one reads what is known; and that of a run with nothing
left to do. The first fifth of its records must be those of a run without a stop, but for the seconds that they took.
"""

from __future__ import annotations

import os

if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")

import contextlib
import hashlib
import itertools
import json
import multiprocessing
import random
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import attrs

import roughcontact as rc
from roughcontact.results import Record

SLOPE = 0.1  # rms slope; the mean pressure is a twentieth of it, in units of E*
ROUNDS = 3
EXECUTORS = ("one process", "two threads", "two processes")
# Parts of a long study, whose times are compared.
PARTS = 20


def make_study(cells: int, seeds: range, convolver: str = "auto", responses: tuple[str, ...] = ()) -> rc.Study:
    """Return a study of periodic rough contacts, each on one thread."""
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=SLOPE, shortest=8.0, longest=float(cells), rolloff=cells / 4, seed=7
    )
    body = rc.Body(surface, rc.Elastic(1.0, 0.0))
    grid = rc.Grid((cells, cells), float(cells))
    problem = rc.ContactProblem(body, grid=grid, boundary="periodic", convolver=convolver, threads=1)
    return rc.Study(problem, seeds=seeds, pressure=[0.05 * SLOPE], responses=responses)


@contextlib.contextmanager
def start(name: str) -> Iterator[Executor | None]:
    """Yield an executor of one of the kinds; None for this process."""
    if name == "one process":
        yield None
    elif name == "two threads":
        with ThreadPoolExecutor(2) as threads:
            yield threads
    else:
        with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
            yield pool


def measure_rates(contacts: int) -> None:
    """Print contacts a second of wall time."""
    convolvers = ("circular-fft", *(name for name in ("compiled",) if name in rc.convolvers))
    print("cells a side, convolver: contacts a second by", ", ".join(EXECUTORS))
    for cells in (64, 128):
        for convolver in convolvers:
            best = dict.fromkeys(EXECUTORS, 0.0)
            with contextlib.ExitStack() as stack:
                executors = {name: stack.enter_context(start(name)) for name in EXECUTORS}
                # The first round is shorter and does not count: workers start, and compiled code is loaded.
                for number in range(ROUNDS + 1):
                    for name, executor in executors.items():
                        seeds = range(contacts if number else 8)
                        study = make_study(cells, seeds, convolver, ("stiffness",))
                        with tempfile.TemporaryDirectory() as folder:
                            begin = time.perf_counter()
                            study.run(folder, executor=executor)
                            rate = len(seeds) / (time.perf_counter() - begin)
                        best[name] = max(best[name], rate) if number else 0.0
            print(f"{cells}, {convolver}: " + ", ".join(f"{best[name]:.1f}" for name in EXECUTORS), flush=True)


def run_records(folder: Path, contacts: int) -> None:
    """Run the study; write CPU and wall time since its start after each record, and then its digests."""
    begin, begin_cpu = time.perf_counter(), time.process_time()
    with Path(f"{folder}.times").open("a", encoding="utf-8") as file:

        def note(records: object) -> None:
            file.write(f"{time.process_time() - begin_cpu:.6f} {time.perf_counter() - begin:.6f}\n")
            file.flush()

        result = make_study(32, range(contacts)).run(folder, on_records=note)
    spent = time.process_time() - begin_cpu, time.perf_counter() - begin
    digests = [digest_records(result.records[:count]) for count in (contacts // 5, contacts)]
    print(json.dumps({"records": len(result), "computed": result.computed, "digests": digests, "spent": spent}))


def digest_records(records: Sequence[Record]) -> str:
    """Return a digest of all that records state but the seconds that they took."""
    stated = [{name: value for name, value in attrs.asdict(one).items() if name != "seconds"} for one in records]
    return hashlib.sha256(json.dumps(stated, sort_keys=True).encode()).hexdigest()[:16]


def begin_run(folder: Path, contacts: int) -> subprocess.Popen[str]:
    """Start `run_records` in a process of its own, its times in an empty file."""
    Path(f"{folder}.times").write_text("", encoding="utf-8")
    command = [sys.executable, __file__, "records", str(folder), str(contacts)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def end_run(process: subprocess.Popen[str]) -> dict[str, Any]:
    """Return what a run has found and spent."""
    found: dict[str, Any] = json.loads(process.communicate()[0])
    return found


def read_times(folder: Path) -> list[tuple[float, float]]:
    """Return CPU and wall time after each record of the last run."""
    lines = Path(f"{folder}.times").read_text(encoding="utf-8").splitlines()
    # The last line may not be whole yet.
    return [(float(cpu), float(wall)) for cpu, wall in map(str.split, lines[:-1])]


def count_lines(folder: Path) -> int:
    """Return how many whole records there are in the journals of killed runs."""
    return sum(path.read_bytes().count(b"\n") for path in folder.glob("study-*.jsonl"))


def describe_parts(spent: Sequence[float], few: int) -> str:
    """Return the median times of so many records each, ms, and the change from the first to the last."""
    parts = [1e3 * statistics.median(spent[place : place + few]) for place in range(0, len(spent) - few + 1, few)]
    return f"{' '.join(f'{one:.2f}' for one in parts)}, {100 * (parts[-1] / parts[0] - 1):+.1f} %"


def measure_kills(contacts: int) -> None:
    """Print what the records of a long study cost, and what kills and another run cost."""
    draw = random.Random(0)
    few = contacts // PARTS
    spent: list[float] = []
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch, "killed")
        known = 0
        for part in (0.2, 0.6, None):
            process = begin_run(folder, contacts)
            if part is None:
                found = end_run(process)
            else:
                wanted = int(contacts * (part + 0.2 * draw.random()))
                while len(read_times(folder)) < wanted:
                    time.sleep(0.5)
                time.sleep(draw.random())
                process.kill()
                process.wait()
            times = read_times(folder)
            if known:
                print(f"going on: {times[known - 1][0]:.2f} s of CPU time, {times[known - 1][1]:.2f} s of wall time")
            new = times[known:]
            spent += [after - before for (before, _), (after, _) in itertools.pairwise(new)]
            if part is not None:
                known = count_lines(folder)
                print(f"killed after {known} records", flush=True)
        print(f"killed twice: {found}")
        print(f"again, nothing left to do: {end_run(begin_run(folder, contacts))}", flush=True)
        print(f"median CPU ms a record, {few} at a time: {describe_parts(spent, few)}", flush=True)
        whole = end_run(begin_run(Path(scratch, "whole"), contacts // 5))
        print(f"a fifth without a stop: {whole}")
        same = whole["digests"][1] == found["digests"][0] and found["records"] == contacts
        print("the same records" if same else "OTHER RECORDS")


if __name__ == "__main__":
    kind, *rest = sys.argv[1:]
    if kind == "records":
        run_records(Path(rest[0]), int(rest[1]))
    elif kind == "rates":
        measure_rates(*map(int, rest or ["100"]))
    else:
        measure_kills(*map(int, rest or ["20000"]))
