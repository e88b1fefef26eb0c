"""Studies: nothing is lost, nothing is solved twice, and every mishap has its sentence."""

from __future__ import annotations

import contextlib
import csv
import hashlib
import itertools
import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
import weakref
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from roughcontact._faces.cli.run import list_warnings
from roughcontact._solve.problem.sweep import Sweep
from roughcontact._work.studies.chain import run_chain
from roughcontact._work.studies.record import read_index, write_index
from roughcontact._work.studies.toml import read_study

STEEL = rc.ElasticPerfectlyPlastic(210e9, 0.3, 6e9)
GRID = rc.Grid((48, 48), 1e-4)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=1e-4, shortest=8e-6, seed=5)


@attrs.frozen
class Foam(rc.Material):
    """A material that nobody has registered."""

    factor: float
    pressure_limit = np.inf

    @property
    def compliance(self):
        return self.factor * 1e-11


def problem(surface=ROUGH, material=STEEL, **parts):
    return rc.ContactProblem(rc.Body(surface, material), grid=GRID, **parts)


def study(**changes):
    parts = {
        "problems": {"periodic": problem(boundary="periodic"), "free": problem(rc.ParaboloidSurface(5e-3) + ROUGH)},
        "force": [0.1, 0.5, 1.0],
        "seeds": [0, 1],
        "areas": ["blend", "cell-count"],
    }
    return rc.Study(**{**parts, **changes})


def test_every_problem_meets_every_seed_and_load(tmp_path):
    result = study().run(tmp_path)
    assert [(r.problem, r.seed, r.load) for r in result.records] == [
        (name, seed, load) for name in ("periodic", "free") for seed in (0, 1) for load in (0.1, 0.5, 1.0)
    ]
    assert result.computed == 12
    assert not result.failed
    assert len({record.key for record in result.records}) == 12


def test_a_record_is_its_solution(tmp_path):
    result = study().run(tmp_path)
    for record in result.records:
        solution = result.solution(record)
        assert solution.force == record.force == pytest.approx(record.load)
        assert solution.area("cell-count").value == record.areas["cell-count"][0]
        assert solution.area().value == record.areas["blend"][0]
        again = rc.ContactProblem(**solution.origin.problem).solve(**solution.origin.load)
        np.testing.assert_allclose(again.pressure, solution.pressure, atol=1e-3 * record.p_max)


def test_seeds_are_added_to_the_surfaces_own(tmp_path):
    result = study(problems=problem(), seeds=[3]).run(tmp_path)
    surface = result.solution(result.records[0]).origin.problem["body"].surface
    assert surface == attrs.evolve(ROUGH, seed=8)


def test_what_is_there_is_not_solved_again(tmp_path, monkeypatch):
    first = study().run(tmp_path)
    monkeypatch.setattr(rc.ContactProblem, "solve", lambda *_, **__: pytest.fail("solved"))
    again = study().run(tmp_path)
    assert again.computed == 0
    assert again.records == first.records
    # Another estimator needs no solve either.
    more = study(areas=["perimeter"]).run(tmp_path)
    assert all("perimeter" in record.areas for record in more.records)


def test_only_what_is_missing_or_changed_is_solved(tmp_path):
    study().run(tmp_path)
    assert study(force=[0.1, 0.5, 1.0, 2.0]).run(tmp_path).computed == 4
    assert study(seeds=[0, 1, 2]).run(tmp_path).computed == 6
    changed = {"periodic": problem(boundary="periodic"), "free": problem(rc.ParaboloidSurface(6e-3) + ROUGH)}
    assert study(problems=changed).run(tmp_path).computed == 6


def test_loads_start_from_those_before(tmp_path):
    loads = list(np.geomspace(0.1, 10.0, 12))
    warm = study(problems=problem(boundary="periodic"), seeds=[], force=loads).run(tmp_path / "warm")
    cold = [problem(boundary="periodic").solve(force=load).convolutions for load in loads]
    assert sum(record.convolutions for record in warm.records) < 0.85 * sum(cold)


@pytest.mark.slow
@pytest.mark.parametrize("pool", ["threads", "processes"])
def test_any_executor_gives_the_same(tmp_path, pool):
    alone = study().run(tmp_path / "alone")
    if pool == "threads":
        executor = ThreadPoolExecutor(2)
    else:
        executor = ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn"))
    seen = []
    with executor:
        pooled = study().run(tmp_path / "pooled", executor=executor, on_records=seen.extend)
    strip = [attrs.evolve(record, seconds=0.0) for record in pooled.records]
    assert strip == [attrs.evolve(record, seconds=0.0) for record in alone.records]
    assert sorted(record.key for record in seen) == sorted(record.key for record in pooled.records)


def build(hurst, seed, boundary="periodic"):
    if hurst == 0.9 and seed == 1:
        raise KeyError("no such wave")
    return problem(attrs.evolve(ROUGH, hurst=hurst, seed=seed), boundary=boundary)


def over(**changes):
    return rc.Study(build, **{"hurst": [0.3, 0.8], "force": [0.1, 0.5], "seed": range(2), **changes})


class TestAxes:
    """The parameters of a function as axes."""

    def test_every_combination_is_a_problem_of_its_own(self, tmp_path):
        result = over().run(tmp_path)
        assert [(*record.parameters.values(), record.load) for record in result] == [
            (hurst, seed, load) for hurst in (0.3, 0.8) for seed in (0, 1) for load in (0.1, 0.5)
        ]
        assert result.computed == len({record.key for record in result}) == 8
        # Each is the solution of the problem that the function builds, under the key that it has in any study.
        record = result[-1]
        again = build(**record.parameters).solve(force=record.load)
        assert record.areas["blend"][0] == pytest.approx(again.area().value, rel=1e-3)
        named = rc.Study(problems=build(0.8, 1), force=[0.1, 0.5]).run(tmp_path)
        assert named.computed == 0
        assert [one.key for one in named] == [one.key for one in result[-2:]]

    def test_it_goes_on_where_it_was_and_solves_what_was_changed(self, tmp_path):
        first = over().run(tmp_path)
        assert over().run(tmp_path).computed == 0
        assert over().run(tmp_path).records == first.records
        assert over(hurst=[0.3, 0.8, 0.5]).run(tmp_path).computed == 4
        # A changed function builds other problems: they have other keys.
        changed = rc.Study(
            lambda hurst, seed: build(hurst, seed, boundary="free"), hurst=[0.3], seed=[0], force=[0.1, 0.5]
        )
        assert changed.run(tmp_path).computed == 2

    def test_problems_are_built_when_they_are_solved_and_not_kept(self, tmp_path):
        alive, most = weakref.WeakSet(), []

        def counted(seed):
            made = build(0.8, seed)
            alive.add(made.body)
            most.append(len(alive))
            return made

        study = rc.Study(counted, seed=range(12), force=[0.5])
        assert len(most) == 1
        study.run(tmp_path)
        assert max(most) <= 3

    @pytest.mark.slow
    @pytest.mark.parametrize("pool", ["threads", "processes"])
    def test_any_executor_gives_the_same_though_the_function_is_not_sent(self, tmp_path, pool):
        alone = over().run(tmp_path / "alone")
        study = rc.Study(lambda hurst, seed: build(hurst, seed), hurst=[0.3, 0.8], seed=range(2), force=[0.1, 0.5])
        spawn = multiprocessing.get_context("spawn")
        with ThreadPoolExecutor(2) if pool == "threads" else ProcessPoolExecutor(2, mp_context=spawn) as executor:
            pooled = study.run(tmp_path / "pooled", executor=executor)
        assert [attrs.evolve(one, seconds=0.0) for one in pooled] == [attrs.evolve(one, seconds=0.0) for one in alone]

    @pytest.mark.parametrize("threads", [0, 2])
    def test_what_cannot_be_built_is_in_the_records_with_its_place(self, tmp_path, threads):
        study = over(hurst=[0.8, 0.9])
        with ThreadPoolExecutor(threads) if threads else contextlib.nullcontext() as executor:
            result = study.run(tmp_path, executor=executor)
        assert result.computed == 6
        assert [(one.status, one.parameters) for one in result.failed] == [("REFUSED", {"hurst": 0.9, "seed": 1})] * 2
        assert result.failed[0].message == (
            "The problem with hurst=0.9, seed=1 cannot be built: KeyError: 'no such wave'."
        )
        assert np.isnan(result.failed[0].force)

    def test_a_data_frame_has_a_row_for_each_solve_and_a_column_for_each_axis(self, tmp_path):
        pytest.importorskip("pandas")
        result = over(areas=["blend", "cell-count"], hurst=[0.3, 0.9]).run(tmp_path)
        frame = result.to_pandas()
        assert list(frame.columns[:2]) == ["hurst", "seed"]
        assert len(frame) == len(result) == 8
        assert frame.attrs["units"]["load"] == "N"
        assert frame.attrs["units"]["area cell-count"] == "m2"
        mean = frame.groupby(["hurst", "load"])["area blend"].mean()
        expected = [record.areas["blend"][0] for record in result if record.parameters == {"hurst": 0.9, "seed": 0}]
        np.testing.assert_allclose(mean[0.9], expected)
        assert frame.query("status == 'REFUSED'")["area blend"].isna().all()
        result.to_csv(tmp_path / "records.csv")
        with (tmp_path / "records.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        assert [(float(row["hurst"]), int(row["seed"])) for row in rows] == list(
            zip(frame.hurst, frame.seed, strict=True)
        )

    def test_a_dataset_has_a_dimension_for_each_axis(self, tmp_path):
        pytest.importorskip("xarray")
        result = over(hurst=[0.9, 0.3]).run(tmp_path)
        dataset = result.to_xarray()
        assert dict(dataset.sizes) == {"hurst": 2, "seed": 2, "load": 2}
        for record in result:
            place = dataset.sel(**record.parameters, load=record.load)
            assert str(place.status.item()) == record.status
            area, uncertainty = record.areas.get("blend", (np.nan, np.nan))
            np.testing.assert_array_equal([place.area, place.area_uncertainty], [area, uncertainty])
            np.testing.assert_array_equal(place.p_max, record.p_max)
        assert dataset.area.units == "m2"
        assert int(dataset.area.isnull().sum()) == 2

    def test_named_problems_and_seeds_are_dimensions_too(self, tmp_path):
        pytest.importorskip("xarray")
        result = study().run(tmp_path)
        dataset = result.to_xarray()
        assert dataset.area.dims == ("estimator", "problem", "seed", "load")
        found = dataset.area.sel(estimator="cell-count", problem="free", seed=1, load=0.5)
        (record,) = [one for one in result if (one.problem, one.seed, one.load) == ("free", 1, 0.5)]
        assert float(found) == record.areas["cell-count"][0]
        assert list(result.to_pandas().columns[:2]) == ["problem", "seed"]

    def test_results_are_short_and_indexed(self, tmp_path):
        result = over(seed=[0]).run(tmp_path)
        assert repr(over(seed=[0])) == "<Study 2 values of hurst, 1 value of seed, 2 loads of force>"
        assert repr(study()) == "<Study 2 problems, 3 loads of force>"
        assert repr(result) == f"<StudyResult 4 solves, 4 of them now, in {tmp_path}>"
        assert result[0] is result.records[0]
        assert result[1:3] == result.records[1:3]
        with pytest.raises(rc.InputError, match="whole number from 0 to 3"):
            result[4]
        assert "<th>hurst</th>" in result._repr_html_()

    def test_the_plan_has_every_axis_and_the_time(self):
        """The rows behind the plans of the problems, before anything is solved."""

        def rows_of(study):
            rows = str(study.explain()).split("\n\n")[-1].splitlines()
            return {row[:10].strip(): row[11:] for row in rows}

        built = rows_of(over(seed=range(9)))
        assert built["hurst"] == "0.3, 0.8"
        assert built["seed"] == "0, 1, 2, 3, 4, 5, 6, ..., 8"
        assert built["force"] == "100 mN, 500 mN"
        assert built["solves"] == "36: 2 of hurst x 9 of seed x 2 of force"
        assert built[""] == "if all problems are like the first"
        named = rows_of(study())
        assert named["problem"] == "periodic, free"
        assert named["solves"] == "12: 2 of problem x 2 of seed x 3 of force"
        assert "" not in named
        assert re.fullmatch(r"about [\d.e+]+ (s|minutes|hours) in one process on this machine, .*", named["time"])

    def test_the_list_of_records_keeps_the_parameters_and_reads_older_ones(self, tmp_path):
        result = over(seed=[0]).run(tmp_path)
        (index,) = tmp_path.glob("study-*.json")
        assert [one.parameters for one in read_index(index).values()] == [{"hurst": 0.3, "seed": 0}] * 2 + [
            {"hurst": 0.8, "seed": 0}
        ] * 2
        assert list(read_index(index).values()) == list(result)
        # One without axes is, byte for byte, what it was before there were any.
        plain = rc.Study(problems=problem(), force=[0.1]).run(tmp_path / "plain")
        (index,) = (tmp_path / "plain").glob("study-*.json")
        assert "parameters" not in index.read_text(encoding="utf-8")
        assert list(read_index(index).values()) == list(plain)

    @pytest.mark.parametrize(
        ("changes", "words"),
        [
            ({"hurts": [0.3]}, "Did you mean 'hurst'"),
            ({"hurst": 0.3}, r"must be a list .* One value is hurst=\[value\]"),
            ({"hurst": "rough"}, "must be a list"),
            ({"hurst": []}, "from 1 to 100000 values"),
            ({"hurst": itertools.count()}, "from 1 to 100000 values"),
            ({"hurst": [0.3, 0.3]}, "given twice"),
            ({"hurst": [np.nan]}, "finite number"),
            ({"hurst": [STEEL]}, "a number, a text, True or False"),
            ({"seed": range(10**5)}, "at most 100000"),
            ({"seeds": [0]}, r"seed=\[\.\.\.\] instead of seeds="),
            ({"hurst": [3.0]}, "hurst=3.0, seed=0 cannot be built: The Hurst exponent"),
            ({"hurst": [0.9], "seed": [1]}, "cannot be built: KeyError"),
            ({"force": None}, "exactly one list of loads"),
            ({"force": [1e30]}, "hurst=0.3, seed=0"),
        ],
    )
    def test_bad_axes_get_a_sentence(self, changes, words):
        with pytest.raises(rc.InputError, match=words):
            over(**changes)

    @pytest.mark.parametrize(
        ("function", "words"),
        [
            (lambda pressure: None, "uses the name 'pressure' itself"),
            (lambda status="x": None, "uses the name 'status' itself"),
            (lambda hurst: None, r"needs a value of 'hurst'"),
            (lambda: "problem", "must be a ContactProblem"),
        ],
    )
    def test_a_function_that_builds_no_problem_gets_a_sentence(self, function, words):
        with pytest.raises(rc.InputError, match=words):
            rc.Study(function, force=[1.0])

    def test_axes_need_a_function(self):
        with pytest.raises(rc.InputError, match="no argument of Study named 'hurst'"):
            rc.Study(problem(), hurst=[0.3], force=[1.0])


class Flaky(ThreadPoolExecutor):
    """Loses the first task of each chain."""

    def __init__(self):
        super().__init__(1)
        self.lost = set()

    def submit(self, work, chain):
        name = (chain.name, chain.seed)
        if name in self.lost:
            return super().submit(work, chain)
        self.lost.add(name)
        # The worker dies after it has solved the first load.
        run_chain(attrs.evolve(chain, loads=chain.loads[:1]))
        future = Future()
        future.set_exception(RuntimeError("the worker died"))
        return future


def test_a_task_whose_worker_died_is_run_again_from_where_it_was(tmp_path):
    with Flaky() as executor:
        result = study().run(tmp_path, executor=executor)
    assert not result.failed
    assert len(result.records) == 12
    # The first load of each chain was on disk already.
    assert result.computed == 8


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
        study().run(tmp_path, executor=executor)
    result = study().run(tmp_path)
    assert len(result.records) == 12
    assert result.computed <= 12 - 6


@pytest.mark.slow
def test_a_killed_process_of_a_pool(tmp_path):
    """A pool that loses a process breaks; what was finished is safe."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as executor:

        def kill(_):
            for pid in list(executor._processes):
                # What was finished before is reported after the kill.
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)

        with pytest.raises(rc.StudyStopped, match="The executor broke"):
            study().run(tmp_path, executor=executor, on_records=kill)
    assert study().run(tmp_path).computed <= 9


@pytest.mark.slow
def test_a_dask_cluster_loses_a_worker_in_the_middle(tmp_path, dask_cluster):
    loads = list(np.geomspace(0.05, 5.0, 8))
    wanted = study(seeds=list(range(5)), force=loads)
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
        first = study().run(tmp_path)
        path = tmp_path / f"{first.records[4].key}.npz"
        path.write_bytes(path.read_bytes()[:1000])
        again = study().run(tmp_path)
        assert again.computed == 1
        assert again.solution(again.records[4]).force == pytest.approx(0.5)

    @pytest.mark.slow
    @pytest.mark.parametrize("content", [b"", b"[{", b"\xff\xfe", b'{"a": 1}', b'[{"key": "x"}]', b"[1, 2]"])
    def test_a_corrupt_index_is_made_again(self, tmp_path, content):
        first = study().run(tmp_path)
        (index,) = tmp_path.glob("study-*.json")
        index.write_bytes(content)
        again = study().run(tmp_path)
        assert again.computed == 0
        assert again.records == first.records
        assert len(json.loads(index.read_text())["records"]) == 12

    def test_a_flipped_bit_is_solved_again(self, tmp_path):
        first = study().run(tmp_path)
        rng = np.random.default_rng(1)
        for record in first.records[:3]:
            flip_bit(tmp_path / f"{record.key}.npz", rng)
        again = study().run(tmp_path)
        assert again.computed == 3
        assert [attrs.evolve(one, seconds=0.0) for one in again.records] == [
            attrs.evolve(one, seconds=0.0) for one in first.records
        ]

    def test_a_file_under_the_name_of_another_is_solved_again(self, tmp_path):
        first = study().run(tmp_path)
        one, other = (tmp_path / f"{record.key}.npz" for record in first.records[:2])
        one.write_bytes(other.read_bytes())
        assert study().run(tmp_path).computed == 1
        one.write_bytes(other.read_bytes())
        # Without the records of the index all files are read.
        assert study(areas=["perimeter"]).run(tmp_path).computed == 1

    def test_a_flipped_bit_in_the_index_is_found(self, tmp_path):
        study(seeds=[0]).run(tmp_path)
        (index,) = tmp_path.glob("study-*.json")
        intact = index.read_bytes()
        assert len(read_index(index)) == 6
        rng = np.random.default_rng(2)
        for _ in range(200):
            index.write_bytes(intact)
            flip_bit(index, rng)
            assert read_index(index) == {}

    def test_the_index_leads_to_no_other_folder(self, tmp_path):
        result = study(seeds=[0]).run(tmp_path)
        (index,) = tmp_path.glob("study-*.json")
        with pytest.raises(rc.InputError, match="32 hexadecimal digits"):
            attrs.evolve(result.records[0], key="../../secret")
        lines = index.read_text().splitlines()
        for key, count in (("../../secret", 0), (result.records[1].key, 5), (result.records[0].key, 6)):
            records = "\n".join([lines[1].replace(result.records[0].key, key), *lines[2:-1]])
            head = (
                lines[0].partition('"sha256": "')[0]
                + f'"sha256": "{hashlib.sha256(records.encode()).hexdigest()}", "records": ['
            )
            index.write_text("\n".join([head, records, lines[-1], ""]))
            assert len(read_index(index)) == count

    def test_a_file_that_was_taken_away_is_solved_again(self, tmp_path):
        first = study().run(tmp_path)
        (tmp_path / f"{first.records[0].key}.npz").unlink()
        assert study().run(tmp_path).computed == 1

    @pytest.mark.slow
    def test_a_full_disk_stops_the_study_with_a_sentence(self, tmp_path):
        """Files of this process may not grow beyond a limit, which fails as a full disk does."""
        script = tmp_path / "limited.py"
        script.write_text(
            "import resource, sys\n"
            f"sys.path.insert(0, {os.path.dirname(__file__)!r})\n"
            "from test_studies import study\n"
            "import roughcontact as rc\n"
            "limit = int(sys.argv[2])\n"
            "resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))\n"
            "try:\n"
            "    print(study().run(sys.argv[1]))\n"
            "except rc.StudyStopped as error:\n"
            "    print('stopped:', error)\n"
        )
        folder = tmp_path / "out"
        command = [sys.executable, str(script), str(folder)]
        whole = study(problems=problem(boundary="periodic"), seeds=[0]).run(tmp_path / "whole")
        sizes = sorted((tmp_path / "whole" / f"{record.key}.npz").stat().st_size for record in whole.records)
        done = subprocess.run([*command, str(sizes[0] - 100)], capture_output=True, text=True, check=True)
        assert "cannot be written to (File too large): 0 of 12 solves are reported" in done.stdout
        assert not list(folder.glob("*partial*"))
        done = subprocess.run([*command, str(10**9)], capture_output=True, text=True, check=True)
        assert "12 solves, 12 of them now" in done.stdout

    def test_two_studies_in_one_folder_at_once(self, tmp_path):
        command = (
            f"import sys; sys.path.insert(0, {os.path.dirname(__file__)!r}); "
            "from test_studies import study; r = study(force=eval(sys.argv[2])).run(sys.argv[1]); print(len(r.records))"
        )
        running = [
            subprocess.Popen([sys.executable, "-c", command, str(tmp_path), loads], stdout=subprocess.PIPE, text=True)
            for loads in ("[0.1, 0.5]", "[0.1, 0.5]", "[0.5, 1.0]")
        ]
        assert [process.communicate()[0].strip() for process in running] == ["8", "8", "8"]
        assert study().run(tmp_path).computed == 0
        assert not list(tmp_path.glob("*partial*"))

    def test_a_study_that_was_killed_goes_on(self, tmp_path):
        command = (
            f"import sys; sys.path.insert(0, {os.path.dirname(__file__)!r}); from test_studies import study; "
            "study(seeds=range(12)).run(sys.argv[1])"
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
        result = study(seeds=range(12)).run(tmp_path)
        assert result.computed == 72 - finished


@attrs.frozen
class Refusing(rc.Solver):
    tolerance: float = 1e-8

    def solve(self, convolution, task):
        raise rc.InputError("Refusing cannot carry this load.")


class TestRecords:
    """What is reported of each solve."""

    def test_a_solve_that_does_not_converge_is_a_record_and_is_tried_again(self, tmp_path):
        hopeless = problem(boundary="periodic", solver=rc.ProjectedConjugateGradient(tolerance=1e-12, max_iterations=1))
        result = study(problems={"hopeless": hopeless, "good": problem()}).run(tmp_path)
        assert {record.problem for record in result.failed} == {"hopeless"}
        assert "not converged" in result.failed[0].message
        again = study(problems={"hopeless": hopeless, "good": problem()}).run(tmp_path)
        assert again.computed == len(result.failed)

    def test_a_problem_that_the_solver_refuses_is_a_record(self, tmp_path):
        refused = problem(boundary="periodic", solver=Refusing())
        result = study(problems=refused, seeds=[]).run(tmp_path)
        assert {record.status for record in result.records} == {"REFUSED"}
        assert "this load" in result.records[0].message

    def test_the_table_has_a_row_for_each(self, tmp_path):
        result = study(seeds=[]).run(tmp_path)
        result.to_csv(tmp_path / "out.csv")
        lines = (tmp_path / "out.csv").read_text().splitlines()
        assert len(lines) == 7
        assert "area cell-count [m2]" in lines[0]
        assert ",force [N],mean_pressure [Pa],approach [m],p_max [Pa],saturated_area [m2]," in lines[0]
        assert ",seed," in lines[0]

    def test_what_a_sweep_states_too_has_the_same_name_and_value(self, tmp_path):
        pytest.importorskip("pandas")
        loads = [0.1, 0.5]
        result = study(problems=problem(boundary="periodic"), seeds=[], force=loads).run(tmp_path)
        sweep = Sweep(tuple(map(result.solution, result)))
        frame, expected = result.to_pandas(), sweep.to_pandas()
        common = ["mean_pressure", "force", "approach", "peak_pressure", "peak_pressure_uncertainty"]
        for name in common:
            np.testing.assert_array_equal(frame[name], expected[name])
            assert frame.attrs["units"][name] == expected.attrs["units"][name]
        np.testing.assert_array_equal(frame.saturated_area, [one.saturated_area().value for one in sweep])

    def test_warnings_are_kept_whoever_solves_and_in_every_form(self, tmp_path):
        pytest.importorskip("xarray")
        soft = problem(material=rc.Elastic(210.0, 0.3), boundary="periodic")
        parts = {"problems": {"soft": soft, "good": problem(boundary="periodic")}, "pressure": [1e-3, 2e-3]}
        first = study(**parts, force=None, seeds=[]).run(tmp_path)
        for record in first:
            solution = first.solution(record)
            assert set(solution.warnings) <= set(record.warnings)
            assert record.doubtful == bool(solution.warnings)
        assert all("foam or a gel" in record.warnings[0] for record in first[:2])
        assert str(first).splitlines()[0].endswith(f"now, 4 doubtful (see their warnings), in {tmp_path}")
        frame = first.to_pandas()
        assert frame.warnings[0].startswith("A Young's modulus of 210 Pa")
        assert frame.doubtful.all()
        assert "foam or a gel" in str(first.to_xarray().warnings.sel(problem="soft", load=1e-3).item())
        again = study(**parts, force=None, seeds=[]).run(tmp_path)
        assert (again.computed, again.records) == (0, first.records)

    def test_a_list_that_was_written_without_warnings_is_made_again_and_nothing_is_solved(self, tmp_path, monkeypatch):
        first = study(seeds=[]).run(tmp_path)
        (index,) = tmp_path.glob("study-*.json")
        new = ("warnings", "doubtful", "peak_pressure", "peak_pressure_uncertainty")
        with monkeypatch.context() as context:
            context.setattr(
                "roughcontact._work.studies.record._stated",
                lambda one: {name: value for name, value in attrs.asdict(one).items() if name not in new and value},
            )
            write_index(index, first.records)
        assert "doubtful" not in index.read_text(encoding="utf-8")
        again = study(seeds=[]).run(tmp_path)
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
        ({"problems": problem(rc.ParaboloidSurface(1e-3))}, "no surface of the problem"),
    ],
)
def test_bad_studies_get_a_sentence(changes, words):
    with pytest.raises(rc.InputError, match=words):
        study(**changes)


def test_parts_that_nobody_registered_take_part_in_studies(tmp_path):
    @attrs.frozen
    class Local(rc.Material):
        compliance, pressure_limit = 1e-11, np.inf

    foam = problem(material=Foam(2.0), boundary="periodic")
    with pytest.warns(UserWarning, match="the material test_studies:Foam must be registered"):
        first = study(problems=foam, seeds=[]).run(tmp_path)
    again = study(problems=foam, seeds=[]).run(tmp_path)
    assert (first.computed, again.computed) == (3, 0)
    assert first.solution(first.records[0]).force == pytest.approx(0.1)
    with pytest.warns(UserWarning, match="must be registered"):
        assert study(problems=problem(material=Foam(3.0), boundary="periodic"), seeds=[]).run(tmp_path).computed == 3
    with pytest.raises(rc.InputError, match=r"The content of the material .*Local is not known"):
        study(problems=problem(material=Local()), seeds=[]).run(tmp_path)


STUDY = """
[problems.rough]
boundary = "periodic"
grid = {shape = [48, 48], size = 1e-4}
[problems.rough.body]
surface = {type = "self-affine", hurst = 0.8, rms_height = 1e-7, longest = 1e-4, shortest = 8e-6, seed = 5}
material = {type = "elastic-perfectly-plastic", young = 210e9, poisson = 0.3, hardness = 6e9}
[problems.ball]
grid = {shape = [48, 48], size = 1e-4}
solver = {type = "projected-cg", tolerance = 1e-9}
[problems.ball.body]
surface = {type = "sum", parts = [{type = "sphere", radius = 5e-3}, {type = "file", path = "map.npz", detrend = 1}]}
material = {type = "elastic", young = 210e9, poisson = 0.3}
[study]
force = [0.1, 1.0]
areas = ["blend", "cell-count"]
"""


@pytest.fixture
def study_file(tmp_path):
    np.savez(tmp_path / "map.npz", heights=1e-8 * np.random.default_rng(0).random((48, 48)), size=1e-4)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "study.toml"


class TestFiles:
    """Studies in TOML."""

    def test_a_file_is_the_objects_it_says(self, study_file):
        read = read_study(study_file)
        assert [load.arguments for load in read.loads] == [{"force": 0.1}, {"force": 1.0}]
        assert read.problems["rough"].body.surface == ROUGH
        assert read.problems["rough"].boundary == "periodic"
        assert read.problems["ball"].solver == rc.ProjectedConjugateGradient(tolerance=1e-9)
        assert "less" not in read.explain()
        assert "the best plane subtracted" in read.explain()

    def test_the_command_runs_and_goes_on(self, study_file, capsys):
        assert main(["run", str(study_file), "--dry-run"]) == 0
        assert "4: 2 of problem x 2 of force" in capsys.readouterr().out
        assert main(["run", str(study_file)]) == 0
        folder = study_file.with_suffix("")
        out = capsys.readouterr().out
        printed = out.split()
        begins = f"4 solves, 4 of them now, in {folder}".split()
        # Only estimates are doubtful, which leaves the status at 0, as of `solve`.
        assert printed[: len(begins)] == begins
        assert "warning The contact area is uncertain: the" in " ".join(printed)
        assert max(map(len, out.splitlines())) <= 80
        lines = [line.split() for line in out.splitlines()]
        start = next(place for place, line in enumerate(lines) if line[:4] == ["problem", "load", "area", "blend,"])
        assert [line[:3] for line in lines[start + 1 : start + 5]] == [
            [name, load, unit] for name in ("rough", "ball") for load, unit in (("100", "mN"), ("1", "N"))
        ]
        unit = {"µm2": 1e-12, "nm2": 1e-18}[lines[start][4]]
        for line, record in zip(lines[start + 1 :], read_study(study_file).run(folder), strict=False):
            area, uncertainty = record.areas["blend"]
            assert float(line[3]) * unit == pytest.approx(area, abs=0.1 * uncertainty)
            assert float(line[5]) * unit == pytest.approx(uncertainty, rel=0.06)
        assert main(["run", str(study_file), "--workers", "2"]) == 0
        assert "0 of them now" in capsys.readouterr().out
        assert (folder / "records.csv").read_text().count("CONVERGED") == 4

    def test_the_command_prints_each_warning_once_and_ends_as_solve_does(self, study_file, capsys):
        text = study_file.read_text().replace("young = 210e9, poisson = 0.3}", "young = 210, poisson = 0.3}")
        study_file.write_text(text.replace("force = [0.1, 1.0]", "force = [1e-11, 1e-10]"))
        assert main(["run", str(study_file)]) == 3
        printed = " ".join(capsys.readouterr().out.split())
        assert printed.count("A Young's modulus of 210 Pa is that of a foam or a gel.") == 1
        assert "and the unit of heights from a file. [2 of 4 solves]" in printed
        assert main(["run", str(study_file)]) == 3

    def test_warnings_that_differ_in_numbers_alone_are_one(self, tmp_path):
        result = study(problems=problem(), seeds=[]).run(tmp_path)
        texts = ("9.5 % of 3 µm.", "99 % of 1 m.", "1e-5 % of 4 m."), ("99 % of 1 m.", "Another.")
        records = [attrs.evolve(result[0], warnings=own) for own in (*texts, ())]
        lines = list_warnings(attrs.evolve(result, records=tuple(records)))
        assert lines == [
            "warning  1e-5 % of 4 m. [2 of 3 solves, with other numbers]",
            "warning  Another. [1 of 3 solves]",
        ]

    @pytest.mark.parametrize(
        ("old", "new", "words"),
        [
            ("hurst = 0.8", "hurts = 0.8", "required field missing @ problems.rough.body.surface.hurst"),
            ("hurst = 0.8", "hurst = 0.8, hurts = 1", "unknown field 'hurts' (did you mean 'hurst'?) @ problems.rough"),
            (
                '"periodic"',
                '"perodic"',
                "must be one of 'free', 'periodic', 'wrapped', but got 'perodic'. @ problems.rough",
            ),
            ('"sphere"', '"shere"', "Did you mean 'sphere'? Known:"),
            (
                "young = 210e9",
                "young = -1",
                "Young's modulus must be a finite number, above 0 (Pa), but got -1. @ problems.rough.body.material",
            ),
            ("[study]", "[studi]", "unknown table (did you mean 'study'?) @ studi"),
            ("force =", "forces =", "unknown field 'forces' (did you mean 'force'?) @ study"),
            ("parts =", "part =", "unknown field 'part' (did you mean 'parts'?)"),
            ("[problems.ball]", "[problems.ball", "is not TOML"),
            ("0.1, 1.0", "1e9", "more than the bodies can carry"),
            ('path = "map.npz"', 'path = "none.npz"', "There is no file"),
            ("detrend = 1", "detrand = 1", "unknown field 'detrand' (did you mean 'detrend'?)"),
            ('type = "projected-cg"', 'typ = "projected-cg"', "with the name as type"),
            ("shape = [48, 48], ", "", "required field missing @ problems.rough.grid.shape"),
            (
                '"map.npz"',
                '"../map.npz"',
                "must be that of a file in the folder of the study file, but got '../map.npz'",
            ),
            ('"map.npz"', '"/etc/hostname"', "must be that of a file in the folder of the study file"),
            ('"map.npz"', '"link.npz"', "must be that of a file in the folder of the study file"),
            ('"map.npz"', "3", "must be that of a file in the folder of the study file, but got 3"),
            ('"sphere"', '"subprocess:Popen"', "There is no surface named 'subprocess:Popen'"),
            ("seed = 5", f"seed = {'9' * 5000}", "is not TOML: Exceeds the limit"),
            ("force = [0.1, 1.0]", f"force = {'[' * 5000}", "is not TOML"),
        ],
    )
    def test_what_is_wrong_is_named_with_its_path(self, study_file, capsys, old, new, words):
        (study_file.parent / "link.npz").symlink_to("/etc/hostname")
        study_file.write_text(STUDY.replace(old, new, 1))
        assert main(["run", str(study_file), "--dry-run"]) == 2
        error = capsys.readouterr().err
        assert words in error
        assert error.startswith(("roughcontact: In study.toml:", "roughcontact: The file study.toml"))
