"""The chains of a study, the warnings of its table, and parts that are fields of others."""

from __future__ import annotations

import re
from concurrent.futures import Future, ThreadPoolExecutor

import attrs
import pytest

import roughcontact as rc
from roughcontact._base.archive.plain import parts
from roughcontact._faces.cli.run import list_warnings
from roughcontact._work.studies.chain import run_chain
from roughcontact.faces import build_problem
from scenes import make_problem, make_study


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
        result = make_study().run(tmp_path, executor=executor)
    assert not result.failed
    assert len(result.records) == 12
    # The first load of each chain was on disk already.
    assert result.computed == 8


class TestFiles:
    def test_warnings_that_differ_in_numbers_alone_are_one(self, tmp_path):
        result = make_study(problems=make_problem(), seeds=[]).run(tmp_path)
        texts = ("9.5 % of 3 µm.", "99 % of 1 m.", "1e-5 % of 4 m."), ("99 % of 1 m.", "Another.")
        records = [attrs.evolve(result[0], warnings=own) for own in (*texts, ())]
        lines = list_warnings(attrs.evolve(result, records=tuple(records)))
        assert lines == [
            "warning  1e-5 % of 4 m. [2 of 3 solves, with other numbers]",
            "warning  Another. [1 of 3 solves]",
        ]


class Shape(rc.typing.Part):
    """A part that is a field of others, without a registry of its own."""


@attrs.frozen
class Box(Shape):
    height: float = attrs.field(metadata={"unit": "m"})


@attrs.frozen
class Wedge(rc.Surface):
    shape: Shape

    def heights(self, grid):
        return self.shape.height * (grid.x > 0.0) + 0.0 * grid.y


def test_a_part_that_is_a_field_has_a_type(monkeypatch):
    monkeypatch.setitem(rc.surfaces._classes, "wedge", Wedge)
    monkeypatch.setitem(parts._classes, "box", Box)
    monkeypatch.setitem(parts._classes, "other", rc.Elastic)
    surface = {"type": "wedge", "shape": {"type": "box", "height": "2um"}}
    table = {"body": {"surface": surface, "material": "glass"}, "grid": {"shape": [8, 8], "size": "100um"}}
    assert build_problem(table).body.surface == Wedge(Box(2e-6))
    surface["shape"] = Box(3e-6)
    assert build_problem(table).body.surface == Wedge(Box(3e-6))
    for shape, words in (
        ({"type": "other"}, "A Shape must be the registered name of one, but got 'other'"),
        ({"type": "bax"}, "There is no part named 'bax'. Did you mean 'box'?"),
        ({"type": "box"}, "required field 'height' is missing"),
    ):
        surface["shape"] = shape
        with pytest.raises(rc.InputError, match=re.escape(words)):
            build_problem(table)
