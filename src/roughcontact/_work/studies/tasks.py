"""All chains of a study as tasks of an executor, whose workers may die; each chain is made when it is needed."""

from __future__ import annotations

import pickle
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, as_completed
from pathlib import Path
from typing import Any

import attrs

from roughcontact._base.machine import share_machine
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import ContactProblem
from roughcontact._work.studies.answers import Question
from roughcontact._work.studies.axes import BuiltProblems
from roughcontact._work.studies.chain import Chain, ChainResult, Unbuilt, name_exception, run_chain
from roughcontact._work.studies.lists import Journal, Known
from roughcontact._work.studies.loading import SINGLE_LOADS, Loading
from roughcontact._work.studies.record import Record
from roughcontact._work.studies.shares import Share
from roughcontact.errors import InputError, RoughContactError
from roughcontact.errors.warning import saying_warnings

# Most workers that are given a chain, one after the other, if they die.
_MAX_TRIES = 3
# Errors of pickling: no other worker would do better.
_PICKLING_ERRORS = (pickle.PicklingError, AttributeError, TypeError, MemoryError)


@attrs.frozen(eq=False)
class Chains(Sequence[Chain | Unbuilt]):
    """The chains of a study: a problem of a function is built each time that its chain is taken, and not kept.

    Attributes
    ----------
    problems, seeds, loads, areas
        The ones of the study.
    folder
        The folder of its solutions.
    journal
        Where its records are written.
    known
        Earlier records.
    share
        Which of n shares they are; None for all.
    loading
        What the study finds at each load.
    responses
        What the study asks of each contact.
    fields
        Whether it keeps each solution in a file.
    """

    problems: Mapping[str, ContactProblem]
    seeds: tuple[int, ...]
    loads: tuple[Load, ...]
    areas: tuple[str, ...]
    folder: Path
    journal: Journal
    known: Known
    share: Share | None
    loading: Loading = SINGLE_LOADS
    responses: tuple[Question, ...] = ()
    fields: bool = False
    _places: list[tuple[str, int | None]] = attrs.field(init=False)

    @_places.default
    def _list_places(self) -> list[tuple[str, int | None]]:
        places = [(name, seed) for name in self.problems for seed in self.seeds or (None,)]
        return places if self.share is None else self.share.pick(places)

    def __len__(self) -> int:
        return len(self._places)

    def __getitem__(self, position: Any) -> Any:
        name, seed = self._places[position]
        parameters = self.problems.parameters(name) if isinstance(self.problems, BuiltProblems) else {}
        place: dict[str, Any] = {"name": name, "seed": seed, "parameters": parameters, "loads": self.loads}
        try:
            problem = self.problems[name]
        except InputError as error:
            return Unbuilt(**place, message=str(error))
        files: dict[str, Any] = {"folder": self.folder, "journal": self.journal, "known": self.known}
        asked: dict[str, Any] = {"areas": self.areas, "responses": self.responses, "loading": self.loading}
        return Chain(**place, problem=problem, **files, **asked, fields=self.fields)

    def find(self, record: Record) -> Chain:
        """Return the chain of a record; `InputError` if the study has none, or it has become another one."""
        place = (record.problem, record.seed)
        chain = self[self._places.index(place)] if place in self._places else None
        if not isinstance(chain, Chain) or record.key not in chain.keys:
            raise InputError("The study does not have this record.")
        return chain


def run_chains(
    chains: Sequence[Chain | Unbuilt], executor: Executor | None
) -> Generator[tuple[int, ChainResult], None, None]:
    """Yield the position of each chain and its results, in the order in which they are finished.

    A chain is taken from the sequence, which may build its problem then, when it is run or submitted.
    """
    if executor is None:
        yield from enumerate(map(_run, chains))
        return
    todo = [(position, 1) for position in range(len(chains))]
    waiting: dict[Future[ChainResult], tuple[int, int]] = {}
    try:
        while todo or waiting:
            for position, tries in todo:
                chain = chains[position]
                if isinstance(chain, Unbuilt):
                    yield position, chain.refused()
                    continue
                listed = chain.find_listed()
                if listed is not None:
                    yield position, listed
                    continue
                try:
                    waiting[executor.submit(_run_beside_others, chain.alone())] = position, tries
                except Exception as error:
                    yield position, _explain_loss(chain, error)
            todo = []
            for future in as_completed(list(waiting)):
                position, tries = waiting.pop(future)
                result = _result(future, chains, position, tries)
                if result is None:
                    todo.append((position, tries + 1))
                    break
                yield position, result
                if result.stopped:
                    # Nothing can be written any more, so no further task is begun.
                    waiting = {future: place for future, place in waiting.items() if not future.cancel()}
                    break
    finally:
        for future in waiting:
            future.cancel()


def _run(chain: Chain | Unbuilt) -> ChainResult:
    return chain.refused() if isinstance(chain, Unbuilt) else run_chain(chain)


def _run_beside_others(chain: Chain) -> ChainResult:
    with share_machine(), saying_warnings():
        return run_chain(chain)


def _result(
    future: Future[ChainResult], chains: Sequence[Chain | Unbuilt], position: int, tries: int
) -> ChainResult | None:
    """Return the result of a task, or None if another worker should try it."""
    error = BrokenExecutor("it cancelled a task") if future.cancelled() else future.exception()
    if error is None:
        return future.result()
    if not isinstance(error, Exception):
        # A worker was interrupted from the keyboard, or exits.
        raise error
    if tries < _MAX_TRIES and not isinstance(error, (BrokenExecutor, RoughContactError, *_PICKLING_ERRORS)):
        # A worker died: its finished solutions are on disk, and another one does the rest.
        return None
    return _explain_loss(chains[position], error)


def _explain_loss(chain: Chain | Unbuilt, error: Exception) -> ChainResult:
    """Return the result of a chain that no worker has returned."""
    if isinstance(chain, Unbuilt):
        return chain.refused()
    if isinstance(error, (RoughContactError, *_PICKLING_ERRORS)):
        return chain.failed(name_exception("Sending the problem to a worker", error))
    if isinstance(error, RuntimeError):
        return ChainResult([], lost=f"The executor broke ({error})")
    workers = f"Every worker that the problem {chain.name!r} was given to"
    return ChainResult([], lost=name_exception(workers, error).rstrip("."))
