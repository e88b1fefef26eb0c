"""How many threads a solve takes; tiles that threads share; the same bits whatever their number."""

from __future__ import annotations

import multiprocessing
import os
import sys
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact._base import machine
from roughcontact._base.archive.plain import key_of
from roughcontact._base.machine import choose_threads, map_tiles, split, use_threads
from roughcontact._solve.convolvers.base import approximate_inverse
from roughcontact._solve.problem import run as run_module
from roughcontact._work.studies.toml import read_study
from roughcontact.faces import available_threads
from roughcontact.typing import BoundKernel, PairConstants
from scenes import each_once
from strategies import grids, seeds
from test_memory import rough_problem

KERNEL = BoundKernel(rc.Love())
PAIRS = [(rc.DCFFT(), "free"), (rc.CircularFFT(), "periodic"), (rc.CircularFFT(), "wrapped")]
COUNTS = (1, 2, 3, 5)


@pytest.fixture
def many(monkeypatch):
    """A machine of five processors, on which the smallest arrays are shared by threads."""
    monkeypatch.setattr(machine, "available_threads", lambda: 5)
    monkeypatch.setattr(machine, "_CELLS_PER_THREAD", 1)


def write(root, **files):
    for name, text in files.items():
        path = root / name.replace("__", "/").replace("--", ".")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


class TestNumber:
    def test_is_that_of_the_processors_of_this_process(self, tmp_path, monkeypatch):
        monkeypatch.delattr(os, "process_cpu_count", raising=False)
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 3, 5}, raising=False)
        assert available_threads(tmp_path) == 3
        monkeypatch.delattr(os, "sched_getaffinity")
        monkeypatch.setattr(os, "cpu_count", lambda: None)
        assert available_threads(tmp_path) == 1

    @pytest.mark.parametrize(
        ("files", "count"),
        [
            ({"cpu--max": "250000 100000\n"}, 2),
            ({"cpu--max": "50000 100000\n"}, 1),
            ({"cpu--max": "max 100000\n"}, 8),
            ({"cpu--max": "damaged"}, 8),
            ({"job__cpu--max": "400000 100000\n", "cpu--max": "300000 100000\n"}, 3),
            ({"job__cpu--max": "400000 100000\n"}, 4),
        ],
    )
    def test_is_at_most_the_quota_of_a_control_group_of_version_2(self, tmp_path, monkeypatch, files, count):
        monkeypatch.setattr(os, "process_cpu_count", lambda: 8, raising=False)
        write(tmp_path, proc__self__cgroup="0::/job\n")
        write(tmp_path / "sys/fs/cgroup", **files)
        assert available_threads(tmp_path) == count

    @pytest.mark.parametrize(("quota", "count"), [("600000", 6), ("-1", 8)])
    def test_is_at_most_the_quota_of_a_control_group_of_version_1(self, tmp_path, monkeypatch, quota, count):
        monkeypatch.setattr(os, "process_cpu_count", lambda: 8, raising=False)
        write(tmp_path, proc__self__cgroup="2:cpu,cpuacct:/docker/1\n0::/\n")
        write(tmp_path / "sys/fs/cgroup/cpu", cpu__x="", **{"cpu--cfs_quota_us": quota, "cpu--cfs_period_us": "100000"})
        assert available_threads(tmp_path) == count

    def test_follows_the_size_of_the_grid_and_the_machine(self, monkeypatch):
        monkeypatch.setattr(machine, "available_threads", lambda: 4)
        assert [choose_threads("auto", n * n)[0] for n in (2, 256, 512, 1024, 2048, 8192)] == [1, 1, 1, 2, 4, 4]
        assert choose_threads(3, 4) == (3, "as given")
        assert choose_threads(9, 4) == (4, "not 9: this process may use no more")

    @pytest.mark.slow
    def test_is_one_beside_others_of_a_pool(self, monkeypatch):
        monkeypatch.setattr(machine, "available_threads", lambda: 4)
        with machine.share_machine():
            assert choose_threads("auto", 2**24) == (1, "others of a pool work beside this process")
            assert choose_threads(2, 2**24)[0] == 2
        assert choose_threads("auto", 2**24)[0] == 4
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            assert pool.submit(choose_threads, "auto", 2**24).result()[0] == 1

    def test_is_one_where_the_address_space_is_limited(self, monkeypatch):
        resource = pytest.importorskip("resource")
        monkeypatch.setattr(machine, "available_threads", lambda: 4)
        monkeypatch.setattr(resource, "getrlimit", lambda kind: (2**40, 2**41))
        assert choose_threads("auto", 2**24) == (
            1, "each takes a part of the address space, which is limited (ulimit -v)"
        )  # fmt: skip
        assert choose_threads(2, 2**24)[0] == 2

    @pytest.mark.parametrize("value", [0, -1, 1.5, "all", "2", None, True, np.nan, [1]])
    def test_that_is_none_is_refused(self, value):
        with pytest.raises(rc.InputError, match="The number of threads must be 'auto' or a whole number of at least 1"):
            rough_problem(32, threads=value)


class TestTiles:
    @given(st.integers(1, 50), st.integers(1, 60))
    def test_cover_an_axis_once(self, length, step):
        covered = [cell for tile in split(length, step) for cell in range(length)[tile]]
        assert covered == list(range(length))

    @pytest.mark.parametrize("count", COUNTS)
    def test_are_worked_on_once_and_returned_in_their_order(self, count):
        seen = []
        with use_threads(count):
            starts = map_tiles(lambda tile: seen.append(tile.start) or tile.start, split(100, 3))
        assert starts == sorted(seen) == list(range(0, 100, 3))

    def test_are_shared_by_so_many_threads_and_no_more(self):
        names, meeting = set(), threading.Barrier(3, timeout=30)

        def work(tile):
            # Nobody passes before three have come.
            meeting.wait()
            names.add(threading.current_thread().name)

        with use_threads(3):
            map_tiles(work, split(3, 1))
            assert len(names) == 3
            names.clear()
            map_tiles(lambda tile: names.add(threading.current_thread().name), split(500, 1))
        assert len(names) <= 3

    @pytest.mark.parametrize("count", COUNTS)
    def test_that_fail_raise_their_error(self, count):
        with use_threads(count), pytest.raises(ZeroDivisionError):
            map_tiles(lambda tile: 1 // (tile.start - 7), split(20, 1))

    def test_follow_the_floating_point_errors_of_the_caller(self):
        meeting = threading.Barrier(2, timeout=30)

        def work(tile):
            meeting.wait()
            return np.divide(1.0, np.zeros(1)).item()

        with use_threads(2):
            with np.errstate(divide="ignore"):
                assert map_tiles(work, split(2, 1)) == [np.inf, np.inf]
            with np.errstate(divide="raise"), pytest.raises(FloatingPointError):
                map_tiles(work, split(2, 1))

    def test_need_no_thread_that_cannot_be_started(self, monkeypatch):
        class Full:
            def submit(self, *_):
                raise RuntimeError("can't start new thread")

        monkeypatch.setattr(machine, "_pool", Full)
        with use_threads(4):
            assert map_tiles(lambda tile: tile.start, split(5, 1)) == [0, 1, 2, 3, 4]

    def test_work_while_others_use_all_threads(self):
        def solve(seed):
            with use_threads(3):
                return map_tiles(lambda tile: seed + tile.start, split(50, 1))

        with ThreadPoolExecutor(8) as pool:
            for seed, found in enumerate(pool.map(solve, range(40))):
                assert found == list(range(seed, seed + 50))

    @pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
    @pytest.mark.filterwarnings("ignore::DeprecationWarning")
    def test_work_in_a_forked_process(self):
        with use_threads(3):
            map_tiles(lambda tile: None, split(50, 1))
            child = os.fork()
            if child == 0:
                os._exit(0 if map_tiles(lambda tile: tile.start, split(50, 1)) == list(range(50)) else 1)
        assert os.waitpid(child, 0)[1] == 0


class TestBits:
    @pytest.mark.slow
    @pytest.mark.parametrize(("convolver", "boundary"), PAIRS)
    @pytest.mark.parametrize("dtype", [np.float32, np.float64])
    @given(grid=grids(90), seed=seeds)
    def test_of_a_convolution_are_the_same(self, convolver, boundary, dtype, grid, seed):
        pressure = np.random.default_rng(seed).random(grid.shape).astype(dtype)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(machine, "_CELLS_PER_THREAD", 1)
            patch.setattr("roughcontact._solve.convolvers.transforms._ROW_BLOCK_VALUES", 100)
            convolution = convolver.prepare(KERNEL, grid, rc.Boundary(boundary))
            inverse, fields = approximate_inverse(convolution.setup, dtype), []
            for count in COUNTS:
                for large in (2**60, 0):
                    patch.setattr("roughcontact._solve.convolvers.transforms._MIN_COLUMNWISE_WAVES", large)
                    with use_threads(count):
                        fields.append((convolution.apply(pressure), inverse.apply(pressure)))
        assert all(field.dtype == dtype and field.shape == grid.shape for pair in fields for field in pair)
        for pair in fields[1:]:
            np.testing.assert_array_equal(pair, fields[0])

    @pytest.mark.parametrize(("convolver", "boundary"), PAIRS[:2])
    def test_of_shear_are_the_same(self, convolver, boundary, many):
        grid = rc.Grid((40, 150), (40.0, 150.0))
        tractions = np.random.default_rng(0).standard_normal((3, *grid.shape))
        kernel = BoundKernel(rc.Love(), pair=PairConstants(0.29, 0.43))
        convolution = convolver.prepare(kernel, grid, rc.Boundary(boundary)).shear()
        fields = []
        for count in COUNTS:
            with use_threads(count):
                fields.append(convolution.apply(tractions, "xyz", "xyz"))
        for field in fields[1:]:
            np.testing.assert_array_equal(field, fields[0])

    @each_once(
        {
            "boundary": ["free", "periodic", "wrapped"],
            "solver": ["projected-cg", "polonsky-keer", "spectral-gradient"],
        }
    )
    def test_of_a_solution_are_the_same(self, boundary, solver, many):
        found = [
            rough_problem(64, boundary=boundary, solver=solver, threads=count).solve(pressure=5e6) for count in COUNTS
        ]
        for solution in found[1:]:
            np.testing.assert_array_equal(solution.pressure, found[0].pressure)
            np.testing.assert_array_equal(solution.displacement, found[0].displacement)
            assert (solution.errors, solution.residuals) == (found[0].errors, found[0].residuals)

    @pytest.mark.parametrize(("boundary", "pressure"), [("free", 1e6), ("periodic", 1e6), ("periodic", 2e7)])
    def test_of_a_solution_on_lists_of_cells_are_the_same(self, boundary, pressure, many, monkeypatch):
        """Few and many active cells, whose vectors are gathered by many tiles."""
        monkeypatch.setattr(machine, "_VALUES_PER_TILE", 100)
        monkeypatch.setattr("roughcontact._solve.solvers.conjugate.field_descent._MAX_FIELD_CELLS", 0)
        found = [rough_problem(96, boundary=boundary, threads=count).solve(pressure=pressure) for count in COUNTS]
        for solution in found[1:]:
            np.testing.assert_array_equal(solution.pressure, found[0].pressure)
            assert (solution.errors, solution.residuals) == (found[0].errors, found[0].residuals)

    def test_are_found_by_as_many_threads_as_the_problem_says(self, many, monkeypatch):
        import scipy.fft

        workers, transform = set(), scipy.fft.rfft
        monkeypatch.setattr(
            scipy.fft,
            "rfft",
            lambda *args, workers=1, _seen=workers, **more: (
                _seen.add(workers) or transform(*args, workers=workers, **more)
            ),
        )
        problem = rough_problem(64, boundary="periodic", threads=4)
        solution = problem.solve(pressure=5e6)
        assert workers == {4}
        workers.clear()
        problem.verify(solution)
        assert workers == {4}


class TestProblem:
    def test_explains_the_number(self, monkeypatch):
        monkeypatch.setattr(machine, "available_threads", lambda: 3)
        lines = [
            next(line for line in rough_problem(cells, threads=given).explain().splitlines() if "threads" in line)
            for cells, given in ((32, "auto"), (1024, "auto"), (2048, "auto"), (32, 2), (32, 7))
        ]
        assert [" ".join(line.split()) for line in lines] == [
            "threads 1: two pay from 1024 x 1024 cells",
            "threads 2: one for each 524288 cells",
            "threads 3: this process may use no more",
            "threads 2: as given",
            "threads 3: not 7: this process may use no more",
        ]

    def test_is_the_same_whatever_the_number(self, tmp_path):
        one, two = (rough_problem(32, threads=count, memory_limit=limit) for count, limit in ((1, None), (2, "1 GiB")))
        assert key_of(one.parts) == key_of(two.parts)
        assert "threads" not in two.parts
        assert attrs.evolve(two, boundary="periodic").threads == 2
        two.solve(pressure=5e6).save(tmp_path / "two.npz")
        one.verify(rc.ContactSolution.load(tmp_path / "two.npz"))

    def test_says_it_in_a_study_file(self, tmp_path):
        text = """
[problems.wave]
grid = {shape = [8, 8], size = 1e-3}
body.surface = {type = "wavy", amplitude = 1e-6, wavelength = 1e-3}
body.material = {type = "elastic", young = 1e9, poisson = 0.3}
threads = THREADS
memory_limit = "2 GiB"
[study]
pressure = [1e4]
"""
        path = Path(tmp_path / "study.toml")
        for threads_text, value in (("2", 2), ('"auto"', "auto")):
            path.write_text(text.replace("THREADS", threads_text))
            problem = read_study(path).problems["wave"]
            assert (problem.threads, problem.memory_limit) == (value, 2**31)
        path.write_text(text.replace("THREADS", '"many"'))
        with pytest.raises(rc.InputError, match="The number of threads must be 'auto' or"):
            read_study(path)


@pytest.mark.parametrize("pooled", [False, True])
def test_workers_of_a_study_take_one_thread(tmp_path, many, monkeypatch, pooled):
    counts, make = [], run_module.make_task
    monkeypatch.setattr(run_module, "make_task", lambda *given: counts.append(machine._THREADS.get()) or make(*given))
    study = rc.Study(problems=rough_problem(32), pressure=[5e6])
    # Threads of this process are workers that no process tells from others.
    with ThreadPoolExecutor(2) as executor:
        assert not study.run(tmp_path, executor=executor if pooled else None).failed
    assert counts == [1 if pooled else 5]


@pytest.mark.skipif(sys.platform != "linux", reason="counts the threads of a process as Linux does")
def test_a_small_solve_starts_no_thread():
    before = threading.active_count()
    rough_problem(64).solve(pressure=5e6)
    assert threading.active_count() == before
