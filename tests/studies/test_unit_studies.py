"""The chains of a study, and the warnings of its table."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor

import attrs

from roughcontact._faces.cli.run import list_warnings
from roughcontact._work.studies.chain import run_chain
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
