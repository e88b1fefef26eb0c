"""Studies of paths on which time and sliding distance pass: files, records, continuation, refusals."""

from __future__ import annotations

import contextlib
import csv
import os
import random
import signal
import subprocess
import sys
import time

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from unit_files import PathFile, digest_of, read_study

STUDY = """
[problems.worn]
grid = {shape = [24, 13], size = [240e-6, 70e-6]}
laws = [{type = "archard", coefficient = "1e-16m2/N"}]
body = {surface = {type = "sphere", radius = "1mm"}, material = {young = "210GPa", poisson = 0.3, hardness = "2GPa"}}
[problems.rough]
boundary = "periodic"
laws = [{type = "archard", coefficient = "1e-15m2/N", of = "counterbody"}]
grid = {shape = [16, 16], size = 1e-4}
[problems.rough.body]
surface = {type = "self-affine", hurst = 0.8, rms_height = 1e-7, longest = 1e-4, shortest = 25e-6, seed = 5}
material = "bearing steel"
[study]
force = ["0.2N", "0.4N"]
sliding = ["0m", "10cm", "1m"]
accuracy = 0.02
fields = true
responses = ["perimeter"]
"""
SLIDING = [0.0, 0.1, 1.0]


@pytest.fixture
def study_file(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "study.toml"


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The study, and its results in a folder."""
    folder = tmp_path_factory.mktemp("passing")
    (folder / "study.toml").write_text(STUDY)
    study = read_study(folder / "study.toml")
    return study, study.run(folder / "all")


@pytest.mark.slow
def test_the_records_are_those_of_paths_by_hand(finished):
    study, result = finished
    assert [(one.problem, one.load) for one in result] == [(name, f) for name in ("worn", "rough") for f in (0.2, 0.4)]
    for record in result:
        path = study.problems[record.problem].path(force=record.load, sliding=SLIDING, accuracy=0.02)
        assert record.status == "CONVERGED"
        assert (record.time, record.sliding) == (None, 1.0)
        assert record.numbers["worn_volume"] == (path.table().columns["worn_volume"][-1], "m3")
        assert record.areas["blend"][0] == path[-1].area().value
        assert record.approach == path[-1].approach
        found = result.path(record)
        assert found.increments == path.increments
        for one, other in zip(found, path, strict=True):
            np.testing.assert_array_equal(one.pressure, other.pressure)
        assert result.solution(record).force == path[-1].force
        assert record.seconds == sum(state.seconds for state in found)
        rc.load(result.folder / f"{record.key}.npz", verify=True)


def test_what_the_laws_state_is_in_columns(finished):
    _, result = finished
    table = result.table()
    assert table.units["worn_volume"] == "m3"
    assert table.units["sliding"] == "m"
    assert "time" not in table.columns
    assert "dissipated" not in table.columns
    # Wear of the same work by a coefficient ten times as large.
    volume = table.columns["worn_volume"]
    assert volume[2] == pytest.approx(10.0 * volume[0], rel=1e-9)
    assert "worn volume" in str(result)
    # Flattening is remembered: no load is one of surfaces that were not.
    assert "first loading" not in str(result)


def test_it_goes_on_where_it_stopped(finished, tmp_path):
    study, result = finished
    again = study.run(result.folder)
    assert again.computed == 0
    assert again.records == result.records
    for record in result.records[1:]:
        source = result.folder / f"{record.key}.npz"
        (tmp_path / source.name).write_bytes(source.read_bytes())
    found = study.run(tmp_path)
    assert found.computed == 1
    for one, other in zip(found, result, strict=True):
        assert (one.key, one.numbers, one.areas, one.answers) == (other.key, other.numbers, other.areas, other.answers)
    # A file of another path under the name of this one is not believed.
    for path in tmp_path.glob("study*"):
        path.unlink()
    first, second = (tmp_path / f"{record.key}.npz" for record in result.records[:2])
    first.write_bytes(second.read_bytes())
    repaired = study.run(tmp_path)
    assert repaired.computed == 1
    assert repaired[0].numbers == result[0].numbers


@pytest.mark.slow
def test_without_files_paths_are_solved_again_to_the_same_bits(finished, tmp_path):
    study, result = finished
    bare = rc.Study(study.problems, force=study.force, sliding=SLIDING, accuracy=0.02)
    found = bare.run(tmp_path)
    assert not list(tmp_path.glob("*.npz"))
    for one, other in zip(found, result, strict=True):
        assert one.numbers == other.numbers
        np.testing.assert_array_equal(found.path(one)[-1].pressure, result.path(other)[-1].pressure)
    assert bare.run(tmp_path).computed == 0
    # Other places are other paths.
    assert rc.Study(study.problems, force=study.force, sliding=[0.0, 1.0]).run(tmp_path).computed == 4


def test_the_command_runs_it(study_file, finished, capsys):
    assert main(["run", str(study_file), "-o", str(study_file.parent / "night")]) in (0, 3)
    with (study_file.parent / "night" / "records.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    _, result = finished
    (name,) = [one for one in rows[0] if one.startswith("worn_volume")]
    assert [float(row[name]) for row in rows] == [record.numbers["worn_volume"][0] for record in result]


def test_creep_over_axes_of_a_function(tmp_path):
    def make(ratio: float) -> rc.ContactProblem:
        rubber = rc.Viscoelastic(moduli=[1e6, ratio * 1e6], times=["10ms"], poisson=0.5)
        body = rc.Body(rc.ParaboloidSurface(radius=10e-3), rubber)
        return rc.ContactProblem(body, grid=rc.Grid((16, 16), 4e-3))

    study = rc.Study(make, ratio=[1.0, 3.0], approach=["20um"], time=["0s", "10s"])
    assert "time 0 s, 10 s, under each normal load" in str(study.explain())
    result = study.run(tmp_path)
    forces = [record.force for record in result]
    # Both have relaxed to the same modulus.
    assert forces[0] == pytest.approx(forces[1], rel=1e-4)
    assert [record.time for record in result] == [10.0, 10.0]
    first = result.path(result[1])[0].force
    assert first == pytest.approx(4.0 * forces[1], rel=1e-4)


def test_loads_that_come_back_keep_their_records(tmp_path):
    """Each state remembers those before: the first and the third, at one load, are not the same."""
    ball = rc.Body(rc.SphereSurface(1e-3), rc.ElasticPerfectlyPlastic(210e9, 0.3, 2e9))
    problem = rc.ContactProblem(ball, grid=rc.Grid((24, 20), (1e-4, 0.8e-4)), laws=rc.Flattening())
    study = rc.Study(problem, force=[1.0, 4.0, 1.0, 4.0])
    first = study.run(tmp_path)
    assert first[2].approach > 1.2 * first[0].approach
    again = study.run(tmp_path)
    assert again.computed == 0
    assert again.records == first.records


def test_a_load_that_fails_leaves_the_others(tmp_path):
    """Each load is a path on fresh surfaces: it does not need the one before."""

    def make(size: float) -> rc.ContactProblem:
        ball = rc.Body(rc.SphereSurface(1e-3), rc.ElasticPerfectlyPlastic(210e9, 0.3, 2e9))
        return rc.ContactProblem(ball, grid=rc.Grid((12, 12), size), laws=rc.Archard("1e-16m2/N"))

    # On the smaller domain the first is more than the hardness carries.
    study = rc.Study(make, size=[4e-4, 1e-4], force=[100.0, 1.0], sliding=["0m", "1m"])
    result = study.run(tmp_path)
    assert [record.status for record in result] == ["CONVERGED", "CONVERGED", "REFUSED", "CONVERGED"]
    alone = make(1e-4).path(force=1.0, sliding=["0m", "1m"])
    assert result[3].numbers["worn_volume"][0] == alone.table().columns["worn_volume"][-1]


SCENARIO = """
[problems.worn]
grid = {shape = [40, 25], size = [240e-6, 70e-6]}
laws = [{type = "archard", coefficient = "1e-16m2/N"}]
body = {surface = {type = "sphere", radius = "1mm"}, material = {young = "210GPa", poisson = 0.3, hardness = "2GPa"}}
[study]
force = ["0.2N", "0.3N"]
sliding = ["0m", "10cm", "1m", "2m"]
factors = [1, 2, 0.5, 1]
accuracy = 1e-3
"""


def stated(records):
    """Return all that records state but the seconds that they took."""
    return [{name: value for name, value in attrs.asdict(one).items() if name != "seconds"} for one in records]


class TestScenario:
    """Loads that change as times and distances pass, over the load of the study."""

    @pytest.fixture(scope="class")
    @staticmethod
    def whole(tmp_path_factory):
        """The study, and its results by a run without a stop."""
        folder = tmp_path_factory.mktemp("scenario")
        (folder / "study.toml").write_text(SCENARIO)
        study = read_study(folder / "study.toml")
        return study, study.run(folder / "all")

    @pytest.mark.slow
    def test_it_is_a_path_of_its_loads(self, whole):
        study, result = whole
        for record in result:
            loads = [factor * record.load for factor in (1.0, 2.0, 0.5, 1.0)]
            path = study.problems["worn"].path(force=loads, sliding=[0.0, 0.1, 1.0, 2.0])
            assert record.numbers["worn_volume"] == (path.table().columns["worn_volume"][-1], "m3")
            assert record.approach == path[-1].approach
            np.testing.assert_array_equal(result.path(record).force, path.force)
        assert "under 1, 2, 0.5, 1 times each normal load" in str(study.explain())

    def test_it_is_told_from_other_ones(self, whole, tmp_path):
        study, _ = whole
        given = {"force": [0.2], "sliding": study.sliding, "accuracy": 0.1, "fields": True}
        for factors in (None, [1, 1, 1, 1], [1, 2, 0.5, 2]):
            found = rc.Study(study.problems, **given, factors=factors).run(tmp_path)
            assert found.computed == 1
            rc.load(tmp_path / f"{found[0].key}.npz", verify=True)
        for path in tmp_path.glob("study*"):
            path.unlink()
        assert rc.Study(study.problems, **given, factors=[1, 2, 0.5, 2]).run(tmp_path).computed == 0

    @pytest.mark.slow
    def test_what_was_interrupted_goes_on(self, whole, tmp_path, monkeypatch, caplog):
        study, result = whole
        caplog.set_level("INFO", logger="roughcontact")
        study.run(tmp_path / "other")
        needed = _count_solves(caplog)
        written = 0
        write = PathFile.write

        def write_and_stop(self, *others):
            nonlocal written
            write(self, *others)
            written += 1
            if written == needed // 4:
                raise KeyboardInterrupt

        caplog.clear()
        with monkeypatch.context() as patch:
            patch.setattr("roughcontact._solve.problem.path_file._PATIENCE", 0.0)
            patch.setattr(PathFile, "write", write_and_stop)
            with pytest.raises(KeyboardInterrupt):
                study.run(tmp_path)
        before = _count_solves(caplog)
        assert before >= written
        (draft,) = tmp_path.glob("*.npz")
        assert len(rc.load(draft)) >= 1
        caplog.clear()
        again = study.run(tmp_path)
        assert _count_solves(caplog) == needed - before
        assert stated(again) == stated(result)
        assert not list(tmp_path.glob("*.npz"))

    def test_a_damaged_draft_is_not_believed(self, whole, tmp_path):
        study, result = whole
        draft = tmp_path / f"{result[0].key}-draft.npz"
        draft.write_bytes(b"heights")
        assert stated(study.run(tmp_path)) == stated(result)
        assert not draft.exists()
        # One whose process was killed between the record and its removal.
        draft.write_bytes(b"heights")
        assert study.run(tmp_path).computed == 0
        assert not draft.exists()

    @pytest.mark.slow
    @pytest.mark.skipif(os.name != "posix", reason="processes are killed by a signal of POSIX")
    def test_kills_lose_nothing(self, tmp_path):
        """The records are those of a run that was left alone, and kills found the path at several places."""
        (tmp_path / "study.toml").write_text(SCENARIO.replace("accuracy = 1e-3", "accuracy = 5e-6"))
        study = read_study(tmp_path / "study.toml")
        alone = study.run(tmp_path / "alone")
        command = [sys.executable, "-m", "roughcontact", "run", "study.toml", "-o", "night"]
        rng = random.Random(5)
        found = set()
        for _ in range(6):
            process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL)
            _wait_for_writing(tmp_path / "night", process)
            time.sleep(rng.uniform(0.0, 0.3))
            process.send_signal(signal.SIGKILL)
            process.wait(timeout=300)
            drafts = _list_drafts(tmp_path / "night")
            found |= {digest_of(np.frombuffer(path.read_bytes(), np.uint8)) for path in drafts}
        assert len(found) >= 3
        done = subprocess.run(command, cwd=tmp_path, stdout=subprocess.DEVNULL, timeout=600)
        assert done.returncode in (0, 3)
        again = study.run(tmp_path / "night")
        assert again.computed == 0
        assert stated(again) == stated(alone)
        assert not _list_drafts(tmp_path / "night")


def _count_solves(caplog):
    return sum(record.getMessage().startswith("solved ") for record in caplog.records)


def _list_drafts(folder):
    return list(folder.glob("*-draft.npz"))


def _wait_for_writing(folder, process):
    """Wait until a draft was written by a process, or it has ended."""
    known = _list_states(folder)
    while _list_states(folder) <= known and process.poll() is None:
        time.sleep(0.002)


def _list_states(folder):
    states = set()
    for path in _list_drafts(folder):
        with contextlib.suppress(FileNotFoundError):
            states.add(path.stat().st_mtime_ns)
    return states


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"sliding": ["1m", "0m"]}, "not fall"),
        ({"sliding": "1m"}, "a list"),
        ({"sliding": ["0m"], "time": ["0s", "1s"]}, "one value for each place"),
        ({"time": ["0s", "1s"]}, "Nothing changes with the time"),
        ({"sliding": ["0m"], "friction": 0.3, "tangential_force": [(0.1, 0.0)]}, "without friction"),
        ({"sliding": ["0m"], "accuracy": 2.0}, "at most 1"),
        ({"accuracy": 0.01}, "increments of time or sliding"),
        ({"sliding": ["0m", "1m"], "factors": [1, 2, 3]}, "one value for each place"),
        ({"sliding": ["0m", "1m"], "factors": [0, 1]}, "above 0"),
        ({"sliding": ["0m", "1m"], "factors": [1, -1]}, "at least 0"),
        ({"sliding": ["0m", "1m"], "factors": 2.0}, "must be a list of numbers, factors="),
        ({"sliding": ["0m"], "factors": []}, "must be a list of numbers, factors="),
        ({"factors": [1, 2]}, r"give time=\[...\] or sliding= too"),
    ],
)
def test_what_does_not_fit_gets_a_sentence(arguments, said):
    ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    problem = rc.ContactProblem(ball, grid=rc.Grid((16, 16), 100e-6), laws=rc.Archard("1e-16m2/N"))
    with pytest.raises(rc.InputError, match=said):
        rc.Study(problem, force=[1.0], **arguments)
