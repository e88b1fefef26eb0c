"""Studies: every problem with every seed at every load, and the plan in words."""

from __future__ import annotations

import contextlib
import logging
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import attrs

from roughcontact._base import checks
from roughcontact._base.archive import remove_stale
from roughcontact._base.archive.plain import key_of
from roughcontact._base.arrays import Pair
from roughcontact._base.checks import callback, choice, flag, integer
from roughcontact._base.machine.progress import count_done, show_progress, tell_both
from roughcontact._base.units import Force, Length, PlainText, Pressure, binary, counted
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import FrictionLaw
from roughcontact._solve.problem import PATH_ACCURACY, ContactProblem
from roughcontact._solve.solution import DEFAULT_AREA, UNCERTAINTIES, CoupledProcess, Response, areas, solution_key
from roughcontact._work.studies.answers import Question, read_responses
from roughcontact._work.studies.axes import BuiltProblems
from roughcontact._work.studies.chain import DRAFT, Chain, Unbuilt, name_full_disk, remove_draft
from roughcontact._work.studies.lists import Known, RecordList
from roughcontact._work.studies.loading import Loading
from roughcontact._work.studies.paths import read_loading
from roughcontact._work.studies.record import Record
from roughcontact._work.studies.result import SolvedAgain, StudyResult
from roughcontact._work.studies.shares import Share
from roughcontact._work.studies.tasks import Chains, run_chains
from roughcontact.errors import InputError, NotWritten, StudyStopped

_LOGGER = logging.getLogger("roughcontact")
# Convolutions of a solve, measured on rough surfaces over two decades of load with warm starts.
_TYPICAL_CONVOLUTIONS = 25
# Most values of an axis that are listed; of more, the first ones and the last.
_MAX_LISTED_VALUES = 8
# Units of a time, s; each is used from twice its length on.
_TIME_UNITS = {"hours": 3600.0, "minutes": 60.0, "s": 1.0}
# Units in which texts of a study file are read.
_PASCAL, _NEWTON, _METRE, _SECOND = ({"unit": unit} for unit in ("Pa", "N", "m", "s"))


def describe_study(
    known: Sequence[tuple[str, ContactProblem]],
    axes: Mapping[str, Sequence[Any]],
    loads: Sequence[Load],
    *,
    sampled: bool,
    loading: Loading,
) -> str:
    """Return the plans of the known problems, the values on each axis, and the work of all solves.

    Parameters
    ----------
    known
        Names and problems: all, or the first where a function builds them.
    axes
        The values that are combined, by the name of their axis: problems, parameters of a function, seeds.
    loads
        The loads of each combination.
    sampled
        Whether the known problem is the first of several.
    loading
        What is found at each load.
    """
    plans = [problem.plan for _, problem in known]
    memory = [loading.memory_of(plan) for plan in plans]
    kind = loads[0].kind
    count = math.prod(map(len, axes.values())) * len(loads)
    cells = sum(plan.grid.cells for plan in plans) / len(plans) * count
    seconds = sum(plan.seconds for plan in plans) / len(plans) * count
    lists = {**axes, kind: [str(load).removeprefix(f"{kind} ") for load in loads]}
    rows = [(name, _list_values(values)) for name, values in lists.items()]
    rows += [
        ("solves", f"{count}: {' x '.join(f'{len(values)} of {name}' for name, values in lists.items())}"),
        ("work", f"{cells / 1e6:.3g} million cells in all, about {_TYPICAL_CONVOLUTIONS} convolutions for each"),
        ("memory", f"at most {binary(max(memory))} for one solve"),
        ("time", f"about {_format_time(seconds)} in one process on this machine, within a factor of three"),
    ]
    if any(isinstance(law, CoupledProcess) for plan in plans for law in plan.laws):
        rows.append(("", "for the contacts alone: what laws take stands with each problem"))
    if sampled:
        rows.append(("", "if all problems are like the first"))
    own = loading.list_rows()
    rows = [*rows[: len(lists)], *own[:1], *rows[len(lists) :], *own[1:]]
    texts = [f"{name}:\n{loading.explain(problem, loads)}" for name, problem in known]
    return PlainText("\n\n".join([*texts, "\n".join(f"{label:<10} {text}" for label, text in rows)]))


def _list_values(values: Sequence[Any]) -> str:
    texts = [str(value) for value in values]
    return ", ".join(
        texts if len(texts) <= _MAX_LISTED_VALUES else [*texts[: _MAX_LISTED_VALUES - 1], "...", texts[-1]]
    )


def _format_time(seconds: float) -> str:
    unit = next((unit for unit, length in _TIME_UNITS.items() if seconds >= 2.0 * length), "s")
    return f"{seconds / _TIME_UNITS[unit]:.2g} {unit}"


def _problems(value: object) -> Mapping[str, ContactProblem]:
    if isinstance(value, BuiltProblems):
        return value
    if isinstance(value, ContactProblem):
        value = {"problem": value}
    if not isinstance(value, Mapping) or not value:
        allowed = "a ContactProblem, a mapping of names to them, or a function that builds one"
        raise InputError.about("The problems of a study", value, allowed)
    for name, problem in value.items():
        if not isinstance(name, str) or not isinstance(problem, ContactProblem):
            raise InputError.about(f"The problem {name!r} of a study", problem, "a ContactProblem under a name")
    return dict(value)


def _as_tuple(value: object) -> object:
    # `Load.sequence` refuses values that are not lists, in words.
    try:
        return tuple(value) if isinstance(value, Iterable) and not isinstance(value, (str, bytes)) else value
    except Exception:
        return value


def _as_list(value: object, what: str) -> tuple[Any, ...]:
    items = _as_tuple(value)
    if not isinstance(items, tuple):
        raise InputError.about(what, value, "a list")
    return items


def _names(value: str | Sequence[str]) -> tuple[str, ...]:
    names = (value,) if isinstance(value, str) else _as_list(value, "The area estimators of a study")
    for name in names:
        if not isinstance(name, str):
            raise InputError.about("An area estimator of a study", name, "a registered name")
        areas.resolve(name)
    return names


def _seeds(value: Iterable[int]) -> tuple[int, ...]:
    return tuple(integer(seed, "A seed of the study", at_least=0) for seed in _as_list(value, "The seeds of a study"))


def _uncertainty(value: str) -> str:
    return choice(value, "The uncertainty", list(UNCERTAINTIES))


def _fields(value: object) -> bool:
    return flag(value, "fields=")


@attrs.frozen(eq=False, init=False)
class Study:
    """Every problem with every seed at every load, and every estimator's area of each.

    Parameters
    ----------
    problems
        A `ContactProblem`, or several by name; or a function that returns one, called with a value of each axis by
        name when its solves begin. A problem that it cannot build is in the records, with the reason.
    pressure, force, approach
        Exactly one list: nominal mean pressures, Pa; normal forces, N; approaches, m. Each solve starts from
        the solutions at the loads before. With a hardness each load is a first loading, unless the problem has the law
        `Flattening`, with which the loads follow each other in their order.
    areas
        Names of area estimators.
    responses
        What is asked of each contact, for columns of the table: registered names of responses, such as
        ``"stiffness"``, or instances, ``rc.responses.create("conductance", conductivity=45.0)``.
    seeds
        Added to the seed of each random surface of each problem; if empty, the surfaces are used as they are. A
        function has an axis instead, ``seed=[...]``.
    tangential_force, displacement
        At most one list of pairs (x, y), N or m: loads along the surface, one after the other under each normal load,
        as of `ContactProblem.path`; then a solve is a path with friction, `StudyResult.path`.
    friction
        The law by which the surfaces slip, or a coefficient of friction.
    substeps
        Increments of each step of a path; ``"auto"``: as many as it needs.
    time, sliding
        Times, s, and sliding distances, m, which pass under each normal load, on fresh surfaces, as of
        `ContactProblem.path`; then a solve is such a path.
    factors
        The loads at these times or distances, over the normal load: ``factors=[1, 2, 0.5]`` with ``force=[1, 10]`` is
        one path under 1, 2, 0.5 N and one under 10, 20, 5 N. Without, the load holds.
    accuracy
        Admissible error of an increment of such a path.
    uncertainty
        What the uncertainties of its answers are found from, ``"auto"``, ``"model"`` or ``"two grids"``; see
        `ContactSolution.area`. By the model nothing is solved for them.
    fields
        Whether each solution is kept in a file, with all its fields: 32 bytes a cell. Without, the records are kept
        alone, about a kilobyte each, and `StudyResult.solution` solves again, to the same bits.
    **axes
        Values of the parameters of the function, numbers or texts: ``hurst=[0.3, 0.8], seed=range(8)``. All
        combinations are solved, and the records state them as `Record.parameters`.

    Raises
    ------
    InputError
        If an argument is of a wrong type, there is not exactly one list of loads, a load cannot be carried,
        or seeds are given for a problem without random surfaces; if the axes are not parameters of the function, or
        it does not build its first problem.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> study = rc.Study(problems=problem, force=[0.5, 1.0])
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     print(len(study.run(folder)))
    2
    """

    problems: Mapping[str, ContactProblem] = attrs.field(converter=_problems)
    pressure: Sequence[float] | None = attrs.field(default=None, converter=_as_tuple, kw_only=True, metadata=_PASCAL)
    force: Sequence[float] | None = attrs.field(default=None, converter=_as_tuple, kw_only=True, metadata=_NEWTON)
    approach: Sequence[float] | None = attrs.field(default=None, converter=_as_tuple, kw_only=True, metadata=_METRE)
    areas: tuple[str, ...] = attrs.field(default=(DEFAULT_AREA,), converter=_names, kw_only=True)
    responses: tuple[Response[Any], ...] = attrs.field(default=(), converter=read_responses, kw_only=True)
    seeds: tuple[int, ...] = attrs.field(default=(), converter=_seeds, kw_only=True)
    tangential_force: Sequence[Pair] | None = attrs.field(default=None, kw_only=True, metadata=_NEWTON)
    displacement: Sequence[Pair] | None = attrs.field(default=None, kw_only=True, metadata=_METRE)
    friction: float | FrictionLaw | None = attrs.field(default=None, kw_only=True)
    substeps: int | str = attrs.field(default="auto", kw_only=True)
    time: Sequence[float] | None = attrs.field(default=None, kw_only=True, metadata=_SECOND)
    sliding: Sequence[float] | None = attrs.field(default=None, kw_only=True, metadata=_METRE)
    factors: Sequence[float] | None = attrs.field(default=None, kw_only=True)
    accuracy: float = attrs.field(default=PATH_ACCURACY, kw_only=True)
    uncertainty: str = attrs.field(default="auto", converter=_uncertainty, kw_only=True)
    fields: bool = attrs.field(default=False, converter=_fields, kw_only=True)
    loading: Loading = attrs.field(init=False, repr=False)

    @loading.default
    def _find_loading(self) -> Loading:
        along = {name: getattr(self, name) for name in ("tangential_force", "displacement", "friction", "substeps")}
        passed = {name: getattr(self, name) for name in ("time", "sliding", "factors", "accuracy")}
        return read_loading(along, passed, self.uncertainty, self.responses)

    def __init__(
        self,
        problems: ContactProblem | Mapping[str, ContactProblem] | Callable[..., ContactProblem],
        *,
        pressure: Iterable[Pressure] | None = None,
        force: Iterable[Force] | None = None,
        approach: Iterable[Length] | None = None,
        areas: str | Sequence[str] = (DEFAULT_AREA,),
        responses: str | Response[Any] | Sequence[str | Response[Any]] = (),
        seeds: Iterable[int] = (),
        tangential_force: Sequence[Pair] | None = None,
        displacement: Sequence[Pair] | None = None,
        friction: float | FrictionLaw | None = None,
        substeps: int | str = "auto",
        time: Iterable[float | str] | None = None,
        sliding: Iterable[Length] | None = None,
        factors: Iterable[float] | None = None,
        accuracy: float = PATH_ACCURACY,
        uncertainty: str = "auto",
        fields: bool = False,
        **axes: Iterable[Any],
    ) -> None:
        arguments = {name: value for name, value in locals().items() if name not in ("self", "problems", "axes")}
        made: Any = problems
        if callable(problems):
            made = BuiltProblems.over(problems, axes, ("problems", *arguments))
        elif axes:
            raise InputError.unknown("argument of Study", min(axes), ("problems", *arguments))
        self.__attrs_init__(made, **arguments)

    def __attrs_post_init__(self) -> None:
        if isinstance(self.problems, BuiltProblems) and self.seeds:
            raise InputError("A function takes its seed as a parameter: give seed=[...] instead of seeds=.")
        for name, problem in self._known_problems:
            if self.seeds and not _has_random_surface(problem):
                raise InputError(f"Seeds are given, but no surface of the problem {name!r} has one: leave seeds= out.")
            try:
                self.loading.require(problem, self.loads)
            except InputError as error:
                raise InputError(f"Problem {name!r}: {error.marked}") from error

    @property
    def _known_problems(self) -> list[tuple[str, ContactProblem]]:
        """All problems, or only the first if a function builds them."""
        names = list(self.problems)[:1] if isinstance(self.problems, BuiltProblems) else self.problems
        return [(name, self.problems[name]) for name in names]

    @property
    def loads(self) -> tuple[Load, ...]:
        """The loads, of one kind."""
        # Problems that a function builds are asked one by one, when they are solved.
        built = isinstance(self.problems, BuiltProblems)
        attract = built or any(problem.adhesion is not None for problem in self.problems.values())
        unloads = not built and any(map(self.loading.follows, self.problems.values()))
        sequence = Load.signed_sequence if attract else Load.resting_sequence if unloads else Load.sequence
        return sequence(pressure=self.pressure, force=self.force, approach=self.approach)

    @property
    def key(self) -> str:
        """A name for the study, made from its content; with a function, from its name and the axes."""
        return self._long_key[:12]

    @property
    def _long_key(self) -> str:
        described: Any = {}
        if isinstance(self.problems, BuiltProblems):
            described = [self.problems.name, dict(self.problems.axes)]
        else:
            described = {name: problem.parts for name, problem in self.problems.items()}
        return key_of([described, [load.arguments for load in self.loads], self.seeds, *self.loading.parts])

    def _find_content(self) -> str:
        """Return the key of its content and of the versions that its records depend on."""
        chosen = dict.fromkeys(kind for problem in self.problems.values() for kind in problem.chosen)
        return solution_key(self._long_key, {}, chosen=tuple(chosen))

    def chains(self) -> Iterator[Chain]:
        """Yield each problem with each seed, at all loads."""
        for chain in self._points(RecordList(Path(), self.key, None, ""), Known(), None):
            if isinstance(chain, Unbuilt):
                raise InputError(chain.message)
            yield chain

    def _points(self, records: RecordList, known: Known, share: Share | None) -> Chains:
        files = (records.folder, records.journal, known)
        questions = tuple(map(Question.of, self.responses))
        asked = (self.loading, questions, self.fields)
        return Chains(self.problems, self.seeds, self.loads, self.areas, *files, share, *asked)

    def explain(self) -> str:
        """Return in words the plan of every problem, or of the first that is built, the axes, and work and time."""
        axes = self.axes or {"problem": tuple(self.problems), **({"seed": self.seeds} if self.seeds else {})}
        known = self._known_problems
        sampled = len(known) < len(self.problems)
        return describe_study(known, axes, self.loads, sampled=sampled, loading=self.loading)

    def run(
        self,
        folder: str | Path,
        *,
        executor: Executor | None = None,
        share: tuple[int, int] | str | None = None,
        on_records: Callable[[Sequence[Record]], None] | None = None,
        progress: bool = False,
    ) -> StudyResult:
        """Solve the contacts whose records are not in the folder yet.

        Parameters
        ----------
        folder
            The folder of the list of records, and of the solutions that are kept, one npz file each; made if it is
            missing. Workers on other machines must see the same folder.
        executor
            Any `concurrent.futures.Executor`, such as a process pool or the one of a dask client, which gets one
            task for each problem and seed; in this process if None.
        share
            ``(3, 64)`` or ``"3/64"``: the third of 64 shares alone, for jobs that write into one folder. Shares differ
            by at most one problem and seed. When all have run, ``run(folder)`` returns the whole, and solves what is
            missing.
        on_records
            Called with the records of each problem and seed as soon as they are known.
        progress
            Whether to show on standard error how far it has come (extra ``progress``).

        Returns
        -------
        StudyResult
            The records in the order of the study; with `share`, its own.

        Raises
        ------
        InputError
            If there is no such share, or the folder cannot be made.
        StudyStopped
            If the disk is full, the executor broke or a problem ended every worker that it was given to; what is on
            disk is safe, and the next run continues.
        """
        if executor is not None and not callable(getattr(executor, "submit", None)):
            raise InputError.about("The executor", executor, "a concurrent.futures.Executor, or None")
        told = callback(on_records, "on_records=", "records")
        part = None if share is None else Share.of(share)
        target = _make_folder(folder)
        remove_stale(target)
        content = "" if isinstance(self.problems, BuiltProblems) else self._find_content()
        listed = RecordList(target, self.key, part, content)
        known = listed.read()
        self._remove_drafts(target, known)
        chains = self._points(listed, known, part)
        done: dict[int, list[Record]] = {}
        computed = 0
        stops: list[str] = []
        # Closed, so that an exception of `on_records` cancels the tasks that wait.
        with (
            show_progress("study", shown=flag(progress, "progress=")) as change,
            contextlib.closing(run_chains(chains, executor)) as results,
        ):
            tell = tell_both(told, count_done(change, len(chains), "contact"))
            for position, result in results:
                done[position] = result.records
                computed = computed + result.computed
                stops += [reason for reason in (result.stopped, result.lost) if reason]
                tell(result.records)
                _log_chain(result.records)
                if executor is None and stops:
                    break
        records = [record for position in sorted(done) for record in done[position]]
        stops += _write_list(listed, records, known, ended=not stops)
        if stops:
            raise _stop_error(stops[0], done, len(chains) * len(self.loads))
        return StudyResult(folder=target, records=tuple(records), computed=computed, again=SolvedAgain(chains))

    def _remove_drafts(self, folder: Path, known: Known) -> None:
        """Remove the unfinished paths of records, whose processes were killed just after these were written."""
        for file in folder.glob(f"*{DRAFT}") if self.loading.has_draft else ():
            record = known.records.get(file.name.removesuffix(DRAFT))
            if record is not None and record.has_solution:
                remove_draft(file)

    def __repr__(self) -> str:
        axes = ", ".join(f"{counted(len(values), 'value')} of {name}" for name, values in self.axes.items())
        loads = self.loads
        what = axes or counted(len(self.problems), "problem")
        return f"<Study {what}, {counted(len(loads), 'load')} of {loads[0].kind}>"

    @property
    def axes(self) -> Mapping[str, tuple[Any, ...]]:
        """The values of each parameter of the function; empty without one."""
        return self.problems.axes if isinstance(self.problems, BuiltProblems) else {}


def _log_chain(records: Sequence[Record]) -> None:
    """Log what was found of each contact of one problem and seed."""
    for record in records:
        level = logging.WARNING if record.message else logging.INFO
        what = (record.problem, record.seed, record.control, record.load, record.status, record.message)
        _LOGGER.log(level, "study: %s, seed %s, %s %g: %s %s", *what)


def _make_folder(folder: str | Path) -> Path:
    target = checks.path(folder, "The folder of the study")
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"The folder {str(target)!r} of the study cannot be made: {error.strerror or error}."
        ) from error
    return target


def _write_list(listed: RecordList, records: Sequence[Record], known: Known, *, ended: bool) -> list[str]:
    """Write the list of records if it has changed; return why it could not be written."""
    is_new = any(known.records.get(record.key) != record for record in records)
    try:
        if is_new or listed.is_scattered():
            listed.close(records, ended=ended)
    except NotWritten as error:
        # A finished study may lie where nothing can be written.
        return [name_full_disk(listed.folder, error)] if is_new else []
    return []


def _stop_error(reason: str, done: Mapping[int, list[Record]], total: int) -> StudyStopped:
    count = sum(len(records) for records in done.values())
    return StudyStopped(
        f"{reason}: {count} of {total} solves are reported, and every finished one is on disk. "
        "Correct this and run the study again: it solves only what is missing."
    )


def _has_random_surface(problem: ContactProblem) -> bool:
    return any(body.surface.reseed(0) is not None for body in (problem.body, problem.counterbody))
