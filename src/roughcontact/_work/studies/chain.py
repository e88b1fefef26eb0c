"""The loads of one problem, solved one after another by one worker, and failures in words."""

from __future__ import annotations

import contextlib
import copy
import traceback
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import attrs

from roughcontact._base.archive.plain import key_of
from roughcontact._parts.grid import Load
from roughcontact._parts.kernels import InfluenceKernel
from roughcontact._parts.materials import Material
from roughcontact._parts.surfaces import Surface
from roughcontact._solve.convolvers import Convolver
from roughcontact._solve.problem import Body, ContactProblem
from roughcontact._solve.solution import ContactSolution, list_all_warnings, solution_key
from roughcontact._solve.solvers import Solver
from roughcontact._work.studies.answers import Question, find_answers, has_answers
from roughcontact._work.studies.axes import MAX_REASON_CHARACTERS
from roughcontact._work.studies.lists import Journal, Known
from roughcontact._work.studies.loading import SINGLE_LOADS, Loading, list_law_numbers
from roughcontact._work.studies.record import Place, Record
from roughcontact.errors import InputError, NotConverged, NotWritten, RoughContactError

# The end of the name of a file in which a long path is kept until its record is written.
DRAFT = "-draft.npz"
_KINDS = {Surface: "surface", Material: "material", InfluenceKernel: "kernel", Convolver: "convolver", Solver: "solver"}


def name_full_disk(folder: Path, error: NotWritten) -> str:
    """Return in words why nothing can be written into a folder."""
    return f"The folder {folder} cannot be written to ({error.strerror})"


def name_exception(what: str, error: Exception) -> str:
    """Return in a sentence what failed, and by which exception."""
    reason = " ".join(traceback.format_exception_only(_met(error))[-1].split())
    return f"{what} failed ({reason[:MAX_REASON_CHARACTERS]})."


def _met(error: BaseException) -> BaseException:
    """Return the original exception if the public call of a worker has translated it."""
    return error.__cause__ if isinstance(error, RoughContactError) and error.__cause__ is not None else error


def status_of(error: Exception) -> tuple[str, str]:
    """Return the status and the message of a load without a solution."""
    if isinstance(error, NotConverged):
        return error.solution.status.name, error.reason
    if isinstance(error, InputError):
        return "REFUSED", str(error)
    # The innermost part of the problem in whose method it was raised.
    for frame, _ in reversed(list(traceback.walk_tb(_met(error).__traceback__))):
        owner = frame.f_locals.get("self")
        for base, kind in _KINDS.items():
            if isinstance(owner, base):
                return "FAILED", name_exception(f"The {kind} {type(owner).__name__}", error)
    return "FAILED", name_exception("The solve", error)


@attrs.frozen(eq=False, kw_only=True)
class Point:
    """One problem of a study, and its loads.

    Attributes
    ----------
    name, seed, parameters
        The name of the problem in the study, its seed, and the value on each axis.
    loads
        Its loads.
    """

    name: str
    seed: int | None = None
    parameters: Mapping[str, Any] = attrs.Factory(dict)
    loads: tuple[Load, ...]

    def find_place(self, load: Load) -> Place:
        """Return the place of the record of a load in its study."""
        return self.name, self.seed, load.kind, load.value

    def record(self, key: str, load: Load, status: str = "FAILED", message: str = "") -> Record:
        """Return the record of a load that has no solution."""
        return Record(
            problem=self.name,
            seed=self.seed,
            parameters=self.parameters,
            control=load.kind,
            load=load.value,
            key=key,
            status=status,
            message=message,
        )

    def record_all(self, keys: Sequence[str], status: str, message: str) -> ChainResult:
        """Return the same record for all loads, whose keys are given."""
        return ChainResult([self.record(*each, status, message) for each in zip(keys, self.loads, strict=True)])


@attrs.frozen(eq=False, kw_only=True)
class Unbuilt(Point):
    """A problem that could not be built.

    Attributes
    ----------
    message
        Why not, in a sentence.
    """

    message: str

    def refused(self) -> ChainResult:
        """Return its records, whose keys are made from the name and the load, since no problem was built."""
        keys = [key_of([self.name, load.arguments]) for load in self.loads]
        return self.record_all(keys, "REFUSED", self.message)


@attrs.frozen(eq=False, kw_only=True)
class Chain(Point):
    """One problem at all loads of a study, each solve starting from those before.

    Attributes
    ----------
    problem
        The problem, before it is given the seed.
    areas
        Area estimators.
    folder
        The folder of the solutions, on a disk that every worker sees.
    journal
        Where its records are written.
    known
        Earlier records.
    loading
        What is found at each load.
    responses
        What is asked of each contact.
    fields
        Whether each solution is kept in a file.
    """

    problem: ContactProblem
    areas: tuple[str, ...]
    folder: Path
    journal: Journal
    known: Known = attrs.Factory(Known)
    loading: Loading = SINGLE_LOADS
    responses: tuple[Question, ...] = ()
    fields: bool = False

    def bodies(self) -> dict[str, Any]:
        """Return the bodies with the seed added to the seeds of their surfaces."""
        bodies = {"body": self.problem.body, "counterbody": self.problem.counterbody}
        if self.seed is None:
            return bodies
        try:
            return {
                name: Body(one.surface.reseed(self.seed) or one.surface, one.material) for name, one in bodies.items()
            }
        except Exception as error:
            what = f"The problem {self.name!r} cannot be given the seed {self.seed}"
            raise InputError(f"{what}: {error!r:.200}.") from error

    def alone(self) -> Chain:
        """Return the chain for a worker: its problem holds no fields in memory, and of all records it has its own."""
        records = self.known.records
        # The keys take a while, and a new study needs none of them.
        known = Known({key: records[key] for key in self.keys if key in records} if records else {})
        return attrs.evolve(self, problem=copy.copy(self.problem), known=known)

    @cached_property
    def seeded(self) -> ContactProblem:
        """Return the problem with its seed; a surface is first evaluated when its problem is made."""
        return self.problem if self.seed is None else attrs.evolve(self.problem, **self.bodies())

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """The key of each load."""
        places = list(map(self.find_place, self.loads))
        found = [self.known.keys[place] for place in places if place in self.known.keys]
        # Where a load comes back, its place does not tell which of the states is meant.
        return tuple(found) if len(found) == len(set(places)) == len(places) else self.solution_keys()

    def solution_keys(self) -> tuple[str, ...]:
        """Return the key of each load, computed from its content."""
        content = key_of({**self.problem.parts, **self.bodies()})
        if self.loading.parts:
            content = key_of([content, *self.loading.parts])
        chosen = self.problem.chosen
        return tuple(
            solution_key(content, load.arguments, earlier=self.earlier(index), chosen=chosen)
            for index, load in enumerate(self.loads)
        )

    def earlier(self, index: int) -> list[Mapping[str, float]]:
        """Return the loads before one, where its state depends on those before."""
        return [load.arguments for load in self.loads[:index]] if self.loading.follows(self.problem) else []

    def listed(self, key: str, load: Load) -> Record | None:
        """Return the earlier record of a load, which another problem or study may have made; None without one.

        One whose uncertainties were found from something else is none.
        """
        known = self.known.records.get(key)
        if known is None or known.uncertainty != self.loading.uncertainty:
            return None
        place = self.find_place(load)
        # Making a record takes a while, and a run that goes on meets thousands of its own.
        if known.place == place and known.parameters == self.parameters:
            return known
        problem, seed, control, value = place
        return attrs.evolve(known, problem=problem, seed=seed, control=control, load=value, parameters=self.parameters)

    def is_answered(self, record: Record) -> bool:
        """Return whether a record has the areas and answers that are asked for."""
        return set(self.areas) <= set(record.areas) and has_answers(record.answers, self.responses)

    def list_complete(self) -> dict[int, Record]:
        """Return the records by load that need no solution: all that is asked is in them, and no file is."""
        if self.fields or not self.known.records:
            return {}
        found = {}
        for index, (key, load) in enumerate(zip(self.keys, self.loads, strict=True)):
            record = self.listed(key, load)
            if record is not None and record.has_solution and self.is_answered(record):
                found[index] = attrs.evolve(record, message="") if record.message else record
        return found

    def find_listed(self) -> ChainResult | None:
        """Return its records if none of them needs a solution."""
        found = self.list_complete()
        return ChainResult(_in_order(found)) if len(found) == len(self.loads) else None

    def path(self, key: str) -> Path:
        """Return the file of the solution with a key."""
        return self.folder / f"{key}.npz"

    def find_draft(self, key: str) -> Path | None:
        """Return the file of what is found under a key while that is unfinished; None where it does not take long."""
        return self.folder / f"{key}{DRAFT}" if self.loading.has_draft else None

    def failed(self, message: str) -> ChainResult:
        """Return the records of a chain that could not be run at all."""
        return self.record_all(self.keys, "FAILED", message)


@attrs.frozen(eq=False)
class ChainResult:
    """The results of a chain.

    Attributes
    ----------
    records
        In the order of the loads; none for loads that were not reached.
    computed
        How many were solved now.
    stopped, lost
        Why its solutions could not be written; why no worker has returned its records. Empty if all went well.
    """

    records: list[Record]
    computed: int = 0
    stopped: str = ""
    lost: str = ""


def run_chain(chain: Chain) -> ChainResult:
    """Return the records of a chain; a solution that is kept is written before anything is computed from it.

    The loads are solved in the order that their kind asks for. A failure at one load is in its record, and the others
    are solved. Only what cannot be written ends the chain.
    """
    listed = chain.find_listed()
    if listed is not None:
        return listed
    records = chain.list_complete()
    order = chain.loading.order(chain.problem, chain.loads)
    last = max(place for place, index in enumerate(order) if index not in records)
    states: list[ContactSolution] = []
    computed = 0
    is_known = True
    for place, index in enumerate(order[: last + 1]):
        if index in records and not chain.loading.goes_on:
            continue
        key = chain.keys[index]
        load = chain.loads[index]
        state: ContactSolution | None = None
        is_new = False
        draft = chain.find_draft(key)
        try:
            record, state = _find(chain, key, load)
            if record is None:
                if chain.problem.processes and chain.loading.goes_on and not is_known:
                    raise InputError("A law remembers the state at the load before it, which has no solution.")
                is_new = True
                found = chain.loading.solve(chain.seeded, load, states, draft)
                if chain.fields:
                    chain.loading.write(chain.path(key), found, key, chain.earlier(index))
                record, state = _measure(chain, _find_base(chain, key, load, found), found)
            elif state is None and place < last:
                state = _load(chain, key)
            if index not in records and record != chain.known.records.get(key):
                chain.journal.append(record)
        except NotWritten as error:
            return ChainResult(_in_order(records), computed, name_full_disk(chain.folder, error))
        except Exception as error:
            record = chain.record(key, load, *status_of(error))
            state = None
        if draft is not None:
            remove_draft(draft)
        # One that is solved again only for those after it has its record.
        records.setdefault(index, record)
        computed += is_new
        is_known = state is not None
        if state is not None:
            states = [*states[-1:], state]
    return ChainResult(_in_order(records), computed)


def remove_draft(file: Path) -> None:
    """Remove a file in which a path was kept while it was unfinished, if it is there."""
    with contextlib.suppress(OSError):
        file.unlink()


def solve_again(chain: Chain, wanted: str) -> dict[str, Any]:
    """Return states or errors by key: the wanted one, with the bits that it had, and those solved with it."""
    states: list[ContactSolution] = []
    found: dict[str, Any] = {}
    for index in chain.loading.order(chain.problem, chain.loads):
        key = chain.keys[index]
        if key != wanted and not chain.loading.goes_on:
            continue
        try:
            found[key] = chain.loading.solve(chain.seeded, chain.loads[index], states)
        except RoughContactError as error:
            found[key] = error
        else:
            states = [*states[-1:], chain.loading.end_of(found[key])]
    return found


def _in_order(records: Mapping[int, Record]) -> list[Record]:
    """Return the records in the order of their loads."""
    return [records[index] for index in sorted(records)]


def _find(chain: Chain, key: str, load: Load) -> tuple[Record | None, ContactSolution | None]:
    """Return the record of what is on disk, and its last state if it was read; None if it is missing or damaged."""
    known = chain.listed(key, load)
    try:
        figures = chain.loading.read_figures(chain.folder, key)
        if known is None or not known.agrees_with(figures):
            known = chain.record(key, load)
        elif chain.is_answered(known):
            return attrs.evolve(known, message=""), None
        found = chain.loading.read(chain.folder, key)
        chain.loading.verify(chain.seeded, load, found)
    # Damaged files fail in many ways: what cannot be read is solved again.
    except Exception:
        return None, None
    return _measure(chain, known, found)


def _find_base(chain: Chain, key: str, load: Load, found: Any) -> Record:
    """Return the earlier record of what was solved again, whose areas and answers stay, or else an empty one."""
    known = chain.listed(key, load)
    state = chain.loading.end_of(found)
    figures = (state.approach, state.mean_pressure, float(state.pressure.max()))
    is_same = known is not None and (known.approach, known.mean_pressure, known.p_max) == figures
    return known if known is not None and is_same else chain.record(key, load)


def _load(chain: Chain, key: str) -> ContactSolution | None:
    try:
        return chain.loading.end_of(chain.loading.read(chain.folder, key))
    except Exception:
        # Only a start for the next load.
        return None


def _measure(chain: Chain, record: Record, found: Any) -> tuple[Record, ContactSolution]:
    """Return the record of what was found, with the areas and answers that the given record lacks, and its state."""
    state = chain.loading.end_of(found)
    record = _measure_state(chain, record, state)
    own = chain.loading.list_warnings(found)
    warnings = tuple(dict.fromkeys((*own, *record.warnings)))
    figures = chain.loading.list_figures(found)
    return attrs.evolve(record, **figures, warnings=warnings, doubtful=bool(own) or record.doubtful), state


def _measure_state(chain: Chain, record: Record, solution: ContactSolution) -> Record:
    """Return the record of a solution, with the areas and answers that the given record lacks."""
    areas = dict(record.areas)
    failures = []
    for name in chain.areas:
        if name not in areas:
            try:
                area = solution.area(name)
                areas[name] = float(area.value), float(area.uncertainty)
            except Exception as error:
                failures.append(name_exception(f"The area estimator {name!r}", error))
    answers, errors, said = find_answers(solution, chain.responses, record.answers)
    # Known values are not estimated again.
    judged: dict[str, Any] = (
        {"doubtful": record.doubtful, "warnings": record.warnings} if record.success else _judge(solution)
    )
    judged["doubtful"] = bool(judged.get("doubtful") or said)
    judged["warnings"] = tuple(dict.fromkeys((*judged["warnings"], *said)))
    failures += [name_exception(f"The response {name!r}", error) for name, error in errors.items()]
    return attrs.evolve(
        record,
        status=solution.status.name,
        message=" ".join(failures),
        force=solution.force,
        mean_pressure=solution.mean_pressure,
        approach=solution.approach,
        p_max=solution.pressure.max(),
        saturated=solution.saturated_area().value,
        numbers=list_law_numbers(solution),
        areas=areas,
        answers=answers,
        uncertainty=chain.loading.uncertainty,
        iterations=solution.iterations,
        convolutions=solution.convolutions,
        seconds=solution.seconds,
        **judged,
    )


def _judge(solution: ContactSolution) -> dict[str, Any]:
    """Return the maximum pressure and the warnings, as fields of a record; without what fails."""
    found: dict[str, Any] = {}
    known = {}
    # Estimators and parts of the problem are plug-ins.
    with contextlib.suppress(Exception):
        found["doubtful"] = bool(solution.warnings)
    with contextlib.suppress(Exception):
        known["maximum pressure"] = peak = solution.peak_pressure()
        found |= {"peak_pressure": peak.value, "peak_pressure_uncertainty": peak.uncertainty}
    return {**found, "warnings": list_all_warnings(solution, known)}
