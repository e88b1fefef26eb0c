"""The loads of one problem in a row: what one worker does without asking back."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from roughcontact.archive import read_header
from roughcontact.description import key_of
from roughcontact.errors import InputError, NotConverged
from roughcontact.problem import ContactProblem
from roughcontact.solution import ContactSolution
from roughcontact.solution.storage import versions
from roughcontact.studies.record import Record
from roughcontact.sweep import predicted


@attrs.frozen(eq=False, kw_only=True)
class Chain:
    """One problem at all loads of a study, each solve starting from those before.

    Attributes
    ----------
    name, seed
        Which problem of the study.
    problem
        The problem itself.
    control, loads
        Which load is given, and its values.
    areas
        Estimators.
    folder
        Where the solutions lie, on a disk that every worker sees.
    known
        Records from before, by key.
    """

    name: str
    seed: int | None
    problem: ContactProblem
    control: str
    loads: tuple[float, ...]
    areas: tuple[str, ...]
    folder: Path
    known: Mapping[str, Record] = attrs.Factory(dict)

    def keys(self) -> tuple[str, ...]:
        """Return the key of each load."""
        content = key_of(self.problem.parts)
        made_by = [f"{name} {number}" for name, number in versions().items() if name != "python"]
        return tuple(key_of([content, self.control, load], *made_by) for load in self.loads)


def run_chain(chain: Chain) -> tuple[list[Record], int]:
    """Return the records of a chain, and how many were solved now; every solution is on disk before its record is made.

    Raises
    ------
    OSError
        If the disk is full or cannot be written to.
    """
    records: list[Record] = []
    solutions: list[ContactSolution] = []
    computed = 0
    for key, load in zip(chain.keys(), chain.loads, strict=True):
        record = _found(chain, key, load)
        if record is None:
            record, solution = _solved(chain, key, load, solutions)
            computed += 1
        else:
            solution = None
        records.append(record)
        if solution is None and record.success and len(records) < len(chain.loads):
            solution = _loaded(chain, key)
        if solution is not None:
            solutions = [*solutions[-1:], solution]
    return records, computed


def _found(chain: Chain, key: str, load: float) -> Record | None:
    """Return the record of a solution that is on disk; None if there is none that is whole."""
    path = chain.folder / f"{key}.npz"
    if not path.is_file():
        return None
    known = chain.known.get(key)
    if known is not None and set(chain.areas) <= set(known.areas):
        try:
            read_header(path)
        except InputError:
            return None
        return attrs.evolve(known, problem=chain.name, seed=chain.seed)
    solution = _loaded(chain, key)
    return None if solution is None else _record(chain, key, load, solution)


def _loaded(chain: Chain, key: str) -> ContactSolution | None:
    try:
        return ContactSolution.load(chain.folder / f"{key}.npz")
    except InputError:
        # Half a file, from a machine that died: solved again.
        return None


def _solved(
    chain: Chain, key: str, load: float, before: list[ContactSolution]
) -> tuple[Record, ContactSolution | None]:
    empty = Record(problem=chain.name, seed=chain.seed, control=chain.control, load=load, key=key, status="REFUSED")
    start = predicted(before, chain.control, load)
    given: dict[str, Any] = {chain.control: load}
    try:
        solution = chain.problem.solve(**given, start=start)
        record = _record(chain, key, load, solution)
    except NotConverged as error:
        return attrs.evolve(empty, status=error.solution.status.name, message=str(error)), None
    except InputError as error:
        return attrs.evolve(empty, message=str(error)), None
    solution.save(chain.folder / f"{key}.npz")
    return record, solution


def _record(chain: Chain, key: str, load: float, solution: ContactSolution) -> Record:
    areas = {name: solution.area(name) for name in chain.areas}
    return Record(
        problem=chain.name,
        seed=chain.seed,
        control=chain.control,
        load=load,
        key=key,
        status=solution.status.name,
        force=solution.force,
        mean_pressure=solution.mean_pressure,
        approach=solution.approach,
        p_max=float(solution.pressure.max()),
        saturated=solution.saturated_area().value,
        areas={name: (area.value, area.uncertainty) for name, area in areas.items()},
        iterations=solution.iterations,
        convolutions=solution.convolutions,
        seconds=solution.seconds,
    )
