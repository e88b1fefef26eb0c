"""Studies: nothing is lost, nothing is solved twice, and every mishap has its sentence."""

from __future__ import annotations

import contextlib
import hashlib
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor, ThreadPoolExecutor

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.results import Sweep
from scenes import ROUGH, make_problem, make_study
from systems import posix
from unit_files import read_index, write_list


@attrs.frozen
class Foam(rc.Material):
    """A material that nobody has registered."""

    factor: float
    pressure_limit = np.inf

    @property
    def compliance(self):
        return self.factor * 1e-11


def test_every_problem_meets_every_seed_and_load(tmp_path):
    result = make_study().run(tmp_path)
    assert [(r.problem, r.seed, r.load) for r in result.records] == [
        (name, seed, load) for name in ("periodic", "free") for seed in (0, 1) for load in (0.1, 0.5, 1.0)
    ]
    assert result.computed == 12
    assert not result.failed
    assert len({record.key for record in result.records}) == 12


def test_a_record_is_its_solution(tmp_path):
    result = make_study().run(tmp_path)
    for record in result.records:
        solution = result.solution(record)
        assert solution.force == record.force == pytest.approx(record.load)
        assert solution.area("cell-count").value == record.areas["cell-count"][0]
        assert solution.area().value == record.areas["blend"][0]
        again = rc.ContactProblem(**solution.origin.problem).solve(**solution.origin.load)
        np.testing.assert_allclose(again.pressure, solution.pressure, atol=1e-3 * record.p_max)


def test_the_keys_of_parts_that_ship_stay():
    """Those of earlier versions: a study of many hours is continued."""
    ball = rc.Body(rc.SphereSurface(1e-3), rc.Elastic(210e9, 0.3))
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=16e-6, longest=64e-6, seed=1)
    soft = rc.Body(rough + rc.SphereSurface(1e-3), rc.ElasticPerfectlyPlastic(210e9, 0.3, 2e9))
    grid = rc.Grid((16, 16), 100e-6)
    solver = rc.SpectralGradient(tolerance=1e-6)
    flat = rc.Body(rc.FlatSurface(), "glass")
    plastic = rc.ContactProblem(soft, flat, grid=grid, boundary="periodic", kernel="fourier", solver=solver)
    sticky = rc.ContactProblem(ball, grid=grid, adhesion=rc.Exponential(work=0.05, range=2e-6))
    assert rc.Study(rc.ContactProblem(ball, grid=grid), force=[1.0]).key == "956a2b6e5605"
    assert rc.Study({"b": plastic}, pressure=[1e6, 2e6], seeds=(0, 1)).key == "68197aed1936"
    assert rc.Study(sticky, force=[-1e-4, 1e-3]).key == "9a56246bebf7"


def test_seeds_are_added_to_the_surfaces_own(tmp_path):
    result = make_study(problems=make_problem(), seeds=[3]).run(tmp_path)
    surface = result.solution(result.records[0]).origin.problem["body"].surface
    assert surface == attrs.evolve(ROUGH, seed=8)


def test_what_is_there_is_not_solved_again(tmp_path, monkeypatch):
    first = make_study().run(tmp_path)
    monkeypatch.setattr(rc.ContactProblem, "solve", lambda *_, **__: pytest.fail("solved"))
    again = make_study().run(tmp_path)
    assert again.computed == 0
    assert again.records == first.records
    # Another estimator needs no solve either.
    more = make_study(areas=["perimeter"]).run(tmp_path)
    assert all("perimeter" in record.areas for record in more.records)


def test_only_what_is_missing_or_changed_is_solved(tmp_path):
    make_study().run(tmp_path)
    assert make_study(force=[0.1, 0.5, 1.0, 2.0]).run(tmp_path).computed == 4
    assert make_study(seeds=[0, 1, 2]).run(tmp_path).computed == 6
    changed = {"periodic": make_problem(boundary="periodic"), "free": make_problem(rc.ParaboloidSurface(6e-3) + ROUGH)}
    assert make_study(problems=changed).run(tmp_path).computed == 6


def test_loads_start_from_those_before(tmp_path):
    loads = list(np.geomspace(0.1, 10.0, 12))
    warm = make_study(problems=make_problem(boundary="periodic"), seeds=[], force=loads).run(tmp_path / "warm")
    cold = [make_problem(boundary="periodic").solve(force=load).convolutions for load in loads]
    assert sum(record.convolutions for record in warm.records) < 0.85 * sum(cold)


@pytest.mark.slow
@pytest.mark.parametrize("pool", ["threads", "processes"])
def test_any_executor_gives_the_same(tmp_path, pool):
    alone = make_study().run(tmp_path / "alone")
    if pool == "threads":
        executor = ThreadPoolExecutor(2)
    else:
        executor = ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn"))
    seen = []
    with executor:
        pooled = make_study().run(tmp_path / "pooled", executor=executor, on_records=seen.extend)
    strip = [attrs.evolve(record, seconds=0.0) for record in pooled.records]
    assert strip == [attrs.evolve(record, seconds=0.0) for record in alone.records]
    assert sorted(record.key for record in seen) == sorted(record.key for record in pooled.records)


class Dead(ThreadPoolExecutor):
    def submit(self, work, chain):
        if (chain.name, chain.seed) == ("free", 0):
            raise BrokenExecutor("no worker is left")
        return super().submit(work, chain)


def test_a_broken_executor_is_said_and_the_study_goes_on_later(tmp_path):
    with (
        Dead(1) as executor,
        pytest.raises(rc.StudyStopped, match=r"The executor broke.*it solves only what is missing"),
    ):
        make_study().run(tmp_path, executor=executor)
    result = make_study().run(tmp_path)
    assert len(result.records) == 12
    assert result.computed <= 12 - 6


@pytest.mark.slow
@posix
def test_a_killed_process_of_a_pool(tmp_path):
    """A pool that loses a process breaks; what was finished is safe."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as executor:

        def kill(_):
            for pid in list(executor._processes):
                # What was finished before is reported after the kill.
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)

        with pytest.raises(rc.StudyStopped, match="The executor broke"):
            make_study().run(tmp_path, executor=executor, on_records=kill)
    assert make_study().run(tmp_path).computed <= 9


@pytest.mark.slow
def test_a_dask_cluster_loses_a_worker_in_the_middle(tmp_path, dask_cluster):
    loads = list(np.geomspace(0.05, 5.0, 8))
    wanted = make_study(seeds=list(range(5)), force=loads)
    dask_cluster.start(3)
    killed = []

    def kill(_):
        if not killed:
            killed.append(dask_cluster.workers[0])
            killed[0].kill()

    result = wanted.run(tmp_path / "dask", executor=dask_cluster.client.get_executor(), on_records=kill)
    assert killed
    assert len(result.records) == 2 * 5 * 8
    assert not result.failed
    alone = wanted.run(tmp_path / "alone")
    for one, other in zip(result.records, alone.records, strict=True):
        assert one.key == other.key
        assert one.areas["blend"][0] == pytest.approx(other.areas["blend"][0], rel=1e-5)


def flip_bit(path, rng):
    content = bytearray(path.read_bytes())
    content[rng.integers(len(content))] ^= 1 << int(rng.integers(8))
    path.write_bytes(content)


class TestMishaps:
    """Damage on disk."""

    def test_half_a_file_is_solved_again(self, tmp_path):
        first = make_study().run(tmp_path)
        path = tmp_path / f"{first.records[4].key}.npz"
        path.write_bytes(path.read_bytes()[:1000])
        again = make_study().run(tmp_path)
        assert again.computed == 1
        assert again.solution(again.records[4]).force == pytest.approx(0.5)

    @pytest.mark.slow
    @pytest.mark.parametrize("content", [b"", b"[{", b"\xff\xfe", b'{"a": 1}', b'[{"key": "x"}]', b"[1, 2]"])
    def test_a_corrupt_index_is_made_again(self, tmp_path, content):
        first = make_study().run(tmp_path)
        (index,) = tmp_path.glob("study-*.json")
        index.write_bytes(content)
        again = make_study().run(tmp_path)
        assert again.computed == 0
        assert again.records == first.records
        assert len(json.loads(index.read_text())["records"]) == 12

    def test_a_flipped_bit_is_solved_again(self, tmp_path):
        first = make_study().run(tmp_path)
        rng = np.random.default_rng(1)
        for record in first.records[:3]:
            flip_bit(tmp_path / f"{record.key}.npz", rng)
        again = make_study().run(tmp_path)
        assert again.computed == 3
        assert [attrs.evolve(one, seconds=0.0) for one in again.records] == [
            attrs.evolve(one, seconds=0.0) for one in first.records
        ]

    def test_a_file_under_the_name_of_another_is_solved_again(self, tmp_path):
        first = make_study().run(tmp_path)
        one, other = (tmp_path / f"{record.key}.npz" for record in first.records[:2])
        one.write_bytes(other.read_bytes())
        assert make_study().run(tmp_path).computed == 1
        one.write_bytes(other.read_bytes())
        # Without the records of the index all files are read.
        assert make_study(areas=["perimeter"]).run(tmp_path).computed == 1

    def test_a_flipped_bit_in_the_index_is_found(self, tmp_path):
        make_study(seeds=[0]).run(tmp_path)
        (index,) = tmp_path.glob("study-*.json")
        intact = index.read_bytes()
        assert len(read_index(index)) == 6
        rng = np.random.default_rng(2)
        for _ in range(200):
            index.write_bytes(intact)
            flip_bit(index, rng)
            assert read_index(index) == {}

    def test_the_index_leads_to_no_other_folder(self, tmp_path):
        result = make_study(seeds=[0]).run(tmp_path)
        (index,) = tmp_path.glob("study-*.json")
        with pytest.raises(rc.InputError, match="32 hexadecimal digits"):
            attrs.evolve(result.records[0], key="../../secret")
        text = index.read_text()
        for key, count in (("../../secret", 0), (result.records[1].key, 5), (result.records[0].key, 6)):
            changed = text.replace(result.records[0].key, key)
            head, _, lines = changed.partition("\n")
            stated = json.loads(f"{head}]}}")
            content = f"{stated['study']}{stated['current']}" + lines.removesuffix("\n]}\n")
            index.write_text(changed.replace(stated["sha256"], hashlib.sha256(content.encode()).hexdigest()))
            assert len(read_index(index)) == count

    def test_a_file_that_was_taken_away_is_solved_again(self, tmp_path):
        first = make_study().run(tmp_path)
        (tmp_path / f"{first.records[0].key}.npz").unlink()
        assert make_study().run(tmp_path).computed == 1

    @pytest.mark.slow
    @posix
    def test_a_full_disk_stops_the_study_with_a_sentence(self, tmp_path):
        """Files of this process may not grow beyond a limit, which fails as a full disk does."""
        script = tmp_path / "limited.py"
        script.write_text(
            "import resource, sys\n"
            f"sys.path[:0] = {sys.path!r}\n"
            "from scenes import make_study\n"
            "import roughcontact as rc\n"
            "limit = int(sys.argv[2])\n"
            "resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))\n"
            "try:\n"
            "    print(make_study().run(sys.argv[1]))\n"
            "except rc.StudyStopped as error:\n"
            "    print('stopped:', error)\n"
        )
        folder = tmp_path / "out"
        command = [sys.executable, str(script), str(folder)]
        whole = make_study(problems=make_problem(boundary="periodic"), seeds=[0]).run(tmp_path / "whole")
        sizes = sorted((tmp_path / "whole" / f"{record.key}.npz").stat().st_size for record in whole.records)
        done = subprocess.run([*command, str(sizes[0] - 100)], capture_output=True, text=True, check=True)
        assert "cannot be written to (File too large): 0 of 12 solves are reported" in done.stdout
        assert not list(folder.glob("*partial*"))
        done = subprocess.run([*command, str(10**9)], capture_output=True, text=True, check=True)
        assert "12 solves, 12 of them now" in done.stdout

    @pytest.mark.slow
    def test_two_studies_in_one_folder_at_once(self, tmp_path):
        command = (
            f"import sys; sys.path[:0] = {sys.path!r}; "
            "from scenes import make_study; r = make_study(force=eval(sys.argv[2])).run(sys.argv[1]); "
            "print(len(r.records))"
        )
        running = [
            subprocess.Popen([sys.executable, "-c", command, str(tmp_path), loads], stdout=subprocess.PIPE, text=True)
            for loads in ("[0.1, 0.5]", "[0.1, 0.5]", "[0.5, 1.0]")
        ]
        assert [process.communicate()[0].strip() for process in running] == ["8", "8", "8"]
        assert make_study().run(tmp_path).computed == 0
        assert not list(tmp_path.glob("*partial*"))

    @pytest.mark.slow
    def test_a_study_that_was_killed_goes_on(self, tmp_path):
        command = (
            f"import sys; sys.path[:0] = {sys.path!r}; from scenes import make_study; "
            "make_study(seeds=range(12)).run(sys.argv[1])"
        )
        process = subprocess.Popen([sys.executable, "-c", command, str(tmp_path)])
        deadline = time.monotonic() + 60
        while len(list(tmp_path.glob("*.npz"))) < 5 and time.monotonic() < deadline:
            time.sleep(0.02)
        process.kill()
        process.wait()
        finished = len(list(tmp_path.glob("*.npz")))
        assert 5 <= finished < 72
        whole = [path.stem for path in tmp_path.glob("*.npz") if rc.ContactSolution.load(path)]
        assert len(whole) == finished
        result = make_study(seeds=range(12)).run(tmp_path)
        assert result.computed == 72 - finished


@attrs.frozen
class Refusing(rc.Solver):
    tolerance: float = 1e-8

    def solve(self, convolution, task):
        raise rc.InputError("Refusing cannot carry this load.")


class TestRecords:
    """What is reported of each solve."""

    def test_a_solve_that_does_not_converge_is_a_record_and_is_tried_again(self, tmp_path):
        hopeless = make_problem(
            boundary="periodic", solver=rc.ProjectedConjugateGradient(tolerance=1e-12, max_iterations=1)
        )
        result = make_study(problems={"hopeless": hopeless, "good": make_problem()}).run(tmp_path)
        assert {record.problem for record in result.failed} == {"hopeless"}
        assert "not converged" in result.failed[0].message
        again = make_study(problems={"hopeless": hopeless, "good": make_problem()}).run(tmp_path)
        assert again.computed == len(result.failed)

    def test_a_problem_that_the_solver_refuses_is_a_record(self, tmp_path):
        refused = make_problem(boundary="periodic", solver=Refusing())
        result = make_study(problems=refused, seeds=[]).run(tmp_path)
        assert {record.status for record in result.records} == {"REFUSED"}
        assert "this load" in result.records[0].message

    def test_the_table_has_a_row_for_each(self, tmp_path):
        result = make_study(seeds=[]).run(tmp_path)
        result.to_csv(tmp_path / "out.csv")
        lines = (tmp_path / "out.csv").read_text().splitlines()
        assert len(lines) == 7
        assert "area cell-count [m2]" in lines[0]
        assert ",force [N],mean_pressure [Pa],approach [m],p_max [Pa],saturated_area [m2]," in lines[0]
        assert ",seed," in lines[0]

    def test_what_a_sweep_states_too_has_the_same_name_and_value(self, tmp_path):
        pytest.importorskip("pandas")
        loads = [0.1, 0.5]
        result = make_study(problems=make_problem(boundary="periodic"), seeds=[], force=loads).run(tmp_path)
        sweep = Sweep(tuple(map(result.solution, result)))
        frame, expected = result.to_pandas(), sweep.to_pandas()
        common = ["mean_pressure", "force", "approach", "peak_pressure", "peak_pressure_uncertainty"]
        for name in common:
            np.testing.assert_array_equal(frame[name], expected[name])
            assert frame.attrs["units"][name] == expected.attrs["units"][name]
        np.testing.assert_array_equal(frame.saturated_area, [one.saturated_area().value for one in sweep])

    def test_warnings_are_kept_whoever_solves_and_in_every_form(self, tmp_path):
        pytest.importorskip("xarray")
        soft = make_problem(material=rc.Elastic(210.0, 0.3), boundary="periodic")
        parts = {"problems": {"soft": soft, "good": make_problem(boundary="periodic")}, "pressure": [1e-3, 2e-3]}
        first = make_study(**parts, force=None, seeds=[]).run(tmp_path)
        for record in first:
            solution = first.solution(record)
            assert set(solution.warnings) <= set(record.warnings)
            assert record.doubtful == bool(solution.warnings)
        assert all("foam or a gel" in record.warnings[0] for record in first[:2])
        assert " ".join(str(first).partition("\n\n")[0].split()).endswith(
            f"now, 4 doubtful (see their warnings), in {tmp_path}"
        )
        frame = first.to_pandas()
        assert frame.warnings[0].startswith("A Young's modulus of 210 Pa")
        assert frame.doubtful.all()
        assert "foam or a gel" in str(first.to_xarray().warnings.sel(problem="soft", load=1e-3).item())
        again = make_study(**parts, force=None, seeds=[]).run(tmp_path)
        assert (again.computed, again.records) == (0, first.records)

    def test_a_list_that_was_written_without_warnings_is_made_again_and_nothing_is_solved(self, tmp_path, monkeypatch):
        first = make_study(seeds=[]).run(tmp_path)
        (index,) = tmp_path.glob("study-*.json")
        new = ("warnings", "doubtful", "peak_pressure", "peak_pressure_uncertainty")
        with monkeypatch.context() as context:
            context.setattr(
                "roughcontact._work.studies.lists._stated",
                lambda one: {name: value for name, value in attrs.asdict(one).items() if name not in new and value},
            )
            write_list(index, first.records)
        assert "doubtful" not in index.read_text(encoding="utf-8")
        again = make_study(seeds=[]).run(tmp_path)
        assert (again.computed, again.records) == (0, first.records)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"problems": {}}, "problems of a study"),
        ({"problems": {"a": 1}}, "problem 'a'"),
        ({"force": None}, "exactly one list"),
        ({"force": []}, "is empty: give at least one load"),
        ({"pressure": [1e6]}, "exactly one list"),
        ({"force": [1.0, -1.0]}, "A load of force"),
        ({"force": "abc"}, "must be a list, force"),
        ({"force": 1.0}, "must be a list, force"),
        ({"force": [1.0, 1e9]}, "more than the bodies can carry"),
        ({"areas": ["blond"]}, "Did you mean 'blend'"),
        ({"areas": [3]}, "registered name"),
        ({"seeds": [0.5]}, "seed of the study"),
        ({"problems": make_problem(rc.ParaboloidSurface(1e-3))}, "no surface of the problem"),
    ],
)
def test_bad_studies_get_a_sentence(changes, words):
    with pytest.raises(rc.InputError, match=words):
        make_study(**changes)


def test_parts_that_nobody_registered_take_part_in_studies(tmp_path):
    @attrs.frozen
    class Local(rc.Material):
        compliance, pressure_limit = 1e-11, np.inf

    foam = make_problem(material=Foam(2.0), boundary="periodic")
    with pytest.warns(UserWarning, match="the material test_studies:Foam must be registered"):
        first = make_study(problems=foam, seeds=[]).run(tmp_path)
    again = make_study(problems=foam, seeds=[]).run(tmp_path)
    assert (first.computed, again.computed) == (3, 0)
    assert first.solution(first.records[0]).force == pytest.approx(0.1)
    with pytest.warns(UserWarning, match="must be registered"):
        assert (
            make_study(problems=make_problem(material=Foam(3.0), boundary="periodic"), seeds=[]).run(tmp_path).computed
            == 3
        )
    with pytest.raises(rc.InputError, match=r"The content of the material .*Local is not known"):
        make_study(problems=make_problem(material=Local()), seeds=[]).run(tmp_path)
