"""A study that keeps its records alone: a line a solve while it runs, and no fields unless they are asked for."""

from __future__ import annotations

import multiprocessing
import time
from concurrent.futures import ThreadPoolExecutor

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._solve.problem import scene
from roughcontact._work.studies import chain, lists
from scenes import make_study, small_problem, small_study, without_seconds
from systems import posix
from unit_files import read_journal, read_records


def plain_study(**changes):
    """Twelve solves in four chains, of which nothing but the records is kept."""
    return make_study(fields=False, **changes)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """The same study with all its fields."""
    return make_study().run(tmp_path_factory.mktemp("kept"))


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return plain_study().run(tmp_path_factory.mktemp("plain"))


def list_journals(folder):
    return sorted(folder.glob("study-*.jsonl"))


def require_same_fields(found, wanted):
    for name in ("pressure", "displacement", "initial_gap", "gap"):
        assert getattr(found, name).tobytes() == getattr(wanted, name).tobytes()
    assert found.approach == wanted.approach


def interrupt_after(count, monkeypatch):
    """Let the solve after so many be interrupted from the keyboard."""
    solve, solved = rc.ContactProblem.solve, []

    def interrupt(self, **arguments):
        solved.append(1)
        if len(solved) > count:
            raise KeyboardInterrupt
        return solve(self, **arguments)

    monkeypatch.setattr(rc.ContactProblem, "solve", interrupt)


def test_records_have_the_same_bits_with_and_without_fields(kept, plain):
    assert without_seconds(plain) == without_seconds(kept)
    assert [path.suffix for path in plain.folder.iterdir()] == [".json"]
    assert len(list(kept.folder.glob("*.npz"))) == 12


def test_a_solution_without_a_file_is_solved_again_to_the_same_bits(kept, plain):
    for record in (plain[0], plain[5], plain[4], plain[11]):
        require_same_fields(plain.solution(record), kept.solution(record))


def test_a_path_without_a_file_is_solved_again(tmp_path):
    steel = rc.Elastic(210e9, 0.3)
    grid = rc.Grid((16, 24), (200e-6, 300e-6))
    problem = rc.ContactProblem(rc.Body(rc.SphereSurface(0.01), steel), rc.Body(rc.FlatSurface(), steel), grid=grid)
    along = {"tangential_force": [(0.1, 0.0), (-0.1, 0.0)], "friction": 0.3, "substeps": 1}
    found, wanted = (
        rc.Study(problem, force=[0.5, 1.0], fields=fields, **along).run(tmp_path / str(fields))
        for fields in (False, True)
    )
    assert without_seconds(found) == without_seconds(wanted)
    for one, other in zip(found, wanted, strict=True):
        assert len(found.path(one)) == len(wanted.path(other)) == 2
        np.testing.assert_array_equal(found.path(one)[-1].shear, wanted.path(other)[-1].shear)
        require_same_fields(found.solution(one), wanted.solution(other))


def test_what_has_no_solution_is_not_solved_again(tmp_path):
    refused = plain_study(problems=small_problem(), seeds=[], force=[0.1, 0.2]).run(tmp_path)
    lost = attrs.evolve(refused[0], force=np.nan, status="FAILED")
    with pytest.raises(rc.InputError, match="There is no file"):
        refused.solution(lost)
    with pytest.raises(rc.InputError, match="does not have this record"):
        refused.solution(attrs.evolve(refused[0], key="0" * 32))


def test_a_finished_study_computes_neither_solves_nor_keys(plain, monkeypatch):
    with monkeypatch.context() as context:
        context.setattr(rc.ContactProblem, "solve", lambda *_, **__: pytest.fail("solved again"))
        context.setattr(chain.Chain, "solution_keys", lambda _: pytest.fail("described again"))
        context.setattr(lists, "write_list", lambda *_: pytest.fail("written again"))
        again = plain_study().run(plain.folder)
    assert (again.computed, again.records) == (0, plain.records)


def test_the_list_is_written_once_and_each_record_once(tmp_path, monkeypatch):
    """The time of a record must not grow with their number."""
    written, lines = [], []
    with monkeypatch.context() as context:
        write, append = lists.write_list, lists.Journal.append
        context.setattr(lists, "write_list", lambda *given: written.append(given) or write(*given))
        context.setattr(lists.Journal, "append", lambda self, one: lines.append(one) or append(self, one))
        result = small_study(fields=False, seeds=range(5)).run(tmp_path)
    assert len(written) == 1
    assert sorted(one.key for one in lines) == sorted(one.key for one in result)
    assert not list_journals(tmp_path)
    assert set(read_records(tmp_path)) == {one.key for one in result}


def test_other_versions_are_solved_again(tmp_path, monkeypatch):
    plain_study(seeds=[0]).run(tmp_path)
    numbers = {"roughcontact": "0", "numpy": "0"}
    monkeypatch.setattr("roughcontact._solve.solution.origin.versions", lambda chosen=(): numbers)
    assert plain_study(seeds=[0]).run(tmp_path).computed == 6
    assert len(read_records(tmp_path)) == 12


def test_areas_and_responses_that_are_asked_later(tmp_path):
    plain_study(seeds=[0], areas=["cell-count"]).run(tmp_path)
    asked = {"seeds": [0], "areas": ["cell-count", "perimeter"], "responses": ["stiffness"]}
    later = plain_study(**asked).run(tmp_path)
    assert later.computed == 6
    assert without_seconds(later) == without_seconds(plain_study(**asked).run(tmp_path / "at once"))
    assert plain_study(**asked).run(tmp_path).computed == 0


def test_fields_that_are_asked_later(tmp_path, kept):
    plain_study().run(tmp_path)
    later = make_study().run(tmp_path)
    assert later.computed == 12
    require_same_fields(later.solution(later[3]), kept.solution(kept[3]))
    assert plain_study().run(tmp_path).computed == 0


def test_a_larger_study_in_the_folder_solves_the_rest(tmp_path):
    plain_study(seeds=[0], force=[0.5, 1.0]).run(tmp_path)
    assert plain_study(seeds=[0, 1], force=[0.5, 1.0]).run(tmp_path).computed == 4
    # Two problems with a new smallest load, which starts from the larger ones.
    assert plain_study(seeds=[0], force=[0.1, 0.5, 1.0]).run(tmp_path).computed == 2 * 3


def test_an_interrupted_study_goes_on_with_the_same_bits(tmp_path, monkeypatch, plain):
    with monkeypatch.context() as context:
        interrupt_after(5, context)
        with pytest.raises(KeyboardInterrupt):
            plain_study().run(tmp_path)
    assert len(read_records(tmp_path)) == 5
    (journal,) = list_journals(tmp_path)
    assert len(read_journal(journal)) == 5
    result = plain_study().run(tmp_path)
    # Those of the chain that was interrupted are solved again, as the last load starts from them.
    assert result.computed == 12 - 3
    assert without_seconds(result) == without_seconds(plain)


def test_a_torn_or_damaged_line_is_solved_again(tmp_path, monkeypatch, plain):
    with monkeypatch.context() as context:
        interrupt_after(6, context)
        with pytest.raises(KeyboardInterrupt):
            plain_study().run(tmp_path)
    (journal,) = list_journals(tmp_path)
    content = journal.read_bytes()
    assert len(read_records(tmp_path)) == 6
    rng = np.random.default_rng(0)
    for size in rng.integers(len(content), size=30):
        journal.write_bytes(content[:size])
        assert len(read_records(tmp_path)) == content[:size].count(b"\n")
    for place in rng.integers(len(content), size=100):
        changed = bytearray(content)
        changed[place] ^= 1 << int(rng.integers(8))
        journal.write_bytes(changed)
        assert 4 <= len(read_records(tmp_path)) <= 5
    journal.write_bytes(content[:-20])
    result = plain_study().run(tmp_path)
    assert without_seconds(result) == without_seconds(plain)


def test_a_list_of_before_is_read(tmp_path):
    """It does not say of which study its records are."""
    first = plain_study().run(tmp_path)
    (path,) = tmp_path.glob("study-*.json")
    lists.write_list(path, first.records)
    assert "current" not in path.read_text(encoding="utf-8")
    again = plain_study().run(tmp_path)
    assert (again.computed, again.records) == (0, first.records)


def test_threads_find_the_same_bits(tmp_path, plain):
    with ThreadPoolExecutor(2) as executor:
        result = plain_study().run(tmp_path, executor=executor)
    assert without_seconds(result) == without_seconds(plain)
    assert not list_journals(tmp_path)


def test_shares_leave_their_records_to_the_whole(tmp_path, plain):
    for number in (1, 2):
        assert plain_study().run(tmp_path, share=(number, 2)).computed == 6
    whole = plain_study().run(tmp_path)
    assert whole.computed == 0
    assert without_seconds(whole) == without_seconds(plain)


def run_plain(folder):
    plain_study(seeds=range(20)).run(folder)


@pytest.mark.slow
@posix
def test_a_study_that_is_killed_twice_loses_nothing(tmp_path):
    wanted = plain_study(seeds=range(20)).run(tmp_path / "whole")
    folder = tmp_path / "killed"
    folder.mkdir()
    for count in (10, 40):
        process = multiprocessing.get_context("fork").Process(target=run_plain, args=(folder,))
        process.start()
        deadline = time.monotonic() + 60
        while len(read_records(folder)) < count and time.monotonic() < deadline:
            time.sleep(0.01)
        process.kill()
        process.join()
    finished = read_records(folder)
    assert 40 <= len(finished) < len(wanted)
    result = plain_study(seeds=range(20)).run(folder)
    # At most one chain was begun and not ended.
    assert result.computed <= len(wanted) - len(finished) + 2
    assert without_seconds(result) == without_seconds(wanted)
    assert {key: one.seconds for key, one in finished.items()}.items() <= {
        one.key: one.seconds for one in result
    }.items()
    assert not list_journals(folder)


class OtherConvolver(type(rc.convolvers.create("circular-fft"))):
    """Stands for the convolver of a package that `"auto"` chooses where it is installed."""


@pytest.mark.parametrize("seeds", [(), (1, 2)])
def test_records_name_the_package_that_is_chosen(tmp_path, monkeypatch, seeds):
    """Two versions of a plug-in round differently: neither may take the records of the other for its own."""
    study = rc.Study(small_problem(), seeds=seeds, pressure=[1e6], fields=True)
    first = study.run(tmp_path)
    monkeypatch.setattr(scene, "choose_convolver", lambda grid, boundary: OtherConvolver())
    second = rc.Study(small_problem(), seeds=seeds, pressure=[1e6], fields=True).run(tmp_path)
    assert second.computed == len(second) == len(first)
    assert {one.key for one in first}.isdisjoint(one.key for one in second)
    # The file has the same name for it as the list.
    named = [name for name in second.solution(second[0]).origin.versions if "OtherConvolver" in name]
    assert len(named) == 1
    assert rc.Study(small_problem(), seeds=seeds, pressure=[1e6], fields=True).run(tmp_path).computed == 0
