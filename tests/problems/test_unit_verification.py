"""Digests and keys of programs, and studies whose records contradict their files."""

from __future__ import annotations

import itertools
import linecache
import sys
import textwrap
import types

import attrs
import pytest

import roughcontact as rc
from roughcontact._base.archive import plain
from roughcontact._base.archive.plain import programs, programs_of
from roughcontact._solve.solution import storage
from roughcontact._work.studies import lists
from test_verification import MATERIAL, problem, run_study, save
from unit_files import key_of

NOTEBOOK = """
FACTOR = {constant}

def soften(value, power={default}, *, limits=frozenset({{1.0, {limit}}})):
    return value * {helper}

def close_over(value):
    return lambda: value

class Foam:
    shape = ({field}, 2.0)
    inner = close_over({inside})

    @property
    def compliance(self):
        return FACTOR * soften(1e-11) + {body}

    @classmethod
    def make(cls):
        return {made}
"""


def test_a_key_knows_the_cells_of_a_notebook(monkeypatch):
    """The text of the class in its cell, and what it names in the module; not the number of the cell."""
    plain = dict.fromkeys(("constant", "default", "limit", "helper", "field", "inside", "body", "made"), 3.0)
    cells = (f"/tmp/ipykernel_1/{number}.py" for number in itertools.count())

    def digest(**changes):
        module = types.ModuleType("a_notebook")
        monkeypatch.setitem(sys.modules, "a_notebook", module)
        text = NOTEBOOK.format(**plain | changes)
        cell = next(cells)
        monkeypatch.setitem(linecache.cache, cell, (len(text), None, text.splitlines(keepends=True), cell))
        exec(compile(text, cell, "exec"), vars(module))
        return tuple(programs([module.Foam]))

    changed = {digest(**{name: 4.0}) for name in plain}
    assert len(changed) == len(plain)
    assert digest() not in changed
    assert digest() == digest()


def test_a_key_knows_the_distribution_of_a_class(monkeypatch, tmp_path):
    (tmp_path / "gel.py").write_text(textwrap.dedent(MATERIAL).format(constant=1, helper=1, body=0))
    folder = tmp_path / "gel-1.0.dist-info"
    folder.mkdir()
    (folder / "RECORD").write_text("gel.py,,\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    import gel

    keys = []
    for version in ("1.0", "1.1"):
        (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: gel\nVersion: {version}\n")
        plain._packages.cache_clear()
        assert programs_of(gel.Foam()) == [f"gel {version}"]
        keys.append(key_of(gel.Foam()))
    assert keys[0] != keys[1]
    plain._packages.cache_clear()


def test_a_key_knows_the_class_behind_a_name(monkeypatch):
    monkeypatch.setattr(rc.kernels, "_classes", {**rc.kernels._classes})

    @rc.kernels.register("mine")
    @attrs.frozen
    class Mine(rc.Love().__class__):
        pass

    assert programs_of({"kernel": "mine"})
    assert not programs_of({"kernel": "love", "convolver": "auto", "name": "mine"})
    assert not programs_of(problem().parts)


ERRORS = (
    MemoryError(),
    RecursionError(),
    OverflowError("int too large"),
    NotImplementedError(),
    RuntimeError(),
    OSError(5, "EIO"),
    KeyError(1),
)


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
@pytest.mark.parametrize("place", ["read_archive", "read_some", "assemble"])
def test_whatever_fails_while_a_study_reads_is_solved_again(tmp_path, monkeypatch, error, place):
    def fail(*_, **__):
        raise error

    first = run_study(tmp_path)
    for index in tmp_path.glob("*.json"):
        index.unlink()
    with monkeypatch.context() as context:
        context.setattr(storage, place, fail)
        assert run_study(tmp_path).computed == 2
    assert [one.key for one in run_study(tmp_path).records] == [one.key for one in first.records]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_whatever_fails_in_a_list_of_records_is_made_again(tmp_path, monkeypatch, error):
    def fail(*_, **__):
        raise error

    first = run_study(tmp_path)
    with monkeypatch.context() as context:
        context.setattr(lists, "rebuild", fail)
        assert run_study(tmp_path).records == first.records


def test_links_out_of_the_folder_of_a_study_are_not_followed(tmp_path):
    first = run_study(tmp_path / "study")
    path, elsewhere = tmp_path / "study" / f"{first.records[0].key}.npz", tmp_path / "elsewhere.npz"
    path.rename(elsewhere)
    path.symlink_to(elsewhere)
    with pytest.raises(rc.InputError, match="symbolic link"):
        first.solution(first.records[0])
    before = elsewhere.read_bytes()
    assert run_study(tmp_path / "study").computed == 1
    assert not path.is_symlink()
    assert elsewhere.read_bytes() == before
    (index,) = (tmp_path / "study").glob("*.json")
    index.rename(tmp_path / "index")
    index.symlink_to(tmp_path / "index")
    assert lists.read_list(index) == []


@pytest.mark.parametrize(
    "name", ["status", "force", "mean_pressure", "approach", "p_max", "saturated", "areas", "seconds"]
)
def test_a_list_of_records_that_contradicts_the_files_is_not_believed(tmp_path, name):
    first = run_study(tmp_path)
    value = {"status": "STALLED", "areas": {"blend": (1.0, 1.0)}}.get(name, 7.0)
    (index,) = tmp_path.glob("*.json")
    lists.write_list(index, [attrs.evolve(one, **{name: value}) for one in first.records])
    assert run_study(tmp_path).records == first.records


@pytest.mark.parametrize("place", ["read_archive", "assemble"])
def test_a_file_is_not_called_damaged_when_memory_is_short(tmp_path, monkeypatch, place):
    path = save(problem().solve(force=1.0), tmp_path / "solution.npz")

    def fail(*_, **__):
        raise MemoryError

    monkeypatch.setattr(storage, place, fail)
    with pytest.raises(rc.RoughContactError, match="more memory than there is"):
        rc.ContactSolution.load(path)
