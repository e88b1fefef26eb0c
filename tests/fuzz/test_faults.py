"""What the project writes is complete or absent, whatever ends the run; what a study has solved is not lost."""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import os
import random
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.typing import replacing
from scenes import ELASTIC, SMALL_ROUGH, list_unfinished, small_problem, small_study, without_seconds
from systems import linux
from unit_files import read_records, remove_stale

resource = pytest.importorskip("resource", reason="full disks and permissions are those of POSIX")

SEED = 13


@attrs.frozen
class Trouble(rc.Surface):
    """A rough surface that fails for one seed."""

    trouble: str
    seed: int = 0

    def reseed(self, seed):
        return attrs.evolve(self, seed=seed)

    def heights(self, grid):
        if self.seed == 1:
            TROUBLES[self.trouble](grid)
            if self.trouble in FIELDS:
                return FIELDS[self.trouble](grid)
        return attrs.evolve(SMALL_ROUGH, seed=self.seed).heights(grid)


class Locked(Trouble):
    """A surface that holds what another process cannot have."""

    def __reduce__(self):
        raise TypeError("locked")


def raise_(error):
    raise error


class Unprintable(Exception):
    def __str__(self):
        raise ValueError("no text")


TROUBLES = {
    "a key": lambda _: {}["absent"],
    "no memory": lambda _: raise_(MemoryError()),
    "no file": lambda _: Path("/nowhere/map.txt").read_text(),
    "a full disk": lambda _: raise_(OSError(28, "No space left on device")),
    "endless recursion": lambda grid: TROUBLES["endless recursion"](grid),
    "an error without a text": lambda _: raise_(Unprintable()),
    "NaN": lambda _: None,
    "another shape": lambda _: None,
    "texts": lambda _: None,
    "killed": lambda _: os.kill(os.getpid(), signal.SIGKILL),
    "ends the process": lambda _: os._exit(3),
}
FIELDS = {
    "NaN": lambda grid: np.full(grid.shape, np.nan),
    "another shape": lambda _: np.zeros((2, 2)),
    "texts": lambda grid: np.full(grid.shape, "high"),
}
EXCEPTIONS = {
    "a key": r"The surface Trouble failed \(KeyError: 'absent'\)",
    "no memory": r"The surface Trouble failed \(MemoryError\)",
    "no file": "The surface Trouble failed .*No such file",
    "a full disk": "The surface Trouble failed .*No space left",
    "endless recursion": "The surface Trouble failed .*RecursionError",
    "an error without a text": "The surface Trouble failed .*Unprintable",
    "NaN": "finite|NaN|nan",
    "another shape": "shape",
    "texts": ".",
}


@pytest.mark.filterwarnings("ignore:.*must be registered")
class TestOneFailingPart:
    """It is the record of its solves, and the others go on."""

    @pytest.mark.parametrize("trouble", EXCEPTIONS)
    def test_a_surface(self, tmp_path, trouble):
        troubled = small_study(problems=small_problem(Trouble(trouble)))
        result = troubled.run(tmp_path)
        assert [record.success for record in result.records] == [True, True, False, False, True, True]
        for record in result.failed:
            assert record.seed == 1
            assert record.status in ("FAILED", "REFUSED")
            assert record.message.endswith(".")
            assert "\n" not in record.message
        assert "2 without a certified solution" in str(result)
        assert re.search(EXCEPTIONS[trouble], result.failed[0].message)
        # Run again, only what failed is tried.
        assert troubled.run(tmp_path).computed == 2
        assert not list_unfinished(tmp_path)

    @pytest.mark.parametrize("part", ["kernel", "convolver", "solver"])
    def test_any_part_of_one_problem(self, tmp_path, part):
        broken = {
            "kernel": {"kernel": BrokenKernel()},
            "convolver": {"convolver": BrokenConvolver()},
            "solver": {"solver": BrokenSolver()},
        }[part]
        result = small_study(problems={"broken": small_problem(**broken), "good": small_problem()}, seeds=[]).run(
            tmp_path
        )
        assert [record.problem for record in result.failed] == ["broken", "broken"]
        assert result.failed[0].message.startswith(f"The {part} ")
        assert "KeyError: 'absent'" in result.failed[0].message

    def test_an_estimator(self, tmp_path, monkeypatch):
        with monkeypatch.context() as broken:
            broken.setattr(rc.CellCount, "estimate", lambda *_: {}["absent"])
            result = small_study().run(tmp_path)
            assert result.computed == 6
            assert "6 without all areas" in str(result)
            for record in result.records:
                assert record.success
                assert set(record.areas) == {"blend"}
                assert record.message == "The area estimator 'cell-count' failed (KeyError: 'absent')."
            # What is known is not estimated again.
            broken.setattr(rc.Blend, "estimate", lambda *_: pytest.fail("estimated again"))
            assert without_seconds(small_study().run(tmp_path).records) == without_seconds(result.records)
        monkeypatch.setattr(rc.ContactProblem, "solve", lambda *_, **__: pytest.fail("solved again"))
        again = small_study().run(tmp_path)
        assert again.computed == 0
        assert not again.failed
        assert all(set(record.areas) == {"blend", "cell-count"} for record in again.records)

    def test_the_default_estimator(self, tmp_path, monkeypatch):
        with monkeypatch.context() as broken:
            broken.setattr(rc.Blend, "estimate", lambda *_: raise_(MemoryError("blend")))
            result = small_study(areas=["blend"]).run(tmp_path)
            assert "'blend' failed (MemoryError: blend)" in result.records[0].message
            assert result.solution(result.records[0]).force == pytest.approx(0.1)
        monkeypatch.setattr(rc.ContactProblem, "solve", lambda *_, **__: pytest.fail("solved again"))
        again = small_study(areas=["blend"]).run(tmp_path)
        assert not again.failed
        assert all(record.areas["blend"][0] > 0.0 for record in again.records)

    @pytest.mark.slow
    def test_a_problem_that_cannot_be_sent_to_a_worker(self, tmp_path):
        problems = {
            "locked": small_problem(Locked("NaN")),
            "good": small_problem(),
            "broken": small_problem(Trouble("a key")),
        }
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as executor:
            result = small_study(problems=problems, seeds=[1]).run(tmp_path, executor=executor)
        assert [record.success for record in result.records] == [False] * 2 + [True] * 2 + [False] * 2
        assert re.fullmatch(EXCEPTIONS["a key"] + r"\.", result.records[-1].message)
        assert "Sending the problem to a worker failed (TypeError: locked)" in result.records[0].message


@attrs.frozen
class BrokenKernel(rc.InfluenceKernel):
    name = "broken"

    def coefficients(self, *_, **__):
        return {}["absent"]


@attrs.frozen
class BrokenConvolver(rc.Convolver):
    boundaries = frozenset(rc.Boundary)

    def prepare(self, *_):
        return {}["absent"]


@attrs.frozen
class BrokenSolver(rc.Solver):
    tolerance = 1e-6

    def solve(self, *_):
        return {}["absent"]


class TestInterruption:
    """A study ends in order."""

    def test_from_the_keyboard(self, tmp_path, monkeypatch):
        solve, count = rc.ContactProblem.solve, []

        def interrupt(self, **arguments):
            count.append(1)
            return raise_(KeyboardInterrupt()) if len(count) == 4 else solve(self, **arguments)

        with monkeypatch.context() as patched:
            patched.setattr(rc.ContactProblem, "solve", interrupt)
            with pytest.raises(KeyboardInterrupt):
                small_study().run(tmp_path)
        assert len(read_records(tmp_path)) == 3
        assert not list_unfinished(tmp_path)
        assert small_study().run(tmp_path).computed == 3

    def test_of_a_worker(self, tmp_path, monkeypatch):
        monkeypatch.setattr(rc.ContactProblem, "solve", lambda *_, **__: raise_(KeyboardInterrupt()))
        with ThreadPoolExecutor(1) as executor:
            with pytest.raises(KeyboardInterrupt):
                small_study(seeds=range(50)).run(tmp_path, executor=executor)
            # What had not begun was cancelled.
            assert executor._work_queue.qsize() <= 50
        assert not list(tmp_path.glob("*.npz"))

    def test_by_the_caller(self, tmp_path):
        with ThreadPoolExecutor(1) as executor:
            with pytest.raises(ZeroDivisionError):
                small_study(seeds=range(30)).run(tmp_path, executor=executor, on_records=lambda _: 1 / 0)
            executor.shutdown()
        assert len(list(tmp_path.glob("*.npz"))) < 20

    def test_an_executor_that_takes_no_tasks(self, tmp_path):
        executor = ThreadPoolExecutor(1)
        executor.shutdown()
        with pytest.raises(rc.StudyStopped, match=r"The executor broke \(cannot schedule.*: 0 of 6 solves"):
            small_study().run(tmp_path, executor=executor)

    @pytest.mark.filterwarnings("ignore:.*must be registered")
    @pytest.mark.parametrize("trouble", ["killed", pytest.param("ends the process", marks=pytest.mark.slow)])
    def test_a_worker_that_its_task_kills(self, tmp_path, trouble):
        deadly, seen = small_study(problems=small_problem(Trouble(trouble)), seeds=[0, 1, 2]), []
        with (
            ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as executor,
            pytest.raises(rc.StudyStopped, match=r"The executor broke.*2 of 6 solves are reported"),
        ):
            deadly.run(tmp_path, executor=executor, on_records=seen.extend)
        assert sorted(read_records(tmp_path)) == sorted(record.key for record in seen)
        assert len(seen) == 2
        assert not list_unfinished(tmp_path)


class TestUnfinishedFiles:
    """What a killed process leaves, and only that, is removed."""

    def test_of_a_killed_process(self, tmp_path):
        kill = "import os, sys; from roughcontact._base.archive import replacing\n"
        kill += "with replacing(sys.argv[1]) as partial: partial.write_text('half'); os.kill(os.getpid(), 9)"
        for name in ["b" * 250]:
            subprocess.run([sys.executable, "-c", kill, str(tmp_path / name)], check=False)
            # The next process removes what the one before has left.
            assert len(list_unfinished(tmp_path)) == 1
        small_study(seeds=[0]).run(tmp_path)
        assert not list_unfinished(tmp_path)

    def test_by_the_next_that_writes_into_the_folder(self, tmp_path):
        with replacing(tmp_path / "x") as partial:
            partial.write_text("mine")
            machine = partial.name.split(".")[-3].split("-")[0]
            (tmp_path / f".x.{machine}-{dead_process()}.{'0' * 12}.partial").write_text("left")
            assert len(list_unfinished(tmp_path)) == 2
            remove_stale(tmp_path)
            assert list_unfinished(tmp_path) == [partial.name]
        assert (tmp_path / "x").read_text() == "mine"

    def test_what_stays(self, tmp_path):
        """Files of running processes, of other machines, of other programs; and what a link leads to."""
        with replacing(tmp_path / "x") as partial:
            partial.write_text("")
            machine = partial.name.split(".")[-3].split("-")[0]
        dead = dead_process()
        kept = [
            f".x.{machine}-{os.getppid()}.{'0' * 12}.partial",
            f".x.00000000-{dead}.{'0' * 12}.partial",
            f".x.{machine}-{dead}.partial",
            f"x.{machine}-{dead}.{'0' * 12}.partial",
            f".x.{machine}-{10**30}.{'0' * 12}.partial",
        ]
        for name in kept:
            (tmp_path / name).write_text("")
        outside = tmp_path.parent / "outside"
        outside.write_text("here")
        (tmp_path / f".link.{machine}-{dead}.{'0' * 12}.partial").symlink_to(outside)
        (tmp_path / f".folder.{machine}-{dead}.{'0' * 12}.partial").mkdir()
        before = list_unfinished(tmp_path)
        remove_stale(tmp_path)
        assert list_unfinished(tmp_path) == before
        assert outside.read_text() == "here"
        # Those of other machines are removed after a week.
        old = tmp_path / kept[1]
        os.utime(old, (0, time.time() - 8 * 86400))
        remove_stale(tmp_path)
        assert sorted({*list_unfinished(tmp_path), old.name}) == before
        assert not old.exists()

    @linux
    def test_a_file_is_on_the_disk_before_it_has_its_name(self, tmp_path, monkeypatch):
        done, fsync, replace = [], os.fsync, Path.replace
        monkeypatch.setattr(os, "fsync", lambda fd: done.append(name_of_descriptor(fd)) or fsync(fd))
        monkeypatch.setattr(Path, "replace", lambda one, other: done.append(other.name) or replace(one, other))
        with replacing(tmp_path / "x.csv") as partial:
            partial.write_text("1")
        assert done == [partial.name, "x.csv", tmp_path.name]


def name_of_descriptor(descriptor):
    return Path(os.readlink(f"/proc/self/fd/{descriptor}")).name


def dead_process():
    process = subprocess.Popen(["true"])
    process.wait()
    return process.pid


@contextlib.contextmanager
def full_disk(size):
    """Let files grow to a size only: writing more fails as on a full disk, in the same calls of the system."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@contextlib.contextmanager
def without_privileges():
    """Obey the permissions of files, as root does not: give up its capability to override them, for a while."""
    if not sys.platform.startswith("linux"):
        if os.geteuid() == 0:
            pytest.skip("only Linux divides the privileges of root")
        yield
        return
    libc, header = ctypes.CDLL(None), (ctypes.c_uint32 * 2)(0x20080522, 0)
    held = (ctypes.c_uint32 * 6)()
    assert libc.capget(header, held) == 0
    fewer = (ctypes.c_uint32 * 6)(held[0] & ~0b110, *held[1:])
    assert libc.capset(header, fewer) == 0
    try:
        yield
    finally:
        assert libc.capset(header, held) == 0


class TestDisk:
    """A full disk, a folder that cannot be written to: a sentence, and what was there stays as it was."""

    def test_a_full_disk_keeps_what_is_finished(self, tmp_path):
        """The solutions of the larger problem do not fit."""
        large = rc.ContactProblem(rc.Body(SMALL_ROUGH, ELASTIC), grid=rc.Grid((64, 64), 1e-4))
        both, seen = small_study(problems={"small": small_problem(), "large": large}, seeds=[0]), []
        with (
            full_disk(60_000),
            pytest.raises(rc.StudyStopped, match=r"cannot be written to .*: 2 of 4 solves"),
        ):
            both.run(tmp_path, on_records=seen.extend)
        assert set(read_records(tmp_path)) == {record.key for record in seen}
        assert len(seen) == 2
        assert both.run(tmp_path).computed == 2
        assert not list_unfinished(tmp_path)

    def test_a_full_disk_ends_the_tasks_of_an_executor(self, tmp_path):
        with (
            full_disk(1000),
            ThreadPoolExecutor(2) as executor,
            pytest.raises(rc.StudyStopped, match="File too large"),
        ):
            small_study(seeds=range(6)).run(tmp_path, executor=executor)
        assert small_study(seeds=range(6)).run(tmp_path).computed == 12

    def test_a_folder_that_cannot_be_made_or_written_to(self, tmp_path):
        (tmp_path / "file").write_text("")
        with pytest.raises(rc.InputError, match=r"folder .*file/deep' of the study cannot be made"):
            small_study().run(tmp_path / "file" / "deep")
        (tmp_path / "closed").mkdir(mode=0o555)
        with without_privileges(), pytest.raises(rc.StudyStopped, match=r"\(Permission denied\): 0 of 6 solves"):
            small_study().run(tmp_path / "closed")

    def test_a_finished_study_is_read_where_nothing_can_be_written(self, tmp_path):
        first = small_study().run(tmp_path)
        tmp_path.chmod(0o555)
        with without_privileges():
            again = small_study().run(tmp_path)
        assert again.records == first.records

    def test_a_device_is_not_replaced(self):
        with pytest.raises(rc.InputError, match="something else than a file at '/dev/null'"), replacing("/dev/null"):
            pass


def test_nothing_depends_on_the_clocks(tmp_path, monkeypatch):
    """They jump by a year, forwards and backwards, at each call."""
    first = small_study().run(tmp_path / "steady")
    rng = random.Random(SEED)
    for name in ("time", "monotonic", "perf_counter", "process_time", "thread_time"):
        monkeypatch.setattr(time, name, lambda: rng.uniform(-3e7, 3e7))
    result = small_study().run(tmp_path / "jumps")
    assert small_study().run(tmp_path / "jumps").computed == 0
    monkeypatch.undo()
    assert without_seconds(first.records) == without_seconds(result.records)
    for record in result.records:
        assert (result.solution(record).pressure == first.solution(record).pressure).all()
    assert small_study().run(tmp_path / "jumps").computed == 0


@pytest.mark.slow
@linux
def test_too_little_memory_for_one_problem(tmp_path):
    """The address space is limited: the large problem fails, the others are solved."""
    script = (
        "import resource, sys\n"
        f"sys.path[:0] = {sys.path!r}\n"
        "from test_faults import *\n"
        "large = rc.ContactProblem(rc.Body(rc.SphereSurface(1e-3), ELASTIC), grid=rc.Grid((4000, 4000), 1e-4))\n"
        "problems = {'first': small_problem(), 'large': large, 'last': small_problem(rc.SphereSurface(1e-3))}\n"
        # Libraries of linear algebra take buffers at their first use, and end the process where they cannot.
        "small_study(problems={'before': small_problem()}, seeds=[]).run(sys.argv[1] + '/before')\n"
        "pages = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
        "resource.setrlimit(resource.RLIMIT_AS, (pages + 2**27, pages + 2**27))\n"
        "for record in small_study(problems=problems, seeds=[]).run(sys.argv[1]).records:\n"
        "    print(record.problem, record.success, record.message)\n"
    )
    done = subprocess.run([sys.executable, "-c", script, str(tmp_path)], capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert [line.split()[:2] for line in lines] == [
        [name, str(name != "large")] for name in ("first", "large", "last") for _ in range(2)
    ]
    assert all("emory" in line for line in lines[2:4])
    assert not list_unfinished(tmp_path)
