"""SIGKILL at random moments of a study: nothing that was finished is lost."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import random
import signal
import threading
import time
from concurrent.futures import ProcessPoolExecutor

import attrs
import pytest

import roughcontact as rc
from scenes import SMALL_ROUGH, list_unfinished, small_problem, small_study, without_seconds
from systems import posix
from unit_files import read_records

# SIGKILLs at random moments of a study, by how it runs and what is killed. docs/trust/trust.md states their sum.
KILLS = {"serial": 40, "worker of a pool": 20, "parent of a pool": 20, "worker of dask": 20}
# Kills in one test, which takes less than a minute.
BLOCK = {"serial": 10, "worker of a pool": 10, "parent of a pool": 10, "worker of dask": 5}
SEED = 13


@attrs.frozen
class Deadly(rc.Surface):
    """A rough surface that kills the process for one seed."""

    seed: int = 0

    def reseed(self, seed):
        return attrs.evolve(self, seed=seed)

    def heights(self, grid):
        if self.seed == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        return attrs.evolve(SMALL_ROUGH, seed=self.seed).heights(grid)


def kill_study():
    """A study of 12 solves in 4 chains, which takes about half a second."""
    problems = {"free": small_problem(), "periodic": small_problem(boundary="periodic")}
    return small_study(problems=problems, force=[0.05, 0.2, 0.5], seeds=[0, 1])


def run_serially(folder):
    kill_study().run(folder)


def run_on_pool(folder):
    # A group of its own, so that its workers can be killed with it.
    os.setsid()
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork")) as executor:
        kill_study().run(folder, executor=executor)


@pytest.fixture(scope="module")
def forks():
    """Processes that have the package already."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["roughcontact", "numpy.testing", "scipy.fft", "scipy.ndimage"])
    return context


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    result = kill_study().run(tmp_path_factory.mktemp("undisturbed"))
    return result, [result.solution(record) for record in result.records]


def require_no_loss(folder, undisturbed):
    """Finish a study in the folder of a killed one, and compare all of it with the undisturbed one, bit by bit."""
    finished = len(list(folder.glob("*.npz")))
    wanted, solutions = undisturbed
    result = kill_study().run(folder)
    assert result.computed == len(wanted.records) - finished
    assert without_seconds(result.records) == without_seconds(wanted.records)
    for record, solution in zip(result.records, solutions, strict=True):
        found = result.solution(record)
        for name in ("pressure", "displacement", "initial_gap"):
            assert getattr(found, name).tobytes() == getattr(solution, name).tobytes()
        assert found.approach == solution.approach
    assert not list_unfinished(folder)
    assert kill_study().run(folder).computed == 0


def blocks(name):
    return [pytest.param(block, id=f"{name} {block}") for block in range(KILLS[name] // BLOCK[name])]


def folders_of_kills(tmp_path, name, block):
    """Yield a folder and a moment, in units of the time of a run, for each kill; what came too late is not counted."""
    rng = random.Random(f"{SEED} {name} {block}")
    for count in range(10 * BLOCK[name]):
        if len(list(tmp_path.glob("*/killed"))) >= BLOCK[name]:
            return
        folder = tmp_path / str(count)
        folder.mkdir()
        yield folder, rng.random()
    pytest.fail("the study was faster than its kills")


@pytest.mark.slow
@posix
class TestKills:
    """SIGKILL at random moments: nothing that was finished is lost, solved again or changed."""

    @pytest.mark.parametrize("block", blocks("serial"))
    def test_a_serial_study(self, tmp_path, forks, undisturbed, block):
        self.kill_process(tmp_path, forks, undisturbed, run_serially, "serial", block)

    @pytest.mark.parametrize("block", blocks("parent of a pool"))
    def test_the_parent_of_a_pool(self, tmp_path, forks, undisturbed, block):
        self.kill_process(tmp_path, forks, undisturbed, run_on_pool, "parent of a pool", block)

    def kill_process(self, tmp_path, forks, undisturbed, run, name, block):
        duration = None
        for folder, moment in folders_of_kills(tmp_path, name, block):
            process, started = forks.Process(target=run, args=(folder / "study",)), time.monotonic()
            process.start()
            process.join(None if duration is None else moment * duration)
            if process.is_alive():
                process.kill()
                (folder / "killed").touch()
            else:
                duration = time.monotonic() - started
            process.join()
            with contextlib.suppress(ProcessLookupError):
                # Workers without a parent go on for a while.
                time.sleep(0.1 * moment)
                os.killpg(process.pid, signal.SIGKILL)
                time.sleep(0.1)
            (folder / "study").mkdir(exist_ok=True)
            require_no_loss(folder / "study", undisturbed)

    @pytest.mark.parametrize("block", blocks("worker of a pool"))
    def test_a_worker_of_a_pool(self, tmp_path, forks, undisturbed, block):
        duration = None
        for folder, moment in folders_of_kills(tmp_path, "worker of a pool", block):
            seen, stopped = [], ""
            with ProcessPoolExecutor(2, mp_context=forks) as executor:
                list(executor.map(abs, range(4)))
                workers = list(executor._processes)
                timer = threading.Timer(
                    60 if duration is None else moment * duration, kill_one, (workers, moment, folder)
                )
                timer.start()
                started = time.monotonic()
                try:
                    kill_study().run(folder / "study", executor=executor, on_records=seen.extend)
                except rc.StudyStopped as error:
                    stopped = str(error)
                finished = time.monotonic()
                timer.cancel()
                timer.join()
                # One that was killed while it waited for a task has left a lock behind: the other would never end.
                for process in multiprocessing.active_children():
                    process.kill()
            if not (folder / "killed").exists():
                duration = finished - started
            assert not stopped or f"{len(seen)} of 12 solves are reported" in stopped
            assert {record.key for record in seen} <= set(read_records(folder / "study"))
            require_no_loss(folder / "study", undisturbed)

    @pytest.mark.parametrize("block", blocks("worker of dask"))
    def test_a_worker_of_dask(self, tmp_path, undisturbed, dask_cluster, block):
        duration = None
        client = dask_cluster.client
        for folder, moment in folders_of_kills(tmp_path, "worker of dask", block):
            dask_cluster.start(2)
            client.run(run_serially, tmp_path / "warm")
            workers = [worker.pid for worker in dask_cluster.workers]
            timer = threading.Timer(60 if duration is None else moment * duration, kill_one, (workers, moment, folder))
            timer.start()
            started = time.monotonic()
            result = kill_study().run(folder / "study", executor=client.get_executor())
            finished = time.monotonic()
            timer.cancel()
            timer.join()
            if (folder / "killed").exists():
                dask_cluster.workers[choose(workers, moment)].wait(timeout=60)
            else:
                duration = finished - started
            # The other worker has done the rest.
            assert len(result.records) == 12
            assert not result.failed
            require_no_loss(folder / "study", undisturbed)

    def test_dask_gives_up_a_task_that_kills_its_workers(self, tmp_path, dask_cluster):
        deadly = small_study(problems={"good": small_problem(), "deadly": small_problem(Deadly())}, seeds=[0, 1])
        # Dask gives a task up when it has ended four.
        dask_cluster.start(5)
        with pytest.raises(rc.StudyStopped, match=r"Every worker .*'deadly'.*KilledWorker.*6 of 8"):
            deadly.run(tmp_path, executor=dask_cluster.client.get_executor())
        assert len(read_records(tmp_path)) == 6


def choose(workers, moment):
    return int(1000 * moment) % len(workers)


def kill_one(workers, moment, folder):
    with contextlib.suppress(ProcessLookupError):
        os.kill(workers[choose(workers, moment)], signal.SIGKILL)
        (folder / "killed").touch()


def test_all_kills_are_in_blocks():
    assert sum(KILLS.values()) == 100
    assert all(KILLS[name] % BLOCK[name] == 0 for name in KILLS)
