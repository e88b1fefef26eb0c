"""The loads of one problem, solved one after another by one worker, and failures in words."""

from __future__ import annotations

import contextlib
import copy
import traceback
from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import attrs

from roughcontact._base.archive.plain import key_of
from roughcontact._parts.grid import Load
from roughcontact._parts.kernels import InfluenceKernel
from roughcontact._parts.materials import Material
from roughcontact._parts.surfaces import Surface
from roughcontact._solve.convolvers import Convolver
from roughcontact._solve.problem import (
    Body,
    ContactProblem,
    FrictionalPath,
    follow,
    load_path,
    order_of_solving,
    predict_pressure,
    run_solve,
    save_path,
)
from roughcontact._solve.solution import (
    ContactSolution,
    Response,
    list_all_warnings,
    read_figures,
    solution_key,
    write,
)
from roughcontact._solve.solvers import Solver
from roughcontact._work.studies.answers import find_answers, has_answers
from roughcontact._work.studies.paths import Shearing, figures_of, list_figures
from roughcontact._work.studies.record import Record, read_solution, solution_path
from roughcontact.errors import InputError, NotConverged, NotWritten, RoughContactError

_KINDS = {Surface: "surface", Material: "material", InfluenceKernel: "kernel", Convolver: "convolver", Solver: "solver"}
# Most characters of an exception that a record repeats.
_MAX_REASON_CHARACTERS = 300


def name_full_disk(folder: Path, error: NotWritten) -> str:
    """Return in words why nothing can be written into a folder."""
    return f"The folder {folder} cannot be written to ({error.strerror})"


def name_exception(what: str, error: Exception) -> str:
    """Return in a sentence what failed, and by which exception."""
    reason = " ".join(traceback.format_exception_only(_met(error))[-1].split())
    return f"{what} failed ({reason[:_MAX_REASON_CHARACTERS]})."


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
    known
        Earlier records, by key.
    shearing
        Loads along the surface that follow each load; None without.
    responses
        What is asked of each contact.
    """

    problem: ContactProblem
    areas: tuple[str, ...]
    folder: Path
    known: Mapping[str, Record] = attrs.Factory(dict)
    shearing: Shearing | None = None
    responses: tuple[Response[Any], ...] = ()

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
        """Return the chain with a problem that has computed nothing yet, and so holds no fields in memory."""
        return attrs.evolve(self, problem=copy.copy(self.problem))

    @cached_property
    def seeded(self) -> ContactProblem:
        """Return the problem with its seed; a surface is first evaluated when its problem is made."""
        return self.problem if self.seed is None else attrs.evolve(self.problem, **self.bodies())

    def solution_keys(self) -> tuple[str, ...]:
        """Return the key of each load."""
        content = key_of({**self.problem.parts, **self.bodies()})
        if self.shearing is not None:
            content = key_of([content, *self.shearing.parts])
        return tuple(
            solution_key(content, load.arguments, earlier=self.earlier(index)) for index, load in enumerate(self.loads)
        )

    def earlier(self, index: int) -> tuple[Mapping[str, float], ...]:
        """Return the loads before one, where its state depends on those before."""
        follows = self.problem.remembers and self.shearing is None
        return tuple(load.arguments for load in self.loads[:index]) if follows else ()

    def listed(self, key: str, load: Load) -> Record | None:
        """Return the earlier record of a load, which another problem of the study may have made; None without one."""
        known = self.known.get(key)
        if known is None:
            return None
        place: dict[str, Any] = {"problem": self.name, "seed": self.seed, "parameters": self.parameters}
        return attrs.evolve(known, **place, control=load.kind, load=load.value)

    def is_answered(self, record: Record) -> bool:
        """Return whether a record has the areas and answers that are asked for."""
        return set(self.areas) <= set(record.areas) and has_answers(record.answers, self.responses)

    def path(self, key: str) -> Path:
        """Return the file of the solution with a key."""
        return self.folder / f"{key}.npz"

    def failed(self, message: str) -> ChainResult:
        """Return the records of a chain that could not be run at all."""
        return self.record_all(self.solution_keys(), "FAILED", message)


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
    """Return the records of a chain; each solution is written before anything is computed from it.

    The loads are solved from the largest down, those of surfaces that attract each other and paths with friction in
    their order. A failure at one load is in its record, and the others are solved. Only a solution that cannot be
    written ends the chain.
    """
    # A copy, whose problem goes with it.
    chain = attrs.evolve(chain)
    if chain.shearing is not None:
        return _follow_paths(chain, chain.shearing)
    records: dict[int, Record] = {}
    solutions: list[ContactSolution] = []
    computed = 0
    is_known = True
    keys = chain.solution_keys()
    for index in range(len(chain.loads)) if chain.problem.remembers else order_of_solving(chain.loads):
        key = keys[index]
        load = chain.loads[index]
        try:
            record, solution = _find(chain, key, load)
            if record is None:
                if chain.problem.processes and not is_known:
                    raise InputError("A law remembers the state at the load before it, which has no solution.")
                computed += 1
                solution = _solve(chain.seeded, load, solutions)
                # The list of records is flushed once for the chain, and with it the names of all its files.
                write(chain.path(key), solution, flush=False, earlier=chain.earlier(index))
                record = _measure(chain, chain.record(key, load), solution)
            elif solution is None and len(records) + 1 < len(chain.loads):
                solution = _load(chain, key)
        except NotWritten as error:
            return ChainResult(_in_order(records), computed - 1, name_full_disk(chain.folder, error))
        except Exception as error:
            record = chain.record(key, load, *status_of(error))
            solution = None
        records[index] = record
        is_known = solution is not None
        if solution is not None:
            solutions = [*solutions[-1:], solution]
    return ChainResult(_in_order(records), computed)


def _solve(problem: ContactProblem, load: Load, before: list[ContactSolution]) -> ContactSolution:
    """Return the solution at a load, from those before."""
    if problem.remembers:
        return follow(partial(run_solve, problem), before, load)
    return problem.solve(**load.arguments, start=predict_pressure(before, load))


def _follow_paths(chain: Chain, shearing: Shearing) -> ChainResult:
    """Return the records of a chain whose loads are followed by loads along the surface."""
    records: list[Record] = []
    computed = 0
    for key, load in zip(chain.solution_keys(), chain.loads, strict=True):
        try:
            record = _find_path(chain, shearing, key, load)
            if record is None:
                computed += 1
                path = shearing.follow(chain.seeded, load)
                save_path(chain.path(key), path, key)
                record = _measure_path(chain, chain.record(key, load), path)
        except NotWritten as error:
            return ChainResult(records, computed - 1, name_full_disk(chain.folder, error))
        except Exception as error:
            record = chain.record(key, load, *status_of(error))
        records.append(record)
    return ChainResult(records, computed)


def _find_path(chain: Chain, shearing: Shearing, key: str, load: Load) -> Record | None:
    """Return the record of a path on disk; None if there is no intact one."""
    known = chain.listed(key, load)
    try:
        path = load_path(solution_path(chain.folder, key), verify=False, key=key, law=shearing.friction)
        if known is None or not known.agrees_with(figures_of(path)):
            known = chain.record(key, load)
            shearing.verify(chain.seeded, load, path)
        elif chain.is_answered(known):
            return attrs.evolve(known, message="")
    # Damaged files fail in many ways: a path that cannot be read is followed again.
    except Exception:
        return None
    return _measure_path(chain, known, path)


def _measure_path(chain: Chain, record: Record, path: FrictionalPath) -> Record:
    """Return the record of a path, with the areas of the contact at its end that the given record lacks."""
    record = _measure(chain, record, path[-1])
    warnings = tuple(dict.fromkeys((*path.warnings, *record.warnings)))
    return attrs.evolve(
        record, **list_figures(path), warnings=warnings, doubtful=bool(path.warnings) or record.doubtful
    )


def _in_order(records: Mapping[int, Record]) -> list[Record]:
    """Return the records in the order of their loads."""
    return [records[index] for index in sorted(records)]


def _find(chain: Chain, key: str, load: Load) -> tuple[Record | None, ContactSolution | None]:
    """Return the record of a solution on disk, and the solution if it was read; None if there is no intact one."""
    known = chain.listed(key, load)
    try:
        figures = read_figures(solution_path(chain.folder, key), key)
        if known is None or not known.agrees_with(figures):
            known = chain.record(key, load)
        elif chain.is_answered(known):
            return attrs.evolve(known, message=""), None
        solution = read_solution(chain.folder, key)
        chain.seeded.verify(solution)
    # Damaged files fail in many ways: a solution that cannot be read is solved again.
    except Exception:
        return None, None
    return _measure(chain, known, solution), solution


def _load(chain: Chain, key: str) -> ContactSolution | None:
    try:
        return read_solution(chain.folder, key)
    except Exception:
        # Only a start for the next load.
        return None


def _measure(chain: Chain, record: Record, solution: ContactSolution) -> Record:
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
        areas=areas,
        answers=answers,
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
