"""The study: problems, loads, seeds and estimators, all with all."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from pathlib import Path
from typing import Any

import attrs

from roughcontact.body import Body
from roughcontact.checks import integer, number
from roughcontact.description import key_of
from roughcontact.errors import InputError, RoughContactError, StudyStopped
from roughcontact.problem import ContactProblem
from roughcontact.registry import areas as estimators
from roughcontact.solution import DEFAULT_AREA, EstimatesArea
from roughcontact.studies.chain import Chain, run_chain
from roughcontact.studies.index import read_index, write_index
from roughcontact.studies.record import Record, StudyResult
from roughcontact.surfaces import Surface
from roughcontact.surfaces.sum import SurfaceSum

# Convolutions of a solve on its own grid, as measured on rough surfaces over two decades of load, warm starts included.
_WORK = 45
# A chain whose worker died is given to another as often.
_TRIES = 3


def _problems(value: object) -> dict[str, ContactProblem]:
    if isinstance(value, ContactProblem):
        value = {"problem": value}
    if not isinstance(value, Mapping) or not value:
        raise InputError.about("The problems of a study", value, "a ContactProblem, or a mapping of names to them")
    for name, problem in value.items():
        if not isinstance(name, str) or not isinstance(problem, ContactProblem):
            raise InputError.about(f"The problem {name!r} of a study", problem, "a ContactProblem under a name")
    return dict(value)


def _loads(value: object) -> tuple[float, ...]:
    if value is None:
        return ()
    items = value if isinstance(value, Iterable) and not isinstance(value, (str, bytes)) else [value]
    return tuple(number(item, "A load of the study", above=0.0) for item in items)


def _names(value: str | Sequence[str]) -> tuple[str, ...]:
    names = (value,) if isinstance(value, str) else tuple(value)
    for name in names:
        if not isinstance(name, str):
            raise InputError.about("An area estimator of a study", name, "a registered name")
        estimators.resolve(name, EstimatesArea)
    return names


def _seeds(value: Iterable[int]) -> tuple[int, ...]:
    return tuple(integer(seed, "A seed of the study", at_least=0) for seed in value)


@attrs.frozen(eq=False, kw_only=True)
class Study:
    """Every problem with every seed at every load, and every estimator's area of each.

    Parameters
    ----------
    problems
        A `ContactProblem`, or several by name.
    pressure, force, approach
        Exactly one list of loads: nominal mean pressures, Pa; normal forces, N; approaches, m. Each solve
        starts from those of the loads before.
    areas
        Names of area estimators.
    seeds
        Added to the seed of each random surface of each problem; without any the problems are as they are.

    Raises
    ------
    InputError
        If a part is not what it should be, there is not exactly one list of loads, a load cannot be
        carried, or seeds are given for a problem without random surfaces.
    """

    problems: Mapping[str, ContactProblem] = attrs.field(converter=_problems)
    pressure: tuple[float, ...] = attrs.field(default=None, converter=_loads)
    force: tuple[float, ...] = attrs.field(default=None, converter=_loads)
    approach: tuple[float, ...] = attrs.field(default=None, converter=_loads)
    areas: tuple[str, ...] = attrs.field(default=(DEFAULT_AREA,), converter=_names)
    seeds: tuple[int, ...] = attrs.field(default=(), converter=_seeds)

    def __attrs_post_init__(self) -> None:
        given = [name for name in ("pressure", "force", "approach") if getattr(self, name)]
        if len(given) != 1:
            raise InputError(
                "Give a study exactly one list of loads that is not empty: pressure=, force= or approach=."
            )
        for name, problem in self.problems.items():
            if self.seeds and not _random(problem):
                raise InputError(f"Seeds are given, but no surface of the problem {name!r} has one: leave seeds= out.")
            for load in self.loads:
                _require(name, problem, self.control, load)

    @property
    def control(self) -> str:
        """Which load is given."""
        return next(name for name in ("pressure", "force", "approach") if getattr(self, name))

    @property
    def loads(self) -> tuple[float, ...]:
        """The loads, Pa, N or m."""
        return tuple(getattr(self, self.control))

    def chains(self, folder: Path = Path()) -> Iterator[Chain]:
        """Yield each problem with each seed, at all loads."""
        for name, problem in self.problems.items():
            for seed in self.seeds or (None,):
                seeded = problem if seed is None else _seeded(problem, seed)
                yield Chain(
                    name=name,
                    seed=seed,
                    problem=seeded,
                    control=self.control,
                    loads=self.loads,
                    areas=self.areas,
                    folder=folder,
                )

    def explain(self) -> str:
        """Return every plan in words, and what all of it takes."""
        plans = [f"{name}:\n{problem.explain()}" for name, problem in self.problems.items()]
        count = len(self.problems) * max(1, len(self.seeds)) * len(self.loads)
        memory = max(problem.plan.memory for problem in self.problems.values())
        cells = sum(problem.plan.grid.cells for problem in self.problems.values()) * count // len(self.problems)
        total = (
            f"{count} solves ({len(self.problems)} problems, {max(1, len(self.seeds))} seeds, {len(self.loads)} loads "
            f"of {self.control}), {cells / 1e6:.3g} million cells in all, some {_WORK} convolutions of each, "
            f"at most {memory / 2**20:.3g} MiB for one"
        )
        return "\n\n".join([*plans, total])

    def run(
        self,
        folder: str | Path,
        *,
        executor: Executor | None = None,
        on_records: Callable[[Sequence[Record]], None] | None = None,
    ) -> StudyResult:
        """Solve what is not in the folder yet.

        Parameters
        ----------
        folder
            Where the solutions go, one npz file each, with one index of the study; made if it is missing.
            Workers on other machines must see the same folder.
        executor
            Any `concurrent.futures.Executor`, such as a process pool or that of a dask client, which gets one
            task for each problem and seed; in this process if left out.
        on_records
            Called with the records of each problem and seed as they come in.

        Returns
        -------
        StudyResult
            The records in the order of the study.

        Raises
        ------
        StudyStopped
            If the disk is full or the executor broke; what was solved is safe, and run again the study goes on.
        """
        target = Path(folder)
        target.mkdir(parents=True, exist_ok=True)
        index = target / f"study-{self.key}.json"
        known = read_index(index)
        chains = [attrs.evolve(chain, folder=target, known=_of(chain, known)) for chain in self.chains()]
        done: dict[int, list[Record]] = {}
        computed = 0
        try:
            for number_, (records, new) in _results(chains, executor):
                done[number_], computed = records, computed + new
                write_index(index, _in_order(done, known))
                if on_records is not None:
                    on_records(records)
        except OSError as error:
            reason = f"The folder {target} cannot be written to ({error.strerror or error})"
            raise _stopped(reason, done, chains) from error
        except BrokenExecutor as error:
            raise _stopped(f"The executor broke ({error})", done, chains) from error
        return StudyResult(folder=target, records=tuple(_in_order(done, {})), computed=computed)

    @property
    def key(self) -> str:
        """A name for the study, made from its content."""
        parts = {name: problem.parts for name, problem in self.problems.items()}
        return key_of([parts, self.control, self.loads, self.seeds])[:12]


def _of(chain: Chain, known: Mapping[str, Record]) -> dict[str, Record]:
    """Return what is known of a chain: workers need no more."""
    return {key: known[key] for key in set(chain.keys()) & set(known)} if known else {}


def _results(chains: Sequence[Chain], executor: Executor | None) -> Iterator[tuple[int, tuple[list[Record], int]]]:
    """Yield the number of each chain with what came out, as it comes in."""
    if executor is None:
        for number_, chain in enumerate(chains):
            yield number_, run_chain(chain)
        return
    waiting: dict[Future[Any], tuple[int, int]] = {
        executor.submit(run_chain, chain): (number_, 1) for number_, chain in enumerate(chains)
    }
    while waiting:
        for future in as_completed(list(waiting)):
            number_, tries = waiting.pop(future)
            error = _error(future)
            if error is None:
                yield number_, future.result()
            elif isinstance(error, (RoughContactError, BrokenExecutor)) or tries == _TRIES or _is_disk(error):
                raise error
            else:
                # A worker died: what it had finished is on disk, and another goes on.
                waiting[executor.submit(run_chain, chains[number_])] = number_, tries + 1


def _error(future: Future[Any]) -> BaseException | None:
    try:
        return future.exception()
    except CancelledError:
        return BrokenExecutor("it cancelled a task")


def _is_disk(error: BaseException) -> bool:
    return isinstance(error, OSError) and not isinstance(error, ConnectionError)


def _in_order(done: Mapping[int, list[Record]], known: Mapping[str, Record]) -> list[Record]:
    found = [record for number_ in sorted(done) for record in done[number_]]
    keys = {record.key for record in found}
    return found + [record for key, record in known.items() if key not in keys]


def _stopped(reason: str, done: Mapping[int, list[Record]], chains: Sequence[Chain]) -> StudyStopped:
    count = sum(len(records) for records in done.values())
    total = sum(len(chain.loads) for chain in chains)
    return StudyStopped(
        f"{reason}: {count} of {total} solves are reported, and every one that was finished is safe. "
        "Mend that and run the study again: it goes on where it stopped."
    )


def _require(name: str, problem: ContactProblem, control: str, load: float) -> None:
    try:
        problem.require_load(**{control: load})
    except InputError as error:
        raise InputError(f"Problem {name!r}: {error}") from error


def _random(problem: ContactProblem) -> bool:
    return any(_is_random(body.surface) for body in (problem.body, problem.counter))


def _is_random(surface: Surface) -> bool:
    if isinstance(surface, SurfaceSum):
        return any(map(_is_random, surface.parts))
    return attrs.has(type(surface)) and hasattr(surface, "seed")


def _seeded(problem: ContactProblem, seed: int) -> ContactProblem:
    body, counter = (Body(_with_seed(side.surface, seed), side.material) for side in (problem.body, problem.counter))
    return attrs.evolve(problem, body=body, counter=counter)


def _with_seed(surface: Any, seed: int) -> Any:
    if isinstance(surface, SurfaceSum):
        return SurfaceSum(tuple(_with_seed(part, seed) for part in surface.parts))
    return attrs.evolve(surface, seed=surface.seed + seed) if _is_random(surface) else surface
