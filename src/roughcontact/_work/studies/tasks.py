"""Chains as tasks of an executor, whose workers may die."""

from __future__ import annotations

import pickle
from collections.abc import Generator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, as_completed

from roughcontact._base.machine import share_machine
from roughcontact._work.studies.chain import Chain, ChainResult, Unbuilt, run_chain
from roughcontact._work.studies.failures import name_exception
from roughcontact.errors import RoughContactError

# Workers that a chain is given to, one after the other, if they die.
_TRIES = 3
# What pickling raises: no other worker would do better.
_NOT_SENT = (pickle.PicklingError, AttributeError, TypeError, MemoryError)


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
                    # Nothing can be written any more: what has not begun is not begun.
                    waiting = {future: place for future, place in waiting.items() if not future.cancel()}
                    break
    finally:
        for future in waiting:
            future.cancel()


def _run(chain: Chain | Unbuilt) -> ChainResult:
    return chain.refused() if isinstance(chain, Unbuilt) else run_chain(chain)


def _run_beside_others(chain: Chain) -> ChainResult:
    with share_machine():
        return run_chain(chain)


def _result(
    future: Future[ChainResult], chains: Sequence[Chain | Unbuilt], position: int, tries: int
) -> ChainResult | None:
    """Return the result of a task, or None if another worker is to try it."""
    error = BrokenExecutor("it cancelled a task") if future.cancelled() else future.exception()
    if error is None:
        return future.result()
    if not isinstance(error, Exception):
        # A worker was interrupted from the keyboard, or exits.
        raise error
    if tries < _TRIES and not isinstance(error, (BrokenExecutor, RoughContactError, *_NOT_SENT)):
        # A worker died: its finished solutions are on disk, and another one does the rest.
        return None
    return _explain_loss(chains[position], error)


def _explain_loss(chain: Chain | Unbuilt, error: Exception) -> ChainResult:
    """Return the result of a chain that no worker has returned."""
    if isinstance(chain, Unbuilt):
        return chain.refused()
    if isinstance(error, (RoughContactError, *_NOT_SENT)):
        return chain.failed(name_exception("Sending the problem to a worker", error))
    if isinstance(error, RuntimeError):
        return ChainResult([], lost=f"The executor broke ({error})")
    workers = f"Every worker that the problem {chain.name!r} was given to"
    return ChainResult([], lost=name_exception(workers, error).rstrip("."))
